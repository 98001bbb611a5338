"""The coordinates."""

from __future__ import annotations

from lagrange_cli.outputs.planner import Planner


def plan(planner: Planner) -> None:
    """q, a dataset for each family."""
    for family in planner.coordinates:
        planner.add_state("q/", f"coordinate {family.label}", family)
