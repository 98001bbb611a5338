"""Pulls that hardly exceed the limit of friction along a vector: how fast it turns bounds no steps."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import lagrange_cli as lagrange
from lagrange_cli.integrate.guards import creeping
from tests.motions.test_vanishing_friction import TOLERANCES
from tests.support.draws import examples

pytestmark = pytest.mark.filterwarnings("ignore:.*choose units in which they are larger")
BY = pytest.mark.parametrize("method", TOLERANCES)
PUCK = """
parameters: {{F: 2, e: {excess!r}, k: {spring}}}
coordinates: {{x: {{initial: 0}}, y: {{initial: 0}}}}
masses: {{puck: 1.5}}
positions: {{puck: [x, y]}}
potential: k*(x**2 + y**2)/2
dissipation: F*norm((x_dot, y_dot))
forces: {{puck: {pull}}}
"""
MANY = """
sizes: {N: 9}
parameters: {F: 2}
coordinates: {"x[i in range(N)]": {initial: 0}, "y[i in range(N)]": {initial: 0}}
masses: {"puck[i in range(N)]": 1}
positions: {"puck[i in range(N)]": "(x[i], y[i])"}
potential: 0
dissipation: sum(F*norm((x_dot[i], y_dot[i])) for i in range(N))
forces: {"puck[i in range(N)]": "(0.6*(F + 10**(-i - 1)), 0.8*(F + 10**(-i - 1)))"}
"""
PILE = """
parameters: {F: 2, e: 1e-8}
coordinates: {x: {initial: 0}, y: {initial: 0}, u: {initial: 0}, w: {initial: 0}}
masses: {lower: 1, upper: 1}
positions: {lower: [x, y], upper: [u, w]}
potential: 0
dissipation: 5*norm((x_dot, y_dot)) + F*norm((u_dot - x_dot, w_dot - y_dot))
forces: {upper: "(0.6*(F + e), 0.8*(F + e))"}
"""


def moved(text: str, method: str, stop: float = 2.0, most: int = 100) -> lagrange.Trajectory:
    """The motion to a time, in so many steps at ``most``."""
    found = lagrange.solve(text, stop=stop, samples=41, method=method, tolerance=TOLERANCES[method])
    assert found.status == "complete"
    assert found.attributes["steps"] < most
    return found


@BY
@examples(3)
@given(power=st.floats(-10, -4.5), spring=st.sampled_from([0.0, 1.0]))
def test_a_puck_is_pulled_just_beyond_the_limit(method: str, power: float, spring: float) -> None:
    """F + e against F: x = e/k (1 - cos w t), or e t^2/2m."""
    excess = 10.0**power
    motion = moved(PUCK.format(excess=excess, spring=spring, pull='"(0.6*(F + e), 0.8*(F + e))"'), method)
    left, w = (2.0 + excess) - 2.0, np.sqrt(spring / 1.5)
    expected = left * (1 - np.cos(w * motion.t)) / spring if spring else left * motion.t**2 / 3
    rounded = 1e-8 * excess + 1e-15
    assert motion.q["x"] == pytest.approx(0.6 * expected, abs=rounded)
    assert motion.q["y"] == pytest.approx(0.8 * expected, abs=rounded)


@BY
@pytest.mark.parametrize("excess", [1e-6, 1e-8, 1e-10])
def test_a_pull_that_turns_takes_the_puck_with_it(method: str, excess: float) -> None:
    """Friction is opposite to the pull but for terms of e^2: m |v| = e t."""
    motion = moved(PUCK.format(excess=excess, spring=0, pull='"((F + e)*cos(t), (F + e)*sin(t))"'), method)
    t, usual = motion.t, ((2.0 + excess) - 2.0) / 1.5
    assert motion.q["x"] == pytest.approx(usual * (t * np.sin(t) + np.cos(t) - 1), abs=1e-5 * excess)
    assert motion.q["y"] == pytest.approx(usual * (np.sin(t) - t * np.cos(t)), abs=1e-5 * excess)


def test_it_does_what_short_steps_do(monkeypatch: pytest.MonkeyPatch) -> None:
    text = PUCK.format(excess=3e-5, spring=1, pull='"((F + e)*cos(t), (F + e)*sin(t) - x_dot*t)"')
    motion = moved(text, "taylor", 1.0, most=1000)
    monkeypatch.setattr(creeping, "STIFF", np.inf)
    usual = lagrange.solve(text, stop=1.0, samples=41, method="taylor", cache=False)
    assert usual.attributes["steps"] > 2 * motion.attributes["steps"]
    for name in ("x", "y"):
        assert motion.q[name] == pytest.approx(usual.q[name], abs=1e-15)
        assert motion.v[name] == pytest.approx(usual.v[name], abs=1e-13)


@BY
def test_pucks_apart_creep_each_at_its_own_rate(method: str) -> None:
    motion = moved(MANY, method, most=20000)  # ways take longer than some thousand steps
    for i in range(9):
        left = (2 + 10.0 ** (-i - 1)) - 2
        assert motion.q["x"][:, i] == pytest.approx(0.3 * left * motion.t**2, abs=1e-8 * left + 1e-14)


@BY
def test_the_upper_one_of_a_pile_creeps(method: str) -> None:
    motion = moved(PILE, method)
    assert motion.q["u"] == pytest.approx(0.3 * ((2 + 1e-8) - 2) * motion.t**2, abs=1e-15)
    assert np.all(np.abs(motion.q["x"]) < 1e-24)
