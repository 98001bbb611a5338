"""Coordinates relative to those of the joint before, as the angles between the links of an arm are.

Where places depend on sums alone, as on the angles th[i] = th[i - 1] + phi[i], these sums are coordinates of
the joints, too: u_k = a_k q_k + u_j, with j ``before`` k. M of u couples joints to their neighbours, that of
q all to all. So joints are those of u, and with u_dot = C q_dot

    q_ddot_k = (u_ddot_k - u_ddot_j)/a_k,    Q = C^T F,    p = C^T p_u,

for forces F and momenta p_u that belong to u (as for any coordinates: L. A. Pars, A Treatise on Analytical
Dynamics, 1965, sec. 6.1).
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from functools import cached_property
from typing import TYPE_CHECKING, TypeAlias

import numpy as np

from lagrange_cli.expression.index_arrays import Places, distinct
from lagrange_cli.expression.indices import Unsuited
from lagrange_cli.expression.node import Node
from lagrange_cli.families.arrays import (
    NONE,
    Array,
    Chain,
    Domain,
    Slot,
    Slots,
    Source,
    Term,
    Total,
    Tree,
    equal,
    placed,
    total_of,
    tree_of,
)
from lagrange_cli.families.builder import FamilyBuilder
from lagrange_cli.records import dataclass, replace

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Flags: TypeAlias = NDArray[np.bool_]
    Piece: TypeAlias = tuple[Term, Slot, Node]


@dataclass(frozen=True, eq=False)
class Steps:
    """What some coordinates, in these ``rows``, add: ``factor`` times each to those ``before`` them, if there
    are any, and a ``shift`` that may depend on t."""

    domain: Domain
    rows: Places
    before: Places | None
    factor: Node
    shift: Node


@dataclass(frozen=True, eq=False)
class Relative:
    """``chains`` have the sums: the number of the coordinate that each member of these ends with (NONE: it
    rests); ``speeds`` have their velocities. ``steps`` are those of all coordinates; those that are ``alone``
    are none of a sum but their own. ``same`` are chains that are equal to others."""

    slots: Slots
    time: Node
    chains: Mapping[Chain, Places]
    speeds: Sequence[Total]
    before: Places
    steps: Sequence[Steps]
    alone: Flags
    same: Mapping[Array, Chain]

    @cached_property
    def tree(self) -> Tree:
        """The tree of the coordinates."""
        return tree_of(self.before)

    def rates(self, of_joints: Array, shifted: Array | None) -> Iterator[Term]:
        """q_ddot, from u_ddot, and d2/dt2 of shifts that depend on t, by coordinates."""
        for one in self.steps:
            node = self.slots.symbol(one.domain, of_joints, one.rows)
            if one.before is not None:
                node = node - self.slots.symbol(one.domain, of_joints, one.before)
            if shifted is not None and one in self.driven:
                node = node - self.slots.symbol(one.domain, shifted, one.rows)
            yield Term(one.domain, node / one.factor, one.rows)

    @cached_property
    def driven(self) -> Sequence[Steps]:
        """Those whose shifts depend on t."""
        return [one for one in self.steps if one.shift.symbols & self.time.symbols]

    def summed(self, changes: Array) -> Total:
        """u, from q, where both are changes of these."""
        terms = []
        for one in self.steps:
            node = one.factor * self.slots.symbol(one.domain, changes, one.rows)
            terms.append(Term(one.domain, node, one.rows))
        return total_of(len(self.before), terms, self.slots.graph, self.tree)

    def forces(self, own: Total, loads: Sequence[Total]) -> Iterator[Term]:
        """F, from Q by coordinates of their ``own`` and, with the opposite sign, by those on sums."""
        for one in self.steps if own.terms else ():
            node = self.slots.symbol(one.domain, own, one.rows) / one.factor
            yield Term(one.domain, node, one.rows)
            if one.before is not None:
                yield Term(one.domain, -node, one.before)
        for term in self.on_sums([one.terms for one in loads]):
            yield replace(term, node=-term.node)

    def own(self, forces: Total) -> Iterator[Term]:
        """Of forces on the joints' coordinates what acts on each of the coordinates alone."""
        for one in self.steps:
            yield Term(one.domain, one.factor * self.slots.symbol(one.domain, forces, one.rows), one.rows)

    def on_sums(self, pushes: Sequence[Sequence[Term]]) -> Iterator[Term]:
        """What acts on the members of ``chains``, as the joints' coordinates feel it."""
        for push, ends in zip(pushes, self.chains.values()):
            for term in push:
                kept = np.flatnonzero(ends[term.targets] != NONE)
                domain = term.domain if len(kept) == term.domain.count else Domain(len(kept))
                yield Term(domain, placed(self.slots, term.node, domain, kept), ends[term.targets[kept]])

    def on_coordinates(self, terms: Iterable[Term], made: list[Total]) -> Iterator[Term]:
        """Q from F, or p from p_u; the totals that this takes are added to those ``made``."""
        whole = total_of(len(self.before), terms, self.slots.graph, self.tree, back=True)
        if whole.terms:
            made.append(whole)
            for one in self.steps:
                yield Term(one.domain, one.factor * self.slots.symbol(one.domain, whole, one.rows), one.rows)

    def behind(self, chosen: Flags) -> Flags:
        """Which coordinates move some of the joints' that are ``chosen`` (flags, or columns of these)."""
        found: Flags = chosen.copy()
        for k in reversed(self.tree.order.tolist()):
            if self.before[k] != NONE:
                found[self.before[k]] |= found[k]
        return found


