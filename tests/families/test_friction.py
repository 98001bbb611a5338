"""Families with dry friction that stay families, beside the same systems written out and closed forms."""

from __future__ import annotations

import pytest

from tests.families.test_switches import LEDGERS, compare

BLOCKS = """
sizes: {{N: {count}}}
parameters: {{k: 2, V: 0.7, F: 0.6, c: 0.2, "w[i in range(N)]": "0.3*(-1)**i"}}
coordinates: {{"x[i in range(N)]": {{initial: "{start}", velocity: "{speed}"}}}}
masses: {{"block[i in range(N)]": 1 + i/7}}
embedding: {{"block[i in range(N)]": "x[i]"}}
potential: sum((x[i] - V*t)**2/2 for i in range(N)) + sum(k*(x[i] - x[i - 1])**2/2 for i in range(1, N))
generalized_forces:
  "x[i in range(N)]": "{force}"
"""
MOVING = "0.5*sin(i + 1)", "cos(i*i + 1)"
CASES = {
    "blocks that are driven": "-F*sign(x_dot[i])",
    "and damped": "-F*sign(x_dot[i]) - c*x_dot[i]",
    "with a limit that depends on places": "-(F + c*x[i]**2 + c*x[(i + 1) % N]**2)*sign(x_dot[i])",
    "with less friction in motion": "-F*sign(x_dot[i])/(1 + c*abs(x_dot[i]))",
    "unlike in both directions": "where(x_dot[i] > 0, -F, F/2)",
    "on belts": "-F*sign(x_dot[i] - w[i])",
    "for some of them": "where(i % 2 == 0, -F*sign(x_dot[i]), -c*x_dot[i])",
    "in two parts": "-F*sign(x_dot[i])/2 - F*sign(2*x_dot[i])/3",
    "that grows at a time": "-where(t < 1.1, F, 2*F)*sign(x_dot[i])",
    "beside a push that begins at a time": "-F*sign(x_dot[i]) + where(t < 2.1, 0, 1)",
    "beside stops": "-F*sign(x_dot[i]) - 9*max(0, x[i] - 1)",
}


def blocks(count: int, force: str, start: str = MOVING[0], speed: str = MOVING[1]) -> str:
    """The text of a system file."""
    return BLOCKS.format(count=count, force=force, start=start, speed=speed)


@pytest.mark.exhaustive(keep=6)
@pytest.mark.parametrize("count", [1, 2, 3, 8, 9])
@pytest.mark.parametrize("case", CASES)
def test_friction_is_that_of_the_members(case: str, count: int, monkeypatch: pytest.MonkeyPatch) -> None:
    compare(blocks(count, CASES[case]), monkeypatch, stop=4.0)


@pytest.mark.exhaustive(keep=2)
@pytest.mark.parametrize("case", CASES)
def test_blocks_may_begin_at_rest(case: str, monkeypatch: pytest.MonkeyPatch) -> None:
    compare(blocks(9, CASES[case], speed="0"), monkeypatch, LEDGERS, stop=3.0)
