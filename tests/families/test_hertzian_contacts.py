"""Bodies side by side that push each other with powers of their overlaps, by methods without series."""

from __future__ import annotations

import random

import numpy as np
import pytest

from lagrange_cli.integrate.ending import Ending
from tests.support.families import alike, followed

GRAINS = """
sizes: {{N: {count}}}
parameters: {{k: {k!r}, e: {exponent!r}}}
coordinates:
  x[i in range(N)]: {{initial: 1.0*i, velocity: "where(i == 0, 1, 0)"}}
lagrangian: >-
  sum((1 + i % 3/4)*x_dot[i]**2/2 for i in range(N))
  - sum(k/e*max(0, 1 - (x[i+1] - x[i]))**e for i in range(N - 1))
"""
"""A wave goes through grains that touch; behind it, they separate one by one."""
CRADLE = """
sizes: {{N: {count}}}
parameters: {{m: 0.1, g: 9.81, l: 0.2, d: {d!r}, k: 1e7}}
coordinates: {{"a[i in range(N)]": {{initial: "where(i == 0, -0.3, 0)"}}}}
masses: {{"ball[i in range(N)]": m}}
positions: {{"ball[i in range(N)]": ["d*i + l*sin(a[i])", "-l*cos(a[i])"]}}
potential: >-
  sum(m*g*ball[i].y for i in range(N))
  + sum(2*k/5*max(0, d - norm(ball[i] - ball[i - 1]))**(5/2) for i in range(1, N))
"""
METHODS = {"ias15": (2.0**-52, 1e-9, 10000), "DOP853": (1e-10, 1e-6, 10000), "Radau": (1e-10, 1e-6, 20000)}
"""The tolerance, how far they may be from motions by series, and the most steps."""


@pytest.mark.exhaustive(keep=0.5)
@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("exponent", [2.5, 2.0, 2.25, 3.25])
def test_grains_that_separate(exponent: float, method: str, request: pytest.FixtureRequest) -> None:
    """A step that leads beyond where grains part finds no force there."""
    chance = random.Random(request.config.option.seed)
    given = {"count": chance.randint(20, 60), "k": chance.uniform(500, 2000), "exponent": exponent}
    text, outputs = GRAINS.format(**given), frozenset(["q", "h"])
    tolerance, apart, most = METHODS[method]
    ready, motion = followed(text, outputs, stop=2.0, method=method, tolerance=tolerance)
    assert ready.machine.program.loops
    _, expected = followed(text, outputs, stop=2.0)
    alike(motion.data, expected.data, apart, text)
    assert motion.outcome.steps < most, text


@pytest.mark.parametrize(
    ("count", "k", "exponent"), [(22, 1143.333582012672, 1.75), (60, 634.7821382266156, 2.25)]
)
def test_a_trial_without_a_force_leaves_nothing_behind(count: int, k: float, exponent: float) -> None:
    """Where these grains separated, the polynomials of a trial that found no force there were continued, and
    no step was possible any more."""
    text, outputs = GRAINS.format(count=count, k=k, exponent=exponent), frozenset(["q", "h"])
    _, motion = followed(text, outputs, stop=2.0, method="ias15")
    _, expected = followed(text, outputs, stop=2.0)
    assert motion.outcome.ending is Ending.COMPLETE
    alike(motion.data, expected.data, 1e-9, text)


@pytest.mark.exhaustive(keep=0.5)
@pytest.mark.parametrize("method", ["DOP853", "Radau"])
def test_balls_in_a_row_begin_at_rest(method: str, request: pytest.FixtureRequest) -> None:
    """Their places are rounded the more coarsely the farther away they are, and so are their overlaps."""
    chance = random.Random(request.config.option.seed)
    text = CRADLE.format(count=chance.randint(20, 90), d=chance.uniform(0.01, 0.1))
    outputs = frozenset(["q", "h"])
    ready, motion = followed(text, outputs, stop=0.22, samples=12, method=method, tolerance=1e-10)
    assert ready.machine.program.loops and motion.outcome.steps < 200, text
    angles = motion["q/a"]
    before = motion["t"] < 0.2
    assert np.max(np.abs(angles[before, 1:])) < 1e-12, text
    assert np.ptp(motion["diagnostics/h"]) < 1e-9
