"""The particles' positions in space."""

from __future__ import annotations

from lagrange_cli.outputs.planner import Planner


def plan(planner: Planner) -> None:
    """r(q, t), a dataset for each family of particles, its components as the last axis."""
    positions = {one.name: one.position for one in planner.model.particles if not one.body}
    planner.add_vectors("positions/", "position of", "embedding", positions)
