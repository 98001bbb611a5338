"""Code that factors the mass matrix once a step and solves with it at every order.

Each diagonal block on its own. A definite block, and one with constraints, in the form L D L^T, which needs
no pivoting (``symmetric``); any other by Gaussian elimination with partial pivoting. Small blocks are
unrolled, with exchanges as selections; large ones, definite or not, call functions of ``lu``.
"""

from __future__ import annotations

from collections.abc import Mapping
from functools import reduce
from typing import Generic, Protocol, cast

from lagrange_cli.native.linear.lu import LargeGeneral
from lagrange_cli.native.linear.pivots import FLOOR
from lagrange_cli.native.linear.symmetric import factor_loose, factor_symmetric
from lagrange_cli.native.numbers.kind import Condition, NumberKind, V, Written
from lagrange_cli.records import dataclass, field

ANY_SIZE = 1 << 40
UNROLLED = {"definite": 12, "general": 5}
"""Rows of a block up to which its elimination is unrolled."""


class Factored(Protocol[V]):
    """A block that equations can be solved with."""

    def solve(self, right: list[V | None], scale: V | None) -> list[V | None]:
        """x with M x = ``scale * right``."""


@dataclass
class Factorization(Generic[V]):
    """How ``definite`` and ``general`` blocks are factored: unrolled up to so many rows (``unrolled``),
    larger ones by loops. These lie one behind the other from ``%work[place]`` on, and call ``functions``."""

    kind: NumberKind[V]
    place: int
    unrolled: Mapping[str, int] = field(default_factory=lambda: UNROLLED)
    functions: dict[str, None] = field(default_factory=dict)

    def factor(
        self,
        matrix: list[list[V | None]],
        definite: bool,
        constraints: int = 0,
        *,
        loose: bool = False,
        surplus: int = 0,
    ) -> tuple[Factored[V], Condition]:
        """A factored block, and whether it is regular; its last rows are those of ``constraints``, of which
        ``surplus`` follow from others. In a ``loose`` one these alone determine some coordinates."""
        name = "definite" if definite else "general"
        if definite and (constraints or len(matrix) <= self.unrolled[name]):
            factor = factor_loose if loose and constraints else factor_symmetric
            return factor(self.kind, matrix, len(matrix) - constraints, surplus)
        if surplus:
            from lagrange_cli.native.linear.dependent import factor_dependent

            return factor_dependent(cast("Written[V]", self.kind), matrix, surplus, constraints)
        if len(matrix) <= self.unrolled[name]:
            return factor_general(self.kind, matrix)
        block = LargeGeneral(cast("Written[V]", self.kind), self.place, len(matrix))
        self.place += block.doubles
        self.functions.update(dict.fromkeys(block.functions))
        return block, block.factor(matrix)


def all_unrolled(kind: NumberKind[V]) -> Factorization[V]:
    """A factorization in blocks of any size, without memory."""
    return Factorization(kind, 0, dict.fromkeys(UNROLLED, ANY_SIZE))


@dataclass(frozen=True)
class General(Generic[V]):
    """P M = L U of a block: ``swaps[j][i]`` says whether rows j and i were exchanged."""

    kind: NumberKind[V]
    swaps: tuple[tuple[Condition, ...], ...]
    lower: tuple[tuple[V | None, ...], ...]
    upper: tuple[tuple[V | None, ...], ...]
    reciprocal: tuple[V | None, ...]

    def solve(self, right: list[V | None], scale: V | None) -> list[V | None]:
        """x with M x = ``scale * right``."""
        kind = self.kind
        x = [kind.mul(value, scale) for value in right]
        size = len(x)
        for j in range(size):
            for i, swap in zip(range(j + 1, size), self.swaps[j]):
                exchange(kind, swap, x, j, x, i)
        for j in range(size):
            for i in range(j + 1, size):
                x[i] = kind.fms(self.lower[i][j], x[j], x[i])
        for j in reversed(range(size)):
            for i in range(j + 1, size):
                x[j] = kind.fms(self.upper[j][i], x[i], x[j])
            x[j] = kind.mul(x[j], self.reciprocal[j])
        return x


def exchange(
    kind: NumberKind[V], swap: Condition, a: list[V | None], i: int, b: list[V | None], k: int
) -> None:
    """Exchange ``a[i]`` and ``b[k]`` where ``swap`` holds."""
    if a[i] is not None or b[k] is not None:
        a[i], b[k] = kind.select(swap, b[k], a[i]), kind.select(swap, a[i], b[k])


def factor_general(kind: NumberKind[V], matrix: list[list[V | None]]) -> tuple[General[V], Condition]:
    """P M = L U of a block by partial pivoting, and whether it is regular: whether no pivot is rounding, in
    units of the largest entries of rows."""
    size = len(matrix)
    rows = [list(row) for row in matrix]
    units = [kind.div(kind.one, reduce(kind.larger, map(kind.magnitude, row))) for row in matrix]
    relative = [[kind.mul(kind.magnitude(x), unit) for x in row] for row, unit in zip(matrix, units)]
    lower: list[list[V | None]] = [[None] * size for _ in range(size)]
    swaps: list[tuple[Condition, ...]] = []
    reciprocal: list[V | None] = []
    regular = kind.true
    for j in range(size):
        swapped: list[Condition] = []
        scale = reduce(kind.larger, (row[j] for row in relative))
        for i in range(j + 1, size):
            here, there = kind.magnitude(rows[j][j]), kind.magnitude(rows[i][j])
            swap = kind.compare("ogt", there, here)
            swapped.append(swap)
            for k in range(size):
                both = rows if k >= j else lower
                exchange(kind, swap, both[j], k, both[i], k)
            exchange(kind, swap, units, j, units, i)
        swaps.append(tuple(swapped))
        floor = kind.mul(kind.number(FLOOR * kind.unit), scale) if j else None
        pivot = kind.mul(kind.magnitude(rows[j][j]), units[j])
        regular = kind.both(regular, kind.compare("ogt", pivot, floor))
        reciprocal.append(kind.div(kind.one, rows[j][j]))
        for i in range(j + 1, size):
            lower[i][j] = kind.mul(rows[i][j], reciprocal[j])
            for k in range(j + 1, size):
                rows[i][k] = kind.fms(lower[i][j], rows[j][k], rows[i][k])
    left, right = (tuple(map(tuple, part)) for part in (lower, rows))
    return General(kind, tuple(swaps), left, right, tuple(reciprocal)), regular
