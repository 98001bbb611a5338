"""The angular velocities of rigid bodies, in space."""

from __future__ import annotations

from lagrange_cli.outputs.planner import Planner


def plan(planner: Planner) -> None:
    """omega, a dataset for each family of bodies, its components as the last axis."""
    planner.add_vectors("angular_velocities/", "angular velocity of", "bodies", planner.bodies.spins)
