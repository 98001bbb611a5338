"""Rigid bodies of families as they are printed with indices: beside the file itself differentiated."""

from __future__ import annotations

import random

import pytest

from lagrange_cli.families import system as systems
from lagrange_cli.records import replace
from lagrange_cli.run.family_equations import DerivedFamilies, derive_printed, in_form, written
from lagrange_cli.run.verification import verify_families
from lagrange_cli.spec.read import read_spec
from tests.families.test_bodies import KINDS, TOPS, drawn
from tests.families.test_quaternions import bodies
from tests.symbolic.families.test_forms import assert_module


def printed(text: str, form: str = "lagrange") -> DerivedFamilies:
    """The equations, with indices however few bodies there are."""
    found = derive_printed(read_spec(text, "system.yaml"), form, indexed=True)
    assert isinstance(found, DerivedFamilies), text
    return found


@pytest.mark.exhaustive(keep=0.5)
def test_the_norms_of_quaternions_have_multipliers_in_every_format() -> None:
    derived = printed(bodies(3))
    names = {"text": "lambda_body_norm[i]", "latex": r"\lambda_{\mathrm{body},\mathrm{norm},i}"}
    for format_, name in names.items():
        assert name in written(derived, format_, "lagrange", {}), format_
    assert_module(derived)


@pytest.mark.exhaustive(keep=0.35, most=20)
@pytest.mark.parametrize("case", range(10))
@pytest.mark.parametrize("kind", KINDS)
def test_bodies_are_those_of_the_file(
    kind: str, case: int, pytestconfig: pytest.Config, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(systems, "FEWEST_JOINTED", 0)
    chance = random.Random(f"{pytestconfig.option.seed} printed {kind} {case}")
    text = drawn(chance, kind, chance.choice([1, 2, 3, 4]))
    found = verify_families(printed(text), {})
    assert found.difference <= 1e-12, (str(found), text)


RODS = """
sizes: {{N: 1}}
parameters: {{m: 0.3, l: 0.4, k: 0.7}}
coordinates: {{"a[i in range(N)]": {{initial: 0.2, velocity: 1}}}}
bodies:
  body[i in range(N)]:
    mass: m
    solid: {{box: [0.3, 0.4, 0.5]}}
    position: [0, l/2*sin(a[i]), -l/2*cos(a[i])]
    orientation: {{matrix: [[1, 0, 0], [0, "cos(a[i])", "-sin(a[i])"], [0, "sin(a[i])", "cos(a[i])"]]}}
potential: sum(k*body[i].R33*{} for i in range(N))
"""


def test_terms_that_cancel_are_no_difference(monkeypatch: pytest.MonkeyPatch) -> None:
    """Of a rod that turns freely at t = 0, compiled accelerations are what its centrifugal terms leave by
    rounding, 5e-17, and the printed equation has nothing else. A force that acts is a difference."""
    monkeypatch.setattr(systems, "FEWEST_JOINTED", 0)
    free, pushed = (printed(RODS.format(one)) for one in ("sin(2*t)", "cos(2*t)"))
    assert verify_families(free, {}).difference <= 1e-12
    equations = replace(pushed.equations, equations=free.equations.equations)
    assert verify_families(replace(pushed, equations=equations), {}).difference > 1e-3


@pytest.mark.exhaustive(keep=0.15)
def test_a_thousand_tops_are_those_of_a_textbook() -> None:
    """Goldstein, Classical Mechanics, 3rd ed., eqs. 5.52 and 5.53: the momenta of a heavy symmetric top."""
    text = TOPS.replace("COUNT", "1000")
    derived = printed(text)
    lines = " ".join(written(derived, "text", "lagrange", {}).split())
    for line in (
        "p_psi[i] = I3*cos(theta[i])*phi_dot[i] + I3*psi_dot[i] [for i in range(N)]",
        "p_theta[i] = (m*l**2 + I1)*theta_dot[i] [for i in range(N)]",
        "U = m*g*l*sum(cos(theta[i]) for i in range(N))",
        "- I3*sin(theta[i])*theta_dot[i]*psi_dot[i] = 0 [phi[i], for i in range(N)]",
        "p_psi[i]: psi[i] is cyclic: L does not contain it",
    ):
        assert line in lines, line
    for format_ in ("latex", "unicode"):
        assert written(derived, format_, "lagrange", {}).count("\n") < 60
    assert "R_top_z[i] = " in written(in_form(derived, "reactions"), "text", "reactions", {})
    lines = "".join(written(in_form(derived, "hamilton"), "text", "hamilton", {}).split())
    for line in (  # wherever they are broken
        "phi_dot[i] = (p_phi[i] - cos(theta[i])*p_psi[i])/((m*l**2 + I1)*sin(theta[i])**2)",
        "- (1 + cos(theta[i])**2)*p_phi[i]*p_psi[i]/((m*l**2 + I1)*sin(theta[i])**3)",
    ):
        assert "".join(line.split()) in lines, line
    assert "M_phi_psi[i,i] = I3*cos(theta[i])" in written(derived, "text", "matrix", {})
