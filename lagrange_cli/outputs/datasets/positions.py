"""The particles' positions in space."""

from __future__ import annotations

from lagrange_cli.outputs.planner import Planner

AXES = "xyz"


def plan(planner: Planner) -> None:
    """r(q, t), a dataset for each family of particles, its components as the last axis."""
    positions = {particle.name: particle.position for particle in planner.model.particles}
    for family in planner.families("embedding", positions):
        names = tuple(
            planner.observe(f"{name}.{axis}", x)
            for name in family.members
            for axis, x in zip(AXES, positions[name])
        )
        components = len(positions[family.members[0]])
        planner.add_family("positions/", f"position of {family.label}", family, names, components)
