"""Equations for multipliers in which most constraints meet most others: L D L^T row by row.

The upper half of the matrix is an array with a row of whole vectors for each unknown. Each pivot's row is
taken from the rows behind it, and then divided by the pivot: it is that column of L.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, TypeAlias

import numpy as np

from lagrange_cli.native.families.constraints.saddle_tables import SaddleTables
from lagrange_cli.native.families.tables import Tables, place_at, places_at
from lagrange_cli.native.families.vectors import Numbers, Operands, Vectors
from lagrange_cli.native.interface import LANES
from lagrange_cli.native.linear.pivots import FLOOR
from lagrange_cli.native.llvm.flow import Variable
from lagrange_cli.native.llvm.vector import Bit, Index, Integer, Pointer
from lagrange_cli.native.state import whole_vectors

if TYPE_CHECKING:
    from lagrange_cli.expression.index_arrays import Places


class DenseTables:
    """Where the arrays of ``count`` unknowns are behind a beginning: x, 1/D, the first entries of the
    diagonal, whether rows have others than on it, and the rows of the matrix, each of this ``width``."""

    def __init__(self, count: int, tables: Tables) -> None:
        self.count, self.tables = count, tables
        self.width = width = whole_vectors(count)
        self.places = {
            "unknowns": 0,
            "inverse": width,
            "diagonal": 2 * width,
            "filled": 3 * width,
            "matrix": 4 * width,
        }
        self.size = 4 * width + count * width
        """The doubles of all arrays."""

    def placed(self, pairs: Places, sizes: Places | None = None) -> Mapping[str, Places]:
        """Where the entries of the unknowns ``pairs`` (entries, 2), the larger first, go in the matrix; and
        where the ``sizes`` are that pivots are compared with, if these are no entries on its diagonal."""
        found = {"matrix": pairs[:, 1] * self.width + pairs[:, 0]}
        return found if sizes is None else {**found, "diagonal": sizes}


SolvingTables: TypeAlias = "SaddleTables | DenseTables"


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

    @property
    def _filled(self) -> Pointer:
        """Where doubles tell which rows have entries besides the one on the diagonal."""
        return self.f.place(self.place("filled"), 0, "double")

    def _is_filled(self, k: Integer) -> Bit:
        return self.f.load(self._filled, k) > 0.0

    def row(self, k: Integer) -> Pointer:
        """A row of the matrix."""
        return self.place("matrix", k * self.tabled.width)

    def load(self, place: Pointer, at: Integer) -> Operands:
        """Eight numbers side by side."""
        return self.vectors.operand(self.vectors.load_row(place, at, LANES))

    def store(self, value: Operands, place: Pointer, at: Integer) -> None:
        """The same, stored."""
        self.vectors.store_row(self.vectors.number(value), place, at)

    def everywhere(self, one: Numbers) -> Operands:
        """A number eight times."""
        return self.vectors.operand(self.vectors.splat(one, LANES))

    def take(self, some: Operands, row: Pointer, target: Pointer, first: Integer) -> None:
        """Take ``some`` times a ``row`` from a ``target``, from the block of the ``first`` one on."""
        with self.f.loop(block_of(first), self.tabled.width, LANES, tested=False) as j:
            self.store(self.vectors.kind.fms(some, self.load(row, j), self.load(target, j)), target, j)

    def scale(self, place: Pointer, first: Index, by: Pointer | Operands) -> None:
        """Multiply numbers from ``first`` on by one, or by as many."""
        with self.f.loop(first, self.tabled.width, LANES, tested=False) as j:
            factor = self.load(by, j) if isinstance(by, Pointer) else by
            self.store(self.vectors.kind.mul(self.load(place, j), factor), place, j)

    def factor(self, base: Pointer, entries: Mapping[str, Places], regular: Variable[Bit]) -> None:
        """L and D from the ``entries``, which are side by side from ``base`` on, and whether they are
        regular."""
        f, vectors, kind = self.f, self.vectors, self.vectors.kind
        count, width = self.tabled.count, self.tabled.width
        for name, size in (("inverse", width), ("matrix", count * width)):
            with f.loop(0, size, LANES, tested=False) as at:
                vectors.store_row(vectors.zero(LANES), self.place(name), at)
        targets = self.tables.of_array(entries["matrix"])
        with f.loop(0, len(entries["matrix"]), tested=False) as k:
            vectors.store(vectors.load(base, k), self.place("matrix"), place_at(f, k + targets))
        behind = self.tables.of_array(entries["diagonal"]) if "diagonal" in entries else None
        with f.loop(0, count, tested=False) as k:
            source, at = (self.row(k), k) if behind is None else (base, place_at(f, k + behind))
            vectors.store(vectors.load(source, at), self.place("diagonal"), k)
        least = f.constant(FLOOR * kind.unit)
        with f.loop(0, count, tested=False) as k:
            row, begin = self.row(k), block_of(k)
            pivot, whole = vectors.load(row, k), vectors.load(self.place("diagonal"), k)
            sizes = vectors.high(whole), vectors.high(pivot)
            all_of, own = sizes if self.definite else (f.magnitude(one) for one in sizes)
            regular.set(regular.get() & (all_of * least < own))
            inverse = kind.div(kind.one, self.everywhere(pivot))
            vectors.store(vectors.lane(vectors.number(inverse), 0), self.place("inverse"), k)
            with f.loop(begin, k + 1, tested=False) as j:
                vectors.store(vectors.constant(0.0), row, j)
            filled = f.variable(f.constant(0.0))
            with f.loop(k + 1, count) as i:
                entry = vectors.load(row, i)
                with f.when(~vectors.high(entry).equals(0.0)):  # most are 0 where contacts do not touch
                    self.take(kind.mul(self.everywhere(entry), inverse), row, self.row(i), i)
                    filled.set(f.constant(1.0))
            with f.when(filled.get() > 0.0):
                self.scale(row, begin, inverse)
            f.store(filled.get(), self._filled, k)

    def solve(self, right: Pointer) -> None:
        """The unknowns with K x = what is at ``right``, with a 0 behind it."""
        f, vectors, kind = self.f, self.vectors, self.vectors.kind
        count, width, unknowns = self.tabled.count, self.tabled.width, self.place("unknowns")
        table = self.tables.of_places([*range(count), *[count] * (width - count)])
        with f.loop(0, width, LANES, tested=False) as at:
            vectors.store_row(vectors.gather(right, places_at(f, at + table)), unknowns, at)
        with f.loop(0, count, tested=False) as k, f.when(self._is_filled(k)):
            self.take(self.everywhere(vectors.load(unknowns, k)), self.row(k), unknowns, k)
        self.scale(unknowns, 0, self.place("inverse"))
        with f.loop(0, count, tested=False) as done:
            k = f.count(count - 1) - done
            with f.when(self._is_filled(k)):
                row, total = self.row(k), vectors.variable(vectors.zero(LANES))
                with f.loop(block_of(k), width, LANES, tested=False) as j:
                    less = kind.fms(self.load(row, j), self.load(unknowns, j), vectors.operand(total.get()))
                    total.set(vectors.number(less))
                vectors.store(vectors.total(total.get(), vectors.load(unknowns, k)), unknowns, k)

    @property
    def solution(self) -> int:
        """A table of the places of the unknowns from ``base`` on."""
        start = self.first + self.tabled.places["unknowns"]
        return self.tables.of_array(start + np.arange(self.tabled.count))


def block_of(k: Integer) -> Integer:
    """The first of the eight unknowns that the ``k``-th one is among."""
    return k.operation("and", -LANES)
