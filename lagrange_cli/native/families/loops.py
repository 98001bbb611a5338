"""Loops over the members of a domain: which terms of totals are computed together, and in what order.

Members are in rows: within one, a table of places goes up by 1 or stays as it is. So the numbers of eight
members are one load, or one number for all of them, instead of eight places that have to be looked up: in a
sum over pairs of bodies one index stays and the other one goes up.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from lagrange_cli.expression.node import Node
from lagrange_cli.families.arrays import Array, Chain, Domain, Slot, Slots, Term, Total
from lagrange_cli.native.interface import LANES
from lagrange_cli.records import dataclass

if TYPE_CHECKING:
    from lagrange_cli.expression.index_arrays import Places

USUAL = 0.5
"""A table goes up, or stays, if it does so from member to member in more than this part of all cases."""
SHORT = 4
"""Members of a row on average below which places are looked up."""


@dataclass(frozen=True, eq=False)
class Rows:
    """Where rows begin, how long they are, and by how much each table goes up in them: 1, 0 or, where places
    are looked up, None."""

    starts: Places
    lengths: Places
    strides: tuple[int | None, ...]

    @cached_property
    def blocks(self) -> Places:
        """The first block of eight members of each row, and the number of all."""
        blocks: Places = np.concatenate([[0], np.cumsum(-(-self.lengths // LANES))])
        return blocks


def rows_of(tables: Sequence[Places], count: int) -> Rows:
    """The rows of ``count`` members with these tables."""
    breaks = np.zeros(max(count - 1, 0), dtype=bool)
    strides: list[int | None] = []
    for table in tables:
        steps = np.diff(table)
        shares = [(float(np.mean(steps == stride)) if count > 1 else 1.0, stride) for stride in (0, 1)]
        share, stride = max(shares)
        strides.append(stride if share > USUAL else None)
        if strides[-1] is not None:
            breaks |= steps != stride
    starts = np.concatenate([[0], np.flatnonzero(breaks) + 1])
    if count > LANES and count < SHORT * len(starts):
        return Rows(np.zeros(1, np.int64), np.array([count]), (None,) * len(tables))
    return Rows(starts, np.diff(np.append(starts, count)), tuple(strides))


def are_same(one: Places, other: Places) -> bool:
    """Whether two tables are equal. Most that are not differ at their ends."""
    if one is other or not (len(one) and len(one) == len(other)):
        return one is other
    return bool(one[0] == other[0] and one[-1] == other[-1] and np.array_equal(one, other))


@dataclass(frozen=True, eq=False)
class Loop:
    """The terms of one domain that are computed together, each with the total it belongs to."""

    domain: Domain
    terms: Sequence[tuple[Term, Array]]
    slots: Slots
    alone: frozenset[Array] = frozenset()
    """Arrays that are no totals and have no other terms."""
    onto: bool = False
    """Whether terms of totals are added to what is there before."""

    @cached_property
    def used(self) -> Mapping[Node, Slot]:
        """The slots in the terms."""
        return {symbol: slot for term, _ in self.terms for symbol, slot in self.slots.inside(term.node)}

    @cached_property
    def numbered(self) -> tuple[list[Places], list[int]]:
        """The tables that differ, and the number of each slot's table, then of each term's targets."""
        tables: list[Places] = []
        numbers: list[int] = []
        for table in [slot.table for slot in self.used.values()] + [term.targets for term, _ in self.terms]:
            same = (i for i, one in enumerate(tables) if are_same(one, table))
            i = next(same, len(tables))
            if i == len(tables):
                tables.append(table)
            numbers.append(i)
        return tables, numbers

    @cached_property
    def rows(self) -> Rows:
        """The members in rows."""
        return rows_of(self.numbered[0], self.domain.count)

    @cached_property
    def put(self) -> frozenset[Array]:
        """Arrays all of whose places the loop fills, one after the other: they need not be 0 before."""
        if len(self.rows.starts) > 1:
            return frozenset()
        targets = self.numbered[1][len(self.used) :]
        return frozenset(
            total
            for (term, total), i in zip(self.terms, targets)
            if self.rows.strides[i] == 1
            and (not self.onto and len(total.terms) == 1 if isinstance(total, Total) else total in self.alone)
            and len(term.targets) == total.count
            and np.array_equal(term.targets, np.arange(total.count))
        )


def loops(totals: Sequence[Total], slots: Slots) -> list[Loop | Chain]:
    """How these totals are computed, those that others contain before these: loops over their terms, and sums
    along chains behind those of their terms."""
    level: dict[Array, int] = {}
    found: dict[tuple[int, int], list[tuple[Term, Array]]] = {}
    along: dict[int, list[Loop | Chain]] = {}
    for total in totals:
        inside = [slot.array for one in total.terms for _, slot in slots.inside(one.node)]
        level[total] = 1 + max((level.get(array, 0) for array in inside), default=0)
        for term in total.terms:
            found.setdefault((level[total], id(term.domain)), []).append((term, total))
        if isinstance(total, Chain) and total.terms:
            along.setdefault(level[total], []).append(total)
    made: dict[int, list[Loop | Chain]] = {}
    for (height, _), terms in found.items():
        made.setdefault(height, []).append(Loop(terms[0][0].domain, terms, slots))
    return [one for height in sorted(made) for one in (*made[height], *along.get(height, ()))]


def needed(roots: Iterable[Total], slots: Slots, known: Iterable[Array] = ()) -> list[Total]:
    """These totals and those that they contain, except ``known`` ones, in the order of their computation."""
    found: dict[Total, None] = {}
    left = set(known)

    def visit(total: Total) -> None:
        if total in found or total in left:
            return
        for term in total.terms:
            for _, slot in slots.inside(term.node):
                if isinstance(slot.array, Total):
                    visit(slot.array)
        found[total] = None

    for root in roots:
        visit(root)
    return list(found)
