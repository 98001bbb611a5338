"""Elimination with row interchanges of real and complex matrices that are full or banded, several columns at
a time.

Column by column (Golub and Van Loan, Matrix Computations, 4th ed., sec. 3.4 and 4.3.5). Element (i, j) is at
i * ``stride`` + j + ``first``: of a band, a row holds what is up to ``reach`` before its diagonal and twice
as far behind it, as interchanges may fill it. A full matrix is one whose band reaches everywhere. Behind each
row are zeros, so that vectors may end there. Of complex matrices, imaginary parts are ``doubles`` further.
"""

from __future__ import annotations

from typing import TypeAlias

from lagrange_cli.native.llvm.function import Function
from lagrange_cli.native.llvm.vector import Integer, Real
from lagrange_cli.native.state import LANES, whole_vectors
from lagrange_cli.records import dataclass

Number: TypeAlias = "tuple[Real, ...]"
"""A real number, or the two parts of a complex one."""


@dataclass(frozen=True)
class Banded:
    """Where the elements of a matrix of ``size`` rows are that are at most ``reach`` from the diagonal."""

    size: int
    reach: int

    @property
    def full(self) -> bool:
        """Whether nothing is saved by a band."""
        return 3 * self.reach + 1 + LANES >= self.size

    @property
    def lanes(self) -> int:
        """Columns that are worked on at a time: not many more than there are."""
        most = self.size if self.full else 2 * self.reach
        return next((lanes for lanes in (2, 4) if lanes >= most), LANES)

    @property
    def stride(self) -> int:
        """From an element to the one below it."""
        return whole_vectors(self.size, 1) if self.full else 3 * self.reach + LANES

    @property
    def first(self) -> int:
        """Where element (0, 0) is."""
        return 0 if self.full else self.reach

    @property
    def doubles(self) -> int:
        """Doubles of a matrix, or of a part of a complex one."""
        return whole_vectors(self.size * (self.stride + 1), 1)

    @property
    def length(self) -> int:
        """Doubles of a right-hand side, and of what is behind its numbers."""
        return whole_vectors(self.size, 1)

    @property
    def factors(self) -> int:
        """Doubles of a column of L."""
        return whole_vectors(self.size if self.full else self.reach, 1)

    @property
    def more(self) -> int:
        """Doubles that its factorization takes besides, for each part: columns of L, inverse pivots, and
        (for the first part only) the rows that rows were exchanged with."""
        return self.size * self.factors + 2 * self.length

    def room(self, parts: int) -> int:
        """Doubles of a matrix of so many parts with its factorization."""
        return parts * (self.doubles + self.more)

    def at(self, i: Integer, j: Integer) -> Integer:
        """The place of an element."""
        place = i * self.stride + j
        return place + self.first if self.first else place

    def within(self, f: Function, i: Integer) -> tuple[Integer, Integer]:
        """The first column of the band in a row, and the one behind the last one."""
        if self.full:
            return f.count(0), f.count(self.size)
        low = f.select(i > self.reach, i - self.reach, f.count(0))
        return low, self.end(f, i + (self.reach + 1))

    def end(self, f: Function, last: Integer) -> Integer:
        """This column, or the one behind the last one."""
        return f.select(last < self.size, last, f.count(self.size))

    # functions

    def functions(self, parts: int) -> list[Function]:
        """``@factor_<parts>(a)`` and ``@solve_<parts>(a, x)``, for matrices of so many parts with what is
        ``more`` behind them; parts of ``x`` are ``length`` apart."""
        return [_Factor(self, parts).write(), _Solve(self, parts).write()]


class _Elimination:
    """What both functions do with numbers of 1 or 2 parts."""

    def __init__(self, band: Banded, parts: int, head: str) -> None:
        self.band, self.parts, self.lanes = band, parts, band.lanes
        self.f = Function(head)
        start = parts * band.doubles
        self.columns = [start + k * band.size * band.factors for k in range(parts)]
        start += parts * band.size * band.factors
        self.inverses = [start + k * band.length for k in range(parts)]
        self.pivots = self.f.place("%a", start + parts * band.length, "i64")

    def get(self, index: Integer, places: list[int], lanes: int = 1) -> Number:
        """Numbers of the factorization."""
        return tuple(self.f.load_row("%a", index + place, lanes) for place in places)

    def put(self, value: Number, index: Integer, places: list[int]) -> None:
        for one, place in zip(value, places):
            self.f.store_row(one, "%a", index + place)

    @property
    def matrix(self) -> list[int]:
        """Where the parts of elements are."""
        return [k * self.band.doubles for k in range(self.parts)]

    def times(self, a: Number, b: Number) -> Number:
        """a b"""
        if self.parts == 1:
            return (a[0] * b[0],)
        f = self.f
        return f.fused(-a[1], b[1], a[0] * b[0]), f.fused(a[1], b[0], a[0] * b[1])

    def less(self, c: Number, a: Number, b: Number) -> Number:
        """c - a b"""
        f = self.f
        if self.parts == 1:
            return (f.fused(-a[0], b[0], c[0]),)
        real = f.fused(a[1], b[1], f.fused(-a[0], b[0], c[0]))
        return real, f.fused(-a[1], b[0], f.fused(-a[0], b[1], c[1]))

    def wide(self, a: Number) -> Number:
        """A number in every lane."""
        return tuple(self.f.splat(one, self.lanes) for one in a)

    def last_column(self, k: Integer) -> Integer:
        """The column behind the last one that row k may have something in."""
        band = self.band
        return self.f.count(band.size) if band.full else band.end(self.f, k + (2 * band.reach + 1))

    def last_row(self, k: Integer) -> Integer:
        """The row behind the last one that column k may have something in."""
        band = self.band
        return self.f.count(band.size) if band.full else band.end(self.f, k + (band.reach + 1))


