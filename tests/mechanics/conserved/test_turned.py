"""Conserved polynomials along the axes in which a potential is written, turned by an angle that is a
parameter."""

from __future__ import annotations

import pytest

from lagrange_cli.expression.build import build
from lagrange_cli.expression.parse import parse
from lagrange_cli.expression.zero import is_zero
from lagrange_cli.mechanics.conserved.noether import Noether
from lagrange_cli.mechanics.conserved.polynomial_integrals import PolynomialIntegrals
from lagrange_cli.mechanics.conserved.symmetries import symmetries
from lagrange_cli.mechanics.conserved.turned import integrals, turned
from lagrange_cli.mechanics.substitution import substituted
from tests.support.motion import residual_of

TURNED = """
parameters: {{A: 1.3, B: 0.7, m: 2, n: 3, alpha: 0.4}}
coordinates: {{x: {{initial: 0.8, velocity: 0.3}}, y: {{initial: 0.3, velocity: 0.2}}}}
definitions:
  a: x*cos(alpha) - y*sin(alpha)
  b: x*sin(alpha) + y*cos(alpha)
  va: x_dot*cos(alpha) - y_dot*sin(alpha)
  vb: x_dot*sin(alpha) + y_dot*cos(alpha)
masses: {{p: m}}
positions: {{p: [x, y]}}
potential: {}
observables: {{published: "{}"}}
"""
GREENE = TURNED.format(
    "(A*a**2 + B*b**2)/2 + a**2*b + 2*b**3",
    "a**4 + 4*a**2*b**2 - 4*m*va*(va*b - vb*a) + 4*A*a**2*b + (4*A - B)*(m*va**2 + A*a**2)",
)
CASES = {
    "Greene 1981, Henon and Heiles 1:6": GREENE,
    "Garnier 1919, one of the axes": TURNED.format(
        "B*(x**2 + y**2)**2 + A*a**2",
        "B*m*(x*y_dot - y*x_dot)**2 - A*(m*va**2 + 2*A*a**2 + 2*B*a**2*(a**2 + b**2))",
    ),
}


def searched(text):
    model = residual_of(text).model
    noether = Noether(model)
    return PolynomialIntegrals(model, noether, [noether.energy])


@pytest.mark.exhaustive(keep=0.5)
@pytest.mark.parametrize("case", CASES)
def test_published_integrals_are_found_in_turned_axes(case):
    search = searched(CASES[case])
    model, graph, published = search.model, search.graph, search.model.observables["published"]
    assert search.states.conserves(published)
    (found,) = integrals(model, search.noether, search.known)
    assert search.rank([*search.known, found.node]) == 2
    assert search.rank([*search.known, found.node, published]) == 2
    along = turned(model, search.noether)
    (written,) = substituted(graph, [build(parse(found.text), graph.symbol, model.algebra)], along.here)
    assert is_zero(written - found.node)
    assert found.note == f"; {along.text}" and "X = x*cos(alpha) - y*sin(alpha)" in found.note


def test_masses_turn_the_axes():
    """Axes are orthogonal in the metric of the masses, and T is a sum of squares along them."""
    text = GREENE.replace("masses: {p: m}", "masses: {p: m, q: n}").replace("[x, y]", "[x, 0], q: [0, y]")
    search = searched(text.replace("+ 2*b**3", "").replace("a**2*b", "a**4").replace("B*b**2", "0"))
    along = turned(search.model, search.noether)
    other = Noether(along.model).energetics.lagrangian
    (again,) = substituted(search.graph, [other], along.here)
    assert is_zero(again - search.noether.energetics.lagrangian)


@pytest.mark.exhaustive(keep=2)
@pytest.mark.parametrize(
    ("potential", "expected"),
    [("(A*a**2 + B*b**2)/2 + a**2*b + B*b**3", False), ("-A/norm(p) + B*a", None), ("A*x**2 + x*y**3", None)],
)
def test_what_is_not_found(potential, expected):
    """Where it is not integrable, or not written along axes."""
    search = searched(TURNED.format(potential, "0*x"))
    assert (turned(search.model, search.noether) is None) == (expected is None)
    assert not [*integrals(search.model, search.noether, search.known)]


@pytest.mark.exhaustive(keep=0.15)
def test_they_are_conserved_quantities_of_the_system():
    residual = residual_of(GREENE)
    (found,) = symmetries(residual.model, residual.conserved)
    assert found.conserved.quantity == "I_1" and "Y = x*sin(alpha) + y*cos(alpha)" in found.conserved.because
