"""Hamilton's action."""

from __future__ import annotations

from lagrange_cli.outputs.planner import Planner


def plan(planner: Planner) -> None:
    """int L dt from the start."""
    planner.add_integral("diagnostics/action", "action int L dt", planner.energetics.lagrangian)
