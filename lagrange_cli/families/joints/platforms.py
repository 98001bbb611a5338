"""Several chains that hang from what the same coordinates move: a cart, or places of a body that turns.

The chains are made one tree. Its first node is the platform: its coordinates are those that move several
nodes, and its components are all the places, its *mounts*, from which chains hang. A chain goes on with the
components of its own mount. So each coordinate moves one node again. What does not turn has one mount.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from typing import TYPE_CHECKING, TypeAlias

import numpy as np

from lagrange_cli.expression.index_arrays import Places
from lagrange_cli.expression.indices import Unsuited
from lagrange_cli.expression.node import Node
from lagrange_cli.families.arrays import NONE, Chain, Domain, Term, Total, equal, merged, placed, tree_of
from lagrange_cli.families.builder import FamilyBuilder
from lagrange_cli.families.chains import ChainBuilder, Moved
from lagrange_cli.families.joints.articulation import constant_total, places_of
from lagrange_cli.families.joints.carriages import at_root, terms_of
from lagrange_cli.records import dataclass
from lagrange_cli.spec.spec import Spec

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Flags: TypeAlias = NDArray[np.bool_]

MOST = 12
"""Components of a platform: a chain takes them all along."""
FEWEST = 24
"""Coordinates for each of several mounts below which members are written out: where both take as long."""


@dataclass(frozen=True, eq=False)
class Strand:
    """``chains`` of the same members, one for each axis (None: it has none along this), behind ``first``
    others in the tree of all, and the ``parents`` of its members."""

    chains: tuple[Chain | None, ...]
    first: int
    parents: Places


def put_on_platforms(builder: ChainBuilder, spec: Spec) -> None:
    """Chains that share coordinates are one tree from here on. Raises ``Unsuited`` where none do, or in other
    ways."""
    strands = [*strands_of(builder, [place for _, place, _ in places_of(builder, spec)])]
    count = 1 + sum(len(one.parents) for one in strands)
    rows = shared(builder, strands, count)
    if not rows.any():
        raise Unsuited
    bases, steps, mounts, parents = hung(builder, strands, rows, count)
    axes = max(len(one.chains) for one in strands)
    if axes * len(bases) > MOST or (len(bases) > 1 and builder.q.count < FEWEST * len(bases)):
        raise Unsuited
    start, tree = np.zeros(1, dtype=np.int64), tree_of(parents)
    needed = {*builder.slots.made_of(one.node for listed in steps for one in listed)}
    builder.restart(total for total in builder.totals if all(term.node in needed for term in total.terms))
    trees: dict[tuple[int, int], Total] = {}
    for mount, base in enumerate(bases):
        for axis in range(axes):
            terms = [
                Term(domain, placed(builder.slots, one.node, domain, which), one.targets[which])
                for one in steps[axis]
                if len(which := np.flatnonzero(mounts[one.targets] == mount))
                for domain in (Domain(len(which)),)
            ]
            terms = [Term(builder.root, base[axis], start), *merged(builder.slots, terms)]
            trees[mount, axis] = builder.added(count, terms, tree)
    for strand in strands:
        own = np.arange(strand.first, strand.first + len(strand.parents))
        for axis, chain in enumerate(strand.chains):
            if chain is not None:
                builder.move(chain, Moved([trees[k, axis] for k in range(len(bases))], mounts[own], own))


def strands_of(builder: FamilyBuilder, places: Iterable[tuple[Node, ...]]) -> Iterator[Strand]:
    """The chains that ``places`` are on, those of one place together."""
    found: dict[tuple[Chain | None, ...], None] = {}
    for place in places:
        on = tuple(chain_of(builder, x) for x in place)
        if any(one is not None for one in on):
            found[on] = None
    chains = [one for on in found for one in on if one is not None]
    if len({*chains}) < len(chains):
        raise Unsuited
    first = 1
    for on in found:
        trees = [one.tree.parents for one in on if one is not None and one.tree is not None]
        if not all(equal(one, trees[0]) for one in trees):
            raise Unsuited
        yield Strand(on, first, trees[0])
        first += len(trees[0])


def chain_of(builder: FamilyBuilder, x: Node) -> Chain | None:
    """The chain that a component of a place is on, if any."""
    found = [
        (symbol, slot.array)
        for symbol, slot in builder.slots.inside(x)
        if isinstance(slot.array, Chain) and not constant_total(builder, slot.array)
    ]
    added = [one for symbol, one in found if not builder.graph.diff(x, symbol).symbols & symbol.symbols]
    if len(added) > 1:
        raise Unsuited
    return added[0] if added else None


def steps_of(strand: Strand) -> Iterator[tuple[int, Term]]:
    """What is added along each axis, at the members of the tree of all."""
    for axis, chain in enumerate(strand.chains):
        for term in chain.terms if chain is not None else ():
            yield axis, Term(term.domain, term.node, term.targets + strand.first)


def shared(builder: FamilyBuilder, strands: Sequence[Strand], count: int) -> Flags:
    """Which coordinates move several of the members of all chains, themselves."""
    first = np.full(builder.q.count, NONE, dtype=np.int64)
    several = np.zeros(builder.q.count, dtype=bool)
    for _, term in (step for one in strands for step in steps_of(one)):
        for _, slot in builder.slots.inside(term.node):
            if slot.array is builder.q:
                least, most = np.full(builder.q.count, count), np.full(builder.q.count, NONE)
                np.minimum.at(least, slot.table, term.targets)
                np.maximum.at(most, slot.table, term.targets)
                moved = most != NONE
                several |= moved & ((least != most) | ((first != NONE) & (first != least)))
                first[moved & (first == NONE)] = least[moved & (first == NONE)]
    return several


def hung(
    builder: FamilyBuilder, strands: Sequence[Strand], rows: Flags, count: int
) -> tuple[list[tuple[Node, ...]], list[list[Term]], Places, Places]:
    """The mounts, along all axes; what is added behind these, axis by axis; the mount of each member, and its
    parent."""
    axes = max(len(one.chains) for one in strands)
    parents = np.full(count, NONE, dtype=np.int64)
    steps: list[list[Term]] = [[] for _ in range(axes)]
    based: dict[int, list[Node]] = {}
    for strand in strands:
        own = slice(strand.first, strand.first + len(strand.parents))
        parents[own] = np.where(strand.parents == NONE, NONE, strand.parents + strand.first)
        for axis, term in steps_of(strand):
            for own_term, base in parted(builder, term, rows):
                steps[axis].append(own_term)
                for member, node in zip(own_term.targets.tolist(), base):
                    if not node.is_zero:
                        known = based.setdefault(member, [builder.graph.zero] * axes)
                        known[axis] = known[axis] + node
    numbers: dict[tuple[Node, ...], int] = {}
    mounts = np.zeros(count, dtype=np.int64)
    for member, base in based.items():
        if parents[member] != NONE:
            raise Unsuited  # what is within a chain moves with it
        parents[member], mounts[member] = 0, numbers.setdefault(tuple(base), len(numbers))
    for member in tree_of(parents).order.tolist():
        if parents[member] > 0:
            mounts[member] = mounts[parents[member]]
    return [*numbers], steps, mounts, parents


def parted(builder: FamilyBuilder, term: Term, rows: Flags) -> Iterator[tuple[Term, list[Node]]]:
    """A term without what shared coordinates alone add, and this, member by member."""
    graph, slots = builder.graph, builder.slots
    listed = [
        (one, factor, carried(builder, one, rows, term.domain.count)) for one, factor in terms_of(term.node)
    ]
    kinds, labels = np.unique(np.array([flags for _, _, flags in listed]), axis=1, return_inverse=True)
    for label, kind in enumerate(kinds.T):
        which = np.flatnonzero(labels.reshape(-1) == label)
        domain = term.domain if len(which) == term.domain.count else Domain(len(which))
        base, rest = (
            graph.sum([(one, a) for (one, a, _), on in zip(listed, kind) if on == chosen])
            for chosen in (True, False)
        )
        if any(slot.array is builder.q and rows[slot.table[which]].any() for _, slot in slots.inside(rest)):
            raise Unsuited  # such coordinates do not stand apart
        yield (
            Term(domain, placed(slots, rest, domain, which), term.targets[which]),
            [graph.zero] * len(which) if base.is_zero else of_each(builder, base, which),
        )


def of_each(builder: FamilyBuilder, node: Node, which: Places) -> list[Node]:
    """An expression as one of the root, for each of these members."""
    tables = [slot.table[which] for _, slot in builder.slots.inside(node)]
    _, first, kinds = np.unique(np.array(tables), axis=1, return_index=True, return_inverse=True)
    own = Domain(len(first))
    chosen = placed(builder.slots, node, own, which[first])
    made = [
        at_root(builder, placed(builder.slots, chosen, Domain(1), np.array([k]))) for k in range(len(first))
    ]
    return [made[kind] for kind in kinds.reshape(-1).tolist()]


def carried(builder: FamilyBuilder, addend: Node, rows: Flags, count: int) -> Flags:
    """For which members nothing but shared coordinates moves an addend."""
    slots = [slot for _, slot in builder.slots.inside(addend)]
    if any(isinstance(slot.array, Total) and not constant_total(builder, slot.array) for slot in slots):
        return np.zeros(count, dtype=bool)
    moving = [rows[slot.table] for slot in slots if slot.array is builder.q]
    return np.all(moving, axis=0) if moving else np.zeros(count, dtype=bool)
