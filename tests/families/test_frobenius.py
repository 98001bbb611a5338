"""Whether constraints on velocities of families are integrable, for all members at once: beside the same
decided member by member, and as ``check`` says it."""

from __future__ import annotations

import random

import pytest

from lagrange_cli.families import frobenius
from lagrange_cli.families.system import any_family_system
from lagrange_cli.mechanics.constrained.frobenius import integrability
from lagrange_cli.run.check import classify
from lagrange_cli.run.classification import as_text
from lagrange_cli.run.derive import derive_system
from lagrange_cli.spec.read import read_spec
from lagrange_cli.spec.values import resolve_values
from tests.families.test_nonholonomic import drawn

DISKS = """
sizes: {N: 3}
parameters: {R: 0.5, "c[i in range(N)]": i}
coordinates:
  x[i in range(N)]: {initial: 0.1 + i}
  y[i in range(N)]: {initial: 1}
  phi[i in range(N)]: {initial: 0.4}
  w[i in range(N)]: {initial: 0}
masses: {"b[i in range(N)]": 1, "a[i in range(N)]": 0.4}
positions: {"b[i in range(N)]": ["x[i]", "y[i]"], "a[i in range(N)]": ["phi[i]", "w[i]"]}
potential: 0
nonholonomic:
"""
CASES = {
    "rolling disks": (
        "rx[i in range(N)]: x_dot[i] - R*cos(phi[i])*w_dot[i]",
        "ry[i in range(N)]: y_dot[i] - R*sin(phi[i])*w_dot[i]",
    ),
    "by parameters": ("one[i in range(N)]: x_dot[i] - c[i]*sin(phi[i])*w_dot[i]",),
    "by their numbers": ("one[i in range(N)]: x_dot[i] + (i % 2)*y[i]*phi_dot[i] + y_dot[i]",),
    "times a function": ("one[i in range(N)]: (x_dot[i]*y[i] + y_dot[i]*x[i])*(2 + sin(w[i]))",),
    "driven": ("one[i in range(N)]: x_dot[i] - cos(t)*y[i]",),
    "driven alike": ("one[i in range(N)]: x_dot[i]*y[i] + x[i]*y_dot[i] - cos(t)",),
    "neighbours": ("one[i in range(N - 1)]: x_dot[i] - x[i + 1]*y_dot[i]",),
    "functions of a few": ("one[i in range(N)]: (x_dot[i] + y[i]*phi_dot[i])/(1 + y[i]**2)",),
}


def compared(text: str) -> frobenius.Integrability:
    """The result, which is that of the members where it is one."""
    spec = read_spec(text, "system.yaml")
    parameters = resolve_values(spec).parameters
    system = any_family_system(spec)
    assert system is not None
    found = frobenius.integrability(system, parameters)
    expected = integrability(derive_system(spec).model, parameters)
    assert found.alone.keys() == expected.alone.keys()
    for name, alone in found.alone.items():
        assert alone is None or alone is expected.alone[name], name
    assert found.together in (None, expected.together)
    if found.functions is not None:
        assert found.functions == expected.functions
        assert not expected.combinations
    return found


@pytest.mark.exhaustive(keep=0.35)
@pytest.mark.parametrize("seed", range(20))
def test_random_systems_are_as_their_members(seed: int) -> None:
    text = drawn(random.Random(seed))
    compared(text if len(read_spec(text, "system.yaml").coordinates) < 30 else drawn(random.Random(2)))


@pytest.mark.exhaustive(keep=3)
@pytest.mark.parametrize("case", CASES)
def test_kinds_of_constraints_are_as_their_members(case: str) -> None:
    found = compared(DISKS + "".join(f"  {line}\n" for line in CASES[case]))
    assert None not in found.alone.values()
    assert (found.together is None) == (case in ("rolling disks", "neighbours"))


def test_holonomic_constraints_leave_it_open() -> None:
    text = DISKS + "  one[i in range(N)]: x_dot[i] - y[i]*w_dot[i]\nconstraints: {rod: 'x[0] - y[0]'}\n"
    assert compared(text).alone == {"one[0]": None, "one[1]": False, "one[2]": False}


@pytest.mark.exhaustive(keep=0.6)
def test_check_says_it_in_a_line() -> None:
    def said(*lines: str) -> str:
        text = DISKS + "".join(f"  {line}\n" for line in lines)
        spec = read_spec(text, "system.yaml", {"N": "400"})
        return " ".join(as_text(classify(spec, values=resolve_values(spec)), verbose=False).split())

    text = said(*CASES["rolling disks"])
    assert "each of rx[0..399] is not integrable (Frobenius): it is nonholonomic" in text
    assert "whether combinations of constraints on velocities are integrable: that takes too much" in text
    text = said("roll[i in range(N)]: x_dot[i] - R*w_dot[i]")
    one = "roll[i] is integrable (Frobenius), so it is holonomic: a function of q and t is constant"
    assert f"{one} [for i in range(400)] so the configurations that a motion reaches" in text
    assert "at most 1200 dimensions of 1600" in text and "too much work" not in text
