"""Friction that is switched off, or is 0 from the start, while it holds something."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray
from scipy.linalg import expm

import lagrange_cli as lagrange
from lagrange_cli.integrate.ending import Ending
from tests.support.draws import examples
from tests.support.motion import Motion, follow

ON_A_LINE = """
parameters: {{F: {force}}}
coordinates: {{x: {{initial: 0}}, clock: {{initial: 0, velocity: 1}}}}
masses: {{block: 1, hand: 1}}
positions: {{block: x, hand: clock}}
potential: 0
generalized_forces: {{x: "({load}) - ({limit})*sign(x_dot)"}}
"""
IN_A_PLANE = """
parameters: {{F: {force}}}
coordinates: {{x: {{initial: 0}}, y: {{initial: 0}}, clock: {{initial: 0, velocity: 1}}}}
masses: {{block: 1, hand: 1}}
positions: {{block: [x, y], hand: [clock, 0]}}
potential: 0
definitions: {{u: "(x_dot, y_dot)"}}
forces: {{block: "(0.6*({load}), 0.8*({load})) - ({limit})*u/norm(u)"}}
"""
TOLERANCES = {"taylor": 2.0**-52, "ias15": 2.0**-52, "DOP853": 1e-12, "Radau": 1e-10}
STOP = 2.0
PLACES = pytest.mark.parametrize("text", [ON_A_LINE, IN_A_PLANE], ids=["line", "plane"])


def damped(t: NDArray[np.float64]) -> NDArray[np.float64]:
    """x'' = -20 x - c x' from x = 1 at rest, with c = 4 where x falls and 1 where it rises."""
    expected, reach, begins = np.zeros(len(t)), 1.0, 0.0
    for damping in (4.0, 1.0, 4.0):
        turned = np.sqrt(20 - damping**2 / 4)
        since = t - begins
        here = (since >= 0) & (since <= np.pi / turned)
        swing = np.cos(turned * since) + damping / 2 / turned * np.sin(turned * since)
        expected[here] = (reach * np.exp(-damping / 2 * since) * swing)[here]
        reach *= -np.exp(-damping / 2 * np.pi / turned)
        begins += np.pi / turned
    return expected


def block(
    text: str, load: str, limit: str, method: str = "taylor", force: float = 2, more: str = ""
) -> Motion:
    """The motion of a block of mass 1 from rest, under a load, with friction up to a limit."""
    text = text.format(load=load, limit=limit, force=force) + more
    motion = follow(text, STOP, 41, method=method, tolerance=TOLERANCES[method])
    assert motion.outcome.ending is Ending.COMPLETE
    return motion


def distance(motion: Motion, text: str) -> np.ndarray:
    """How far the block has come along the load."""
    if text is ON_A_LINE:
        return motion["q/x"]
    assert motion["q/x"] * 0.8 == pytest.approx(motion["q/y"] * 0.6, abs=1e-9)
    return 0.6 * motion["q/x"] + 0.8 * motion["q/y"]


@PLACES
@pytest.mark.exhaustive(keep=0.5, most=8)
@pytest.mark.parametrize("method", TOLERANCES)
@pytest.mark.parametrize("condition", ["t < {at}", "clock < {at}", "clock**2 < {at}**2"])
@examples(3)
@given(at=st.floats(0.3, 1.5), load=st.floats(0.5, 1.9), rest=st.sampled_from([0.0, 0.25]))
def test_what_a_brake_has_held_moves_when_it_is_let_go(
    text: str, method: str, condition: str, at: float, load: float, rest: float
) -> None:
    motion = block(text, str(load), f"where({condition.format(at=at)}, F, {rest})", method)
    since = np.maximum(motion.t - at, 0)
    assert distance(motion, text) == pytest.approx((load - rest) * since**2 / 2, abs=1e-9)


@PLACES
@pytest.mark.parametrize("method", TOLERANCES)
def test_an_event_lets_it_go(text: str, method: str) -> None:
    motion = block(
        text, "1.5", "F", method, more="events: {let_go: {when: t - 0.7, action: {set: {F: 0}}}}\n"
    )
    assert distance(motion, text) == pytest.approx(0.75 * np.maximum(motion.t - 0.7, 0) ** 2, abs=1e-9)


@PLACES
@pytest.mark.parametrize("method", TOLERANCES)
def test_without_friction_it_moves_from_the_start(text: str, method: str) -> None:
    motion = block(text, "1.5", "F", method, force=0)
    assert distance(motion, text) == pytest.approx(0.75 * motion.t**2, abs=1e-9)


@PLACES
def test_what_nothing_pushes_stays_until_something_does(text: str) -> None:
    motion = block(text, "where(t < 1, 0, 1.5)", "where(t < 0.4, F, 0)")
    assert distance(motion, text) == pytest.approx(0.75 * np.maximum(motion.t - 1, 0) ** 2, abs=1e-14)


@PLACES
def test_what_is_at_rest_is_held_when_the_brake_is_applied(text: str) -> None:
    motion = block(text, "where(t < 1, 0, 1.5)", "where(t < 0.4, 0, F)")
    assert np.all(np.abs(distance(motion, text)) < 1e-30)


