"""Contacts whose force is a power of the depth, as Hertz's, against closed forms and conservation laws."""

from __future__ import annotations

import math
import random

import numpy as np
import pytest

from lagrange_cli.integrate.ending import Ending
from tests.support.motion import follow

BALL = """
parameters: {{k: {k}, p: {p}, a: 2}}
coordinates: {{y: {{initial: {y}, velocity: {v}}}}}
masses: {{b: 1}}
embedding: {{b: y}}
potential: k/p*{power}
"""
POWERS = [
    "max(0, -y)**{p}", "where(y < 0, -y, 0)**p", "(-min(y, 0))**p", "((abs(y) - y)/2)**{p}",
    "sqrt(max(0, -y))**(2*p)", "a**p*(max(0, -y)/a)**p", "(max(0, -y)**2 + max(0, y - 9)**2)**{half}",
    "abs(min(y, 0))**{p}", "(max(0, -y) + max(0, y - 9))**{p}",
]  # fmt: skip


@pytest.fixture
def source(request: pytest.FixtureRequest) -> random.Random:
    return random.Random(request.config.option.seed)


def contact_time(k: float, p: float, v: float) -> float:
    """How long a unit mass with the speed v is in contact with U = k/p s^p: twice the integral of ds/s' up to
    the largest s (H. Hertz, J. reine angew. Math. 92, 156, 1882, for p = 5/2)."""
    deepest = (p * v * v / (2 * k)) ** (1 / p)
    return 2 * deepest / v * math.sqrt(math.pi) / p * math.gamma(1 / p) / math.gamma(1 / p + 0.5)


@pytest.mark.parametrize("power", POWERS)
def test_a_ball_is_as_long_in_contact_as_hertz_found(power: str, source: random.Random) -> None:
    k, v, p = 10 ** source.uniform(1, 5), source.uniform(0.5, 3), source.choice((2.25, 2.5, 3.3))
    text = BALL.format(k=repr(k), p=p, y=1.0, v=repr(-v), power=power.format(p=p, half=p / 2))
    stop = 2.0 / v + contact_time(k, p, v)
    motion = follow(text, stop, 3)
    assert motion.outcome.ending is Ending.COMPLETE
    rounding = 2e-14 * (1 + v) * (1 + math.sqrt(k))
    assert motion["q/y"][-1] == pytest.approx(1.0, abs=rounding)
    assert motion["v/y"][-1] == pytest.approx(v, rel=1e-13)


@pytest.mark.parametrize(("method", "bound"), [("taylor", 1e-13), ("DOP853", 1e-7), ("ias15", 1e-12)])
def test_a_motion_may_begin_with_a_touch(method: str, bound: float) -> None:
    text = BALL.format(k=300.0, p=2.5, y=0.0, v=-1.0, power="max(0, -y)**p")
    motion = follow(text, 1.0, 3, method=method, tolerance=2.0**-52 if method != "DOP853" else 1e-10)
    assert motion["q/y"][-1] == pytest.approx(1.0 - contact_time(300.0, 2.5, 1.0), abs=bound)


def test_a_ball_is_let_go_where_it_touches() -> None:
    """It bounces up to where it was; the contact ends and begins at once there."""
    text = BALL.format(k=100.0, p=2.5, y=1.0, v=0.0, power="max(0, 1 - y)**p").replace("k/p", "9.81*y + k/p")
    motion = follow(text, 3.0)
    h = motion["v/y"] ** 2 / 2 + 9.81 * motion["q/y"] + 40.0 * (1 - motion["q/y"]) ** 2.5
    assert motion.outcome.ending is Ending.COMPLETE
    assert motion["q/y"].max() <= 1.0 + 1e-14
    np.testing.assert_allclose(h, 9.81, rtol=1e-14)


def test_beads_that_touch_pass_on_a_push() -> None:
    """What is felt of it far away is below 1e-80 at first."""
    text = """
        sizes: {N: 8}
        coordinates: {"x[i in range(N)]": {initial: 0, velocity: "where(i == 0, 1, 0)"}}
        masses: {"b[i in range(N)]": 1}
        embedding: {"b[i in range(N)]": "x[i]"}
        potential: sum(40*max(0, x[i - 1] - x[i])**(5/2) for i in range(1, N))
    """
    motion, other = (follow(text, 2.0, 5, method=method) for method in ("taylor", "ias15"))
    assert motion.outcome.ending is Ending.COMPLETE
    q, v = np.array([motion[f"{part}/x"] for part in "qv"])
    np.testing.assert_allclose(v.sum(axis=1), 1.0, rtol=1e-14)
    energy = (v**2).sum(axis=1) / 2 + 40 * (np.maximum(0, q[:, :-1] - q[:, 1:]) ** 2.5).sum(axis=1)
    np.testing.assert_allclose(energy, 0.5, rtol=1e-14)
    np.testing.assert_allclose(other["q/x"], q, atol=1e-13)
    assert v[-1, -1] > 0.9
