"""Sums over pairs, cut into strips of rows that threads share (see ``sharing``).

In a row one body stays and the other goes on. What a pair adds to the one is summed in a register, and added
at the end of the row; what it adds to the other, at its *column*. Threads may go through rows at the same
time, one behind the other, if each column still gets its terms in the order of the rows.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING

import numpy as np

from lagrange_cli.expression.index_arrays import distinct
from lagrange_cli.expression.node import reachable
from lagrange_cli.native.families.additions import Additions, Key, LookedUp, keys
from lagrange_cli.native.families.chunks import add_chunks, chunks_of
from lagrange_cli.native.families.evaluation import Evaluation, Writer
from lagrange_cli.native.families.loops import Loop
from lagrange_cli.native.families.sharing import ARGUMENTS, Parts, Tiles, given
from lagrange_cli.native.families.spans import behind, larger, smaller
from lagrange_cli.native.families.vectors import Operands
from lagrange_cli.native.interface import LANES
from lagrange_cli.native.llvm.function import Function
from lagrange_cli.native.llvm.vector import Bit, Integer, Real
from lagrange_cli.records import dataclass

if TYPE_CHECKING:
    from lagrange_cli.expression.index_arrays import Places

HEIGHT, WIDTH = 32, 128
"""Rows of a strip, and columns between two looks at the strip above: a multiple of eight of them."""
WORTH = 2**16
"""Operations on eight numbers in an evaluation from which on it is shared."""


@dataclass(frozen=True, eq=False)
class Strips:
    """How the rows of a loop are shared: the column of each row's first member, and the column up to which a
    strip must have come when the row ends. ``lead`` is the table that columns are counted in."""

    loop: Loop
    lead: int | None
    least: int
    ends: Places
    columns: int

    @property
    def tiles(self) -> Tiles:
        """In numbers. What is kept of a row are the sums in registers."""
        rows, kept = len(self.loop.rows.starts), LANES * len(still(self.loop))
        return Tiles(rows, HEIGHT, -(-self.columns // WIDTH), WIDTH, kept)


def still(loop: Loop) -> list[Key]:
    """Those that stay within a row."""
    return [key for key in keys(loop) if loop.rows.strides[key[1]] == 0]


def operations_of(loop: Loop) -> int:
    """Operations on eight numbers."""
    return len(reachable([term.node for term, _ in loop.terms])) * int(loop.rows.blocks[-1])


def strips_of(loop: Loop) -> Strips | None:
    """How a loop is shared, if that is worthwhile and keeps the order of additions."""
    rows, tables = loop.rows, loop.numbered[0]
    if len(rows.starts) < 2 * HEIGHT or any(rows.strides[i] is None for _, i in keys(loop)):
        return None
    if operations_of(loop) < WORTH:
        return None
    moving = [key for key in keys(loop) if rows.strides[key[1]] == 1]
    lead = moving[0][1] if moving else None
    first = np.zeros_like(rows.starts) if lead is None else tables[lead][rows.starts]
    least = int(first.min())
    first = first - least
    last = first + rows.lengths
    columns, ends = int(last.max()), first + LANES * np.diff(rows.blocks)
    distances: dict[Key, int] = {}
    for key in moving:
        apart = tables[key[1]][rows.starts] - first
        if np.any(apart != apart[0]):
            return None
        distances[key] = int(apart[0])
    for key, one in distances.items():
        if any(other[0] is key[0] and 0 < far - one < columns for other, far in distances.items()):
            return None
    for total, i in still(loop):
        places = tables[i][rows.starts]
        if len(distinct(places)) < len(places):
            return None
        for key, distance in distances.items():
            if key[0] is total:
                column = places - distance
                if not in_order(column, first, last, columns):
                    return None
                ends = np.maximum(ends, np.where((column >= 0) & (column < columns), column + 1, 0))
    return Strips(loop, lead, least, ends, columns)


def in_order(column: Places, first: Places, last: Places, columns: int) -> bool:
    """Whether what rows add at their ends to these columns is added before what later rows add there: there
    is none, or rows end before the column, and columns are cut between vectors."""
    low = np.append(np.minimum.accumulate(first[::-1])[::-1][1:], columns)
    high = np.append(np.maximum.accumulate(last[::-1])[::-1][1:], 0)
    later = (low <= column) & (column < high)
    return not np.any(later) or bool(np.all(first % LANES == 0) and np.all(last[later] <= column[later]))


class TileAdditions(Additions):
    """Between two columns. Of eight members that lie on both sides of one, the sums in registers are those of
    the right side; what they add to columns is added on each side."""

    def within(self, left: Integer, right: Integer, length: Integer) -> None:
        """The columns, in members of the row, which has so many."""
        self.left, self.right, self.length = left, right, length

    def add(self, values: Sequence[Operands], inside: Bit, j: Integer, looked_up: LookedUp) -> None:
        before = {key: one.get() for key, one in self.sums.items()}
        super().add(values, inside, j, looked_up)
        complete = j + LANES <= self.right
        for key, one in self.sums.items():
            one.set(self.f.select(complete, one.get(), before[key]))

    def put(self, value: Real, key: Key, at: Integer) -> None:
        f, base, j = self.f, self.where(key[0]), at - self.bases[key[1]]
        end = smaller(f, self.right, self.length)
        total = f.load_row(base, at, LANES) + value
        with f.when((j >= self.left) & (j + LANES <= end)):
            f.store_row(total, base, at)
        with f.otherwise():
            first, last = larger(f, j, self.left), smaller(f, j + LANES, end)
            with f.loop(first, last) as k:
                f.store(f.lane(total, k - j), base, self.bases[key[1]] + k)


class TileWriter(Writer):
    """The code of some rows of a loop between two columns."""

    def __init__(self, evaluation: Evaluation, strips: Strips) -> None:
        super().__init__(evaluation, strips.loop)
        self.strips = strips
        self.top, self.bottom, self.left, self.right = (
            Integer(self.f, name, 1) for name in ("%top", "%bottom", "%left", "%right")
        )

    def write_tile(self) -> None:
        """The rows."""
        self.write_rows(self.top, self.bottom)

    def row(self, bases: Sequence[Integer], length: Integer, r: Integer) -> None:
        f, strips = self.f, self.strips
        first = f.count(0)
        if strips.lead is not None:
            first = bases[strips.lead] - strips.least
        end = self.listed_at(strips.ends, r)
        with f.when((self.left < end) & (self.right > first)):
            fixed = self.fixed(bases)
            added = TileAdditions(self.vectors, self.loop, self.terms, self.evaluation.where)
            added.begin(bases)
            self.enter(r)
            left, right = (behind(f, one, first) for one in (self.left, self.right))
            added.within(left, right, length)
            kept = f.place("%kept", (r - self.top) * strips.tiles.kept, "double")
            with f.when(left > 0):
                added.resume(kept)
            with f.loop(left & -LANES, smaller(f, right, length), LANES) as j:
                self.eight(bases, length, j, fixed, added)
            with f.when(self.right >= end):
                added.end(length)
            with f.otherwise():
                added.pause(kept)


class Sharing:
    """The loops of an evaluation that are shared. ``within`` gives the evaluation in another function."""

    def __init__(self, within: Callable[[Function], Evaluation], parts: Parts) -> None:
        self.within, self.parts = within, parts

    def take(self, evaluation: Evaluation, loop: Loop) -> bool:
        """Write a loop, if it is shared."""
        strips = strips_of(loop)
        if strips is None:
            return self.take_chunks(evaluation, loop)
        number, f = len(self.parts.listed), evaluation.f
        ends = "i64 %top, i64 %bottom, i64 %left, i64 %right, ptr %kept"
        inner = self.within(Function(f"define internal void @tile{number}({ARGUMENTS}, {ends}) #0"))
        TileWriter(inner, strips).write_tile()
        inner.f.give()
        self.parts.add(strips.tiles, inner.f.text())
        evaluation.f.operations += inner.f.operations
        f.call(None, f"share{number}", *given(f))
        return True

    def take_chunks(self, evaluation: Evaluation, loop: Loop) -> bool:
        """The same for chunks of rows."""
        chunks = chunks_of(loop) if operations_of(loop) >= WORTH else None
        if chunks is None:
            return False
        f, tables = evaluation.f, evaluation.tables
        number, operations = add_chunks(self.parts, chunks, tables, lambda f: Writer(self.within(f), loop))
        f.operations += operations
        f.call(None, f"share{number}", *given(f))
        return True
