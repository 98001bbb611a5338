"""Equations for multipliers of which some follow from others: an elimination of blocks of known rank.

The unknowns of parts that do not meet each other are such blocks, if they are few. In larger parts, those
constraints are a block of which some follow from the others, and any other unknown is one. With K_bb for a
block, K_cb for what couples later ones with it, and G_b for its solution of least norm, by complete pivoting
(``linear.dependent``),

    K_cd <- K_cd - K_cb G_b K_bd,    y_c <- y_c - K_cb G_b y_b,    x_b = G_b y_b - sum_c (G_b K_bc) x_c.

A combination z of the constraints in a block with K z = 0 has K_cb z = 0. So it is left to the block whatever
is eliminated before, and the x_b of least norm are, together, the multipliers of least norm.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from contextlib import contextmanager
from itertools import pairwise
from typing import TYPE_CHECKING

import numpy as np

from lagrange_cli.families.elimination import Blocks
from lagrange_cli.native.families.tables import Tables, place_at
from lagrange_cli.native.families.vectors import Vectors
from lagrange_cli.native.linear.dependent import FACTOR, SOLVE, size_of
from lagrange_cli.native.llvm.flow import Variable
from lagrange_cli.native.llvm.vector import Bit, Index, Integer, Pointer
from lagrange_cli.native.numbers.kind import Written
from lagrange_cli.native.state import whole_vectors

if TYPE_CHECKING:
    from collections.abc import Iterator

    from lagrange_cli.expression.index_arrays import Places


class DependentTables:
    """Where things are behind a beginning: the solution of ``count`` unknowns, the blocks, and for each block
    and each later one that it meets K_cb and (G_b K_bc)^T, row by row. From number ``first`` on, unknowns are
    multipliers; ``surplus`` of them follow from others.

    Numbers lie side by side, as those of ``linear.dependent``, also if they have two parts.
    """

    def __init__(
        self, count: int, found: Blocks, first: int, surplus: Collection[int], tables: Tables
    ) -> None:
        self.count, self.first, self.tables = count, first, tables
        self.blocks = [np.array(one, dtype=np.int64) for one in found.blocks]
        self.sizes = np.array([len(one) for one in self.blocks], dtype=np.int64)
        self.surplus = np.array([sum(i in surplus for i in one) for one in found.blocks], dtype=np.int64)
        self.met = np.array([c for later in found.columns for c in later], dtype=np.int64)
        """The later ones, block by block."""
        self.begins = np.cumsum([0, *map(len, found.columns)])
        """Where those of each block begin."""
        self.meeting = np.repeat(np.arange(len(self.blocks)), np.diff(self.begins))
        """The blocks that these are met by."""
        areas = [size_of(n, more) for n, more in zip(self.sizes.tolist(), self.surplus.tolist())]
        both = (self.sizes[self.meeting] * self.sizes[self.met]).tolist()
        listed = count, len(both), *(2 * one for one in (*areas, *both, *both))
        ends = np.cumsum([*map(whole_vectors, listed)])
        """Each number may take two doubles."""
        self.filled = int(ends[0])
        """Where it is said which K_cb are not 0: contacts that hold nothing have none."""
        places = np.split(ends[1:-1], [len(areas), len(areas) + len(both)])
        self.at_blocks, self.at_couplings, self.at_shares = places
        self.size = int(ends[-1])
        """The doubles of all arrays."""

    def placed(self, pairs: Places, sizes: Places | None = None) -> Mapping[str, Places]:
        """The unknowns of the entries ``pairs`` (entries, 2)."""
        return {"rows": pairs[:, 1], "columns": pairs[:, 0]}

    def coupling(self, later: Places, earlier: Places) -> Places:
        """The number of what couples blocks with earlier ones."""
        count = len(self.blocks)
        keys = self.meeting * count + self.met
        order = np.argsort(keys)
        found: Places = order[np.searchsorted(keys[order], earlier * count + later)]
        return found


class InTurn:
    """What solves for multipliers, from ``base[first]`` on."""

    definite = True

    def __init__(self, vectors: Vectors, tabled: DependentTables, base: Pointer | str, first: int) -> None:
        self.f, self.vectors, self.base, self.first = vectors.f, vectors, base, first
        self.tabled, self.tables = tabled, tabled.tables
        self.single: Written[object] = vectors.single()
        self.doubles = self.single.parts
        array = self.tables.of_array
        self._sizes, self._ranks = array(tabled.sizes), array(tabled.sizes - tabled.surplus)
        self._blocks, self._couplings, self._shares = map(
            array, (tabled.at_blocks, tabled.at_couplings, tabled.at_shares)
        )
        self._begins = array(np.cumsum([0, *tabled.sizes.tolist()]))
        self._unknowns = array(np.concatenate(tabled.blocks))
        self._first, self._met = array(tabled.begins), array(tabled.met)

    def place(self, at: Index) -> Pointer:
        """A place behind the beginning."""
        return self.vectors.place(self.base, at + self.first if isinstance(at, Integer) else self.first + at)

    def factor(self, base: Pointer, entries: Mapping[str, Places], regular: Variable[Bit]) -> None:
        """Factor the blocks, whose ``entries`` are side by side from ``base`` on, and find out whether they
        have their ranks."""
        f, tabled = self.f, self.tabled
        self._clear()
        self._fill(base, entries)
        with self._each_block() as (b, block, n):
            self._measure(b, block, n)
            rank = place_at(f, b + self._ranks)
            made = f.call(Bit, f"{FACTOR}_{self.doubles}", block, rank, n, lanes=1)
            regular.set(regular.get() & made)
            if len(tabled.met):
                with self._each_met(b) as c:
                    self._share(block, n, rank, c)
                self._update(b, n)

    def solve(self, right: Pointer) -> None:
        """The unknowns with K x = what is at ``right``."""
        f, single, vectors = self.f, self.single, self.vectors
        with self._each_block() as (b, block, n), f.loop(0, n, tested=False) as i:
            value = vectors.operand(vectors.load(right, self._unknown(b, i)))
            self._put(value, block, n * n + i)
        with self._each_block() as (b, block, n):
            f.call(None, f"{SOLVE}_{self.doubles}", block, place_at(f, b + self._ranks), n)
            if len(self.tabled.met):
                self._forward(b, block, n)
        with self._each_block(backward=True) as (b, block, n):
            if len(self.tabled.met):
                self._backward(b, block, n)
            with f.loop(0, n, tested=False) as i:
                value = single.load(block.name, ((n * n + i) * self.doubles).name, 1)
                vectors.store(vectors.of_single(value), self.place(0), self._unknown(b, i))

    @property
    def solution(self) -> int:
        """A table of the places of the unknowns from ``base`` on."""
        return self.tables.of_array(self.first + np.arange(self.tabled.count))

    # places

    def _at(self, at: Integer) -> Pointer:
        """The place of a block, or of what couples two of them."""
        return self.f.place(self.place(at), 0, "double")

    def _get(self, place: Pointer, at: Integer) -> object:
        return self.single.load(place.name, (at * self.doubles).name, 1)

    def _put(self, value: object, place: Pointer, at: Integer) -> None:
        self.single.store(value, place.name, (at * self.doubles).name, 1)

    def _take(self, a: object, b: object, place: Pointer, at: Integer) -> None:
        """Take a b from a number."""
        self._put(self.single.fms(a, b, self._get(place, at)), place, at)

    def _unknown(self, b: Integer, i: Integer) -> Integer:
        """The ``i``-th unknown of a block."""
        return place_at(self.f, place_at(self.f, b + self._begins) + i + self._unknowns)

    @contextmanager
    def _each_block(self, *, backward: bool = False) -> Iterator[tuple[Integer, Pointer, Integer]]:
        """Each block, its place and its size."""
        f, count = self.f, len(self.tabled.blocks)
        with f.loop(0, count, tested=False) as k:
            b = f.count(count - 1) - k if backward else k
            yield b, self._at(place_at(f, b + self._blocks)), place_at(f, b + self._sizes)

    @contextmanager
    def _each_met(self, b: Integer) -> Iterator[Integer]:
        """What couples each later block with a block."""
        f = self.f
        with f.loop(place_at(f, b + self._first), place_at(f, b + (self._first + 1))) as c:
            yield c

    # factors

    def _clear(self) -> None:
        f = self.f
        with self._each_block() as (_, block, n), f.loop(0, n * n * self.doubles, tested=False) as i:
            f.store(f.constant(0.0), block, i)
        if len(self.tabled.met):
            begin, end = int(self.tabled.at_couplings[0]), int(self.tabled.at_shares[0])
            with f.loop(0, end - begin, tested=False) as i:
                f.store(f.constant(0.0), self._at(f.count(begin)), i)

    def _fill(self, base: Pointer, entries: Mapping[str, Places]) -> None:
        """Entries above and below the diagonals of blocks, and beside them; and what is on the diagonal."""
        f, tabled = self.f, self.tabled
        of, within = np.zeros((2, tabled.count), dtype=np.int64)
        for number, one in enumerate(tabled.blocks):
            of[one], within[one] = number, np.arange(len(one))
        rows, columns = entries["rows"], entries["columns"]
        swapped = of[rows] < of[columns]
        later, earlier = np.where(swapped, columns, rows), np.where(swapped, rows, columns)
        c, b, i, j = of[later], of[earlier], within[later], within[earlier]
        inside, n = b == c, tabled.sizes[b]
        first = np.empty(len(rows), dtype=np.int64)
        first[inside] = tabled.at_blocks[b[inside]]
        if not inside.all():
            first[~inside] = tabled.at_couplings[tabled.coupling(c[~inside], b[~inside])]
        above = first + (i * n + j) * self.doubles
        below = np.where(inside, first + (j * n + i) * self.doubles, above)
        tables = [self.tables.of_array(one) for one in (above, below)]
        whole = self._at(f.count(0))
        with f.loop(0, len(rows), tested=False) as e:
            entry = self.vectors.operand(self.vectors.load(base, e))
            for table in tables:
                self.single.store(entry, whole.name, place_at(f, e + table).name, 1)
        with self._each_block() as (_, block, size), f.loop(0, size, tested=False) as k:
            f.store(f.constant(0.0), block, (size * (size + 2) + k) * self.doubles)
            self._remember(block, size, k)

    def _remember(self, block: Pointer, n: Integer, k: Integer) -> None:
        """Keep the largest number that has been on the diagonal."""
        f, place = self.f, (n * (n + 2) + k) * self.doubles
        size = f.magnitude(f.load(block, (k * n + k) * self.doubles))
        f.store(f.function("maxnum", f.load(block, place), size), block, place)

    def _measure(self, b: Integer, block: Pointer, n: Integer) -> None:
        """In which units rows are compared: of coordinates their own largest entry, of constraints that of
        all of these."""
        f, doubles = self.f, self.doubles
        common = f.variable(f.constant(0.0))
        units = f.place(block, (n + 1) * n * doubles)
        with f.loop(0, n, tested=False) as i:
            largest = f.variable(f.constant(0.0))
            with f.loop(0, n, tested=False) as j:
                size = f.magnitude(f.load_row(block, (i * n + j) * doubles, 1))
                largest.set(f.function("maxnum", largest.get(), size))
            f.store_row(largest.get(), units, i * doubles)
            with f.when(~(self._unknown(b, i) < self.tabled.first)):
                common.set(f.function("maxnum", common.get(), largest.get()))
        with f.loop(0, n, tested=False) as i:
            bound = ~(self._unknown(b, i) < self.tabled.first)
            size = f.select(bound, common.get(), f.load_row(units, i * doubles, 1))
            f.store_row(f.constant(1.0) / size, units, i * doubles)
            if doubles > 1:
                f.store_row(f.constant(0.0), units, i * doubles + 1)

    def _share(self, block: Pointer, n: Integer, rank: Integer, c: Integer) -> None:
        """(G_b K_bc)^T, row by row."""
        f, behind = self.f, n * n
        coupling, shares = (self._at(place_at(f, c + table)) for table in (self._couplings, self._shares))
        found, count = f.variable(f.constant(0.0)), self._size_of_met(c)
        with f.loop(0, n * count, tested=False) as k:
            size = f.magnitude(f.load(coupling, k * self.doubles))
            found.set(f.function("maxnum", found.get(), size))
        f.store(found.get(), self._at(c + self.tabled.filled))
        with f.when(self._is_filled(c)), f.loop(0, count, tested=False) as j:
            with f.loop(0, n, tested=False) as i:
                self._put(self._get(coupling, j * n + i), block, behind + i)
            f.call(None, f"{SOLVE}_{self.doubles}", block, rank, n)
            with f.loop(0, n, tested=False) as i:
                self._put(self._get(block, behind + i), shares, j * n + i)

    def _update(self, b: Integer, n: Integer) -> None:
        """Take from later blocks, and from what couples them, what a block gives to them."""
        f, tabled = self.f, self.tabled
        first, second, begins = self._pairs()
        later, earlier = tabled.met[first], tabled.met[second]
        alone = later == earlier
        targets = np.empty(len(first), dtype=np.int64)
        targets[alone] = tabled.at_blocks[later[alone]]
        targets[~alone] = tabled.at_couplings[tabled.coupling(later[~alone], earlier[~alone])]
        listed = first, second, targets, tabled.sizes[earlier], alone.astype(np.int64)
        table = [self.tables.of_array(one) for one in (begins, *listed)]
        with f.loop(place_at(f, b + table[0]), place_at(f, b + (table[0] + 1))) as u:
            c, d, at, width, own = (place_at(f, u + one) for one in table[1:])
            coupling = self._at(place_at(f, c + self._couplings))
            shares, target = self._at(place_at(f, d + self._shares)), self._at(at)
            with (
                f.when(self._is_filled(c) & self._is_filled(d)),
                f.loop(0, self._size_of_met(c), tested=False) as i,
                f.loop(0, width, tested=False) as j,
                f.loop(0, n, tested=False) as k,
            ):
                one, other = self._get(coupling, i * n + k), self._get(shares, j * n + k)
                self._take(one, other, target, i * width + j)
            with f.when(own.equals(1)), f.loop(0, width, tested=False) as i:
                self._remember(target, width, i)

    def _pairs(self) -> Sequence[Places]:
        """All pairs of later ones that a block meets: what couples both with it, the one that is eliminated
        later first; and where the pairs of each block begin."""
        met, begins = self.tabled.met.tolist(), self.tabled.begins.tolist()
        found: list[tuple[int, int]] = []
        ends = [0]
        for begin, end in pairwise(begins):
            found += [(c, d) for c in range(begin, end) for d in range(begin, end) if met[c] >= met[d]]
            ends.append(len(found))
        first, second = np.array(found, dtype=np.int64).reshape(-1, 2).T
        return first, second, np.array(ends)

    def _is_filled(self, c: Integer) -> Bit:
        """Whether what couples a later block with an earlier one is not 0."""
        return ~self.f.load(self._at(c + self.tabled.filled)).equals(0.0)

    def _size_of_met(self, c: Integer) -> Integer:
        """The size of a later block."""
        return place_at(self.f, place_at(self.f, c + self._met) + self._sizes)

    # solution

    def _forward(self, b: Integer, block: Pointer, n: Integer) -> None:
        """Take from the right-hand sides of later blocks what the unknowns of a block give to them."""
        f = self.f
        with self._each_met(b) as c, f.when(self._is_filled(c)):
            later = place_at(f, c + self._met)
            size, to = place_at(f, later + self._sizes), self._at(place_at(f, later + self._blocks))
            coupling = self._at(place_at(f, c + self._couplings))
            with f.loop(0, size, tested=False) as j, f.loop(0, n, tested=False) as k:
                self._take(self._get(coupling, j * n + k), self._get(block, n * n + k), to, size * size + j)

    def _backward(self, b: Integer, block: Pointer, n: Integer) -> None:
        """Take from the unknowns of a block what those of later ones give to them."""
        f = self.f
        with self._each_met(b) as c, f.when(self._is_filled(c)):
            later = place_at(f, c + self._met)
            size, by = place_at(f, later + self._sizes), self._at(place_at(f, later + self._blocks))
            shares = self._at(place_at(f, c + self._shares))
            with f.loop(0, size, tested=False) as j, f.loop(0, n, tested=False) as k:
                self._take(self._get(shares, j * n + k), self._get(by, size * size + j), block, n * n + k)
