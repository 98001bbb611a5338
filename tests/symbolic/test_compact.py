"""Rates of change as products of powers."""

from __future__ import annotations

import pytest

from lagrange_cli.run.equations import as_written, derive
from tests.support.motion import spec_of

CARS = """
parameters: {m: 1, k: 4, c: 0.3}
coordinates: {x: {initial: 1}, y: {initial: 0}}
masses: {a: m, b: m}
positions: {a: [x], b: [y]}
potential: k*x**2/2
dissipation: c*(x_dot - y_dot)**2/2
"""
APART = CARS.replace("(x_dot - y_dot)**2/2", "(x_dot**2 + 3*y_dot**2)/2")
BALL = """
parameters: {m: 1, g: 9.81, c: 0.05}
coordinates: {x: {initial: 0}, y: {initial: 0}}
masses: {ball: m}
positions: {ball: [x, y]}
potential: m*g*ball.y
forces: {ball: "-c*norm((ball.vx, ball.vy))*(ball.vx, ball.vy)"}
"""


@pytest.mark.parametrize(
    ("text", "line"),
    [
        (CARS, "dh/dt = -c*(x_dot - y_dot)**2\n"),
        (APART, "dh/dt = -c*x_dot**2 - 3*c*y_dot**2\n"),
        (BALL, "dh/dt = -c*(x_dot**2 + y_dot**2)**(3/2)\n"),
    ],
    ids=["relative velocity", "no power", "drag"],
)  # fmt: skip
def test_the_power_of_friction_reads_as_in_a_textbook(text: str, line: str) -> None:
    assert line in as_written(derive(spec_of(text)), "text", "lagrange", {})


PRODUCTS = """
parameters: {m: 1, a: 1, b: 2}
coordinates: {x: {initial: 0}, y: {initial: 1}}
masses: {bob: m}
positions: {bob: [x, y]}
potential: x**2/2 + (x - a)*(y - b)*(x - b) + (x + y)*(x - y)
events:
  between: (x - a)*(x - b)
  close: {when: (x - y)*(x_dot - y_dot), action: {set: {y_dot: (x - a)*(y_dot - b)}}}
"""


@pytest.mark.exhaustive(keep=0.55)
@pytest.mark.parametrize(
    "line",
    [
        "U = 3*x**2/2 - y**2 + (x - a)*(x - b)*(y - b)",
        "(x - a)*(x - b) = 0",
        "(x - y)*(x_dot - y_dot) = 0",
        "close, in either direction: y_dot -> (x - a)*(y_dot - b)",
    ],
)
def test_products_of_sums_are_written_out_only_where_that_is_shorter(line: str) -> None:
    assert f"  {line}\n" in as_written(derive(spec_of(PRODUCTS)), "text", "lagrange", {}) + "\n"
