"""From a model to its equations of motion, in the formulation that takes the fewest convolutions.

d'Alembert's principle for an embedding r_i(q, t) (Goldstein, Classical Mechanics, 3rd ed., eq. 1.45 ff.):

    R_k = sum_i (m_i r_i'' - F_i) . dr_i/dq_k + dU/dq_k - d/dt dU/dq_dot_k + dD/dq_dot_k - Q_k = 0

or, with the kinetic energy multiplied out, d/dt dT/dq_dot_k - dT/dq_k in place of the masses' accelerations;
Euler-Lagrange for a given L: R_k = d/dt dL/dq_dot_k - dL/dq_k + dD/dq_dot_k - Q_k = 0; and for these two
Routh's reduction of the cyclic coordinates.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from functools import partial
from typing import TypeVar

from lagrange_cli.errors import SingularCoordinate
from lagrange_cli.expression.graph import Graph
from lagrange_cli.expression.node import Node, bits
from lagrange_cli.expression.normal_forms import MAX_NODES
from lagrange_cli.expression.zero import independent, is_zero
from lagrange_cli.mechanics.conservation import Conserved, conservation
from lagrange_cli.mechanics.energetics import Energetics
from lagrange_cli.mechanics.formulation import Formulation, euler_lagrange, gyroscopic, normalized, rate
from lagrange_cli.mechanics.jumps import refuse_jumps
from lagrange_cli.mechanics.reduced import reduced_kinetic_energy
from lagrange_cli.mechanics.residual import Residual
from lagrange_cli.mechanics.routh import routh
from lagrange_cli.mechanics.saturation import saturated, saturated_rows
from lagrange_cli.mechanics.variables import contract, graph_of, numbered, variables
from lagrange_cli.model.model import Model
from lagrange_cli.series.lowering import lower

T = TypeVar("T")

PATIENCE, LEAST_ATTEMPT = 2, 1_000_000
"""A further formulation may take so many times the steps before it, and so many in any case."""
STEPS_A_NODE = 4
"""What a new node takes at least: so a formulation that is left out leaves nodes for those that are not."""


def derive(model: Model[Node]) -> Residual:
    """The equations of motion of ``model``; raises ``SingularCoordinate`` where M has a row of zeros,
    ``InfiniteForce`` where an energy jumps."""
    graph = graph_of(model)
    refuse_jumps(model)
    cyclic, conserved = conservation(model)
    forms = formulations(model, graph, conserved)
    first, *others = forms
    for name, row in zip(model.coordinates, forms[first].mass_matrix):
        if all(is_zero(entry) for entry in row if entry is not graph.zero):
            raise SingularCoordinate(name)
    costs = {first: convolutions(model, graph, forms[first])}
    for name in others:
        cost = if_affordable(graph, partial(convolutions, model, graph, forms[name]))
        if cost is not None:
            costs[name] = cost
    chosen = min(costs, key=lambda name: costs[name])
    velocities = numbered(model.v)
    slopes = graph.gradient(model.potential, velocities).values()
    rows = saturated_rows(graph, forms[chosen].residual, variables(model))
    return Residual(
        model=saturated(model),
        graph=graph,
        **{**vars(forms[chosen]), "residual": rows},
        definite=model.lagrangian is None
        and not any(graph.gradient(p, velocities) for p in slopes)
        and symmetric(forms[chosen].mass_matrix),
        formulation=chosen,
        costs=costs,
        scleronomic=scleronomic(model),
        cyclic=cyclic,
        conserved=conserved,
    )


def formulations(model: Model[Node], graph: Graph, conserved: Iterable[Conserved]) -> dict[str, Formulation]:
    """The candidates by name, each with all forces; of two that cost the same the earlier one is simpler.

    The first one is always there. Another is left out where it takes far more work, as where sums multiply.
    """
    forms: dict[str, Formulation] = {}
    if model.lagrangian is not None:
        add_energetic(forms, model, graph, "lagrangian", model.lagrangian, conserved)
    else:
        forms["embedding"] = from_embedding(model, graph)

        def add() -> None:
            kinetic = reduced_kinetic_energy(model)
            if kinetic is not None:
                name = "kinetic energy"
                add_energetic(forms, model, graph, name, kinetic - model.potential, conserved)

        if_affordable(graph, add)
    return forms


def add_energetic(
    forms: dict[str, Formulation],
    model: Model[Node],
    graph: Graph,
    base: str,
    lagrangian: Node,
    conserved: Iterable[Conserved],
) -> None:
    """Add to ``forms`` those that follow from L: Euler and Lagrange's, called ``base``, and its variants."""
    forces = Energetics(model).forces
    residual, matrix = euler_lagrange(model, graph, lagrangian, forces)
    forms[base] = normalized(graph, residual, matrix, variables(model))
    other = if_affordable(graph, lambda: gyroscopic(model, graph, lagrangian, residual))
    if other is not None:
        forms["gyroscopic forces"] = normalized(graph, other, matrix, variables(model))
    names = {each.quantity for each in conserved}
    steady = {k for k, name in enumerate(model.coordinates) if f"p_{name}" in names}
    reduced = if_affordable(graph, lambda: routh(model, graph, lagrangian, forces, matrix, steady))
    if reduced is not None:
        forms["Routh"] = reduced


