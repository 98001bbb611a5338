"""Equations for multipliers in which most constraints meet most others: L D L^T row by row.

Most entries may be 0, as those of contacts that do not touch. So unknowns that meet others are listed first,
and the matrix is one of these alone: the work does not depend on how many others there are. The upper half of
this matrix is an array with a row of whole vectors for each unknown. Each pivot's row is taken from the rows
behind it, and then divided by the pivot: it is that column of L.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, TypeAlias

import numpy as np

from lagrange_cli.native.families.constraints.saddle_tables import SaddleTables
from lagrange_cli.native.families.tables import Tables, place_at
from lagrange_cli.native.families.vectors import Numbers, Operands, Vectors
from lagrange_cli.native.interface import LANES
from lagrange_cli.native.linear.pivots import FLOOR
from lagrange_cli.native.llvm.flow import Variable
from lagrange_cli.native.llvm.vector import Bit, Index, Integer, Pointer
from lagrange_cli.native.state import whole_vectors

if TYPE_CHECKING:
    from lagrange_cli.expression.index_arrays import Places
    from lagrange_cli.native.families.constraints.in_turn import DependentTables


class DenseTables:
    """Where the arrays of ``count`` unknowns are behind a beginning: x and 1/D of all; which of them meet
    others, where each of these is among them, and how many there are; x, 1/D, the first entries of the
    diagonal, whether rows have others than on it, and the rows of the matrix, all of these alone."""

    def __init__(self, count: int, tables: Tables) -> None:
        self.count, self.tables = count, tables
        width = whole_vectors(count)
        names = "solution", "alone", "listed", "order", "unknowns", "inverse", "diagonal", "filled"
        self.places = {name: i * width for i, name in enumerate(names)}
        self.places |= {"number": len(names) * width, "matrix": len(names) * width + LANES}
        self.size = self.places["matrix"] + count * width
        """The doubles of all arrays."""

    def placed(self, pairs: Places, sizes: Places | None = None) -> Mapping[str, Places]:
        """The unknowns of the entries ``pairs`` (entries, 2), the larger first; and where the ``sizes`` are
        that pivots are compared with, if these are no entries on the diagonal."""
        found = {"rows": pairs[:, 1], "columns": pairs[:, 0]}
        return found if sizes is None else {**found, "diagonal": sizes}


SolvingTables: TypeAlias = "SaddleTables | DenseTables | DependentTables"


class Dense:
    """What solves for multipliers, from ``base[first]`` on."""

    def __init__(self, vectors: Vectors, tabled: DenseTables, base: Pointer | str, first: int) -> None:
        self.f, self.vectors, self.base, self.first = vectors.f, vectors, base, first
        self.tabled, self.tables = tabled, tabled.tables

    definite = True
    """Whether pivots have to be positive; else they have not to be 0."""

    def place(self, name: str, at: Index = 0) -> Pointer:
        """A place in one of the arrays."""
        place = self.vectors.place
        return place(place(self.base, self.first + self.tabled.places[name]), at)

    def integers(self, name: str) -> Pointer:
        """The place of an array of whole numbers, or of doubles that tell something."""
        return self.f.place(self.place(name), 0, "double")

    def _is_filled(self, k: Integer) -> Bit:
        return self.f.load(self.integers("filled"), k) > 0.0

    @property
    def _number(self) -> Integer:
        """How many unknowns meet others."""
        return self.f.load_integer(self.integers("number"))

    def _listed(self, k: Integer) -> Integer:
        """The ``k``-th of them."""
        return self.f.load_integer(self.integers("listed"), k)

    def row(self, k: Integer, width: Integer) -> Pointer:
        """A row of the matrix."""
        return self.place("matrix", k * width)

    def load(self, place: Pointer, at: Integer) -> Operands:
        """Eight numbers side by side."""
        return self.vectors.operand(self.vectors.load_row(place, at, LANES))

    def store(self, value: Operands, place: Pointer, at: Integer) -> None:
        """The same, stored."""
        self.vectors.store_row(self.vectors.number(value), place, at)

    def everywhere(self, one: Numbers) -> Operands:
        """A number eight times."""
        return self.vectors.operand(self.vectors.splat(one, LANES))

    def clear(self, name: str, size: Integer) -> None:
        """Begin with numbers that are 0."""
        with self.f.loop(0, size, LANES) as at:
            self.vectors.store_row(self.vectors.zero(LANES), self.place(name), at)

    def take(self, some: Operands, row: Pointer, target: Pointer, first: Integer, width: Integer) -> None:
        """Take ``some`` times a ``row`` from a ``target``, from the block of the ``first`` one on."""
        with self.f.loop(block_of(first), width, LANES, tested=False) as j:
            self.store(self.vectors.kind.fms(some, self.load(row, j), self.load(target, j)), target, j)

    def scale(self, place: Pointer, first: Index, by: Pointer | Operands, width: Integer) -> None:
        """Multiply numbers from ``first`` on by one, or by as many."""
        with self.f.loop(first, width, LANES, tested=False) as j:
            factor = self.load(by, j) if isinstance(by, Pointer) else by
            self.store(self.vectors.kind.mul(self.load(place, j), factor), place, j)

    def factor(self, base: Pointer, entries: Mapping[str, Places], regular: Variable[Bit]) -> None:
        """L and D from the ``entries``, which are side by side from ``base`` on, with a 0 behind them, and
        whether they are regular."""
        f, vectors, count = self.f, self.vectors, self.tabled.count
        beside, on = self._sorted(entries)
        self._list(base, *beside)
        number = self._number
        sizes = entries.get("diagonal")
        own, whole = (self.tables.of_array(on if one is None else one) for one in (None, sizes))
        order = self.integers("order")
        with f.loop(0, count, tested=False) as i, f.when(f.load_integer(order, i).equals(count)):
            pivot = vectors.load(base, place_at(f, i + own))
            self._test(regular, vectors.load(base, place_at(f, i + whole)), pivot)
            vectors.store(self._first_of(self._inverse_of(pivot)), self.place("alone"), i)
        width = self.begin(number)
        self._fill(base, *beside, width)
        with f.loop(0, number) as k:
            i = self._listed(k)
            vectors.store(vectors.load(base, place_at(f, i + own)), self.row(k, width), k)
            vectors.store(vectors.load(base, place_at(f, i + whole)), self.place("diagonal"), k)
        self.eliminate(number, width, regular)

    def begin(self, number: Integer) -> Integer:
        """A matrix of zeros of so many unknowns; the width of its rows."""
        width = block_of(number + (LANES - 1))
        self.clear("inverse", width)
        self.clear("matrix", number * width)
        return width

    def _test(self, regular: Variable[Bit], whole: Numbers, pivot: Numbers) -> None:
        """Find out whether a pivot is more than rounding beside ``whole``."""
        both = self.vectors.high(whole), self.vectors.high(pivot)
        all_of, own = both if self.definite else (self.f.magnitude(one) for one in both)
        regular.set(regular.get() & (all_of * (FLOOR * self.vectors.kind.unit) < own))

    def _inverse_of(self, pivot: Numbers) -> Operands:
        return self.vectors.kind.div(self.vectors.kind.one, self.everywhere(pivot))

    def _first_of(self, numbers: Operands) -> Numbers:
        return self.vectors.lane(self.vectors.number(numbers), 0)

    def eliminate(self, number: Integer, width: Integer, regular: Variable[Bit]) -> None:
        """L and D of the matrix of so many unknowns."""
        f, vectors, kind = self.f, self.vectors, self.vectors.kind
        with f.loop(0, number) as k:
            row, begin = self.row(k, width), block_of(k)
            pivot = vectors.load(row, k)
            self._test(regular, vectors.load(self.place("diagonal"), k), pivot)
            inverse = self._inverse_of(pivot)
            vectors.store(self._first_of(inverse), self.place("inverse"), k)
            with f.loop(begin, k + 1, tested=False) as j:
                vectors.store(vectors.constant(0.0), row, j)
            filled = f.variable(f.constant(0.0))
            with f.loop(k + 1, number) as i:
                entry = vectors.load(row, i)
                with f.when(~vectors.high(entry).equals(0.0)):
                    self.take(kind.mul(self.everywhere(entry), inverse), row, self.row(i, width), i, width)
                    filled.set(f.constant(1.0))
            with f.when(filled.get() > 0.0):
                self.scale(row, begin, inverse, width)
            f.store(filled.get(), self.integers("filled"), k)

    def _sorted(self, entries: Mapping[str, Places]) -> tuple[tuple[int, int, int, int], Places]:
        """How many entries are beside the diagonal, with tables of these, their rows and their columns; and
        which entry each unknown has on it: the one behind all where it has none."""
        rows, columns = entries["rows"], entries["columns"]
        on = np.full(self.tabled.count, len(rows))
        on[rows[rows == columns]] = np.flatnonzero(rows == columns)
        beside = np.flatnonzero(rows != columns)
        tables = (self.tables.of_array(one) for one in (beside, rows[beside], columns[beside]))
        return (len(beside), *tables), on  # type: ignore[return-value]

    def _list(self, base: Pointer, count: int, which: int, rows: int, columns: int) -> None:
        """List the unknowns that meet others."""
        f, every, order = self.f, self.tabled.count, self.integers("order")
        with f.loop(0, every, tested=False) as i:
            f.store(f.count(every), order, i)
        with f.loop(0, count) as e, f.when(self._is_entry(base, e + which)):
            for table in (rows, columns):
                f.store(f.count(0), order, place_at(f, e + table))
        number = f.variable(f.count(0))
        with f.loop(0, every, tested=False) as i, f.when(f.load_integer(order, i) < every):
            f.store(number.get(), order, i)
            f.store(i, self.integers("listed"), number.get())
            number.set(number.get() + 1)
        f.store(number.get(), self.integers("number"))

    def _is_entry(self, base: Pointer, at: Integer) -> Bit:
        """Whether an entry is not 0."""
        return ~self.vectors.high(self.vectors.load(base, place_at(self.f, at))).equals(0.0)

    def _fill(self, base: Pointer, count: int, which: int, rows: int, columns: int, width: Integer) -> None:
        """The matrix of those that meet others, beside its diagonal."""
        f, vectors, order = self.f, self.vectors, self.integers("order")
        with f.loop(0, count) as e, f.when(self._is_entry(base, e + which)):
            row, column = (f.load_integer(order, place_at(f, e + table)) for table in (rows, columns))
            value = vectors.load(base, place_at(f, e + which))
            vectors.store(value, self.place("matrix"), row * width + column)

    def solve(self, right: Pointer) -> None:
        """The unknowns with K x = what is at ``right``."""
        f, vectors, count = self.f, self.vectors, self.tabled.count
        with f.loop(0, count, LANES, tested=False) as at:
            alone = vectors.kind.mul(self.load(right, at), self.load(self.place("alone"), at))
            self.store(alone, self.place("solution"), at)
        number = self._number
        with f.when(number > 0):
            self._solve_together(right, number, block_of(number + (LANES - 1)))

    def _solve_together(self, right: Pointer, number: Integer, width: Integer) -> None:
        """Those that meet others."""
        f, vectors, kind = self.f, self.vectors, self.vectors.kind
        unknowns = self.place("unknowns")
        vectors.store_row(vectors.zero(LANES), unknowns, width - LANES)
        with f.loop(0, number, tested=False) as k:
            vectors.store(vectors.load(right, self._listed(k)), unknowns, k)
        with f.loop(0, number, tested=False) as k, f.when(self._is_filled(k)):
            row = self.row(k, width)
            self.take(self.everywhere(vectors.load(unknowns, k)), row, unknowns, k, width)
        self.scale(unknowns, 0, self.place("inverse"), width)
        with f.loop(0, number, tested=False) as done:
            k = number - 1 - done
            with f.when(self._is_filled(k)):
                row, total = self.row(k, width), vectors.variable(vectors.zero(LANES))
                with f.loop(block_of(k), width, LANES, tested=False) as j:
                    less = kind.fms(self.load(row, j), self.load(unknowns, j), vectors.operand(total.get()))
                    total.set(vectors.number(less))
                vectors.store(vectors.total(total.get(), vectors.load(unknowns, k)), unknowns, k)
        with f.loop(0, number, tested=False) as k:
            vectors.store(vectors.load(unknowns, k), self.place("solution"), self._listed(k))

    @property
    def solution(self) -> int:
        """A table of the places of the unknowns from ``base`` on."""
        start = self.first + self.tabled.places["solution"]
        return self.tables.of_array(start + np.arange(self.tabled.count))


def block_of(k: Integer) -> Integer:
    """The first of the eight unknowns that the ``k``-th one is among."""
    return k.operation("and", -LANES)
