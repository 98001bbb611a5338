"""``Lengths``: the rows of a state and their series as step control sees them: doubles, in every kind of
number.

A vector of them is a few rows of one motion side by side, one row of several motions, or a single double (the
high part of a number). What is written over ``Lengths`` is written once for all of them.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from typing import overload

from lagrange_cli.native.llvm.function import Function
from lagrange_cli.native.llvm.vector import Bit, Index, Integer, Pointer, Real
from lagrange_cli.native.state import LANES, whole_vectors, width_of
from lagrange_cli.records import dataclass, replace


@dataclass(frozen=True)
class Lengths:
    """Where they are: places and distances in doubles.

    q, v and other rows follow one another, ``degrees`` of the first two, ``rows`` in all; there are places
    for ``width``. The ``order`` is that of q's series. A vector has ``lanes`` doubles, of ``together`` rows.
    From a row to the next it is ``row`` doubles in ``%work``, where coefficient 0 of row 0 is at ``first``;
    from a coefficient to the next it is ``term``.

    Steps are chosen by the velocities, or by the rows that are ``followed`` instead: the first of them, and
    how many they are. If they are ``apart``, nothing that other rows hold has a say, nor what is no number.
    If ``floor`` is not 0, no velocity is measured by less than what is at its row from there on in ``%work``.
    If coordinates are ``followers``, they have no series of their own: it follows from the velocities'.
    Where rows are taken one by one, series may be ``packed`` with those of so many rows.
    """

    degrees: int
    rows: int
    width: int
    order: int
    lanes: int
    together: int
    row: int
    term: int
    first: int = 0
    followed: tuple[int, int] = (0, 0)
    apart: bool = False
    floor: int = 0
    followers: bool = False
    packed: int = 1

    @property
    def leading(self) -> tuple[int, int]:
        """The rows that steps are chosen by: the first one, and how many."""
        return self.followed if self.followed[1] else (self.degrees, self.degrees)

    @property
    def top(self) -> int:
        """The order to which velocities are known."""
        return self.order - 1

    @property
    def motions(self) -> int:
        """How many motions there are: so many numbers each of them has of its own."""
        return self.lanes // self.together

    @contextmanager
    def each(self, f: Function, first: Index = 0, last: Index | None = None) -> Iterator[Row]:
        """Rows of the state, one vector after another: all of them, or some."""
        if last is None:
            last = self.width if self.together > 1 else self.rows
        with f.loop(first, last, self.together, tested=False) as i:
            yield Row(self, f, i)

    @contextmanager
    def stored(self, f: Function) -> Iterator[Row]:
        """The vectors of rows that have series of their own."""
        with self.velocities(f) if self.followers else self.each(f) as row:
            yield row

    @property
    def speeds(self) -> tuple[int, int]:
        """The rows of these vectors."""
        first, count = self.leading
        if self.together == 1:
            return first, first + count
        last = min(self.width, whole_vectors(first + count)) if self.followers else self.width
        return self.vector(first), last

    def one_by_one(self) -> Lengths:
        """The same rows, each a vector of its own."""
        return replace(self, lanes=1, together=1, packed=self.lanes)

    @overload
    def vector(self, row: int) -> int: ...
    @overload
    def vector(self, row: Index) -> Index: ...
    def vector(self, row: Index) -> Index:
        """The first row of the vector that one is in."""
        return row & -self.together

    @contextmanager
    def velocities(self, f: Function, rows: tuple[Integer, Integer] | None = None) -> Iterator[Row]:
        """The vectors that hold velocities (``leading``), and others where there are several rows in each; or
        those in some ``rows``."""
        first, last = rows or self.speeds
        with f.loop(first, last, self.together, tested=False) as i:
            yield Row(self, f, i)

    def place(self, f: Function, row: Integer, work: Pointer | str = "%work") -> Pointer:
        """Where coefficient 0 of a row is, the first one of its vector."""
        if self.row == 1:
            at = row
        elif self.packed == 1:
            at = row * self.row
        else:
            lane = row & (self.packed - 1)
            at = (row - lane) * self.row + lane
        return f.place(work, at + self.first if self.first else at, "double")

    def gather(self, f: Function, operation: str, value: Real) -> Real:
        """For each motion the largest (``fmax``) or least number (``fmin``), or their sum (``fadd``)."""
        if self.together == 1:
            return value
        return f.reduce(operation, value, f.constant(0.0) if operation == "fadd" else None)

    def of_motions(self, f: Function, rows: Bit) -> Bit:
        """For each motion whether something holds for any row of a vector."""
        return rows if self.together == 1 else f.any(rows)

    def wide(self, f: Function, value: Real) -> Real:
        """A number of each motion, for every row of a vector."""
        return f.splat(value, self.lanes)


def side_by_side(degrees: int, rows: int, order: int, floor: int = 0) -> Lengths:
    """Those of one motion whose rows are side by side, order after order."""
    width = width_of(rows)
    lanes = min(width, LANES)
    return Lengths(degrees, rows, width, order, lanes, lanes, row=1, term=width, floor=floor)


@dataclass(frozen=True)
class Row:
    """The rows that one vector holds, from row ``i`` on."""

    lengths: Lengths
    f: Function
    i: Integer

    def at(self, base: Pointer | str, shift: int = 0) -> Real:
        """Their numbers in an array like the state, ``shift`` rows further."""
        return self.f.load_row(base, self._place(shift), self.lengths.lanes)

    def put(self, value: Real, base: Pointer | str, shift: int = 0) -> None:
        """The same, stored."""
        self.f.store_row(value, base, self._place(shift))

    def _place(self, shift: int) -> Integer:
        i = self.i + shift if shift else self.i
        return i if self.lengths.motions == 1 else i * self.lengths.motions

    def series(self, work: Pointer | str = "%work") -> RowSeries:
        """Their series."""
        return RowSeries(self.lengths, self.f, self.lengths.place(self.f, self.i, work))

    def floored(self, speed: Real, work: Pointer | str = "%work") -> Real:
        """Their speeds, or the least that they are measured by."""
        if not self.lengths.floor:
            return speed
        return self.f.larger(speed, self.at(work, self.lengths.floor))

    def among(self, first: Index, count: int) -> Bit:
        """Which are among ``count`` rows from ``first`` on."""
        return self.beyond(first) < count

    def beyond(self, first: Index) -> Integer:
        """How many rows they are behind the ``first`` one."""
        f, together = self.f, self.lengths.together
        if together == 1:
            return self.i - first if first else self.i
        i, behind = (self.i - first, 0) if isinstance(first, Integer) else (self.i, first)
        lanes = ", ".join(f"i64 {lane - behind}" for lane in range(together))
        return f.splat(i, together) + Integer(f, f"<{lanes}>", together)

    def moving(self, condition: Bit) -> Bit:
        """The velocities among those of ``Lengths.velocities`` where it holds."""
        return condition if self.lengths.together == 1 else condition & self.among(*self.lengths.leading)

    @contextmanager
    def if_velocities(self) -> Iterator[None]:
        """The rules for velocities, and for rows beside them."""
        if self.lengths.together > 1:
            yield
        else:
            with self.f.when(self.among(*self.lengths.leading)):
                yield

    def only(self, which: Bit, value: Real) -> Real:
        """The numbers of ``which``, and 0."""
        return self.f.select(which, value, self.f.zero(value.lanes))

    def only_velocities(self, value: Real) -> Real:
        """The numbers of velocities among those of ``Lengths.velocities``, and 0."""
        return value if self.lengths.together == 1 else self.only(self.among(*self.lengths.leading), value)


@dataclass(frozen=True)
class RowSeries:
    """Coefficients of them."""

    lengths: Lengths
    f: Function
    place: Pointer

    def __getitem__(self, m: Index) -> Real:
        """The ``m``-th ones."""
        return self.f.load_row(self.place, m * self.lengths.term, self.lengths.lanes)

    def put(self, value: Real, m: Index) -> None:
        """The same, stored."""
        self.f.store_row(value, self.place, m * self.lengths.term)

    def terms(self, first: int, last: int) -> list[Real]:
        """The terms from ``first`` to ``last``."""
        return [self[m] for m in range(first, last + 1)]


@dataclass(frozen=True)
class FollowingSeries(Row):
    """Coordinates whose series follows from that of their velocities (``Lengths.followers``)."""

    def series(self, work: Pointer | str = "%work") -> RowSeries:
        lengths, f = self.lengths, self.f
        return Integrated(lengths, f, lengths.place(f, self.i + lengths.degrees, work))


@dataclass(frozen=True)
class Integrated(RowSeries):
    """Coefficients of the integral of a series."""

    def __getitem__(self, m: Index) -> Real:
        assert isinstance(m, int)
        return super().__getitem__(m - 1) / float(m)
