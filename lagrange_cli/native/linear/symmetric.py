"""Code that factors the mass matrix, if it is positive, or the equations with constraints, and solves them.

It is L D L^T of the symmetric matrix: M (Golub and Van Loan, Matrix Computations, 4th ed., sec. 4.1), or
[[M, -A^T], [-A, 0]]. There the coordinates are eliminated first; this leaves -A M^-1 A^T, which is negative
if the constraints are independent. So no pivoting is needed (M. Benzi, G. H. Golub and J. Liesen, Acta
Numerica 14, 2005, sec. 5). Zeros are never used: among coordinates, and then among constraints, the one
coupled to the fewest others is eliminated next (minimum degree: W. F. Tinney and J. W. Walker, Proc. IEEE 55,
1967). Constraints some of which follow from others are left to ``dependent``.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Generic, cast

from lagrange_cli.native.linear.pivots import FLOOR
from lagrange_cli.native.numbers.kind import Condition, NumberKind, V, Written
from lagrange_cli.records import dataclass

if TYPE_CHECKING:
    from lagrange_cli.native.linear.dependent import Dependent


@dataclass(frozen=True)
class Symmetric(Generic[V]):
    """L D L^T of a block: the pivots in their ``order``, ``columns[p]`` the entries (i, L_ip) below
    that of p, and the reciprocals of D. Where constraints depend on each other, what elimination of the
    coordinates leaves of the block is the ``rest``."""

    kind: NumberKind[V]
    order: Sequence[int]
    columns: Sequence[Sequence[tuple[int, V]]]
    reciprocals: Sequence[V | None]
    rest: Dependent[V] | None = None

    def solve(self, right: list[V | None], scale: V | None) -> list[V | None]:
        """x with K x = ``scale * right``."""
        kind, x = self.kind, list(right)
        for p in self.order:
            for i, entry in self.columns[p]:
                x[i] = kind.fms(entry, x[p], x[i])
        if self.rest is not None:
            first = len(x) - self.rest.size
            x[first:] = self.rest.solve(x[first:], scale)
        for p in reversed(self.order):
            x[p] = kind.mul(x[p], kind.mul(self.reciprocals[p], scale))
            for i, entry in self.columns[p]:
                x[p] = kind.fms(entry, x[i], x[p])
        return x


@dataclass(frozen=True)
class Loose(Generic[V]):
    """A block with M + c A^T A in place of M, factored; ``weighted`` is -c A, row by row."""

    block: Symmetric[V]
    weighted: Sequence[Sequence[V | None]]

    def solve(self, right: list[V | None], scale: V | None) -> list[V | None]:
        """x with K x = ``scale * right``."""
        kind, coordinates = self.block.kind, len(right) - len(self.weighted)
        moved = list(right)
        for row, value in zip(self.weighted, right[coordinates:]):
            for k, entry in enumerate(row):
                moved[k] = kind.fma(entry, value, moved[k])
        return self.block.solve(moved, scale)


def factor_loose(
    kind: NumberKind[V], matrix: list[list[V | None]], coordinates: int, surplus: int = 0
) -> tuple[Loose[V], Condition]:
    """A block whose M is singular although the whole block is not, and whether it is regular.

    M + c A^T A is positive, and has the same solutions: what it adds to the equations follows from those of
    the constraints (G. H. Golub and C. Greif, SIAM J. Sci. Comput. 24, 2003). The weight c makes both parts
    of equal size; without masses, that of the second one is 1.
    """
    total: V | None = None
    squares: V | None = None
    for j, row in enumerate(matrix):
        for entry in row[:coordinates] if j >= coordinates else row[j : j + 1]:
            if j < coordinates:
                total = kind.add(total, entry)
            else:
                squares = kind.fma(entry, entry, squares)
    weight = kind.div(kind.one if total is None else total, squares)
    wider = [list(row) for row in matrix]
    weighted = []
    for row in matrix[coordinates:]:
        scaled = [kind.mul(weight, entry) for entry in row[:coordinates]]
        weighted.append(scaled)
        for j, entry in enumerate(row[:coordinates]):
            for k in range(coordinates):
                wider[j][k] = kind.fma(scaled[k], entry, wider[j][k])
    made, regular = factor_symmetric(kind, wider, coordinates, surplus)
    return Loose(made, weighted), regular


def factor_symmetric(
    kind: NumberKind[V], matrix: list[list[V | None]], coordinates: int, surplus: int = 0
) -> tuple[Symmetric[V], Condition]:
    """L D L^T of a block with so many ``coordinates`` before its constraints, and whether it is regular;
    ``surplus`` of the constraints follow from others.

    The first pivot is compared with 0, others with the digits that may be lost.
    """
    size = len(matrix)
    rows = [{k: entry for k, entry in enumerate(row) if entry is not None} for row in matrix]
    neighbours = [set(row) - {j} for j, row in enumerate(rows)]
    order: Sequence[int] = [*elimination(neighbours, coordinates)] if coordinates < size else range(size)
    order = order[:coordinates] if surplus else order
    columns: list[list[tuple[int, V]]] = [[] for _ in range(size)]
    reciprocals: list[V | None] = [None] * size
    begins: list[V | None] = []
    regular, unit = kind.true, kind.number(FLOOR * kind.unit)
    for step, p in enumerate(order):
        if step in (0, coordinates):
            begins = [row.get(j) for j, row in enumerate(rows)]
        row = rows[p]
        pivot = row.pop(p, None)
        floor = kind.mul(unit, begins[p]) if step else None
        regular = kind.both(regular, kind.compare("ogt" if p < coordinates else "olt", pivot, floor))
        reciprocals[p] = inverse = kind.div(kind.one, pivot)
        below = list(row.items())
        for i, _ in below:
            del rows[i][p]
        for place, (i, entry) in enumerate(below):
            scaled = kind.mul(entry, inverse)
            assert scaled is not None
            columns[p].append((i, scaled))
            for k, other in below[place:]:
                value = kind.fms(scaled, other, rows[i].get(k))
                assert value is not None
                rows[i][k] = rows[k][i] = value
    if not surplus:
        return Symmetric(kind, order, columns, reciprocals), regular
    from lagrange_cli.native.linear.dependent import factor_dependent

    left = range(coordinates, size)
    rest, whole = factor_dependent(
        cast("Written[V]", kind), [[rows[i].get(k) for k in left] for i in left], surplus, len(left)
    )
    return Symmetric(kind, order, columns, reciprocals, rest), kind.both(regular, whole)


def elimination(neighbours: Sequence[set[int]], coordinates: int) -> dict[int, set[int]]:
    """In which order to eliminate: the ``coordinates`` first, of each part what has fewest neighbours then;
    each with these.

    ``neighbours`` are the places of entries off the diagonal, by row; it is used up.
    """
    order = {}
    for part in (range(coordinates), range(coordinates, len(neighbours))):
        left = dict.fromkeys(part)
        while left:
            p = min(left, key=lambda one: len(neighbours[one]))
            del left[p]
            around = order[p] = neighbours[p]
            for i in around:
                neighbours[i] |= around
                neighbours[i] -= {i, p}
    return order
