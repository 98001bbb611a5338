"""``Residual``: the equations of motion in the implicit form that the Taylor series are solved from.

d'Alembert's principle for an embedding r_i(q, t) (Goldstein, Classical Mechanics, 3rd ed., eq. 1.45 ff.):

    R_k = sum_i (m_i r_i'' - F_i) . dr_i/dq_k + dU/dq_k - d/dt dU/dq_dot_k + dD/dq_dot_k - Q_k = 0

and Euler-Lagrange for a given L: R_k = d/dt dL/dq_dot_k - dL/dq_k + dD/dq_dot_k - Q_k = 0. The time derivatives
stay unexpanded ``ddt`` nodes: their Taylor coefficients come from those of their arguments, so
no second derivative of the embedding is ever formed. R is affine in the accelerations, with the matrix
M = dR/dq_ddot at fixed q, q_dot, t.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

from lagrange_cli.expression.graph import Graph, GraphAlgebra, Node
from lagrange_cli.model.model import Model


@dataclass(frozen=True)
class Residual:
    """The equations R(q, q_dot, q_ddot, t) = 0 of a model over the graph.

    ``residual[k]`` is R_k with ``ddt`` nodes; ``mass_matrix[j][k]`` = dR_j/dq_ddot_k in q, q_dot, t;
    ``definite`` tells that the matrix is symmetric and positive (a kinetic energy of masses).
    """

    model: Model[Node]
    graph: Graph
    residual: tuple[Node, ...]
    mass_matrix: tuple[tuple[Node, ...], ...]
    definite: bool

    @property
    def variables(self) -> int:
        """Bit set of the symbols that change along a motion: q, q_dot and t."""
        bits = self.model.time.symbols
        for symbol in (*self.model.q, *self.model.v):
            bits |= symbol.symbols
        return bits

    @property
    def blocks(self) -> tuple[tuple[int, ...], ...]:
        """Coordinates that the mass matrix couples: its block-diagonal structure."""
        return connected(self.mass_matrix)

    @property
    def constant_mass_matrix(self) -> bool:
        """Whether the mass matrix depends on nothing but parameters."""
        return all(not entry.symbols & self.variables for row in self.mass_matrix for entry in row)


class SingularCoordinate(ValueError):
    """No kinetic energy depends on the velocity of ``coordinate``."""

    def __init__(self, coordinate: str) -> None:
        self.coordinate = coordinate
        super().__init__(f"no kinetic energy depends on the velocity of '{coordinate}'")


def derive_residual(model: Model[Node]) -> Residual:
    """The equations of motion of ``model``; raises ``SingularCoordinate`` where M has a row of zeros."""
    algebra = model.algebra
    assert isinstance(algebra, GraphAlgebra)
    graph = algebra.graph
    if model.lagrangian is not None:
        residual, matrix = _from_lagrangian(model, graph)
    else:
        residual, matrix = _from_embedding(model, graph)
    residual = [
        node + graph.diff(model.dissipation, v) - force
        for node, v, force in zip(residual, model.v, model.generalized_forces)
    ]
    for name, row in zip(model.coordinates, matrix):
        if all(entry.is_zero for entry in row):
            raise SingularCoordinate(name)
    kinetic_potential = any(
        not graph.diff(graph.diff(model.potential, a), b).is_zero for a in model.v for b in model.v
    )
    return Residual(
        model=model,
        graph=graph,
        residual=tuple(residual),
        mass_matrix=tuple(tuple(row) for row in matrix),
        definite=model.lagrangian is None and not kinetic_potential,
    )


def _from_lagrangian(model: Model[Node], graph: Graph) -> tuple[list[Node], list[list[Node]]]:
    lagrangian = model.lagrangian
    assert lagrangian is not None
    momenta = [graph.diff(lagrangian, v) for v in model.v]
    residual = [graph.ddt(p) - graph.diff(lagrangian, q) for p, q in zip(momenta, model.q)]
    return residual, [[graph.diff(p, v) for v in model.v] for p in momenta]


def _from_embedding(model: Model[Node], graph: Graph) -> tuple[list[Node], list[list[Node]]]:
    variables = model.time.symbols
    for symbol in (*model.q, *model.v):
        variables |= symbol.symbols
    components = [
        (particle.mass, position, particle.force[i] if particle.force else graph.zero)
        for particle in model.particles
        for i, position in enumerate(particle.position)
    ]
    jacobian = [[graph.diff(position, q) for q in model.q] for _, position, _ in components]
    inertia = [
        (m * graph.ddt(graph.ddt(position)) if position.symbols & variables else graph.zero) - force
        for m, position, force in components
    ]
    residual = []
    for k, (q, v) in enumerate(zip(model.q, model.v)):
        terms = ((row[k], rate) for row, rate in zip(jacobian, inertia))
        residual.append(
            contract(graph, terms, variables)
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


def contract(graph: Graph, terms: Iterable[tuple[Node, Node]], variables: int) -> Node:
    """``sum a_i * b_i`` with one product for each distinct moving part of the a_i.

    A chain's dr_i/dq_k are the same for all particles beyond k, so that summing the b_i first makes one
    convolution of what would be one for each particle.
    """
    grouped: dict[Node, list[Node]] = {}
    for a, b in terms:
        if a.is_zero or b.is_zero:
            continue
        fixed, moving = graph.split_parameters(a, variables)
        grouped.setdefault(moving, []).append(fixed * b)
    return graph.sum(
        [(moving * graph.sum([(b, 1.0) for b in parts]), 1.0) for moving, parts in grouped.items()]
    )


def connected(matrix: tuple[tuple[Node, ...], ...]) -> tuple[tuple[int, ...], ...]:
    """The index sets that a matrix's nonzero entries connect, each sorted, in order of first index."""
    left = set(range(len(matrix)))
    blocks = []
    while left:
        pending, block = [min(left)], set[int]()
        while pending:
            j = pending.pop()
            if j in left:
                left.discard(j)
                block.add(j)
                pending.extend(k for k in left if not (matrix[j][k].is_zero and matrix[k][j].is_zero))
        blocks.append(tuple(sorted(block)))
    return tuple(blocks)
