"""Machine code that computes totals of families (``families.arrays``): a loop for each domain.

Eight members are worked on at once. Terms of one domain share a loop, and what they have in common. A sum
along a row stays in a register; what is added elsewhere is added in the order of the members. So results do
not depend on anything but the system.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np

from lagrange_cli.expression.node import Node
from lagrange_cli.families.arrays import Array, Slots, Total
from lagrange_cli.native.families.additions import Additions
from lagrange_cli.native.families.loops import Loop, loops, room
from lagrange_cli.native.interface import LANES
from lagrange_cli.native.llvm.function import Function
from lagrange_cli.native.llvm.vector import Bit, Integer, Pointer, Real
from lagrange_cli.native.numbers.lanes import LaneEmitter
from lagrange_cli.native.recurrences.batched import Everywhere
from lagrange_cli.native.recurrences.evaluation import emit_values
from lagrange_cli.native.recurrences.gathering import gathered, place_at, places_at
from lagrange_cli.native.recurrences.layout_batches import Tables
from lagrange_cli.records import dataclass, field

if TYPE_CHECKING:
    from lagrange_cli.expression.index_arrays import Places

Where = Callable[[Array], Pointer]
"""Where the numbers of an array begin."""


@dataclass
class Evaluation:
    """The function that totals are computed in, where arrays are in it, and the constants of the motion."""

    f: Function
    slots: Slots
    where: Where
    tables: Tables
    known: Mapping[Node, str]
    """Operands of symbols that are no slots, in every lane: t."""
    emitter: LaneEmitter = field(default_factory=LaneEmitter)

    def __post_init__(self) -> None:
        self.emitter.lines = self.f.sink

    def write(self, totals: Sequence[Total]) -> None:
        """Compute them."""
        self.clear(totals)
        for loop in loops(totals, self.slots):
            Writer(self, loop).write()

    def clear(self, totals: Sequence[Total]) -> None:
        """Begin with sums that are 0."""
        for total in totals:
            base = self.where(total)
            with self.f.loop(0, room(total.count), LANES, tested=False) as i:
                self.f.store_row(self.f.zero(LANES), base, i)


class Writer:
    """The code of one loop."""

    def __init__(self, evaluation: Evaluation, loop: Loop) -> None:
        self.evaluation, self.f, self.loop = evaluation, evaluation.f, loop
        self.used, self.rows = loop.used, loop.rows
        self.listed, self.number = loop.numbered
        evaluation.emitter.repeated = int(np.sum(-(-self.rows.lengths // LANES)))

    def write(self) -> None:
        """All rows."""
        rows, self.first = self.rows, self.f.count(0)
        if len(rows.starts) == 1:
            bases = [self.f.count(int(table[0])) for table in self.listed]
            self.row(bases, self.f.count(int(rows.lengths[0])), self.f.count(0))
            return
        with self.f.loop(0, len(rows.starts), tested=False) as r:
            length = self.listed_at(rows.lengths, r)
            if None in rows.strides:
                self.first = self.listed_at(rows.starts, r)
            bases = [
                self.listed_at(table[rows.starts], r) if stride is not None else self.f.count(0)
                for table, stride in zip(self.listed, rows.strides)
            ]
            self.row(bases, length, r)

    def listed_at(self, values: Places, r: Integer) -> Integer:
        """An entry of a table."""
        if np.all(values == values[0]):
            return self.f.count(int(values[0]))
        first = self.evaluation.tables.of_places(values.tolist())
        return place_at(self.f, r + first if first else r)

    def row(self, bases: Sequence[Integer], length: Integer, r: Integer) -> None:
        """The members of row number ``r``."""
        f, strides = self.f, self.rows.strides
        fixed: dict[Node, str] = {}
        for (symbol, slot), i in zip(self.used.items(), self.number):
            if strides[i] == 0:
                one = f.load(self.evaluation.where(slot.array), bases[i])
                fixed[symbol] = f.splat(one, LANES).name
        added = Additions(f, self.loop, self.evaluation.where)
        added.begin(bases)
        self.enter(r)
        with f.loop(0, length, LANES, tested=False) as j:
            self.eight(bases, length, j, fixed, added)
        added.end(length)

    def eight(
        self,
        bases: Sequence[Integer],
        length: Integer,
        j: Integer,
        fixed: Mapping[Node, str],
        added: Additions,
    ) -> None:
        """Eight members, from the ``j``-th one of the row on."""
        f, evaluation, strides = self.f, self.evaluation, self.rows.strides
        lanes = ", ".join(f"i64 {lane}" for lane in range(LANES))
        inside: Bit = f.splat(j, LANES) + Integer(f, f"<{lanes}>", LANES) < f.splat(length, LANES)
        known: dict[Node, str | None] = {**evaluation.known, **fixed}
        for (symbol, slot), i in zip(self.used.items(), self.number):
            base = evaluation.where(slot.array)
            if strides[i] == 1:
                known[symbol] = f.load_row(base, bases[i] + j, LANES).name
            elif strides[i] is None:
                known[symbol] = gathered(evaluation.emitter, base.name, self.looked_up(i, j))
        values = [Real(f, evaluation.emitter.written(one), LANES) for one in self.values(known, j)]
        added.add(values, inside, j, self.looked_up)

    def enter(self, r: Integer) -> None:
        """What is done once in a row."""

    def values(self, known: dict[Node, str | None], j: Integer) -> list[str | None]:
        """The terms of eight members, from the ``j``-th one on, whose slots are ``known``."""
        nodes = [term.node for term, _ in self.loop.terms]
        emit_values(self.evaluation.emitter, nodes, known, Everywhere(self.evaluation.tables.constants.slots))
        return [known[node] for node in nodes]

    def looked_up(self, i: int, j: Integer) -> str:
        """Eight places of a table. Behind its end the last one stands again: a row may end anywhere."""
        table = self.listed[i].tolist()
        at = self.evaluation.tables.of_places([*table, *table[-1:] * LANES])
        return places_at(self.f, self.first + j + at, aligned=False)
