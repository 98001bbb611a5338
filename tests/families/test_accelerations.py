"""Accelerations by numpy beside those of the compiled code, and which surfaces may be conserved."""

from __future__ import annotations

import random

import numpy as np
import pytest

import lagrange_cli as lagrange
from lagrange_cli.families.accelerations import Accelerations
from lagrange_cli.families.system import any_family_system
from lagrange_cli.integrate.family_program import compiled_accelerations
from lagrange_cli.integrate.unchanging import may_be_conserved
from lagrange_cli.spec.read import read_spec
from lagrange_cli.spec.surface import with_surface
from tests.families.test_events import keep_families
from tests.families.test_nonholonomic import drawn, drawn_on_trees
from tests.families.test_sections import family_of
from tests.support.motion import SYSTEMS

CHAIN = """
sizes: {{N: {count}}}
parameters: {{l: 1, m: 1, g: 9.81}}
coordinates: {{X: {{initial: 0}}, Y: {{initial: 0}}, "theta[i in range(N)]": {{initial: 0.3*i}}}}
masses: {{"bob[i in range(N)]": m, top: 2}}
positions:
  top: [X, Y]
  bob[i in range(N)]: ["X + sum(l*sin(theta[j]) for j in range(i + 1))",
                       "Y - sum(l*cos(theta[j]) for j in range(i + 1))"]
potential: {potential}
{constraints}
"""
WEIGHTS = "2*g*Y + sum(m*g*bob[i].y for i in range(N))"
MOMENTUM = "2*X_dot + sum(m*bob[i].vx for i in range(N))"
TURNING = "2*(X*Y_dot - Y*X_dot) + sum(m*(bob[i].x*bob[i].vy - bob[i].y*bob[i].vx) for i in range(N))"
ENERGY = f"X_dot**2 + Y_dot**2 + sum(m*(bob[i].vx**2 + bob[i].vy**2)/2 for i in range(N)) + {WEIGHTS} - 3"
SLOPE, LEVEL = "constraints: {pin: X - Y/5}", "constraints: {pin: 'bob[N - 1].y - 1/5'}"
SURFACES = [
    ("0", "", MOMENTUM, True), ("0", "", TURNING, True), ("0", "", "theta_dot[0]", False),
    (WEIGHTS, "", MOMENTUM, True), (WEIGHTS, "", ENERGY, True), (WEIGHTS, "", TURNING, False),
    (WEIGHTS, SLOPE, ENERGY, True), (WEIGHTS, SLOPE, MOMENTUM, False), (WEIGHTS, SLOPE, "X - Y/5", True),
    (WEIGHTS, SLOPE, "X_dot - Y_dot/5", True), (WEIGHTS, SLOPE, "X_dot - Y_dot/4", False),
    (WEIGHTS, LEVEL, ENERGY, True), (WEIGHTS, LEVEL, MOMENTUM, True), (WEIGHTS, LEVEL, "theta[0]", False),
]  # fmt: skip


pytestmark = pytest.mark.usefixtures("however_small")


@pytest.mark.exhaustive(keep=1)
@pytest.mark.parametrize("seed", range(20))
@pytest.mark.parametrize("make", [drawn, drawn_on_trees])
def test_accelerations_are_those_of_the_compiled_code(make, seed: int) -> None:
    system = any_family_system(read_spec(make(random.Random(seed)), "system.yaml"))
    assert system is not None
    chance = np.random.default_rng(seed)
    q, v = chance.uniform(0.2, 1.2, system.q.count), chance.uniform(-1.0, 1.0, system.q.count)
    given = chance.uniform(0.5, 1.5, system.given.count)
    motion = Accelerations(system, given)
    allowed = motion.allowed(0.3, q, v)
    assert allowed is not None
    expected = compiled_accelerations(system)(0.3, q, allowed, given)
    found = motion.at(0.3, q, allowed)
    assert found is not None and np.allclose(found, expected, rtol=0.0, atol=1e-6 * np.abs(expected).max())


@pytest.mark.exhaustive(keep=3)
@pytest.mark.parametrize("count", [3, 40])
@pytest.mark.parametrize(("potential", "constraints", "where", "expected"), SURFACES)
def test_surfaces_that_motions_keep_to_are_found(
    potential: str, constraints: str, where: str, expected: bool, count: int
) -> None:
    text = CHAIN.format(count=count, potential=potential, constraints=constraints)
    system = any_family_system(with_surface(read_spec(text, "system.yaml"), where))
    assert system is not None and may_be_conserved(system) is expected


@pytest.mark.exhaustive(keep=0.25)
def test_sections_of_chains_where_they_are_at_rest_are_those_of_the_members(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    text = (SYSTEMS / "n_pendulum.yaml").read_text().replace("N: 5", "N: 3")
    found = []
    for whole in (True, False):
        keep_families(monkeypatch, whole=whole)
        assert family_of("theta_dot[0]", text) == whole
        found.append(lagrange.section(text, where="theta_dot[0]", crossings=2, stop=5, cache=False))
    one, other = found
    assert len(one.t) == 2 and np.allclose(one.t, other.t, rtol=0.0, atol=1e-10)
    assert np.allclose(one.q["theta"], other.q["theta"], rtol=0.0, atol=1e-10)
