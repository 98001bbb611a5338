"""The angular momenta of rigid bodies about their centres of mass, in space."""

from __future__ import annotations

from lagrange_cli.expression.node import Node
from lagrange_cli.model.orientation import cross
from lagrange_cli.outputs.planner import Planner


def plan(planner: Planner) -> None:
    """R I R^T omega, a dataset for each family of bodies, its components as the last axis."""
    parts: dict[str, list[tuple[Node, ...]]] = {}
    for one in planner.model.particles:
        if one.body:
            momentum = cross(one.position, [one.mass * u for u in one.velocity])
            parts.setdefault(one.body, []).append(momentum)
    graph = planner.residual.graph
    found = {
        name: tuple(graph.sum([(x, 1.0) for x in several]) for several in zip(*momenta))
        for name, momenta in parts.items()
    }
    planner.add_vectors("angular_momenta/", "angular momentum of", "bodies", found)
