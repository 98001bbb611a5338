"""Zeros that an event's expression touches are no crossings; where rounding decides, they are two or none."""

from __future__ import annotations

import math
import random

import numpy as np
import pytest
from numpy.typing import NDArray

from lagrange_cli.integrate.ending import Ending
from tests.support.motion import Motion, follow

METHODS = pytest.mark.parametrize(
    ("method", "tolerance"), [("taylor", 2.0**-52), ("ias15", 2.0**-52), ("DOP853", 1e-12), ("Radau", 1e-10)]
)
EACH = 3
"""Draws in a test."""
STOP = 6.0
OSCILLATOR = """
parameters: {{a: {a!r}, b: {b!r}}}
coordinates: {{x: {{initial: 0, velocity: 1}}}}
lagrangian: (x_dot**2 - x**2)/2
events: {{crossing: {{when: {when!r}, direction: {direction}}}}}
"""
TOUCHED = "(x - a)**{even}", "abs(x - a)**{any}", "(x**2 - 2*a*x + a**2)**{any}", "(1 - cos(x - a))**{any}"
OTHER = "(x - b)", "(x - b)**3", "sin(x - b)", "(x - b)*(x + 2)**3", "(x**3 - b**3)"
FLAT = {
    "a polynomial": "x**3 + (2 - 2*a)*x**2 + (a**2 - 4*a)*x + 2*a**2",
    "an exponential": "exp(x - a) - 1 - (x - a)",
    "with a speed": "x_dot**2 - (1 - a**2) - 2*a*(a - x)",
    "a logarithm": "x - a - 2*log(1 + (x - a)/2)",
}
"""Expressions with a double zero at x = a that no factor shows."""
FLATTER = "sin(x - a) - (x - a)", "cosh(x - a) - 1 - (x - a)**2/2"
"""Those with a triple and a fourfold one, which rounding blurs to within 1e-5 and 1e-3."""


@pytest.fixture
def source(request: pytest.FixtureRequest) -> random.Random:
    return random.Random(request.config.option.seed)


def zeros(b: float) -> list[float]:
    """When x = sin t is b."""
    return [math.asin(b), math.pi - math.asin(b)]


def apart(source: random.Random) -> tuple[float, float]:
    """Two places, a and b."""
    a = source.uniform(0.2, 0.8)
    return a, source.choice([one for one in (a - 0.15, a + 0.15) if 0.1 < one < 0.9])


def crossings(motion: Motion) -> NDArray[np.float64]:
    return motion.data.get("events/crossing/t", np.zeros(0))


def parities(times: NDArray[np.float64], a: float) -> list[int]:
    """Whether the numbers of times at which x = sin t is a are even (0) or odd (1); there are no others."""
    beside = [np.count_nonzero(np.abs(times - t) < 0.05) for t in zeros(a)]
    assert sum(beside) == len(times)
    return [count % 2 for count in beside]


@pytest.mark.exhaustive(keep=2)
@METHODS
@pytest.mark.parametrize("other", OTHER)
@pytest.mark.parametrize("touched", TOUCHED)
def test_factors_that_are_never_negative_change_no_sign(
    touched: str, other: str, method: str, tolerance: float, source: random.Random
) -> None:
    """Whatever else there is, and however it is scaled; nor does rounding."""
    a, b = apart(source)
    scale = source.choice((-1, 1)) * 10.0 ** source.uniform(-20, 20)
    touched = touched.format(even=source.choice((2, 4, 6)), any=source.choice((1, 2, 3)))
    when = f"{scale!r}*{touched}*{other}"
    text = OSCILLATOR.format(a=a, b=b, when=when, direction="either")
    motion = follow(text, STOP, 3, method=method, tolerance=tolerance)
    assert crossings(motion) == pytest.approx(zeros(b), abs=1e-9 if method == "Radau" else 1e-11)
    assert motion.outcome.happened["crossing"].grazes is None


@pytest.mark.exhaustive(keep=0.5)
@METHODS
@pytest.mark.parametrize("when", TOUCHED)
def test_what_only_touches_0_does_not_happen(
    when: str, method: str, tolerance: float, source: random.Random
) -> None:
    a, b = apart(source)
    text = OSCILLATOR.format(a=a, b=b, when=when.format(even=2, any=1), direction="either")
    motion = follow(text, STOP, 3, method=method, tolerance=tolerance)
    assert motion.outcome.ending is Ending.COMPLETE
    assert not len(crossings(motion)) and motion.outcome.happened["crossing"].grazes is None


@pytest.mark.exhaustive(keep=2)
@METHODS
@pytest.mark.parametrize("when", FLAT.values(), ids=FLAT)
def test_where_rounding_crosses_0_it_comes_back(
    when: str, method: str, tolerance: float, source: random.Random
) -> None:
    """Once in either direction, or not at all."""
    for _ in range(EACH):
        a, b = apart(source)
        scaled = f"{source.choice((-1, 1)) * 10.0 ** source.uniform(-9, 9)!r}*({when})"
        text = OSCILLATOR.format(a=a, b=b, when=scaled, direction="either")
        motion = follow(text, STOP, 3, method=method, tolerance=tolerance)
        times = crossings(motion)
        assert motion.outcome.ending is Ending.COMPLETE
        assert parities(times, a) == [0, 0], (a, scaled, times)


@pytest.mark.exhaustive(keep=1)
@METHODS
@pytest.mark.parametrize("when", FLATTER)
def test_crossings_of_flat_zeros_agree_with_the_signs_beside_them(
    when: str, method: str, tolerance: float, source: random.Random
) -> None:
    """Also where polynomials of long steps have missed one: what cannot jump has been 0."""
    for _ in range(EACH):
        a, b = apart(source)
        text = OSCILLATOR.format(a=a, b=b, when=when, direction="either")
        motion = follow(text, STOP, 3, method=method, tolerance=tolerance)
        assert motion.outcome.ending is Ending.COMPLETE
        assert parities(crossings(motion), a) == [int("sin" in when)] * 2, a


@pytest.mark.exhaustive(keep=0.5)
@pytest.mark.parametrize("when", FLAT.values(), ids=FLAT)
def test_there_are_as_many_crossings_in_either_direction(when: str, source: random.Random) -> None:
    a, b = apart(source)
    counts = [
        len(crossings(follow(OSCILLATOR.format(a=a, b=b, when=when, direction=one), STOP, 3)))
        for one in ("rising", "falling", "either")
    ]
    assert counts[0] == counts[1] and sum(counts) == 2 * counts[2]
