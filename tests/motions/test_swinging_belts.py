"""Pucks on belts that swing, which stick and are set sliding again: few steps with every method, and the
motion of an integration that treats each of these phases by itself."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

from lagrange_cli.integrate.ending import Ending
from tests.support.motion import follow

Array = NDArray[np.float64]
BELTS = {
    "stops along its rate": (0.414, 51.061, 5.293, (0.385, 2.64, 0.0), (0.836, 4.334, 5.974),
                             (-0.156, 0.151, 0.104, -0.434)),
    "stops soon": (0.928, 30.208, 6.995, (0.2346, 2.777, 4.151), (0.3128, 2.777, 5.722),
                   (-0.199, -0.013, -0.302, -0.006)),
    "begins at rest": (1.222, 21.607, 3.543, (0.2922, 6.053, 5.794), (0.3896, 6.053, 7.365),
                       (0.287, 0.409, 0.0, 0.0)),
}  # fmt: skip
"""Mass, spring, friction; amplitude, frequency and phase of the belt's velocity along x (a cosine) and along
y (a sine); places and velocities."""
STEPS = {
    ("taylor", 2.0**-52): 400, ("ias15", 2.0**-52): 1600, ("DOP853", 1e-9): 500, ("DOP853", 1e-12): 1200,
    ("Radau", 1e-9): 1600,
}  # fmt: skip
"""The most steps. (With some of these methods there were 1,000 to 900,000, or no end.)"""
BEGINS = 1e-7
"""The time after which what begins to slide is followed on its way."""


def text_of(case: str) -> str:
    m, k, limit, (a, w, c), (b, o, d), (x, y, u, v) = BELTS[case]
    slip = f"(x_dot - {a}*cos({w}*t + {c}), y_dot - {b}*sin({o}*t + {d}))"
    return f"""
coordinates: {{x: {{initial: {x}, velocity: {u}}}, y: {{initial: {y}, velocity: {v}}}}}
masses: {{puck: {m}}}
positions: {{puck: [x, y]}}
potential: {k}*(x**2 + y**2)/2
forces: {{puck: "-{limit}/norm({slip})*{slip}"}}
"""


TIMES = np.linspace(0.0, 2.0, 41)


@cache
def in_phases(case: str) -> Array:
    """Coordinates at the samples: sliding until the velocity relative to the belt is 0, then on the belt
    until its force and that of the spring exceed friction, and so on."""
    times = TIMES
    m, k, limit, (a, w, c), (b, o, d), start = BELTS[case]

    def belt(t: float) -> Array:
        return np.array([a * np.cos(w * t + c), b * np.sin(o * t + d)])

    def place(t: float) -> Array:
        return np.array([a / w * np.sin(w * t + c), -b / o * np.cos(o * t + d)])

    def excess(t: float, q: Array, since: float) -> float:
        rate = np.array([-a * w * np.sin(w * t + c), b * o * np.cos(o * t + d)])
        pull = m * rate + k * (q + place(t) - place(since))
        return float(np.linalg.norm(pull)) - limit

    def sliding(t: float, s: Array) -> Array:
        slip = s[2:] - belt(t)
        return np.concatenate([s[2:], (-k * s[:2] - limit * slip / np.linalg.norm(slip)) / m])

    def slow(t: float, s: Array) -> float:
        return float(np.linalg.norm(s[2:] - belt(t))) - 1e-9

    slow.terminal, slow.direction = True, -1.0  # type: ignore[attr-defined]
    t, s, found = 0.0, np.array(start), np.full((2, len(times)), np.nan)
    while t < times[-1]:
        way = solve_ivp(
            sliding, (t, times[-1]), s, method="Radau", rtol=1e-11, atol=1e-13, events=slow, dense_output=True
        )
        within = (times >= t) & (times <= way.t[-1])
        found[:, within] = way.sol(times[within])[:2]
        t, q = float(way.t[-1]), way.y[:2, -1]
        if t >= times[-1]:
            break
        grid = np.linspace(t, times[-1], 4001)
        loose = next((n for n, one in enumerate(grid) if excess(one, q, t) > 0.0), len(grid) - 1)
        end = float(times[-1])
        if excess(grid[loose], q, t) > 0.0:
            end = brentq(lambda one: excess(one, q, t), grid[loose - 1], grid[loose], xtol=1e-14)  # noqa: B023
        within = (times >= t) & (times <= end)
        found[:, within] = np.array([q + place(one) - place(t) for one in times[within]]).T
        q = q + place(end) - place(t)
        pull = -k * q - m * np.array([-a * w * np.sin(w * end + c), b * o * np.cos(o * end + d)])
        t = end + BEGINS
        s = np.concatenate([q + belt(end) * BEGINS, belt(t) + pull / limit * 2e-9])
    return found


@pytest.mark.exhaustive(keep=2)
@pytest.mark.parametrize(("method", "tolerance"), STEPS)
@pytest.mark.parametrize("case", BELTS)
def test_a_puck_that_sticks_and_slides(case: str, method: str, tolerance: float) -> None:
    motion = follow(text_of(case), 2.0, 41, method=method, tolerance=tolerance)
    assert motion.outcome.ending is Ending.COMPLETE
    assert motion.outcome.steps < STEPS[method, tolerance]
    x, y = in_phases(case)
    for name, expected in (("q/x", x), ("q/y", y)):
        assert np.max(np.abs(motion[name] - expected)) < 1e-6
