"""The generalized velocities."""

from __future__ import annotations

from lagrange_cli.outputs.planner import Planner


def plan(planner: Planner) -> None:
    """q_dot, a dataset for each family of coordinates."""
    for family in planner.coordinates:
        planner.add_state("v/", f"velocity d{family.label}/dt", family)
