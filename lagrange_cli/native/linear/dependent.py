"""Elimination with complete pivoting in a block whose rank is known, in loops, for numbers of any kind.

Where ``surplus`` constraints follow from others, the block has so many vectors z with M z = 0, multipliers
whose forces are 0. P M Q = L U is left off after ``rank`` columns (Golub and Van Loan, Matrix Computations,
4th ed., secs. 3.4.8 and 5.5): the others give the vectors z, which are made orthogonal to each other. The
unknowns of those columns count as 0, and what x has along each z is taken off at the end. So the multipliers
are those of least norm, and which constraints are left out is decided anew where a step begins: of a ball in
a pipe, for example, it is not the same one everywhere.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import reduce
from typing import Any, Generic

from lagrange_cli.native.linear.lu import EliminationFunction
from lagrange_cli.native.linear.pivots import FLOOR
from lagrange_cli.native.llvm.vector import Bit, Integer, Pointer, Real
from lagrange_cli.native.numbers.kind import V, Written
from lagrange_cli.records import dataclass

FACTOR, SOLVE = "factor_dependent", "solve_dependent"
ROWS = 5
"""Rows behind the block: its right-hand side, the units of rows, the largest numbers that are known to have
been on the diagonal, and then those of columns, and the rows and columns that each was exchanged with."""


def size_of(rows: int, surplus: int) -> int:
    """The numbers of a block, and of what is behind it: ``ROWS``, the vectors z, and 1/z^2 of each; and of a
    sum."""
    return rows * (rows + ROWS) + surplus * (rows + 1) + 1


@dataclass(frozen=True)
class Dependent(Generic[V]):
    """A block of ``size`` rows at ``place``, ``surplus`` of which follow from others."""

    kind: Written[V]
    place: Pointer
    size: int
    surplus: int

    def solve(self, right: list[V | None], scale: V | None) -> list[V | None]:
        """x with M x = ``scale * right``."""
        kind, first = self.kind, self.size * self.size
        for i, value in enumerate(right):
            kind.store(kind.mul(value, scale), self.place.name, kind.parts * (first + i), 1)
        self._call(None, SOLVE)
        return [kind.load(self.place.name, kind.parts * (first + i), 1) for i in range(self.size)]

    def _call(self, result: type[Bit] | None, name: str) -> Bit | None:
        f = self.kind.body
        counts = f.count(self.size - self.surplus), f.count(self.size)
        return f.call(result, f"{name}_{self.kind.parts}", self.place, *counts, lanes=1)

    def factored(self, matrix: Sequence[Sequence[V | None]], units: Sequence[V | None]) -> str:
        """Store the block, and the ``units`` that pivots of its rows are compared in, and factor it; an i1
        that tells whether it has its rank."""
        kind, behind = self.kind, self.size * (self.size + 1)
        for i, entry in enumerate(entry for row in matrix for entry in row):
            kind.store(entry, self.place.name, kind.parts * i, 1)
        for i, unit in enumerate(units):
            kind.store(unit, self.place.name, kind.parts * (behind + i), 1)
            kind.store(None, self.place.name, kind.parts * (behind + self.size + i), 1)
        made = self._call(Bit, FACTOR)
        assert made is not None
        return made.name


def factor_dependent(
    kind: Written[V], matrix: Sequence[Sequence[V | None]], surplus: int, constraints: int
) -> tuple[Dependent[V], str]:
    """A block whose last rows are those of ``constraints``, ``surplus`` of which follow from others; and
    whether it has the rank that is left.

    Rows are measured by their largest entries, those of constraints all by one: slopes that become 0
    count little.
    """
    size, others = len(matrix), len(matrix) - constraints
    largest = [reduce(kind.larger, map(kind.magnitude, row)) for row in matrix]
    common = reduce(kind.larger, largest[others:])
    units = [kind.div(kind.one, one) for one in (*largest[:others], *[common] * constraints)]
    place = kind.body.room(kind.parts * size_of(size, surplus))
    block = Dependent(kind, place, size, surplus)
    return block, block.factored(matrix, units)


class DependentFunction(EliminationFunction[V]):
    """A function of such a block of ``n`` rows and a ``rank``."""

    def __init__(self, make: type[Written[V]], result: str, name: str) -> None:
        super().__init__(make, result, f"{name}_{make.parts}", "i64 %rank, ")
        self.rank, self.surplus = Integer(self, "%rank"), self.n - Integer(self, "%rank")
        self.right, self.units, self.largest, self.rows, self.columns = (
            self.place("%a", (self.n + row) * self.width) for row in range(ROWS)
        )
        self.inverses = self.place("%a", (self.n + ROWS + self.surplus) * self.width)

    def null_vector(self, number: Integer) -> Pointer:
        """Where one of the vectors z is."""
        return self.place("%a", (self.n + ROWS + number) * self.width)

    def dot(self, x: Pointer, y: Pointer) -> V:
        """The scalar product of two vectors, which is left behind the inverses."""
        place = self.surplus * self.doubles
        self.put(None, self.inverses.name, place)
        with self.loop(0, self.n, tested=False) as i:
            a, b = (self.get(one.name, i * self.doubles) for one in (x, y))
            self.put(self.kind.fma(a, b, self.get(self.inverses.name, place)), self.inverses.name, place)
        return self.get(self.inverses.name, place)

    def take_off(self, x: Pointer, number: Integer) -> None:
        """Make x orthogonal to a vector z."""
        z, inverse = self.null_vector(number), self.get(self.inverses.name, number * self.doubles)
        part = self.kind.mul(self.dot(x, z), inverse)
        with self.loop(0, self.n, tested=False) as i:
            self.subtract(part, self.get(z.name, i * self.doubles), x, i)

    def subtract(self, a: V | None, b: V, x: Pointer, i: Integer) -> None:
        """x_i - a b in place of x_i."""
        place = i * self.doubles
        self.put(self.kind.fms(a, b, self.get(x.name, place)), x.name, place)

    def solve_upper(self, x: Pointer) -> None:
        """Solve with U for the first unknowns."""
        with self.loop(0, self.rank) as done:
            j = self.rank - done - 1
            place = j * self.doubles
            value = self.kind.mul(self.get(x.name, place), self.get("%a", self.at(j, j)))
            self.put(value, x.name, place)
            with self.loop(0, j) as i:
                self.subtract(value, self.get("%a", self.at(i, j)), x, i)


def called_in(text: str) -> str:
    """The functions of such blocks that a text calls."""
    kinds: list[type[Written[Any]]] = []
    if f"@{FACTOR}_1(" in text:
        from lagrange_cli.native.numbers.double import Emitter

        kinds.append(Emitter)
    if f"@{FACTOR}_2(" in text:
        from lagrange_cli.native.numbers.double_double import DoubleDouble

        kinds.append(DoubleDouble)
    made = ((factor_function(one), solve_function(one)) for one in kinds)
    return "".join(text for both in made for text in both)


def factor_function(make: type[Written[V]]) -> str:
    """``i1 @factor_dependent(a, rank, n)``: whether the rank of ``a`` is that. Then L is below its diagonal,
    U above, the inverses of U's diagonal are between them, and the vectors z are behind all."""
    f = DependentFunction(make, "i1", FACTOR)
    kind, n = f.kind, f.n

    def size(i: Integer, j: Integer) -> Real:
        return f.magnitude(f.load("%a", f.at(i, j))) * f.load(f.units, i * f.doubles)

    with f.loop(0, n, tested=False) as j:
        largest = f.variable(f.load(f.largest, j * f.doubles) * f.load(f.units, j * f.doubles))
        with f.loop(0, n, tested=False) as i:
            largest.set(f.function("maxnum", largest.get(), size(i, j)))
        f.store(largest.get(), f.largest, j * f.doubles)
    regular = f.variable(Bit(f, "true"))
    with f.loop(0, f.rank) as j:
        row, column, most = f.variable(j), f.variable(j), f.variable(size(j, j))
        with f.loop(j, n, tested=False) as i, f.loop(j, n, tested=False) as k:
            here = size(i, k)
            more = here > most.get()
            row.set(f.select(more, i, row.get()))
            column.set(f.select(more, k, column.get()))
            most.set(f.select(more, here, most.get()))
        floor = f.load(f.largest, column.get() * f.doubles) * (FLOOR * kind.unit)
        regular.set(regular.get() & (most.get() > floor))
        f.store(row.get(), f.rows, j)
        f.store(column.get(), f.columns, j)
        f.exchange("%a", j * f.width, row.get() * f.width, f.width)
        f.exchange(f.units, j * f.doubles, row.get() * f.doubles, f.doubles)
        f.exchange(f.largest, j * f.doubles, column.get() * f.doubles, f.doubles)
        with f.loop(0, n, tested=False) as i:
            f.exchange("%a", f.at(i, j), f.at(i, column.get()), f.doubles)
        inverse = kind.div(kind.one, f.get("%a", f.at(j, j)))
        f.put(inverse, "%a", f.at(j, j))
        with f.loop(j + 1, n) as i:
            factor = kind.mul(f.get("%a", f.at(i, j)), inverse)
            f.put(factor, "%a", f.at(i, j))
            with f.loop(j + 1, n) as k:
                place = f.at(i, k)
                f.put(kind.fms(factor, f.get("%a", f.at(j, k)), f.get("%a", place)), "%a", place)
    with f.loop(0, f.surplus) as number:
        z, last = f.null_vector(number), f.rank + number
        with f.loop(0, n, tested=False) as i:
            f.put(None, z.name, i * f.doubles)
        f.put(kind.one, z.name, last * f.doubles)
        with f.loop(0, f.rank) as i:
            f.put(kind.neg(f.get("%a", f.at(i, last))), z.name, i * f.doubles)
        f.solve_upper(z)
        with f.loop(0, number) as other:
            f.take_off(z, other)
        f.put(kind.div(kind.one, f.dot(z, z)), f.inverses.name, number * f.doubles)
    f.give(regular.get())
    return f.text()


def solve_function(make: type[Written[V]]) -> str:
    """``@solve_dependent(a, rank, n)``: the right-hand side behind ``a`` becomes the solution."""
    f = DependentFunction(make, "void", SOLVE)
    x, n, doubles = f.right, f.n, f.doubles
    with f.loop(0, f.rank) as j:
        f.exchange(x, j * doubles, f.load_integer(f.rows, j) * doubles, doubles)
    with f.loop(0, f.rank) as j:
        known = f.get(x.name, j * doubles)
        with f.loop(j + 1, n) as i:
            f.subtract(known, f.get("%a", f.at(i, j)), x, i)
    f.solve_upper(x)
    with f.loop(f.rank, n) as i:
        f.put(None, x.name, i * doubles)
    with f.loop(0, f.surplus) as number:
        f.take_off(x, number)
    with f.loop(0, f.rank) as done:
        j = f.rank - done - 1
        f.exchange(x, j * doubles, f.load_integer(f.columns, j) * doubles, doubles)
    f.give()
    return f.text()
