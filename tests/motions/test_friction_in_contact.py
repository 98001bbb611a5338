"""Bodies that dry friction and a stop hold together, against closed forms."""

from __future__ import annotations

import math
import random

import numpy as np
import pytest

from lagrange_cli.integrate.ending import Ending
from tests.support.motion import FULL, follow

AT_A_STOP = """
parameters: {{A: {A}, w: {w}, f: {f}, e: {e}}}
coordinates: {{x: {{initial: {x}}}}}
lagrangian: x_dot**2/2
generalized_forces: {{x: "A*cos(w*t) - f*sign(x_dot)"}}
events: {{stop: {{when: x, direction: rising, action: {{set: {{x_dot: "-e*x_dot"}}}}}}}}
"""


@pytest.mark.exhaustive(keep=2)
@pytest.mark.parametrize(
    ("method", "tolerance", "bound"),
    [("taylor", FULL, 1e-12), ("ias15", FULL, 1e-12), ("DOP853", 1e-12, 1e-8), ("Radau", 1e-10, 1e-7)],
)
@pytest.mark.parametrize("case", range(5))
def test_a_body_leaves_a_stop_when_the_pull_exceeds_friction(
    case: int, method: str, tolerance: float, bound: float, request: pytest.FixtureRequest
) -> None:
    """A force pushes it there, so that it comes to rest after infinitely many impacts. As the force turns
    round, the stop lets it go at A cos(w t) = f, and friction at -f: x'' = A cos(w t) + f from then on."""
    chance = random.Random(f"{request.config.option.seed} {case}")
    A, w, e = chance.uniform(1, 9), chance.uniform(0.5, 2), chance.uniform(0.1, 0.6)
    f, x = A * chance.uniform(0.05, 0.6), -chance.uniform(0.05, 0.2) * A / (20 * w * w)
    left = math.acos(-f / A) / w
    stop = left + 0.4 / w
    text = AT_A_STOP.format(A=A, w=w, f=f, e=e, x=x)
    motion = follow(text, stop, 101, method=method, tolerance=tolerance)
    assert motion.outcome.ending is Ending.COMPLETE, text
    after = np.maximum(motion.t - left, 0.0)
    t = left + after
    there = (math.cos(w * left) - np.cos(w * t)) * A / w**2 - A / w * math.sin(w * left) * after
    expected = np.where(after > 0.0, there + f * after**2 / 2, 0.0)
    held = motion.t > 0.9 * left
    assert motion["q/x"][held] == pytest.approx(expected[held], abs=bound * A / w**2), text
