"""From a model to its equations of motion, in the formulation that takes the fewest convolutions.

d'Alembert's principle for an embedding r_i(q, t) (Goldstein, Classical Mechanics, 3rd ed., eq. 1.45 ff.):

    R_k = sum_i (m_i r_i'' - F_i) . dr_i/dq_k + dU/dq_k - d/dt dU/dq_dot_k + dD/dq_dot_k - Q_k = 0

or, with the kinetic energy multiplied out, d/dt dT/dq_dot_k - dT/dq_k in place of the masses' accelerations;
Euler-Lagrange for a given L: R_k = d/dt dL/dq_dot_k - dL/dq_k + dD/dq_dot_k - Q_k = 0; and for these two
Routh's reduction of the cyclic coordinates.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from functools import partial, reduce
from operator import or_
from typing import TypeVar

from lagrange_cli.errors import SingularCoordinate, Undetermined
from lagrange_cli.expression.graph import Graph
from lagrange_cli.expression.node import Node, bits
from lagrange_cli.expression.node_table import MAX_NODES
from lagrange_cli.expression.zero import independent, is_zero
from lagrange_cli.mechanics.conservation import Conserved, conservation
from lagrange_cli.mechanics.constraints import Constraints
from lagrange_cli.mechanics.energetics import Energetics
from lagrange_cli.mechanics.formulation import Formulation, euler_lagrange, gyroscopic, normalized
from lagrange_cli.mechanics.gauge import acting
from lagrange_cli.mechanics.jumps import refuse_jumps
from lagrange_cli.mechanics.reduced import reduced_kinetic_energy
from lagrange_cli.mechanics.redundancy import coupled
from lagrange_cli.mechanics.residual import Residual
from lagrange_cli.mechanics.rigidity import refuse_strain
from lagrange_cli.mechanics.routh import routh
from lagrange_cli.mechanics.rows import Row
from lagrange_cli.mechanics.saturation import saturated, saturated_rows
from lagrange_cli.mechanics.thin import refuse_idle, refuse_spinning
from lagrange_cli.mechanics.unchanging import refuse_unchanging
from lagrange_cli.mechanics.variables import contract, graph_of, nonzero, numbered, rate, variables
from lagrange_cli.mechanics.weightless import weightless
from lagrange_cli.model.model import Model, Particle
from lagrange_cli.records import replace
from lagrange_cli.series.lowering import lower
from lagrange_cli.series.program import SeriesProgram

T = TypeVar("T")

PATIENCE, LEAST_ATTEMPT = 2, 1_000_000
"""A further formulation may take so many times the steps before it, and so many in any case."""
MANY = 30
"""Coordinates from which on no formulation is derived that is known to be the same as another."""
STEPS_A_NODE = 4
"""What a new node takes at least: so a formulation that is left out leaves nodes for those that are not."""


def derive(model: Model[Node]) -> Residual:
    """The equations of motion of ``model``; raises ``SingularCoordinate`` where M has a row of zeros,
    ``InfiniteForce`` where an energy jumps, ``SpecError`` for an event that is the same at all states."""
    graph = graph_of(model)
    refuse_jumps(model)
    refuse_strain(model)
    refuse_undetermined(model)
    refuse_unchanging(model)
    cyclic, conserved = conservation(model)
    constraints = Constraints(model)
    forms = formulations(model, graph, conserved)
    first, *others = forms
    bound = {k for slopes in constraints.slopes for k in slopes}
    rows = enumerate(zip(model.coordinates, forms[first].mass_matrix))
    idle = [
        name
        for k, (name, row) in rows
        if k not in bound and all(is_zero(row[j]) for j in nonzero(row, graph.zero, k))
    ]
    if idle:
        raise SingularCoordinate(idle)
    programs = {first: lowered(model, graph, forms[first])}
    for name in others:
        program = if_affordable(graph, partial(lowered, model, graph, forms[name]))
        if program is not None:
            programs[name] = program
    costs = {name: program.convolutions for name, program in programs.items()}
    chosen = min(costs, key=lambda name: costs[name])
    velocities = numbered(model.v)
    slopes = graph.gradient(model.potential, velocities).values()
    masses = forms[chosen].mass_matrix
    pushed = uses_multipliers(model)
    written = {
        "residual": saturated_rows(
            graph, [*forms[chosen].residual, *constraints.equations], variables(model)
        ),
        "mass_matrix": constraints.bordered(masses, Energetics(model).applied if pushed else ()),
    }
    found = Residual(
        model=saturated(model),
        graph=graph,
        **{**vars(forms[chosen]), **written},
        definite=model.lagrangian is None
        and not any(graph.gradient(p, velocities) for p in slopes)
        and symmetric(masses)
        and not pushed,
        pushed=pushed,
        weightless=weightless(masses) if model.constraints else frozenset(),
        formulation=chosen,
        costs=costs,
        lowered=((*forms[chosen].residual, *constraints.equations, *model.q), programs[chosen]),
        scleronomic=scleronomic(model),
        cyclic=cyclic,
        conserved=conserved,
    )
    refuse_idle(model)
    refuse_spinning(found)
    return replace(found, quiet=derive(without_multipliers(model))) if found.bent else found


def refuse_undetermined(model: Model[Node]) -> None:
    """Raise ``Undetermined`` where forces or events use multipliers that are not unique."""
    if not model.redundant:
        return
    nodes = [*forces_of(model), *(event.argument for event in model.events)]
    constraints = [*model.constraints, *model.redundant]
    rows = Constraints(replace(model, constraints=tuple(constraints))).slopes
    count = len(model.constraints)
    for mine, others in coupled(rows[:count], rows[count:]):
        for one in (constraints[i] for i in (*mine, *(count + j for j in others))):
            if any(node.symbols & one.multiplier.symbols for node in nodes):
                raise Undetermined(one.name)


def forces_of(model: Model[Node]) -> list[Node]:
    """All that acts besides L."""
    return [*model.generalized_forces, model.dissipation, *(x for p in model.particles for x in p.force)]


def without_multipliers(model: Model[Node]) -> Model[Node]:
    """The model without forces that depend on multipliers of constraints."""
    zero = graph_of(model).zero
    bits = reduce(or_, (one.multiplier.symbols for one in model.constraints), 0)

    def kept(force: Node) -> Node:
        return zero if force.symbols & bits else force

    return replace(
        model,
        generalized_forces=tuple(map(kept, model.generalized_forces)),
        dissipation=kept(model.dissipation),
        particles=tuple(replace(one, force=tuple(map(kept, one.force))) for one in model.particles),
    )


def uses_multipliers(model: Model[Node]) -> bool:
    """Whether forces depend on multipliers of constraints."""
    bits = reduce(or_, (one.multiplier.symbols for one in model.constraints), 0)
    return any(force.symbols & bits for force in forces_of(model))


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

        routh = any(each.quantity.startswith("p_") for each in conserved)
        if len(model.q) <= MANY or routh or not is_cartesian(model):
            if_affordable(graph, add)
    return forms


def is_cartesian(model: Model[Node]) -> bool:
    """Whether the coordinates are the masses' places, and U does not depend on velocities: T is as short as
    can be, and Euler and Lagrange's equations are the embedding's."""
    velocities = reduce(or_, (v.symbols for v in model.v), 0)
    positions = {x for particle in model.particles for x in particle.position}
    return positions <= {*model.q} and not model.potential.symbols & velocities


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
    lagrangian = acting(model, graph, lagrangian)
    residual, matrix = euler_lagrange(model, graph, lagrangian, forces)
    forms[base] = normalized(model, residual, matrix)
    other = if_affordable(graph, lambda: gyroscopic(model, graph, lagrangian, residual))
    if other is not None:
        forms["gyroscopic forces"] = normalized(model, other, matrix)
    if model.constraints:
        return
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


def lowered(model: Model[Node], graph: Graph, form: Formulation) -> SeriesProgram:
    """The series that a formulation takes."""
    constraints = Constraints(model)
    rows = (*form.residual, *constraints.equations)
    given = variables(model), model.q, model.v, model.time, rows, (), constraints.multipliers
    return lower(graph, *given)


def symmetric(matrix: Sequence[Sequence[Node]]) -> bool:
    """Whether a matrix is its own transpose; where a coordinate has been eliminated it may not be."""
    places = ((j, k) for j, row in enumerate(matrix) for k in nonzero(row, row[j].graph.zero, j))
    return all(matrix[j][k] is matrix[k][j] for j, k in places)


def scleronomic(model: Model[Node]) -> bool:
    """Whether the embedding (or the given L) and the constraints are free of explicit time."""
    return not depending_on_time(model)


def depending_on_time(model: Model[Node]) -> tuple[str, ...]:
    """Which of ``L``, ``positions``, ``orientations`` and ``constraints`` depend on time explicitly."""
    given = {
        "L": [model.lagrangian] if model.lagrangian is not None else [],
        "positions": [x for particle in model.particles for x in particle.position if not particle.body],
        "orientations": [x for particle in model.particles for x in particle.position if particle.body],
        "constraints": [one.expression for one in model.constraints],
    }
    graph = graph_of(model)
    return tuple(name for name, nodes in given.items() if not independent(graph, nodes, model.time))
