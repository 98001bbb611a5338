"""Elimination with row interchanges, in loops over what lies in memory, for numbers of any kind.

P M = L U column by column (Golub and Van Loan, Matrix Computations, 4th ed., sec. 3.4). Pivots are chosen by
the doubles that numbers begin with. Whether a pivot is rounding is judged in units of the largest entries of
rows: the equations of what is held are multiplied by 2^40, and are no measure for the others.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Generic, TypeAlias

from lagrange_cli.native.linear.pivots import FLOOR
from lagrange_cli.native.llvm.function import Function
from lagrange_cli.native.llvm.vector import Bit, Index, Integer, Pointer, Real
from lagrange_cli.native.numbers.kind import V, Written
from lagrange_cli.records import dataclass

Make: TypeAlias = "Callable[[Function], Written[V]]"
"""Makes a kind of numbers that is written into a function."""


@dataclass(frozen=True)
class LargeGeneral(Generic[V]):
    """A block of ``size`` rows at ``%work[place]``; behind it are its pivots and a right-hand side."""

    kind: Written[V]
    place: int
    size: int

    @property
    def doubles(self) -> int:
        """Doubles that the block takes in all."""
        return self.kind.parts * self.size * (self.size + 2)

    @property
    def functions(self) -> tuple[str, ...]:
        """The functions that it calls."""
        return factor_general(type(self.kind)), solve_general(type(self.kind))

    def factor(self, matrix: list[list[V | None]]) -> str:
        """Store the block and factor it; an i1 that tells whether it is regular."""
        f = self.kind.body
        for i, entry in enumerate(entry for row in matrix for entry in row):
            self._store(entry, i)
        return f.call(Bit, "factor_general", self._address(0), f.count(self.size), lanes=1).name

    def solve(self, right: list[V | None], scale: V | None) -> list[V | None]:
        """x with M x = ``scale * right``."""
        f, first = self.kind.body, self.size * (self.size + 1)
        for i, value in enumerate(right):
            self._store(self.kind.mul(value, scale), first + i)
        f.call(None, "solve_general", self._address(0), self._address(first), f.count(self.size))
        return [self.kind.load("%work", self._index(first + i), 1) for i in range(self.size)]

    def _index(self, number: int) -> int:
        return self.place + self.kind.parts * number

    def _store(self, value: V | None, number: int) -> None:
        self.kind.store(value, "%work", self._index(number), 1)

    def _address(self, number: int) -> Pointer:
        return self.kind.body.place("%work", self._index(number), "double")


class EliminationFunction(Function, Generic[V]):
    """A function of a block ``%a`` of ``n`` rows, with its pivots behind it. What ``kind`` writes goes into
    it. A number takes so many ``doubles``."""

    def __init__(self, make: Make[V], result: str, name: str, more: str = "") -> None:
        super().__init__(f"define internal {result} @{name}(ptr noalias %a, {more}i64 %n) #0")
        self.kind = make(self)
        self.n = Integer(self, "%n")
        self.doubles = self.kind.parts
        self.width = self.n * self.doubles
        self.pivots = self.place("%a", self.n * self.width)
        self.units = self.place("%a", (self.n + 1) * self.width)

    def at(self, i: Integer, j: Integer) -> Integer:
        """Where element (i, j) is."""
        return i * self.width + j * self.doubles

    def get(self, place: str, index: Integer) -> V:
        """A number in memory."""
        return self.kind.load(place, index.name, 1)

    def put(self, value: V | None, place: str, index: Integer) -> None:
        """Store it."""
        self.kind.store(value, place, index.name, 1)

    def exchange(self, place: str | Pointer, one: Integer, other: Integer, doubles: Index) -> None:
        """Exchange so many doubles that begin at two places."""
        first, second = (self.place(place, each) for each in (one, other))
        with self.loop(0, doubles, tested=False) as k:
            value = self.load(first, k)
            self.store(self.load(second, k), first, k)
            self.store(value, second, k)


def factor_general(make: Make[V]) -> str:
    """``i1 @factor_general(a, n)``: whether ``a`` is regular. Then L is below its diagonal, U above, and the
    inverses of U's diagonal between them; the rows that rows were exchanged with are behind it. The room for
    a right-hand side is used for the reciprocals of the largest entries of rows."""
    f = EliminationFunction(make, "i1", "factor_general")
    kind, n = f.kind, f.n

    def size(i: Integer, j: Integer) -> Real:
        return f.magnitude(f.load("%a", f.at(i, j)))

    with f.loop(0, n, tested=False) as i:
        largest = f.variable(f.constant(0.0))
        with f.loop(0, n, tested=False) as j:
            largest.set(f.function("maxnum", largest.get(), size(i, j)))
        f.store(f.constant(1.0) / largest.get(), f.units, i)
    with f.loop(0, n, tested=False) as j:
        largest = f.variable(f.constant(0.0))
        with f.loop(0, n, tested=False) as i:
            largest.set(f.function("maxnum", largest.get(), size(i, j) * f.load(f.units, i)))
        f.store(largest.get(), f.pivots, j)
    regular = f.variable(Bit(f, "true"))
    with f.loop(0, n, tested=False) as j:
        pivot, largest = f.variable(j), f.variable(size(j, j))
        with f.loop(j + 1, n) as i:
            here = size(i, j)
            more = here > largest.get()
            pivot.set(f.select(more, i, pivot.get()))
            largest.set(f.select(more, here, largest.get()))
        floor = f.load(f.pivots, j) * (FLOOR * kind.unit)
        here = largest.get() * f.load(f.units, pivot.get())
        regular.set(regular.get() & (here > floor))
        f.store(pivot.get(), f.pivots, j)
        f.exchange("%a", j * f.width, pivot.get() * f.width, f.width)
        f.exchange(f.units, j, pivot.get(), 1)
        inverse = kind.div(kind.one, f.get("%a", f.at(j, j)))
        f.put(inverse, "%a", f.at(j, j))
        with f.loop(j + 1, n) as i, f.when(size(i, j) > 0.0):  # most are 0 where contacts do not touch
            factor = kind.mul(f.get("%a", f.at(i, j)), inverse)
            f.put(factor, "%a", f.at(i, j))
            with f.loop(j + 1, n, tested=False) as k:
                place = f.at(i, k)
                f.put(kind.fms(factor, f.get("%a", f.at(j, k)), f.get("%a", place)), "%a", place)
    f.give(regular.get())
    return f.text()


def solve_general(make: Make[V]) -> str:
    """``@solve_general(a, b, n)`` with ``a`` as ``@factor_general`` leaves it: ``b`` becomes the solution."""
    f = EliminationFunction(make, "void", "solve_general", "ptr noalias %b, ")
    kind, n, parts = f.kind, f.n, f.doubles

    def eliminate(x: V | None, i: Integer, j: Integer) -> None:
        f.put(kind.fms(x, f.get("%a", f.at(i, j)), f.get("%b", i * parts)), "%b", i * parts)

    with f.loop(0, n, tested=False) as j:
        f.exchange("%b", j * parts, f.load_integer(f.pivots, j) * parts, parts)
    with f.loop(0, n, tested=False) as j:
        known = f.get("%b", j * parts)
        with f.loop(j + 1, n) as i:
            eliminate(known, i, j)
    with f.loop(0, n, tested=False) as done:
        j = n - done - 1
        x = kind.mul(f.get("%b", j * parts), f.get("%a", f.at(j, j)))
        f.put(x, "%b", j * parts)
        with f.loop(0, j) as i:
            eliminate(x, i, j)
    f.give()
    return f.text()