@PLACES
def test_a_brake_is_let_go_and_applied_again(text: str) -> None:
    # from rest at 0.3 to the velocity 0.9 at 0.9; then it slows down at the rate 0.5
    motion = block(text, "1.5", "where(0.3 < t < 0.9, 0, F)")
    free, slowed = np.clip(motion.t - 0.3, 0, 0.6), np.clip(motion.t - 0.9, 0, 1.8)
    expected = 0.75 * free**2 + 0.9 * slowed - 0.25 * slowed**2
    assert distance(motion, text) == pytest.approx(expected, abs=1e-14)


def test_friction_that_grows_from_nothing_stops_two_blocks_against_each_other() -> None:
    # the slip is t - k t**2 for the limit k t, until t = 1/k; then both accelerate at the rate 1/2
    text = """
parameters: {k: 2}
coordinates: {x: {initial: 0}, y: {initial: 0}}
masses: {upper: 1, lower: 1}
positions: {upper: x, lower: y}
potential: 0
definitions: {friction: k*t*sign(x_dot - y_dot)}
generalized_forces: {x: 1 - friction, y: friction}
"""
    motion = follow(text, 1.5, 31)
    slips = np.minimum(motion.t, 0.5)
    slip = slips**2 / 2 - 2 * slips**3 / 3
    assert motion["q/x"] + motion["q/y"] == pytest.approx(motion.t**2 / 2, abs=1e-14)
    assert motion["q/x"] - motion["q/y"] == pytest.approx(slip, abs=1e-14)


CHAIN = """
sizes: {{N: {count}}}
parameters: {{k: 30, F: 2}}
coordinates: {{"x[i in range(N)]": {{initial: 0}}}}
masses: {{"block[i in range(N)]": 1}}
positions: {{"block[i in range(N)]": "x[i]"}}
potential: sum(k*(x[i] - x[i - 1])**2/2 for i in range(1, N))
generalized_forces:
  x[i in range(N)]: where(i == 0, 3*sin(t), 0) - where(t < 1.3, F, 0)*sign(x_dot[i])
"""


def pushed_chain(count: int, times: np.ndarray) -> np.ndarray:
    """Its places (times, blocks): the first block is pushed beyond friction at sin t = 2/3, and is the only
    one that moves until 1.3; from then on there is no friction. By matrix exponentials, with sin t, cos t and
    1 as further components of the state."""
    matrix = np.zeros((2 * count + 3, 2 * count + 3))
    matrix[:count, count : 2 * count] = np.eye(count)
    stiffness = 30 * (2 * np.eye(count) - np.eye(count, k=1) - np.eye(count, k=-1))
    stiffness[0, 0] = stiffness[-1, -1] = 30
    matrix[count : 2 * count, :count] = -stiffness
    matrix[count, 2 * count] = 3
    matrix[2 * count, 2 * count + 1], matrix[2 * count + 1, 2 * count] = 1, -1
    alone = matrix.copy()
    alone[1:count] = alone[count + 1 : 2 * count] = 0
    alone[count, -1] = -2
    begins = np.arcsin(2 / 3)
    first = np.array([*[0.0] * 2 * count, np.sin(begins), np.cos(begins), 1.0])
    later = expm(alone * (1.3 - begins)) @ first
    found = []
    for t in times:
        state = expm(matrix * (t - 1.3)) @ later if t > 1.3 else expm(alone * max(0, t - begins)) @ first
        found.append(state[:count])
    return np.array(found)


@pytest.mark.exhaustive(keep=1.5)
@pytest.mark.parametrize("method", TOLERANCES)
@pytest.mark.parametrize("count", [2, 3, 4])
def test_a_chain_that_is_released_at_rest_is_set_in_motion_from_one_end(count: int, method: str) -> None:
    """Some blocks begin with many derivatives that are 0."""
    motion = lagrange.solve(
        CHAIN.format(count=count), stop=4, samples=21, method=method, tolerance=TOLERANCES[method]
    )
    assert motion.status == "complete"
    assert motion.q["x"] == pytest.approx(pushed_chain(count, motion.t), abs=1e-8)
    assert motion.attributes["steps"] <= 2000


@pytest.mark.parametrize("method", TOLERANCES)
def test_a_resistance_with_a_kink_acts_where_the_friction_beside_it_is_0(method: str) -> None:
    """While nothing presses on the block, x'' = -k x - c x' with another c for each direction of motion."""
    text = """
parameters: {k: 20, c1: 1, c2: 4}
coordinates: {x: {initial: 1}}
masses: {block: 1}
positions: {block: x}
potential: k*x**2/2
generalized_forces: {x: "-where(t < 2, 0, 3)*sign(x_dot) - where(x_dot > 0, c1, c2)*x_dot"}
"""
    motion = follow(text, 1.4, 57, method=method, tolerance=TOLERANCES[method])
    assert motion["q/x"] == pytest.approx(damped(motion.t), abs=1e-8)
