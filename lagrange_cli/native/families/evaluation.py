"""Machine code that computes totals of families (``families.arrays``): a loop for each domain.

Eight members are worked on at once. Terms of one domain share a loop, and what they have in common. A sum
along a row stays in a register; what is added elsewhere is added in the order of the members. So results do
not depend on anything but the system.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np

from lagrange_cli.expression.node import Node
from lagrange_cli.families.arrays import NONE, Array, Chain, Slots, Term, Total, Tree
from lagrange_cli.native.families.additions import Additions
from lagrange_cli.native.families.everywhere import Everywhere
from lagrange_cli.native.families.loops import Loop, loops
from lagrange_cli.native.families.spans import Span, behind, in_vectors, smaller
from lagrange_cli.native.families.tables import Tables, before, place_at, places_at
from lagrange_cli.native.families.vectors import Divisor, Numbers, Operands, Vectors
from lagrange_cli.native.interface import LANES
from lagrange_cli.native.llvm.function import Function
from lagrange_cli.native.llvm.vector import Bit, Index, Integer, Pointer
from lagrange_cli.native.recurrences.evaluation import emit_values
from lagrange_cli.native.state import whole_vectors
from lagrange_cli.records import dataclass, field, replace

if TYPE_CHECKING:
    from lagrange_cli.expression.index_arrays import Places

Where = Callable[[Array], Pointer]
"""Where the numbers of an array begin."""


def room(count: int) -> int:
    """Doubles for so many numbers: what is read and written in whole vectors may go beyond them by two."""
    return whole_vectors(count, 2)


@dataclass(frozen=True)
class LowParts:
    """Where the low parts of ``arrays`` of the state are, and that of t, in every lane."""

    arrays: Mapping[Array, Pointer]
    time: Operands
    high: Where

    def where(self, array: Array) -> Pointer:
        """Where those of an array are; what has none is as it is."""
        return self.arrays[array] if array in self.arrays else self.high(array)


@dataclass
class Evaluation:
    """The function that totals are computed in, where arrays are in it, and the constants of the motion."""

    vectors: Vectors
    slots: Slots
    where: Where
    tables: Tables
    known: Mapping[Node, Operands]
    """Operands of symbols that are no slots, in every lane: t."""
    scales: Mapping[Array, Divisor] = field(default_factory=dict)
    """What numbers of arrays are divided by."""
    parted: Callable[[Sequence[Loop | Chain]], Sequence[Loop | Chain]] = lambda listed: listed
    """Gives loops in parts, of which some may be written apart."""
    apart: Callable[[Evaluation, Loop], bool] = lambda evaluation, loop: False
    """Writes such a loop, or one that several threads share, if it is one."""
    low: LowParts | None = None
    """The low parts of the state, where they count."""

    @property
    def f(self) -> Function:
        """The function."""
        return self.vectors.f

    @property
    def emitter(self) -> Any:
        """The arithmetic of eight members."""
        return self.vectors.kind

    def values(
        self, nodes: Sequence[Node], known: Mapping[Node, Operands], kind: Any = None
    ) -> list[Operands]:
        """Expressions of eight members, of which so much is ``known``; in their arithmetic, or another."""
        found = dict(known)
        constants = Everywhere(self.tables.constants.slots)
        emit_values(kind or self.emitter, [*nodes], found, constants, inverses=True)
        return [found[node] for node in nodes]

    def write(self, totals: Sequence[Total]) -> None:
        """Compute them."""
        listed = self.parted(loops(totals, self.slots))
        self.clear(added(totals, listed))
        self._take(listed)

    def add(self, totals: Sequence[Total]) -> None:
        """Add them to what is where they are; none is a sum along a chain."""
        listed = [one for one in loops(totals, self.slots) if isinstance(one, Loop)]
        self._take([replace(one, onto=True) for one in listed])

    def _take(self, listed: Sequence[Loop | Chain]) -> None:
        for one in listed:
            if isinstance(one, Chain):
                self.add_up(one)
            elif not self.apart(self, one):
                Writer(self, one).write()

    def add_up(self, chain: Chain) -> None:
        """Add the terms of a chain up along it."""
        tree, base = chain.tree, self.where(chain)
        assert tree is not None
        with climb(self.f, self.tables, tree, back=chain.back) as (member, parent, hangs):
            source, target = (member, parent) if chain.back else (parent, member)
            with self.f.when(hangs):
                load, store = self.vectors.load, self.vectors.store
                store(load(base, target) + load(base, source), base, target)

    def clear(self, totals: Iterable[Array]) -> None:
        """Begin with sums that are 0."""
        for total in totals:
            base = self.where(total)
            with self.f.loop(0, room(total.count), LANES, tested=False) as i:
                self.vectors.store_row(self.vectors.zero(LANES), base, i)

    def clear_between(self, total: Array, span: Span) -> None:
        """The same for some of them."""
        base = self.where(total)
        vectors = self.vectors
        in_vectors(self.f, span, lambda i, lanes: vectors.store_row(vectors.zero(lanes), base, i))


def added(totals: Iterable[Array], listed: Iterable[Loop | Chain]) -> list[Array]:
    """Those to which terms are added, and which have to be 0 before."""
    put = frozenset[Array]().union(*(one.put for one in listed if isinstance(one, Loop)))
    return [one for one in totals if one not in put]


@contextmanager
def climb(f: Function, tables: Tables, tree: Tree, *, back: bool) -> Iterator[tuple[Integer, Integer, Bit]]:
    """A loop over the members of a tree, parents first or, if it goes ``back``, last: a member, its parent,
    and whether it has one (else the parent is the number behind the last member)."""
    count = len(tree.parents)
    plain = np.array_equal(tree.order, np.arange(count))
    order = 0 if plain else tables.of_places(tree.order.tolist())
    parents = tables.of_places(np.where(tree.parents == NONE, count, tree.parents).tolist())
    with f.loop(0, count, tested=False) as i:
        at = f.count(count - 1) - i if back else i
        member = at if plain else place_at(f, at + order)
        parent = place_at(f, member + parents)
        yield member, parent, parent < count


@dataclass(frozen=True)
class Piece:
    """Some blocks of eight members of a loop. What is in registers waits at ``registers`` where a row goes on
    in another piece."""

    blocks: Span
    registers: Pointer


class Writer:
    """The code of one loop."""

    def __init__(self, evaluation: Evaluation, loop: Loop) -> None:
        self.evaluation, self.f, self.loop = evaluation, evaluation.f, loop
        self.vectors = evaluation.vectors
        self.used, self.rows = loop.used, loop.rows
        self.listed, self.number = loop.numbered
        self.piece: Piece | None = None
        evaluation.emitter.repeated = int(np.sum(-(-self.rows.lengths // LANES)))

    def write(self, piece: Piece | None = None) -> None:
        """All rows, or a piece."""
        if piece is None:
            self.write_rows(0, len(self.rows.starts))
            return
        first, last = piece.blocks
        with self.f.when(first < last):
            counts = np.diff(self.rows.blocks)
            row_of = np.repeat(np.arange(len(counts)), counts)
            self.piece = piece
            self.write_rows(self.listed_at(row_of, first), self.listed_at(row_of, last - 1) + 1)

    def write_rows(self, first: Index, last: Index) -> None:
        """The rows from ``first`` to before ``last``."""
        rows, self.first = self.rows, self.f.count(0)
        if len(rows.starts) == 1:
            bases = [self.f.count(int(table[0])) for table in self.listed]
            self.row(bases, self.f.count(int(rows.lengths[0])), self.f.count(0))
            return
        with self.f.loop(first, last, tested=False) as r:
            self.write_row(r)

    def write_row(self, r: Integer) -> None:
        """Row number ``r``."""
        rows = self.rows
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
        f, fixed = self.f, self.fixed(bases)
        added = Additions(self.vectors, self.loop, self.terms, self.evaluation.where)
        added.begin(bases)
        self.enter(r)
        if self.piece is None:
            with f.loop(0, length, LANES, tested=False) as j:
                self.eight(bases, length, j, fixed, added)
            added.end(length)
            return
        before = f.count(0) if len(self.rows.starts) == 1 else self.listed_at(self.rows.blocks[:-1], r)
        start, end = (behind(f, one, before) * LANES for one in self.piece.blocks)
        with f.when(start > 0):
            added.resume(self.piece.registers)
        with f.loop(start, smaller(f, end, length), LANES, tested=False) as j:
            self.eight(bases, length, j, fixed, added)
        with f.when(end >= length):
            added.end(length)
        with f.otherwise():
            added.pause(self.piece.registers)

    def fixed(self, bases: Sequence[Integer]) -> dict[Node, Operands]:
        """The slots that stay as they are in a row."""
        vectors, found = self.vectors, dict[Node, Operands]()

        def everywhere(base: Pointer, at: Integer) -> Numbers:
            return vectors.splat(vectors.load(base, at), LANES)

        for (symbol, slot), i in zip(self.used.items(), self.number):
            if self.rows.strides[i] == 0:
                found[symbol] = self.taken(slot.array, partial(everywhere, at=bases[i]))
        return found

    def taken(self, array: Array, take: Callable[[Pointer], Numbers]) -> Operands:
        """Numbers of an array, which ``take`` finds from where they begin on."""
        return self.vectors.operand(self.scaled(array, take(self.evaluation.where(array))))

    def eight(
        self,
        bases: Sequence[Integer],
        length: Integer,
        j: Integer,
        fixed: Mapping[Node, Operands],
        added: Additions,
    ) -> None:
        """Eight members, from the ``j``-th one of the row on."""
        evaluation, inside = self.evaluation, before(self.f, j, length)
        known = {**evaluation.known, **fixed, **self.changing(bases, j)}
        added.add(self.of_eight(known, bases, j, inside), inside, j, self.looked_up)

    def changing(self, bases: Sequence[Integer], j: Integer) -> dict[Node, Operands]:
        """The slots of eight members that are not the same in all of a row."""
        vectors, strides = self.vectors, self.rows.strides
        known: dict[Node, Operands] = {}
        for (symbol, slot), i in zip(self.used.items(), self.number):
            if strides[i] == 1:
                row = partial(vectors.load_row, index=bases[i] + j, lanes=LANES)
                known[symbol] = self.taken(slot.array, row)
            elif strides[i] is None:
                known[symbol] = self.taken(slot.array, partial(vectors.gather, places=self.looked_up(i, j)))
        return known

    def of_eight(
        self, known: dict[Node, Operands], bases: Sequence[Integer], j: Integer, inside: Bit
    ) -> list[Operands]:
        """Their terms; those of members ``inside`` the row count."""
        return self.values(known, j)

    def scaled(self, array: Array, value: Numbers) -> Numbers:
        """Numbers of an array, as the evaluation divides them."""
        scale = self.evaluation.scales.get(array)
        return value if scale is None else self.vectors.divided(value, scale)

    @property
    def terms(self) -> Sequence[tuple[Term, Array]]:
        """Those that ``values`` gives, which are added up."""
        return self.loop.terms

    def enter(self, r: Integer) -> None:
        """The operations done once per row."""

    def values(self, known: dict[Node, Operands], j: Integer) -> list[Operands]:
        """The terms of eight members, from the ``j``-th one on, whose slots are ``known``."""
        return self.evaluation.values([term.node for term, _ in self.loop.terms], known)

    def looked_up(self, i: int, j: Integer) -> Pointer:
        """Eight places of a table. Behind its end the last one stands again: a row may end anywhere."""
        table = self.listed[i].tolist()
        at = self.evaluation.tables.of_places([*table, *table[-1:] * LANES])
        return places_at(self.f, self.first + j + at)
