"""The angular momenta of rigid bodies about their centres of mass, in space."""

from __future__ import annotations

from lagrange_cli.outputs.planner import Planner


def plan(planner: Planner) -> None:
    """R I R^T omega, a dataset for each family of bodies, its components as the last axis."""
    planner.add_vectors("angular_momenta/", "angular momentum of", "bodies", planner.bodies.momenta)
