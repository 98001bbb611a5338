"""Coordinates that move many particles, such as that of a cart which pendulums hang from.

What they move is made a node of a tree, from which the particles hang: then M couples each particle to it
alone, and is factored in time that grows with their number.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING, TypeAlias

import numpy as np

from lagrange_cli.expression.node import Kind, Node
from lagrange_cli.families.arrays import NONE, Domain, Slot, Term, Total, Tree
from lagrange_cli.families.builder import FamilyBuilder
from lagrange_cli.mechanics.substitution import substituted

if TYPE_CHECKING:
    from numpy.typing import NDArray

Weight: TypeAlias = tuple[Domain, Node, Node]
Flags: TypeAlias = "NDArray[np.bool_]"
FEWEST = 8
"""Components of places that a coordinate of many is in."""


def on_carriages(builder: FamilyBuilder, weights: Sequence[Weight]) -> list[Weight]:
    """The components of places and the masses, with a node in place of what such coordinates move; what they
    are if there are none, or where they do not stand apart in sums."""
    rows = shared(builder, weights)
    parted = [split(builder, x, rows) for _, x, _ in weights]
    if not rows.any() or any(one is None for one in parted):
        return [*weights]
    nodes: dict[Node, Total] = {}
    found = []
    for (domain, x, mass), one in zip(weights, parted):
        base, rest = one or (builder.graph.zero, x)
        if not base.is_zero:
            factor, base = builder.graph.split_coefficient(at_root(builder, base))
            if base not in nodes:
                alone = Tree(np.array([NONE]), np.array([0]))
                terms = [Term(builder.root, base, np.zeros(1, dtype=np.int64))]
                nodes[base] = builder.added(1, terms, alone)
            place = np.zeros(domain.count, dtype=np.int64)
            rest += factor * builder.slots.symbol(domain, nodes[base], place)
        found.append((domain, rest, mass))
    return found


def shared(builder: FamilyBuilder, weights: Sequence[Weight]) -> Flags:
    """Which coordinates are each in many components, and of all members in these; none where particles are on
    chains already."""
    counts, apart = np.zeros(builder.q.count, dtype=np.int64), np.zeros(builder.q.count, dtype=bool)
    for domain, x, _ in weights:
        for _, slot in builder.slots.inside(x):
            if isinstance(slot.array, Total):
                return np.zeros(builder.q.count, dtype=bool)
            if slot.array is builder.q:
                if same(slot):
                    counts[slot.table[0]] += domain.count
                elif domain.count > 1:
                    apart[slot.table] = True
    return (counts >= FEWEST) & ~apart


def same(slot: Slot) -> bool:
    """Whether all members have the same number."""
    return len(slot.table) > 0 and bool(np.all(slot.table == slot.table[0]))


def split(builder: FamilyBuilder, x: Node, rows: Flags) -> tuple[Node, Node] | None:
    """A component as a sum of what shared coordinates alone move, and of the rest; None if there is no such
    sum."""
    graph, base, rest = builder.graph, [], []
    for term, factor in terms_of(x):
        moving = [slot for _, slot in builder.slots.inside(term) if slot.array is builder.q]
        carried = [bool(rows[slot.table].any()) for slot in moving]
        if any(carried):
            inside = [slot for _, slot in builder.slots.inside(term)]
            if not all(carried) or term.symbols & builder.time.symbols or not all(map(same, inside)):
                return None
            base.append((term, factor))
        else:
            rest.append((term, factor))
    return graph.sum(base), graph.sum(rest)


def terms_of(x: Node) -> Iterator[tuple[Node, float]]:
    """The terms of a sum, with their factors."""
    if x.kind is not Kind.SUM:
        yield x, 1.0
        return
    constant, coefficients = x.data
    yield from zip(x.arguments, coefficients)
    yield x.graph.one, constant


def at_root(builder: FamilyBuilder, node: Node) -> Node:
    """What is the same for all members, of none of them."""
    slots = builder.slots
    values = {s: slots.symbol(builder.root, one.array, one.table[:1]) for s, one in slots.inside(node)}
    return substituted(builder.graph, [node], values)[0]
