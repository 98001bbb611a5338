"""Linear equations in double-double: elimination with row interchanges, in loops over what lies in memory."""

from __future__ import annotations

from lagrange_cli.native.numbers.double_double import DoubleDouble, DoubleDoubleBody, Pair, function
from lagrange_cli.records import dataclass


@dataclass(frozen=True)
class InMemory:
    """A block of ``size`` rows at ``%work[place]``; behind it are its pivots and a right-hand side."""

    kind: DoubleDouble
    place: int
    size: int

    @property
    def doubles(self) -> int:
        """Doubles that the block takes in all."""
        return 2 * self.size * (self.size + 2)

    def factor(self, matrix: list[list[Pair | None]]) -> str:
        """Store the block and factor it; an i1 that tells whether it is regular."""
        for i, entry in enumerate(entry for row in matrix for entry in row):
            self.kind.store(entry, "%work", self.place + 2 * i, 1)
        block = self.kind.body.place("%work", self.place)
        return self.kind.body.define(f"call i1 @factor(ptr {block}, i64 {self.size})")

    def solve(self, right: list[Pair | None], scale: Pair | None) -> list[Pair | None]:
        """x with M x = ``scale * right``."""
        kind, place = self.kind, self.place + 2 * self.size * (self.size + 1)
        for i, value in enumerate(right):
            kind.store(kind.mul(value, scale), "%work", place + 2 * i, 1)
        block, solution = (kind.body.place("%work", at) for at in (self.place, place))
        kind.body.line(f"  call void @solve(ptr {block}, ptr {solution}, i64 {self.size})")
        return [kind.load("%work", place + 2 * i, 1) for i in range(self.size)]


def linear_solver() -> str:
    """``i1 @factor(a, n)``, false where ``a`` is singular; ``@solve(a, b, n)``: the solution into ``b``.

    ``a`` holds n rows of n numbers, then n pivots (whole numbers); the inverses of U's diagonal are in its
    place.
    """
    return _factor() + _solve()


def _factor() -> str:
    e = DoubleDoubleBody()
    largest, where = e.define("alloca double"), e.define("alloca i64")
    good = e.define("alloca i1")
    e.line(f"  store i1 true, ptr {good}")
    pivots = e.integer("mul", e.integer("mul", "%n", "%n"), 2)

    def at(i: str, j: str) -> str:
        return e.integer("mul", e.integer("add", e.integer("mul", i, "%n"), j), 2)

    def column(j: str) -> None:
        e.line(f"  store double -1.0, ptr {largest}\n  store i64 {j}, ptr {where}")

        def search(i: str) -> None:
            size = e.magnitude(e.load("%a", at(i, j)))
            larger = e.compare("ogt", size, e.load(largest, 0))
            best = e.select(larger, size, e.load(largest, 0))
            old = e.define(f"load i64, ptr {where}")
            e.line(f"  store i64 {e.define(f'select i1 {larger}, i64 {i}, i64 {old}')}, ptr {where}")
            e.store(best, largest, 0)

        e.loop(j, "%n", search)
        old = e.define(f"load i1, ptr {good}")
        regular = e.compare("ogt", e.load(largest, 0), 0.0)
        e.line(f"  store i1 {e.define(f'and i1 {old}, {regular}')}, ptr {good}")
        pivot = e.define(f"load i64, ptr {where}")
        e.line(f"  store i64 {pivot}, ptr {e.place('%a', e.integer('add', pivots, j))}")

        def swap(c: str) -> None:
            one, other = e.get("%a", at(j, c), 1), e.get("%a", at(pivot, c), 1)
            e.put(one, "%a", at(pivot, c), 1)
            e.put(other, "%a", at(j, c), 1)

        e.loop(0, "%n", swap)
        inverse = e.pair(1) / e.get("%a", at(j, j), 1)
        e.put(inverse, "%a", at(j, j), 1)
        below = e.integer("add", j, 1)

        def eliminate(i: str) -> None:
            factor = e.get("%a", at(i, j), 1) * inverse
            e.put(factor, "%a", at(i, j), 1)

            def update(c: str) -> None:
                changed = e.get("%a", at(i, c), 1) - factor * e.get("%a", at(j, c), 1)
                e.put(changed, "%a", at(i, c), 1)

            e.loop(below, "%n", update)

        e.loop(below, "%n", eliminate)

    e.loop(0, "%n", column)
    e.line(f"  ret i1 {e.define(f'load i1, ptr {good}')}")
    return function("i1 @factor(ptr %a, i64 %n)", e)


def _solve() -> str:
    e = DoubleDoubleBody()
    pivots = e.integer("mul", e.integer("mul", "%n", "%n"), 2)

    def at(i: str, j: str) -> str:
        return e.integer("mul", e.integer("add", e.integer("mul", i, "%n"), j), 2)

    def twice(i: str) -> str:
        return e.integer("mul", i, 2)

    def eliminate(i: str, j: str, x: Pair) -> None:
        e.put(e.get("%b", twice(i), 1) - x * e.get("%a", at(i, j), 1), "%b", twice(i), 1)

    def swap(j: str) -> None:
        pivot = e.define(f"load i64, ptr {e.place('%a', e.integer('add', pivots, j))}")
        one, other = e.get("%b", twice(j), 1), e.get("%b", twice(pivot), 1)
        e.put(one, "%b", twice(pivot), 1)
        e.put(other, "%b", twice(j), 1)

    def forward(j: str) -> None:
        x = e.get("%b", twice(j), 1)
        e.loop(e.integer("add", j, 1), "%n", lambda i: eliminate(i, j, x))

    def backward(step: str) -> None:
        j = e.integer("sub", e.integer("sub", "%n", step), 1)
        x = e.get("%b", twice(j), 1) * e.get("%a", at(j, j), 1)
        e.put(x, "%b", twice(j), 1)
        e.loop(0, j, lambda i: eliminate(i, j, x))

    e.loop(0, "%n", swap)
    e.loop(0, "%n", forward)
    e.loop(0, "%n", backward)
    e.line("  ret void")
    return function("void @solve(ptr %a, ptr %b, i64 %n)", e)
