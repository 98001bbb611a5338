"""Constraints with constant coefficients, solved for some of the coordinates before any motion is followed.

A holonomic constraint sum_k a_k q_k + c(t) = 0 gives one coordinate in terms of the others. A constraint on
velocities sum_k a_k q_dot_k + b = 0 with constant b does so up to a constant of the motion. Put into L, the
forces, and all else, these leave the equations of the other coordinates, without multipliers. With
q = N q' + c(t) their mass matrix is N^T M N: smaller, and positive where M is. (M. Benzi, G. H. Golub and J.
Liesen, Acta Numerica 14, 2005, sec. 6, call this a null space method.) The multipliers follow from the
equations of the coordinates that are gone,

    sum_i lambda_i a_ik = d/dt dL/dq_dot_k - dL/dq_k - Q_k.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from functools import cached_property

from lagrange_cli.expression.graph import Graph
from lagrange_cli.expression.node import Kind, Node, union
from lagrange_cli.mechanics.derive import equations_of
from lagrange_cli.mechanics.elimination.relations import LinearRelation, LinearRelations, relations_of
from lagrange_cli.mechanics.energetics import Energetics
from lagrange_cli.mechanics.residual import Dependent, Residual
from lagrange_cli.mechanics.substitution import rewritten, substituted
from lagrange_cli.mechanics.switching.saturation import released
from lagrange_cli.mechanics.variables import graph_of, rate
from lagrange_cli.model.model import Event, Model, Particle
from lagrange_cli.records import dataclass, replace


@dataclass(frozen=True)
class Elimination:
    """The equations ``before`` and ``after`` coordinates were eliminated, and the ``relations`` of these to
    others."""

    before: Residual
    after: Residual
    relations: Mapping[int, LinearRelation]

    @property
    def longest(self) -> int:
        """The number of coordinates in the longest constraint that is gone."""
        return max(one.length for one in self.relations.values())

    @cached_property
    def multipliers(self) -> Mapping[Node, Node]:
        """The multipliers that are gone, from the equations of the coordinates that are."""
        graph, given = self.before.graph, self.before.model.constraints
        gone = [one.constraint for one in self.relations.values()]
        free = {given[i].multiplier: graph.zero for i in gone}
        rows = substituted(graph, [self.before.residual[k] for k in self.relations], free)
        terms: dict[int, list[tuple[Node, float]]] = {i: [] for i in gone}
        for row, one in zip(rows, self.relations.values()):
            for i, weight in one.weights.items():
                terms[i].append((row * weight, -1.0))
        return {given[i].multiplier: graph.sum(some) for i, some in terms.items()}

    def of(self, nodes: Iterable[Node]) -> tuple[Node, ...]:
        """Functions of the motion, with time derivatives in them, in terms of what is left."""
        after = self.after
        known = {one.v: one.speed for one in after.dependent}
        known |= {one.q: one.place for one in after.dependent if one.place is not None}
        nodes = substituted(after.graph, nodes, self.multipliers)
        return followed(after.graph, nodes, known, after.variables)


def followed(
    graph: Graph, nodes: Sequence[Node], known: Mapping[Node, Node], moving: int
) -> tuple[Node, ...]:
    """``nodes`` with expressions in place of symbols, also where they are derived by t."""

    def change(node: Node, arguments: list[Node]) -> Node | None:
        derived = node.kind is Kind.DDT and arguments[0] is not node.arguments[0]
        return rate(graph, arguments[0], moving) if derived else None

    return rewritten(graph, nodes, change, dict(known))


def eliminated(residual: Residual, most: int) -> Elimination | None:
    """The equations without the coordinates that constraints give, each in terms of fewer than ``most``
    others; None if there are none.

    What acts by its multiplier stays, and so does what is redundant. Nothing is eliminated where constraints
    follow from others in turn.
    """
    if not residual.model.constraints or residual.surplus:
        return None
    model = released(residual.model)
    acting: set[int] = set()
    while True:
        relations = relations_of(model, residual, frozenset(acting), most)
        if not relations.found:
            return None
        dependent, places = dependents(model, relations)
        less = without(model, relations, places)
        after = replace(equations_of(less), lowered=None, dependent=dependent, contacts=residual.contacts)
        seen = union(acting_nodes(after))
        counting = {k for k, constant in places.constants.items() if constant.symbols & seen}
        if not counting:
            break
        acting |= counting
    return Elimination(residual, after, relations.found)


@dataclass(frozen=True)
class Substitutions:
    """All coordinates and velocities that are gone, as functions of the others, of t, and of ``constants`` of
    the motion, by coordinate."""

    values: Mapping[Node, Node]
    constants: Mapping[int, Node]


def dependents(model: Model[Node], relations: LinearRelations) -> tuple[tuple[Dependent, ...], Substitutions]:
    """The coordinates that are gone, and what is put in their places."""
    graph, found = graph_of(model), list[Dependent]()
    values, constants = dict[Node, Node](), dict[int, Node]()
    for k, one in sorted(relations.found.items()):
        q, v, name = model.q[k], model.v[k], model.coordinates[k]
        drift = graph.diff(one.rest, model.time) if one.holonomic else one.rest
        speed = graph.sum([(drift, 1.0), *((a * model.v[i], 1.0) for i, a in one.scales.items())])
        moved = graph.sum([(a * model.q[i], 1.0) for i, a in one.scales.items()])
        if one.holonomic:
            values[q] = moved + one.rest
        else:
            constants[k] = graph.symbol(f"constant {name}")
            values[q] = moved + one.rest * model.time + constants[k]
        values[v] = speed
        place = values[q] if one.holonomic else None
        found.append(Dependent(name, model.constraints[one.constraint].name, k, q, v, place, speed))
    return tuple(found), Substitutions(values, constants)


def without(model: Model[Node], relations: LinearRelations, places: Substitutions) -> Model[Node]:
    """The model of the other coordinates."""
    graph, values, gone = graph_of(model), places.values, relations.found

    def each(nodes: Iterable[Node]) -> tuple[Node, ...]:
        return substituted(graph, nodes, values)

    def particle(one: Particle[Node]) -> Particle[Node]:
        return replace(one, position=each(one.position), velocity=each(one.velocity), force=each(one.force))

    given = each(model.generalized_forces)
    forces = [[(force, 1.0)] for force in given]
    for k, one in gone.items():
        for i, scale in one.scales.items():
            forces[i].append((scale * given[k], 1.0))
    kept = [k for k in range(len(model.q)) if k not in gone]
    bound = {one.constraint for one in gone.values()}
    potential, dissipation = each([model.potential, model.dissipation])
    return replace(
        model,
        coordinates=tuple(model.coordinates[k] for k in kept),
        q=tuple(model.q[k] for k in kept),
        v=tuple(model.v[k] for k in kept),
        particles=tuple(map(particle, model.particles)),
        potential=potential,
        lagrangian=None if model.lagrangian is None else each([model.lagrangian])[0],
        generalized_forces=tuple(graph.sum(forces[k]) for k in kept),
        dissipation=dissipation,
        observables={},
        events=tuple(event_of(one, each([one.argument])[0]) for one in model.events),
        edges=each(model.edges),
        constraints=tuple(
            replace(one, expression=each([one.expression])[0])
            for i, one in enumerate(model.constraints)
            if i not in bound
        ),
        redundant=(),
        spec=None,
    )


def event_of(event: Event[Node], argument: Node) -> Event[Node]:
    """The event as the equations see it: what it sets is done outside of them."""
    return replace(event, argument=argument, changes={})


def acting_nodes(residual: Residual) -> Iterable[Node]:
    """All that steps evaluate."""
    model = residual.model
    yield from residual.residual
    for row in residual.entries:
        yield from row.values()
    yield from residual.inertias
    for one in residual.cyclic_momenta:
        yield from (one.momentum, one.speed)
    yield from (event.argument for event in model.events)
    yield from (one.expression for one in model.constraints)
    yield from Energetics(model).momenta if model.constraints else ()
