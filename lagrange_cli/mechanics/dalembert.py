"""d'Alembert's principle for an embedding r_i(q, t) (Goldstein, Classical Mechanics, 3rd ed., eq. 1.45 ff.):

R_k = sum_i (m_i r_i'' - F_i) . dr_i/dq_k + dU/dq_k - d/dt dU/dq_dot_k + dD/dq_dot_k - Q_k = 0
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from lagrange_cli.expression.graph import Graph
from lagrange_cli.expression.node import Node, bits
from lagrange_cli.mechanics.constraints import Constraints
from lagrange_cli.mechanics.formulation import Formulation, normalized
from lagrange_cli.mechanics.gauge import acting
from lagrange_cli.mechanics.rows import Row
from lagrange_cli.mechanics.variables import contract, numbered, rate, variables
from lagrange_cli.model.model import Model, Particle


def from_embedding(model: Model[Node], graph: Graph) -> Formulation:
    """d'Alembert's form; M = sum m dr/dq dr/dq - d2U/dq_dot dq_dot."""
    moving = variables(model)
    components = [
        (particle, position, particle.force[i] if particle.force else graph.zero)
        for particle in model.particles
        for i, position in enumerate(particle.position)
    ]
    coordinates = numbered(model.q)
    jacobian = [graph.gradient(position, coordinates) for _, position, _ in components]
    inertia = [
        (one.mass * rate(graph, graph.ddt(x), moving) if x.symbols & moving else graph.zero) - force
        for one, x, force in components
    ]
    columns: list[list[tuple[Node, Node]]] = [[] for _ in model.q]
    for row, change in zip(jacobian, inertia):
        for k, slope in row.items():
            columns[k].append((slope, change))
    residual = []
    bound_forces = Constraints(model).forces
    potential = acting(model, graph, model.potential)
    for q, v, terms, given, bound in zip(model.q, model.v, columns, model.generalized_forces, bound_forces):
        momentum = graph.diff(potential, v)
        residual.append(
            contract(graph, terms, moving)
            + graph.diff(potential, q)
            - rate(graph, momentum, moving)
            + graph.diff(model.dissipation, v)
            - given
            - bound
        )
    matrix = mass_matrix(model, graph, [one for one, _, _ in components], jacobian)
    return normalized(model, residual, matrix)


def mass_matrix(
    model: Model[Node], graph: Graph, carriers: Sequence[Particle[Node]], jacobian: list[dict[int, Node]]
) -> list[Row]:
    """M_jk = sum_i m_i dr_i/dq_j dr_i/dq_k - d2U/dq_dot_j dq_dot_k, one product for each distinct pair
    of slopes. ``carriers`` are the particles whose components have a row of the ``jacobian`` each.

    Which components have a slope is kept as a bit set, and so is which coordinates meet in them: in a chain
    any two coordinates meet in many components, all with the same pair of slopes. There the masses are added
    up; but those that stand for the rotation of a body stay apart. Rounded, their sums are other masses than
    those of the residual: M would be off by the same factor in every step, and the energy of a body that
    turns would drift.
    """
    columns: list[dict[Node, int]] = [{} for _ in model.q]
    met = [0] * len(model.q)
    for i, row in enumerate(jacobian):
        here = sum(1 << k for k in row)
        for k, slope in row.items():
            columns[k][slope] = columns[k].get(slope, 0) | 1 << i
            met[k] |= here
    turning: dict[Node, int] = {}
    for i, one in enumerate(carriers):
        if one.body:
            turning[one.mass] = turning.get(one.mass, 0) | 1 << i
    apart = [*turning.values()]
    along = (1 << len(carriers)) - 1 - sum(apart)
    carried: dict[int, Node] = {}

    def masses_of(components: int) -> Iterator[Node]:
        for some in filter(None, (components & part for part in (along, *apart))):
            if some not in carried:
                carried[some] = graph.sum([(carriers[i].mass, 1.0) for i in bits(some)])
            yield carried[some]

    velocities = numbered(model.v)
    matrix: list[dict[int, Node]] = [{} for _ in model.q]
    for j, mine in enumerate(columns):
        potential = graph.gradient(graph.diff(model.potential, model.v[j]), velocities)
        beyond = [k for k in bits(met[j] | sum(1 << k for k in potential)) if k >= j]
        graph.work.charge(len(beyond), f"a mass matrix of {len(model.q)} coordinates")
        for k in beyond:
            terms = [
                (graph.product([(x, 1), (y, 1), (mass, 1)]), 1.0)
                for x, having in mine.items()
                for y, other in columns[k].items()
                for mass in masses_of(having & other)
            ]
            matrix[j][k] = graph.sum([*terms, (potential.get(k, graph.zero), -1.0)])
            matrix[k][j] = matrix[j][k]
    return [Row(row, len(model.q), graph.zero) for row in matrix]
