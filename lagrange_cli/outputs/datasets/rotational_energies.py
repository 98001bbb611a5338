"""The kinetic energies of rigid bodies' rotation."""

from __future__ import annotations

from lagrange_cli.expression.node import Node
from lagrange_cli.outputs.planner import Planner


def plan(planner: Planner) -> None:
    """omega . I omega/2, a dataset for each family of bodies."""
    parts: dict[str, list[tuple[Node, float]]] = {}
    for one in planner.model.particles:
        if one.body:
            parts.setdefault(one.body, []).extend((one.mass * u * u, 0.5) for u in one.velocity)
    for family in planner.families("bodies", parts):
        names = tuple(
            planner.observe(f"rotational energy of {name}", planner.residual.graph.sum(parts[name]))
            for name in family.members
        )
        text = f"kinetic energy of the rotation of {family.label}"
        planner.add_family("rotational_energies/", text, family, names)
