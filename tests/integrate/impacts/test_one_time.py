"""Events at one time all happen, once each and in the file's order, whatever rounding makes the first one."""

from __future__ import annotations

import random

import pytest

import lagrange_cli as lagrange

METHODS = "taylor", "ias15", "DOP853"
SEEDS = range(4)
STANDSTILL = """
parameters: {mu: 0.3, a: 1}
coordinates: {x: {initial: 0, velocity: 0.7}, y: {initial: 0}, z: {initial: 0}}
masses: {p: 1, q: 1, r: 1}
positions: {p: [x], q: [y], r: [z]}
potential: x**2/20
generalized_forces: {x: -mu*sign(x_dot)}
events:
  u: {when: x_dot, action: {set: {y: y + 1}}}
  v: {when: a*x_dot, action: {set: {z: 2*z + y}}}
  w: x_dot
"""
WALLS = """
parameters: {c: 1, k: 1}
coordinates: {x: {initial: 0, velocity: c}, y: {initial: 0, velocity: c*k}, z: {initial: 0}}
masses: {p: 1, q: 1, r: 1}
positions: {p: [x], q: [y], r: [z]}
potential: 0
events:
"""
TURNS = "  u: {when: x - 1, direction: rising, action: {set: {y_dot: -y_dot}}}\n"
COUNTS = "  v: {when: y - k, direction: rising, action: {set: {z: z + 1}}}\n"
COMES_BACK = "  v: {when: y - k, direction: falling, action: {set: {z: z + 1}}}\n"
IMPACT = "  v: {when: y - k, direction: rising, action: {set: {y_dot: -y_dot/2}}}\n"


def numbers(motion):
    return {k[:-2]: len(motion.events[k]) for k in sorted(motion.events) if k.endswith("/t")}


@pytest.mark.exhaustive(keep=0.5)
@pytest.mark.parametrize("seed", SEEDS)
@pytest.mark.parametrize("method", METHODS)
def test_everything_that_happens_as_friction_stops_a_body_happens(method, seed):
    draw = random.Random(seed)
    values = {"mu": draw.uniform(0.2, 0.9), "x_dot": draw.uniform(0.2, 1.0), "a": draw.uniform(0.5, 2.0)}
    motion = lagrange.solve(STANDSTILL, stop=5, samples=3, set=values, method=method)
    assert numbers(motion) == {"u": 1, "v": 1, "w": 1}
    assert (motion.q["y"][-1], motion.q["z"][-1]) == (1.0, 1.0)


@pytest.mark.exhaustive(keep=0.3)
@pytest.mark.parametrize("seed", SEEDS)
@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize(
    ("events", "expected", "z", "speed"),
    [
        (TURNS + COUNTS, {"u": 1, "v": 1}, 1.0, -1.0),
        (COUNTS + TURNS, {"u": 1, "v": 1}, 1.0, -1.0),
        (TURNS + COMES_BACK, {"u": 1, "v": 0}, 0.0, -1.0),
        (COMES_BACK + TURNS, {"u": 1, "v": 0}, 0.0, -1.0),
        (TURNS + IMPACT, {"u": 1, "v": 0}, 0.0, -1.0),
        (IMPACT + TURNS, {"u": 1, "v": 0}, 0.0, -1.0),
    ],
)
def test_an_action_may_turn_what_another_event_waits_for(events, expected, z, speed, method, seed):
    draw = random.Random(seed)
    values = {"c": draw.uniform(0.2, 0.9), "k": draw.uniform(0.5, 2.0)}
    motion = lagrange.solve(WALLS + events, stop=1.5 / values["c"], samples=3, set=values, method=method)
    assert numbers(motion) == expected
    assert motion.q["z"][-1] == z
    assert motion.v["y"][-1] == pytest.approx(speed * values["c"] * values["k"], rel=1e-12)
