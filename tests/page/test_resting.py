"""Pages of systems whose bodies may rest on each other."""

from __future__ import annotations

from textwrap import dedent

import pytest

from lagrange_cli.run.request import Request
from lagrange_cli.run.view.motion import read_shown
from lagrange_cli.run.view.page import view
from tests.support.v8 import Engine

TEXT = """
coordinates: {x: {initial: 2, velocity: 1}, y: {initial: 3}}
masses: {low: 1, high: 1}
positions: {low: x, high: y}
potential: 9.81*(x + y)
events:
  floor: {when: x, direction: falling, action: {set: {x_dot: -x_dot/2}}}
  ceiling: {when: 4 - x, direction: falling, action: {set: {x_dot: -x_dot/2}}}
  OTHER
solve: {stop: 1}
"""
GROUND = "ground: {when: y, direction: falling, action: {set: {y_dot: -y_dot/2}}}"
HIT = """hit:
    when: y - x
    direction: falling
    action: {set: {x_dot: (x_dot + y_dot)/2, y_dot: (x_dot + y_dot)/2}}"""


@pytest.mark.exhaustive(keep=0.5)
@pytest.mark.parametrize(("other", "live"), [(GROUND, True), (HIT, False)])
def test_bodies_that_may_rest_on_each_other_are_replayed(other: str, live: bool) -> None:
    """A ball between two walls is not, nor two balls on one floor."""
    page = view(read_shown(dedent(TEXT).replace("OTHER", other).encode(), "balls.yaml", Request()))
    assert page.live is live and ("may rest on each other" in page.why) is not live


RESTING = """
coordinates: {x: {initial: 0}, y: {initial: 0}}
masses: {p: 1, q: 1}
positions: {p: x, q: y}
potential: x
generalized_forces: {y: "where(CONDITION, 1, 0)"}
events: {hit: {when: x, direction: falling, action: {set: {x_dot: -x_dot/2}}}}
solve: {stop: 4}
"""


@pytest.mark.exhaustive(keep=2)
@pytest.mark.parametrize(("condition", "value"), [("x > 0", 0), ("x >= 0", 1), ("x < 0", 0), ("x <= 0", 1)])
def test_what_rests_where_a_force_jumps_feels_its_value_there(condition: str, value: int) -> None:
    page = view(read_shown(RESTING.replace("CONDITION", condition).encode(), "ball.yaml", Request()))
    assert page.live
    found = Engine(page.text).end()
    assert found["v"] == [0.0, pytest.approx(4.0 * value, rel=1e-15)]
