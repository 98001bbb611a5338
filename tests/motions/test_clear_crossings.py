"""What is said of events is so with every method: of clear zeros, multiple ones, and actions."""

from __future__ import annotations

import math
import random

import pytest

from lagrange_cli.integrate.events import Happened
from tests.support.motion import follow

METHODS = pytest.mark.parametrize(
    ("method", "tolerance"), [("taylor", 2.0**-52), ("ias15", 2.0**-52), ("DOP853", 1e-12), ("Radau", 1e-10)]
)
FALL = """
coordinates: {{y: {{initial: {height!r}}}}}
lagrangian: y_dot**2/2 - {g!r}*y
events: {{floor: {{when: {when}{action}}}}}
"""


@pytest.fixture
def source(request: pytest.FixtureRequest) -> random.Random:
    return random.Random(request.config.option.seed)


def happened(method: str, tolerance: float, **given: object) -> Happened:
    motion = follow(FALL.format(**given), 2.0, 3, method=method, tolerance=tolerance)
    return motion.outcome.happened["floor"]


@pytest.mark.exhaustive(keep=1)
@METHODS
@pytest.mark.parametrize(
    "action", ["", ", direction: falling", ", direction: falling, action: {set: {y_dot: -0.9*y_dot}}"]
)
def test_what_falls_from_rest_crosses_clearly(
    method: str, tolerance: float, action: str, source: random.Random
) -> None:
    """It has no speed where the step begins that ends at the floor, and a clear one at its end."""
    height, g = source.uniform(0.5, 2), source.uniform(1, 10)
    found = happened(method, tolerance, height=height, g=g, when="y", action=action)
    assert found.count >= 1
    assert found.grazes is None and found.blurred is None


@pytest.mark.exhaustive(keep=1)
@pytest.mark.parametrize("method", ["taylor", "ias15"])
def test_a_threefold_zero_is_said_to_be_one(method: str, source: random.Random) -> None:
    """The polynomials of the other methods do not tell it from others. Within the rounding errors of the
    expression, that of ``ias15`` may cross 0 more than once."""
    height, g, c = source.uniform(1, 2), source.uniform(1, 10), source.uniform(0.2, 0.8)
    when = f"sin(y - {c!r}) - (y - {c!r})"
    found = happened(method, 2.0**-52, height=height, g=g, when=when, action="")
    assert found.count == 1 if method == "taylor" else found.count % 2 == 1
    assert found.blurred == pytest.approx(math.sqrt(2 * (height - c) / g), rel=1e-3)


@pytest.mark.exhaustive(keep=0.45)
@pytest.mark.parametrize("method", ["ias15", "DOP853", "Radau"])
def test_actions_are_no_narrow_forces(method: str) -> None:
    """Reflections along a normal that is divided by its square, in a circular room; and narrow forces are."""
    room = """
definitions: {towards: 2*(x*x_dot + y*y_dot)/(x**2 + y**2)}
coordinates: {x: {initial: 0, velocity: 1}, y: {initial: 0.3, velocity: 0.5}}
events:
  wall:
    when: 1 - x**2 - y**2
    direction: falling
    action: {set: {x_dot: x_dot - towards*x, y_dot: y_dot - towards*y}}
"""
    free, pushed = (
        follow(f"{room}lagrangian: (x_dot**2 + y_dot**2)/2 - {u}", 9.0, 3, method=method, tolerance=1e-10)
        for u in ("y", "exp(-10**4*(x**2 + y**2 - 0.25)**2)")  # Radau does not miss what is straight
    )
    assert free.outcome.happened["wall"].count > 3
    assert free.outcome.undetected == () and pushed.outcome.undetected == ("narrow",)
