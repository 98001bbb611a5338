"""Families with constraints on velocities, printed with indices: beside the file differentiated directly,
the power of the forces of constraint, and a text."""

from __future__ import annotations

import random
from collections.abc import Sequence
from typing import Any

import numpy as np
import pytest

from lagrange_cli.limits import Work
from lagrange_cli.run.family_equations import (
    DerivedFamilies,
    derive_families,
    derive_printed,
    families_as_data,
    families_as_written,
)
from lagrange_cli.run.verification import verify_families
from lagrange_cli.spec.read import read_spec
from lagrange_cli.spec.values import resolve_values
from lagrange_cli.symbolic.families.lines import Line
from lagrange_cli.symbolic.families.readback import ReadBack
from tests.families.test_nonholonomic import TRAIN, drawn

SLEIGHS = """
sizes: {N: 20}
parameters: {a: 0.3}
coordinates:
  x[i in range(N)]: {initial: 0.3*i}
  y[i in range(N)]: {initial: 1}
  phi[i in range(N)]: {initial: sin(i)}
masses: {"b[i in range(N)]": 1, "w[i in range(N)]": 0.4}
positions: {"b[i in range(N)]": ["x[i]", "y[i]"], "w[i in range(N)]": "phi[i]"}
potential: sum(0.7*b[i].x for i in range(N))
nonholonomic: {"edge[i in range(N)]": "b[i].vy*cos(phi[i]) - b[i].vx*sin(phi[i]) - a*phi_dot[i]"}
"""


pytestmark = pytest.mark.usefixtures("however_small")


def derived_from(text: str) -> DerivedFamilies:
    found = derive_families(read_spec(text, "system.yaml"), small=True)
    assert found is not None
    return found


@pytest.mark.exhaustive(keep=0.2)
@pytest.mark.parametrize("seed", range(30))
def test_random_systems_are_those_of_the_file(seed: int) -> None:
    derived = derived_from(drawn(random.Random(seed)))
    assert verify_families(derived, {}).difference <= 1e-12
    assert_energy(derived)
    assert any(one["kind"] == "nonholonomic" for one in families_as_data(derived, {})["constraints"])


def assert_energy(derived: DerivedFamilies) -> None:
    """dh/dt along what the printed equations of motion say, at any multipliers, is the printed rate and the
    work that is done where velocities break the constraints: sum lambda_i (sum_k a_ik v_k + b_i)."""
    found, chance = derived.equations, np.random.default_rng(0)
    read = ReadBack(derived.system, found)
    q, v = chance.uniform(0.2, 1, (2, read.count))
    parameters, t = np.array([*resolve_values(derived.spec).parameters.values()]), 0.4
    a = np.zeros(read.count)

    def values(lines: Sequence[Line], count: int | None = None) -> Any:
        return read.values(lines, (t, q, v, a, parameters), 10**6, count)[0]

    a = (values(found.rates or ()) + values(found.pulls)) / values(found.diagonal or ())

    def along(expression: Any) -> float:
        ends = []
        for s in (-1e-5, 1e-5):
            state = t + s, q + v * s + a * s**2 / 2, v + a * s, a, parameters
            ends.append(float(read.value(expression, {}, 1, state)[0][0]))
        return (ends[1] - ends[0]) / 2e-5

    rate = along(found.h)
    for one in found.changing:
        rate -= float(read.value(one.rate, {}, 1, (t, q, v, a, parameters))[0][0])
    broken = 0.0
    for line in found.constraints:
        places, indices = read.members(line)
        ends = [
            read.value(line.expression, indices, len(places), (t + s, q + v * s, v, a, parameters))[0]
            for s in (-1e-5, 0.0, 1e-5)
        ]
        on_velocities = line.family.name in found.nonholonomic
        speeds = ends[1] if on_velocities else (ends[2] - ends[0]) / 2e-5
        broken += read.multipliers[places] @ speeds
    assert rate == pytest.approx(broken, rel=1e-6, abs=1e-6)


@pytest.mark.exhaustive(keep=0.4)
def test_what_is_wrong_is_found() -> None:
    derived, other = derived_from(SLEIGHS), derived_from(SLEIGHS.replace("- a*phi_dot", "- 2*a*phi_dot"))
    small = derived_from(SLEIGHS.replace("N: 20", "N: 3"))
    wrong = DerivedFamilies(derived.system, other.equations, Work(), derived.spec)
    assert verify_families(wrong, {}).difference > 1e-3
    assert verify_families(small, {}).difference <= 1e-13
    assert small.equations.changing == () and small.equations.conserved[0].quantity == "h"


@pytest.mark.exhaustive(keep=0.8)
def test_a_thousand_sleighs_take_a_line_each() -> None:
    spec = read_spec(SLEIGHS, "system.yaml", {"N": "1000"})
    derived = derive_printed(spec, "lagrange")
    assert isinstance(derived, DerivedFamilies)
    text = " ".join(families_as_written(derived, "text", "lagrange", {}).split())
    for formula in (
        "cos(phi[i])*y_dot[i] - a*phi_dot[i] = 0 [edge[i], nonholonomic, for i in range(N)]",
        "x_ddot[i] = -0.7 - lambda_edge[i]*sin(phi[i])",
        "2*phi_ddot[i]/5 = -a*lambda_edge[i]",
        "and the derivatives of the constraints together",
        "h: L does not contain t explicitly, and the forces of constraint do no work",
    ):
        assert formula in text, formula
    moving = SLEIGHS.replace("- a*phi_dot[i]", "- a*phi_dot[i] + sin(t)")
    assert "dh/dt = -sum(lambda_edge[i] for i in range(N))*sin(t)" in families_as_written(
        derived_from(moving), "text", "lagrange", {}
    )


@pytest.mark.exhaustive(keep=0.15)
def test_a_train_is_printed_with_indices() -> None:
    spec = read_spec(
        TRAIN.format(
            count=200, potential="0", forces="", holonomic="",
            constraints='edge[i in range(N)]: "f[i].vy*cos(phi[i]) - f[i].vx*sin(phi[i])"',
        ),
        "system.yaml",
    )  # fmt: skip
    derived = derive_printed(spec, "lagrange")
    assert isinstance(derived, DerivedFamilies)
    text = families_as_written(derived, "text", "lagrange", {})
    assert "[edge[i], nonholonomic, for i in range(N)]" in text and text.count("\n") < 150