class _Factor(_Elimination):
    def __init__(self, band: Banded, parts: int) -> None:
        super().__init__(band, parts, f"define internal void @factor_{parts}(ptr noalias %a) #0")

    def write(self) -> Function:
        """P M = L U: the columns of L, the inverses of U's diagonal, and the interchanges. Where a pivot is
        0, they are not finite."""
        f, band = self.f, self.band
        with f.loop(0, band.size, tested=False) as k:
            last, end = self.last_row(k), self.last_column(k)
            chosen, largest = f.variable(k), f.variable(self._size(k, k))
            with f.loop(k + 1, last) as i:
                here = self._size(i, k)
                larger = here > largest.get()
                chosen.set(f.select(larger, i, chosen.get()))
                largest.set(f.select(larger, here, largest.get()))
            f.store(chosen.get(), self.pivots, k)
            with f.when(~chosen.get().equals(k)):
                self._exchange(k, chosen.get(), end)
            inverse = self._inverse(self.get(band.at(k, k), self.matrix))
            self.put(inverse, k, self.inverses)
            with f.loop(k + 1, last) as i:
                factor = self.times(self.get(band.at(i, k), self.matrix), inverse)
                self.put(factor, k * (band.factors - 1) + (i - 1), self.columns)
                wide = self.wide(factor)
                with f.loop(k + 1, end, self.lanes) as j:
                    place = band.at(i, j)
                    above = self.get(band.at(k, j), self.matrix, self.lanes)
                    here_too = self.get(place, self.matrix, self.lanes)
                    self.put(self.less(here_too, wide, above), place, self.matrix)
        f.give()
        return f

    def _size(self, i: Integer, k: Integer) -> Real:
        sizes = [self.f.magnitude(one) for one in self.get(self.band.at(i, k), self.matrix)]
        return sizes[0] if self.parts == 1 else sizes[0] + sizes[1]

    def _exchange(self, k: Integer, other: Integer, end: Integer) -> None:
        with self.f.loop(k, end, self.lanes, tested=False) as j:
            places = self.band.at(k, j), self.band.at(other, j)
            rows = [self.get(place, self.matrix, self.lanes) for place in places]
            for place, row in zip(places, reversed(rows)):
                self.put(row, place, self.matrix)

    def _inverse(self, a: Number) -> Number:
        one = self.f.constant(1.0)
        if self.parts == 1:
            return (one / a[0],)
        share = one / self.f.fused(a[0], a[0], a[1] * a[1])
        return a[0] * share, -(a[1] * share)


class _Solve(_Elimination):
    def __init__(self, band: Banded, parts: int) -> None:
        super().__init__(
            band, parts, f"define internal void @solve_{parts}(ptr noalias %a, ptr noalias %x) #0"
        )
        self.places = [self.f.place("%x", k * band.length, "double") for k in range(parts)]

    def write(self) -> Function:
        """``x`` becomes M^-1 x. What is behind its numbers becomes 0 first: another ``x`` that was not finite
        has left its traces there."""
        f, band = self.f, self.band
        for place in self.places:
            f.store_row(f.zero(LANES), place, f.count(band.size))
        with f.loop(0, band.size, tested=False) as k:
            other, value = f.load_integer(self.pivots, k), self._x(k)
            known = self._x(other)
            self._put(value, other)
            self._put(known, k)
            wide = self.wide(known)
            with f.loop(k + 1, self.last_row(k), self.lanes) as i:
                column = self.get(k * (band.factors - 1) + (i - 1), self.columns, self.lanes)
                self._put(self.less(self._x(i, self.lanes), wide, column), i)
        with f.loop(0, band.size, tested=False) as done:
            k = f.count(band.size - 1) - done
            rest = [f.variable(f.zero(self.lanes)) for _ in range(self.parts)]
            with f.loop(k + 1, self.last_column(k), self.lanes) as j:
                row, x = self.get(band.at(k, j), self.matrix, self.lanes), self._x(j, self.lanes)
                less = self.less(tuple(one.get() for one in rest), row, x)
                for one, part in zip(rest, less):
                    one.set(part)
            sums = tuple(f.reduce("fadd", r.get(), x) for r, x in zip(rest, self._x(k)))
            self._put(self.times(sums, self.get(k, self.inverses)), k)
        f.give()
        return f

    def _x(self, i: Integer, lanes: int = 1) -> Number:
        return tuple(self.f.load_row(place, i, lanes) for place in self.places)

    def _put(self, value: Number, i: Integer) -> None:
        for one, place in zip(value, self.places):
            self.f.store_row(one, place, i)