def relative(builder: FamilyBuilder, places: Iterable[Node]) -> Relative | None:
    """The sums of coordinates that ``places`` depend on otherwise than by an addition; None if there are
    none. Raises ``Unsuited`` where coordinates are in different sums."""
    chains = [*dict.fromkeys(found for x in places for found in within(builder, x))]
    if not chains:
        return None
    count, slots = builder.q.count, builder.slots
    before, owned = np.full(count, NONE, dtype=np.int64), np.zeros(count, dtype=bool)
    simple = np.ones(count, dtype=bool)
    """Whether they are added as they are, but for constants."""
    ends, steps, same = dict[Chain, Places](), list[Steps](), dict[Array, Chain]()
    pure: list[Chain] = []
    for chain in chains:
        assert chain.tree is not None
        pieces = [*pieces_of(builder, chain)]
        own = owners_of(chain, pieces)
        at, parents = ends_of(own, chain.tree), chain.tree.parents
        if is_pure(builder, chain):
            first = next((one for one in pure if equal(ends[one], at)), None)
            if first is not None:
                same[chain] = first
                continue
            pure.append(chain)
        ends[chain] = at
        for term, slot, factor in pieces:
            up = np.where(parents[term.targets] == NONE, NONE, at[parents[term.targets]])
            rows, shift = slot.table, term.node - factor * slots.symbol(term.domain, builder.q, slot.table)
            added = factor is builder.graph.one and not shift.symbols & builder.time.symbols
            if np.any(owned[rows]):
                if not (added and np.all(owned[rows] & simple[rows]) and equal(before[rows], up)):
                    raise Unsuited
                continue
            owned[rows], before[rows], simple[rows] = True, up, added
            steps += steps_of(slots, rows, up, factor, shift)
    others = np.flatnonzero(~owned)
    if len(others):
        steps.append(Steps(Domain(len(others)), others, None, builder.graph.one, builder.graph.zero))
    speeds = [one for chain in ends if (one := builder.rates_of(chain)) is not None]
    alone = simple & (before == NONE)
    made = Relative(slots, builder.time, ends, speeds, before, tuple(steps), alone, same)
    made.tree  # noqa: B018 - refuses coordinates that follow from themselves
    return made


def owners_of(chain: Chain, pieces: Iterable[Piece]) -> Places:
    """The coordinate that each member adds, if any. Raises ``Unsuited`` for two of one, or one of two."""
    own = np.full(chain.count, NONE, dtype=np.int64)
    for term, slot, _ in pieces:
        if np.any(own[term.targets] != NONE):
            raise Unsuited
        own[term.targets] = slot.table
    rows = own[own != NONE]
    if len(distinct(rows)) < len(rows):
        raise Unsuited
    return own


def is_pure(builder: FamilyBuilder, chain: Chain) -> bool:
    """Whether nothing but coordinates is added, each by every member."""
    nodes = [term.node for term in chain.terms]
    return sum(term.domain.count for term in chain.terms) == chain.count and all(
        one in builder.slots.of and builder.slots.of[one].array is builder.q for one in nodes
    )


def steps_of(slots: Slots, rows: Places, before: Places, factor: Node, shift: Node) -> Iterator[Steps]:
    """Those of coordinates that have one before, and of those that have none."""
    for has in (True, False):
        members = np.flatnonzero((before != NONE) == has)
        if len(members):
            domain = Domain(len(members))
            own, more = (placed(slots, one, domain, members) for one in (factor, shift))
            yield Steps(domain, rows[members], before[members] if has else None, own, more)


def ends_of(own: Places, tree: Tree) -> Places:
    """The coordinate of each member, or else of the nearest one before that has any."""
    found: Places = own.copy()
    for member in tree.order.tolist():
        if found[member] == NONE and tree.parents[member] != NONE:
            found[member] = found[tree.parents[member]]
    return found


def within(builder: FamilyBuilder, x: Node) -> Iterator[Chain]:
    """The sums of coordinates that a place depends on otherwise than by an addition, or chains of places
    do that it is made of."""
    for symbol, slot in builder.slots.inside(x):
        if not isinstance(slot.array, Chain):
            continue
        scale = builder.graph.diff(x, symbol)
        if scale.symbols & symbol.symbols and is_sum(builder, slot.array):
            yield slot.array
        for term in slot.array.terms:
            inner = [one.array for _, one in builder.slots.inside(term.node)]
            yield from (one for one in inner if isinstance(one, Chain) and is_sum(builder, one))


def is_sum(builder: FamilyBuilder, chain: Chain) -> bool:
    """Whether a chain adds up coordinates, each times a constant."""
    try:
        return any(True for _ in pieces_of(builder, chain))
    except Unsuited:
        return False


def pieces_of(builder: FamilyBuilder, chain: Chain) -> Iterator[Piece]:
    """The terms of a sum that have a coordinate, this, and its factor. Raises ``Unsuited`` where a term is
    none of a sum of coordinates."""
    lasting = Source.PARAMETERS, Source.WHOLE
    for term in chain.terms:
        inside = [*builder.slots.inside(term.node)]
        own = [(s, slot) for s, slot in inside if slot.array is builder.q]
        others = [slot for _, slot in inside if slot.array is not builder.q]
        known = all(slot.array.source in lasting for slot in others)
        if chain.back or not known or len(own) > 1 or (not own and term.node.symbols & builder.time.symbols):
            raise Unsuited
        for symbol, slot in own:
            factor = builder.graph.diff(term.node, symbol)
            if factor.symbols & (symbol.symbols | builder.time.symbols):
                raise Unsuited
            yield term, slot, factor
