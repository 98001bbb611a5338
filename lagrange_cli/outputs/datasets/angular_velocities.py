"""The angular velocities of rigid bodies, in space."""

from __future__ import annotations

from lagrange_cli.model.scope import Scope
from lagrange_cli.outputs.planner import Planner


def plan(planner: Planner) -> None:
    """omega, a dataset for each family of bodies, its components as the last axis."""
    assert planner.model.spec is not None
    scope = Scope(planner.model.spec, planner.model.algebra)
    found = {name: scope.turning(name).in_space for name in planner.model.spec.bodies}
    planner.add_vectors("angular_velocities/", "angular velocity of", "bodies", found)
