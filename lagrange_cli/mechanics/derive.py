"""From a system to its equations of motion; see ``residual`` for what they are."""

from __future__ import annotations

from lagrange_cli.errors import LagrangeError
from lagrange_cli.expression.graph import Graph, GraphAlgebra, Node
from lagrange_cli.mechanics.conservation import conservation, is_zero
from lagrange_cli.mechanics.residual import Residual
from lagrange_cli.mechanics.variables import contract, graph_of, variables
from lagrange_cli.model.model import Model


class SingularCoordinate(LagrangeError):
    """No kinetic energy depends on the velocity of ``coordinate``."""

    def __init__(self, coordinate: str) -> None:
        self.coordinate = coordinate
        super().__init__(f"no kinetic energy depends on the velocity of '{coordinate}'")


def derive(model: Model[Node]) -> Residual:
    """The equations of motion of ``model``; raises ``SingularCoordinate`` where M has a row of zeros."""
    graph = graph_of(model)
    if model.lagrangian is not None:
        residual, matrix = _from_lagrangian(model, graph)
    else:
        residual, matrix = _from_embedding(model, graph)
    residual = [
        node + graph.diff(model.dissipation, v) - force
        for node, v, force in zip(residual, model.v, model.generalized_forces)
    ]
    for name, row in zip(model.coordinates, matrix):
        if all(is_zero(entry) for entry in row):
            raise SingularCoordinate(name)
    kinetic_potential = any(
        not graph.diff(graph.diff(model.potential, a), b).is_zero for a in model.v for b in model.v
    )
    cyclic, conserved = conservation(model)
    return Residual(
        model=model,
        graph=graph,
        residual=tuple(residual),
        mass_matrix=tuple(tuple(row) for row in matrix),
        definite=model.lagrangian is None and not kinetic_potential,
        scleronomic=scleronomic(model),
        cyclic=cyclic,
        conserved=conserved,
    )


def scleronomic(model: Model[Node]) -> bool:
    """Whether the embedding (or the given L) is free of explicit time."""
    graph = graph_of(model)
    given = [model.lagrangian] if model.lagrangian is not None else []
    positions = [x for particle in model.particles for x in particle.position]
    return all(is_zero(graph.diff(node, model.time)) for node in (*given, *positions))


def _from_lagrangian(model: Model[Node], graph: Graph) -> tuple[list[Node], list[list[Node]]]:
    lagrangian = model.lagrangian
    assert lagrangian is not None
    momenta = [graph.diff(lagrangian, v) for v in model.v]
    residual = [graph.ddt(p) - graph.diff(lagrangian, q) for p, q in zip(momenta, model.q)]
    return residual, [[graph.diff(p, v) for v in model.v] for p in momenta]


def _from_embedding(model: Model[Node], graph: Graph) -> tuple[list[Node], list[list[Node]]]:
    moving = variables(model)
    components = [
        (particle.mass, position, particle.force[i] if particle.force else graph.zero)
        for particle in model.particles
        for i, position in enumerate(particle.position)
    ]
    jacobian = [[graph.diff(position, q) for q in model.q] for _, position, _ in components]
    inertia = [
        (m * graph.ddt(graph.ddt(position)) if position.symbols & moving else graph.zero) - force
        for m, position, force in components
    ]
    residual = []
    for k, (q, v) in enumerate(zip(model.q, model.v)):
        terms = ((row[k], rate) for row, rate in zip(jacobian, inertia))
        residual.append(
            contract(graph, terms, moving)
            + graph.diff(model.potential, q)
            - graph.ddt(graph.diff(model.potential, v))
        )
    size = len(model.q)
    matrix = [[graph.zero] * size for _ in range(size)]
    for j in range(size):
        for k in range(j, size):
            entry = graph.sum(
                [(m * row[j] * row[k], 1.0) for (m, _, _), row in zip(components, jacobian)]
                + [(graph.diff(graph.diff(model.potential, model.v[j]), model.v[k]), -1.0)]
            )
            matrix[j][k] = matrix[k][j] = entry
    return residual, matrix
