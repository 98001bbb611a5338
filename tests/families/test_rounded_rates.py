"""Large systems whose rates are rounded: steps of ias15 do not become shorter with more members."""

from __future__ import annotations

import pytest

from tests.support.families import followed

OSCILLATORS = """
coordinates: {"u[i in range(N)]": {initial: 0.3*i**2}}
lagrangian: sum(u_dot[i]**2/2 for i in range(N)) + sum(cos(u[i] - u[j])/N for i in range(N) for j in range(i))
generalized_forces: {"u[i in range(N)]": sin(5*i) - 0.2*u_dot[i]}
"""
ROPE = """
coordinates: {"u[i in range(N)]": {initial: 0.9*i + 0.01*sin(i)}}
lagrangian: sum(u_dot[i]**2/2 for i in range(N)) - sum(50*(u[i] - u[i - 1] - 1)**2 for i in range(1, N))
dissipation: sum(0.3*(u_dot[i] - u_dot[i - 1])**2/2 for i in range(1, N))
"""


@pytest.mark.exhaustive(keep=0.45)
@pytest.mark.parametrize(("text", "most"), [(OSCILLATORS, 12), (ROPE, 50)])
def test_steps_from_rest_do_not_become_shorter_with_more_members(text: str, most: int) -> None:
    """Places of 1e3 to 1e5 are rounded, so that no step is as precise as small accelerations ask."""
    for count in (60, 700):
        ready, motion = followed(f"sizes: {{N: {count}}}{text}", frozenset(["q"]), method="ias15", samples=2)
        assert ready.machine.program.loops and motion.outcome.steps <= most, (count, motion.outcome.steps)
