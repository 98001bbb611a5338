"""Dry friction along vectors: forces with u/|u|, of velocities u that become 0 together.

Each component of u is the velocity of one coordinate, less that of what it rubs on as places and t say: a
belt, a turntable. While u is not 0, its mode is 1, and the forces have series. Where it is 0 the coordinates
are held, with mode 0, as long as what else acts on them is less than the limit of friction (see
``mechanics.guards.vectors``). With M diagonal there is nothing to solve: the acceleration of each coordinate
is what forces give where the mode is 1, and that of what it rubs on where the mode is 0. While a vector is
held, roots of its square have the value 1, so that no number is infinite.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np

from lagrange_cli.expression.graph import Graph
from lagrange_cli.expression.index_arrays import distinct
from lagrange_cli.expression.indices import Unsuited
from lagrange_cli.expression.node import Kind, Node, union
from lagrange_cli.families.arrays import Domain, Slots, Term
from lagrange_cli.families.switching.friction import rate_at_rest
from lagrange_cli.mechanics.guards.vectors import held
from lagrange_cli.mechanics.switching.lengths import Vector, bases, completed
from lagrange_cli.records import dataclass

if TYPE_CHECKING:
    from lagrange_cli.expression.index_arrays import Places
    from lagrange_cli.families.description import FamilySystem

DIRECTIONS = (
    "friction along a vector u, u/norm(u), that is not a body's own velocity, or that relative to a belt, or "
    "on chains, trees, or with constraints",
    "write it with a speed below which it fades, as in u/sqrt(dot(u, u) + v0**2)",
    "forces",
)
"""What members are written out for, and how to do without."""


@dataclass(frozen=True, eq=False)
class Along:
    """Friction along a ``vector`` of each member of a ``domain``, whose ``length`` decides its mode; the
    ``rows`` of its coordinates, of each component those of all members. Friction is the ``limit`` times a
    component, over the length, times one of ``ratios``. Components are velocities less those of ``belts``,
    whose ``rates`` the velocities have while it is held."""

    domain: Domain
    vector: Vector
    length: Node
    rows: Sequence[Places]
    limit: Node
    ratios: Sequence[Node]
    belts: Sequence[Node]
    rates: Sequence[Node]


def has_direction(slots: Slots, node: Node, speeds: Iterable[Node]) -> bool:
    """Whether an expression is divided by the length of a vector of velocities, which may become 0."""
    listed = [*speeds]
    found = bases([node], union(listed)).items()
    return any(holds and completed(slots.graph, base, listed) is not None for base, holds in found)


def along_vectors(
    system: FamilySystem, terms: Sequence[Term], moving: int
) -> Mapping[tuple[Domain, Node], Along]:
    """The friction in the ``terms`` of forces, by domains and the squares of vectors. Raises ``Unsuited``
    where it acts in another way."""
    slots, graph = system.slots, system.slots.graph
    found: dict[tuple[Domain, Node], list[tuple[Term, Vector]]] = {}
    for term in terms:
        speeds = [symbol for symbol, _ in slots.inside(term.node) if slots.moving(symbol, {system.v})]
        for base, holds in bases([term.node], union(speeds)).items():
            vector = completed(graph, base, speeds) if holds else None
            if vector is not None:
                found.setdefault((term.domain, base), []).append((term, vector))
    if found and (system.joints is not None or system.bonds is not None or system.vector is not None):
        raise Unsuited(*DIRECTIONS)
    made = {place: along(system, listed, moving) for place, listed in found.items()}
    rows = [row for one in made.values() for row in one.rows]
    if rows and len(distinct(np.concatenate(rows))) < sum(map(len, rows)):
        raise Unsuited(*DIRECTIONS)  # what holds a coordinate in two ways is not determined
    return made


def along(system: FamilySystem, listed: Sequence[tuple[Term, Vector]], moving: int) -> Along:
    """Friction along one vector in the terms that have it."""
    slots, graph, (_, vector) = system.slots, system.slots.graph, listed[0]
    own = [slots.of[pivot] for pivot in vector.pivots]
    belts = [pivot - part for part, pivot in zip(vector.parts, vector.pivots)]
    if any(one.array is not system.v for one in own) or any(slots.moving(x, {system.v}) for x in belts):
        raise Unsuited(*DIRECTIONS)
    rates = [rate_at_rest(system, -one, listed[0][0].domain) for one in belts]
    if any(one.symbols & moving for one in vector.weights):
        raise Unsuited(*DIRECTIONS)
    slopes = [graph.zero] * len(own)
    for term, _ in listed:
        targets = [i for i, slot in enumerate(own) if np.array_equal(slot.table, term.targets)]
        at_rest = held(graph, term.node, vector)
        if len(targets) != 1 or at_rest is None:
            raise Unsuited(*DIRECTIONS)
        for i, slope in enumerate(at_rest[1]):
            if i in targets:
                slopes[i] = slopes[i] + slope
            elif not slope.is_zero:
                raise Unsuited(*DIRECTIONS)
    if any(one.is_zero for one in slopes):
        raise Unsuited(*DIRECTIONS)
    ratios = [one / slopes[0] for one in slopes]
    speedy = union(symbol for one in slopes for symbol, _ in slots.inside(one))
    if any(one.symbols & moving for one in ratios) or any(
        completed(graph, base, [s for s, slot in slots.inside(base) if slots.moving(s, {system.v})])
        for base, holds in bases(slopes, speedy).items()
        if holds
    ):
        raise Unsuited(*DIRECTIONS)  # the limit depends on which way another friction acts
    length = graph.power(vector.square, graph.constant(0.5))
    rows = [one.table for one in own]
    return Along(listed[0][0].domain, vector, length, rows, -slopes[0], ratios, belts, rates)


def refuse_elsewhere(
    system: FamilySystem,
    along: Mapping[tuple[Domain, Node], Along],
    terms: Iterable[Term],
    others: Iterable[Node],
) -> None:
    """Raise ``Unsuited`` where directions are in other expressions than ``terms`` of forces along them."""
    slots = system.slots
    for term in terms:
        speeds = [symbol for symbol, _ in slots.inside(term.node) if slots.moving(symbol, {system.v})]
        for base, holds in bases([term.node], union(speeds)).items():
            known = (term.domain, base) in along
            if holds and not known and completed(slots.graph, base, speeds) is not None:
                raise Unsuited(*DIRECTIONS)
    for node in others:
        if has_direction(slots, node, (s for s, _ in slots.inside(node) if slots.moving(s, {system.v}))):
            raise Unsuited(*DIRECTIONS)


def with_lengths(
    graph: Graph,
    node: Node,
    arguments: Sequence[Node],
    domain: Domain,
    along: Mapping[tuple[Domain, Node], Along],
    mode_of: Callable[[Domain, Node], Node],
) -> Node | None:
    """A product with roots of squares of vectors, which are 1 while these are held; None if it has none."""
    if node.kind is not Kind.PRODUCT:
        return None
    changed, factors = False, list[tuple[Node, float]]()
    for base, new, exponent in zip(node.arguments, arguments, node.data):
        one = along.get((domain, base))
        if one is not None and exponent % 1.0 == 0.5:
            changed, new = True, graph.switch(mode_of(domain, one.length), new, graph.one, -1)
        factors.append((new, exponent))
    return graph.product(factors) if changed else None
