"""Equations for multipliers of which some follow from others, in parts that do not meet each other.

Each part is a small block whose rank is known, eliminated by complete pivoting (``linear.dependent``). The
multipliers of a part are those of least norm.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np

from lagrange_cli.families.elimination import parts_of
from lagrange_cli.native.families.tables import Tables, place_at
from lagrange_cli.native.families.vectors import Vectors
from lagrange_cli.native.linear.dependent import FACTOR, SOLVE, size_of
from lagrange_cli.native.llvm.flow import Variable
from lagrange_cli.native.llvm.vector import Bit, Index, Integer, Pointer
from lagrange_cli.native.numbers.kind import Written
from lagrange_cli.native.state import whole_vectors

if TYPE_CHECKING:
    from lagrange_cli.expression.index_arrays import Places


class DependentTables:
    """Where things are behind a beginning: the solution of ``count`` unknowns, and then the block of each
    part of them. From number ``first`` on, unknowns are multipliers; ``surplus`` of them follow from others.

    Blocks have the numbers of ``linear.dependent`` side by side, also if these have two parts.
    """

    def __init__(
        self, count: int, pairs: Places, first: int, surplus: Collection[int], tables: Tables
    ) -> None:
        self.count, self.first, self.tables = count, first, tables
        self.parts = parts_of(count, pairs)
        self.surplus = [sum(i in surplus for i in part) for part in self.parts]
        sizes = [whole_vectors(2 * size_of(len(part), more)) for part, more in zip(self.parts, self.surplus)]
        ends = np.cumsum([whole_vectors(count), *sizes])
        self.blocks: list[int] = ends[:-1].tolist()
        """Where each block is."""
        self.size = int(ends[-1])
        """The doubles of all arrays."""

    def placed(self, pairs: Places, sizes: Places | None = None) -> Mapping[str, Places]:
        """The unknowns of the entries ``pairs`` (entries, 2)."""
        return {"rows": pairs[:, 1], "columns": pairs[:, 0]}


class InTurn:
    """What solves for multipliers, from ``base[first]`` on."""

    definite = True

    def __init__(self, vectors: Vectors, tabled: DependentTables, base: Pointer | str, first: int) -> None:
        self.f, self.vectors, self.base, self.first = vectors.f, vectors, base, first
        self.tabled, self.tables = tabled, tabled.tables
        self.single: Written[object] = vectors.single()
        parts, surplus = tabled.parts, tabled.surplus
        self._sizes, self._ranks, self._blocks, self._begins = (
            self.tables.of_array(np.array(one, dtype=np.int64))
            for one in (
                [len(part) for part in parts],
                [len(part) - more for part, more in zip(parts, surplus)],
                tabled.blocks,
                np.cumsum([0, *map(len, parts)]),
            )
        )
        self._unknowns = self.tables.of_array(np.concatenate([np.array(part) for part in parts]))

    def place(self, at: Index) -> Pointer:
        """A place behind the beginning."""
        return self.vectors.place(self.base, at + self.first if isinstance(at, Integer) else self.first + at)

    def factor(self, base: Pointer, entries: Mapping[str, Places], regular: Variable[Bit]) -> None:
        """Factor the blocks, whose ``entries`` are side by side from ``base`` on, and find out whether they
        have their ranks."""
        f, single, doubles = self.f, self.single, self.single.parts
        ends, which, above, below = map(self.tables.of_array, self._sorted(entries))
        with f.loop(0, len(self.tabled.parts), tested=False) as part:
            block, n = self._block(part), place_at(f, part + self._sizes)
            with f.loop(0, n * n * doubles, tested=False) as i:
                f.store(f.constant(0.0), block, i)
            with f.loop(place_at(f, part + ends), place_at(f, part + (ends + 1))) as e:
                entry = self.vectors.operand(self.vectors.load(base, place_at(f, e + which)))
                for table in (above, below):
                    single.store(entry, block.name, (place_at(f, e + table) * doubles).name, 1)
            self._measure(part, block, n)
            rank = place_at(f, part + self._ranks)
            made = f.call(Bit, f"{FACTOR}_{doubles}", block, rank, n, lanes=1)
            regular.set(regular.get() & made)

    def solve(self, right: Pointer) -> None:
        """The unknowns with K x = what is at ``right``."""
        f, single, doubles, vectors = self.f, self.single, self.single.parts, self.vectors
        with f.loop(0, len(self.tabled.parts), tested=False) as part:
            block, n = self._block(part), place_at(f, part + self._sizes)
            begin, behind = place_at(f, part + self._begins), n * n
            with f.loop(0, n, tested=False) as i:
                unknown = place_at(f, begin + i + self._unknowns)
                value = vectors.operand(vectors.load(right, unknown))
                single.store(value, block.name, ((behind + i) * doubles).name, 1)
            rank = place_at(f, part + self._ranks)
            f.call(None, f"{SOLVE}_{doubles}", block, rank, n)
            with f.loop(0, n, tested=False) as i:
                value = single.load(block.name, ((behind + i) * doubles).name, 1)
                unknown = place_at(f, begin + i + self._unknowns)
                vectors.store(vectors.of_single(value), self.place(0), unknown)

    @property
    def solution(self) -> int:
        """A table of the places of the unknowns from ``base`` on."""
        return self.tables.of_array(self.first + np.arange(self.tabled.count))

    def _block(self, part: Integer) -> Pointer:
        """The place of a block."""
        return self.f.place(self.place(place_at(self.f, part + self._blocks)), 0, "double")

    def _measure(self, part: Integer, block: Pointer, n: Integer) -> None:
        """In which units rows are compared: of coordinates their own largest entry, of constraints that of
        all of these."""
        f, doubles = self.f, self.single.parts
        common = f.variable(f.constant(0.0))
        begin, units = place_at(f, part + self._begins), f.place(block, (n + 1) * n * doubles)
        with f.loop(0, n, tested=False) as i:
            largest = f.variable(f.constant(0.0))
            with f.loop(0, n, tested=False) as j:
                size = f.magnitude(f.load_row(block, (i * n + j) * doubles, 1))
                largest.set(f.function("maxnum", largest.get(), size))
            f.store_row(largest.get(), units, i * doubles)
            with f.when(~(place_at(f, begin + i + self._unknowns) < self.tabled.first)):
                common.set(f.function("maxnum", common.get(), largest.get()))
        with f.loop(0, n, tested=False) as i:
            bound = ~(place_at(f, begin + i + self._unknowns) < self.tabled.first)
            size = f.select(bound, common.get(), f.load_row(units, i * doubles, 1))
            f.store_row(f.constant(1.0) / size, units, i * doubles)
            if doubles > 1:
                f.store_row(f.constant(0.0), units, i * doubles + 1)

    def _sorted(self, entries: Mapping[str, Places]) -> Sequence[Places]:
        """Where the entries of each part begin; which entries these are, and where they are in its block,
        above and below the diagonal."""
        of, within = np.zeros((2, self.tabled.count), dtype=np.int64)
        sizes = np.array([len(part) for part in self.tabled.parts])
        for number, part in enumerate(self.tabled.parts):
            of[part], within[part] = number, np.arange(len(part))
        rows, columns = entries["rows"], entries["columns"]
        order = np.argsort(of[rows], kind="stable")
        begins = np.searchsorted(of[rows][order], np.arange(len(sizes) + 1))
        i, j, n = within[rows][order], within[columns][order], sizes[of[rows]][order]
        return begins, order, i * n + j, j * n + i
