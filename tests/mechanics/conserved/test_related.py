"""What is conserved because parameters are functions of others."""

from __future__ import annotations

import pytest

from lagrange_cli.mechanics.conserved.related import related
from lagrange_cli.mechanics.conserved.symmetries import symmetries
from tests.mechanics.conserved.test_lasting import CENTRES
from tests.support.motion import residual_of

PLANE = """
parameters: {{a: 1.3, c: 0.5, b: {}, m: 1}}
coordinates: {{x: {{initial: 1}}, y: {{initial: 0.3, velocity: 0.2}}}}
masses: {{p: m}}
positions: {{p: [x, y]}}
potential: {}
"""
TWO_CENTRES = "-1/sqrt((x - c)**2 + y**2) - m/sqrt((x + c)**2 + y**2)"
BILLIARD = CENTRES.format(TWO_CENTRES).replace("(a**2 - c**2)", "b**2")
CASES = {
    "a sum of squares": (PLANE.format("sqrt(a**2 - c**2)", "(b**2 + c**2)*x**2 + a**2*y**2"), {"L_z": ()}),
    "a name for another": (PLANE.format("a", "b*x**2 + a*y**2"), {"L_z": ()}),
    "a ratio of frequencies": (PLANE.format("4*a", "b*x**2 + a*y**2"), {"A_x": ()}),
    "numbers that are equal": (PLANE.format("1.3", "b*x**2 + a*y**2"), {}),
    "a formula with a parameter of its own": (PLANE.format("a*c", "b*x**2 + a*y**2"), {}),
    "a formula that is not in the equations": (PLANE.format("a", "a*x**2 + c*y**2"), {}),
    "foci of a billiard": (
        BILLIARD.replace("b**2**2", "b**4").replace("k: 0.8", "b: sqrt(a**2 - c**2)"),
        {"I_1'": ()},
    ),
}


@pytest.mark.exhaustive(keep=0.7)
@pytest.mark.parametrize("case", CASES)
def test_what_follows_from_formulas_of_parameters(case):
    text, expected = CASES[case]
    residual = residual_of(text)
    found = symmetries(residual.model, residual.conserved)
    new = related(residual.model, residual.conserved, found)
    assert {one.conserved.quantity: one.conserved.breaks for one in new} == expected
    assert all("; only where b = " in one.conserved.because for one in new)


FAMILY = """
sizes: {N: 2}
parameters: {a: 1.3, c: 0.5, b: "sqrt(a**2 - c**2)"}
coordinates:
  x[i in range(N)]: {initial: 1 + i}
  y[i in range(N)]: {initial: 0.3, velocity: 0.2}
definitions:
  square[i in range(N)]: x[i]**2
  U[i in range(N)]: (b**2 + c**2)*square[i] + a**2*y[i]**2
masses: {p[i in range(N)]: 1}
positions: {"p[i in range(N)]": "(x[i], y[i])"}
potential: sum(U[i] for i in range(N))
"""


def test_definitions_may_be_families_beside_formulas_of_parameters() -> None:
    """The formula gives both an angular momentum."""
    residual = residual_of(FAMILY)
    found = symmetries(residual.model, residual.conserved)
    new = related(residual.model, residual.conserved, found)
    assert "L_z" in {one.conserved.quantity for one in new}
