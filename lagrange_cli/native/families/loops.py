"""``Loop``: the terms of one domain, which are computed together, and in which order totals are."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from lagrange_cli.expression.node import Node
from lagrange_cli.families.arrays import Array, Domain, Slot, Slots, Term, Total
from lagrange_cli.native.families.rows import Rows, rows_of
from lagrange_cli.native.interface import LANES
from lagrange_cli.records import dataclass

if TYPE_CHECKING:
    from lagrange_cli.expression.index_arrays import Places


def room(count: int) -> int:
    """Doubles for so many numbers: what is read and written in whole vectors may go beyond them by two."""
    return LANES * (-(-count // LANES) + 2)


@dataclass(frozen=True, eq=False)
class Loop:
    """The terms of one domain that are computed together, each with the total it belongs to."""

    domain: Domain
    terms: Sequence[tuple[Term, Total]]
    slots: Slots

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
            same = (i for i, one in enumerate(tables) if one is table or np.array_equal(one, table))
            i = next(same, len(tables))
            if i == len(tables):
                tables.append(table)
            numbers.append(i)
        return tables, numbers

    @cached_property
    def rows(self) -> Rows:
        """The members in rows."""
        return rows_of(self.numbered[0], self.domain.count)


def loops(totals: Sequence[Total], slots: Slots) -> list[Loop]:
    """How these totals are computed, those that others contain before these."""
    level: dict[Array, int] = {}
    found: dict[tuple[int, int], list[tuple[Term, Total]]] = {}
    for total in totals:
        inside = [slot.array for one in total.terms for _, slot in slots.inside(one.node)]
        level[total] = 1 + max((level.get(array, 0) for array in inside), default=0)
        for term in total.terms:
            found.setdefault((level[total], id(term.domain)), []).append((term, total))
    return [
        Loop(terms[0][0].domain, terms, slots)
        for _, terms in sorted(found.items(), key=lambda one: one[0][0])
    ]


def needed(roots: Iterable[Total], slots: Slots, known: Iterable[Array] = ()) -> list[Total]:
    """These totals and those that they contain, but for ``known`` ones, in the order of their computation."""
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