def if_affordable(graph: Graph, function: Callable[[], T]) -> T | None:
    """What ``function`` returns, or None where it takes far more work than all that has been done so far."""
    room = STEPS_A_NODE * (MAX_NODES - len(graph.nodes))
    return graph.work.attempt(min(PATIENCE * graph.work.spent + LEAST_ATTEMPT, room), function)


def from_embedding(model: Model[Node], graph: Graph) -> Formulation:
    """d'Alembert's form; M = sum m dr/dq dr/dq - d2U/dq_dot dq_dot."""
    moving = variables(model)
    components = [
        (particle.mass, position, particle.force[i] if particle.force else graph.zero)
        for particle in model.particles
        for i, position in enumerate(particle.position)
    ]
    coordinates = numbered(model.q)
    jacobian = [graph.gradient(position, coordinates) for _, position, _ in components]
    inertia = [
        (m * rate(graph, graph.ddt(x), moving) if x.symbols & moving else graph.zero) - force
        for m, x, force in components
    ]
    columns: list[list[tuple[Node, Node]]] = [[] for _ in model.q]
    for row, change in zip(jacobian, inertia):
        for k, slope in row.items():
            columns[k].append((slope, change))
    residual = []
    for q, v, terms, given in zip(model.q, model.v, columns, model.generalized_forces):
        momentum = graph.diff(model.potential, v)
        residual.append(
            contract(graph, terms, moving)
            + graph.diff(model.potential, q)
            - rate(graph, momentum, moving)
            + graph.diff(model.dissipation, v)
            - given
        )
    matrix = mass_matrix(model, graph, [m for m, _, _ in components], jacobian)
    return normalized(graph, residual, matrix, moving)


def mass_matrix(
    model: Model[Node], graph: Graph, masses: list[Node], jacobian: list[dict[int, Node]]
) -> tuple[tuple[Node, ...], ...]:
    """M_jk = sum_i m_i dr_i/dq_j dr_i/dq_k - d2U/dq_dot_j dq_dot_k, one product for each distinct pair
    of slopes.

    Which components have a slope is kept as a bit set, and so is which coordinates meet in them: in a chain
    any two coordinates meet in many components, all with the same pair of slopes.
    """
    columns: list[dict[Node, int]] = [{} for _ in model.q]
    met = [0] * len(model.q)
    for i, row in enumerate(jacobian):
        here = sum(1 << k for k in row)
        for k, slope in row.items():
            columns[k][slope] = columns[k].get(slope, 0) | 1 << i
            met[k] |= here
    carried: dict[int, Node] = {}

    def mass_of(components: int) -> Node:
        if components not in carried:
            carried[components] = graph.sum([(masses[i], 1.0) for i in bits(components)])
        return carried[components]

    matrix, velocities = [[graph.zero] * len(model.q) for _ in model.q], numbered(model.v)
    for j, mine in enumerate(columns):
        potential = graph.gradient(graph.diff(model.potential, model.v[j]), velocities)
        for k in bits(met[j] | sum(1 << k for k in potential)):
            if k < j:
                continue
            terms = [
                (graph.product([(x, 1), (y, 1), (mass_of(both), 1)]), 1.0)
                for x, having in mine.items()
                for y, other in columns[k].items()
                if (both := having & other)
            ]
            matrix[j][k] = graph.sum([*terms, (potential.get(k, graph.zero), -1.0)])
            matrix[k][j] = matrix[j][k]
    return tuple(map(tuple, matrix))


def convolutions(model: Model[Node], graph: Graph, form: Formulation) -> int:
    """Convolutions per order that a formulation takes."""
    return lower(graph, variables(model), model.q, model.v, model.time, form.residual, ()).convolutions


def symmetric(matrix: Sequence[Sequence[Node]]) -> bool:
    """Whether a matrix is its own transpose; where a coordinate has been eliminated it may not be."""
    return all(entry is matrix[k][j] for j, row in enumerate(matrix) for k, entry in enumerate(row[:j]))


def scleronomic(model: Model[Node]) -> bool:
    """Whether the embedding (or the given L) is free of explicit time."""
    given = [model.lagrangian] if model.lagrangian is not None else []
    positions = [x for particle in model.particles for x in particle.position]
    return independent(graph_of(model), [*given, *positions], model.time)
