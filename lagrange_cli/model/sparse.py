"""L D L^T of sparse symmetric matrices: which entries of L are not 0, which can be found together, and their
numbers.

Unknowns are eliminated in *rounds*: those of a round are not coupled, so that they depend on earlier rounds
only. Among the rest, those coupled to the fewest others come first (minimum degree, several at a time: J. W.
H. Liu, ACM Trans. Math. Softw. 11, 1985). A chain takes as many rounds as its length has bits: that is cyclic
reduction.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from heapq import heapify, heappop, heappush
from typing import TYPE_CHECKING

from lagrange_cli.records import dataclass

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

SLACK = 1
"""How many more than the fewest others an unknown may meet to belong to a round."""
PART = 1 / 16
"""The part of all unknowns that a round should have."""
MANY = 32
"""Rows from which full ones are arrays."""
Matrix = Sequence[dict[int, float]]
"""A symmetric matrix by rows: its entries by column, as far as they are not 0."""


@dataclass(frozen=True)
class SparseElimination:
    """The ``rounds`` of unknowns, and ``columns[p]``: the later unknowns i with L_ip."""

    rounds: Sequence[Sequence[int]]
    columns: Sequence[Sequence[int]]

    @property
    def entries(self) -> int:
        """The numbers of L below its diagonal."""
        return sum(map(len, self.columns))


def eliminated(
    neighbours: Sequence[set[int]], most: int, waiting: int | None = None
) -> SparseElimination | None:
    """The elimination of all unknowns; None where L would have more than ``most`` numbers.

    ``neighbours`` are the places of entries off the diagonal, by row; it is used up. Unknowns from number
    ``waiting`` on, whose rows have no entries on the diagonal, wait for all that they meet.
    """
    rounds: list[list[int]] = []
    columns: list[list[int]] = [[] for _ in neighbours]
    size, left = 0, set(range(len(neighbours)))
    waits = {p: set(neighbours[p]) for p in range(len(neighbours) if waiting is None else waiting, len(left))}
    left.difference_update(waits)
    while left:
        one = independent(neighbours, left)
        left.difference_update(one)
        for p in one:
            for i in neighbours[p] & waits.keys():
                waits[i].discard(p)
                if not waits[i]:
                    left.add(i)
                    del waits[i]
            around = neighbours[p]
            columns[p] = sorted(around)
            size += len(around)
            if size > most:
                return None
            for i in around:
                neighbours[i] |= around
                neighbours[i] -= {i, p}
        rounds.append(one)
    return SparseElimination(rounds, columns)


def independent(neighbours: Sequence[set[int]], left: set[int]) -> list[int]:
    """Some of those ``left`` that meet few others, and not each other: where these are a small ``PART`` of
    all, as the ends of a wide chain, some of those that meet no more than most do."""
    degrees = {p: len(neighbours[p]) for p in left}
    chosen = apart(neighbours, degrees, min(degrees.values()) + SLACK)
    if len(chosen) < PART * len(left):
        chosen = apart(neighbours, degrees, sorted(degrees.values())[len(degrees) // 2])
    return chosen


def apart(neighbours: Sequence[set[int]], degrees: Mapping[int, int], most: int) -> list[int]:
    """Some that meet at ``most`` so many others, and not each other."""
    chosen: list[int] = []
    barred: set[int] = set()
    for p in sorted((p for p in degrees if degrees[p] <= most), key=lambda p: (degrees[p], p)):
        if p not in barred:
            chosen.append(p)
            barred |= neighbours[p]
    return sorted(chosen)


@dataclass(frozen=True)
class Factors:
    """L D L^T of a matrix, eliminated in this ``order``: ``columns[p]`` has L_ip by i, ``pivots`` D."""

    order: Sequence[int]
    columns: Sequence[Mapping[int, float]]
    pivots: Sequence[float]

    def solve_all(self, right: NDArray[np.float64]) -> NDArray[np.float64]:
        """The same for each column of ``right``."""
        x = right + 0.0
        for p in self.order:
            for i, entry in self.columns[p].items():
                x[i] -= entry * x[p]
        for p in reversed(self.order):
            x[p] /= self.pivots[p]
            for i, entry in self.columns[p].items():
                x[p] -= entry * x[i]
        return x

    def solve(self, right: Sequence[float]) -> list[float]:
        """x with L D L^T x = ``right``."""
        x = list(right)
        for p in self.order:
            known = x[p]
            for i, entry in self.columns[p].items():
                x[i] -= entry * known
        for p in reversed(self.order):
            x[p] = x[p] / self.pivots[p] - sum(entry * x[i] for i, entry in self.columns[p].items())
        return x


def factored(matrix: Matrix, most: int) -> Factors | None:
    """The factors of a positive matrix; None where L is not full and would have more than ``most`` numbers,
    or a pivot is not positive. The unknown that meets the fewest others is eliminated next."""
    if full(matrix, len(matrix)):
        return dense_factors(matrix)
    rows = [dict(row) for row in matrix]
    columns: list[Mapping[int, float]] = [{} for _ in matrix]
    pivots = [0.0] * len(matrix)
    pending = [(len(row), p) for p, row in enumerate(rows)]
    heapify(pending)
    order: list[int] = []
    size = 0
    while pending:
        degree, p = heappop(pending)
        row = rows[p]
        if columns[p] or degree != len(row) or not row:
            continue  # it is eliminated, or waits once more with fewer or more others
        pivots[p] = pivot = row.pop(p, 0.0)
        size += len(row)
        if not 0.0 < pivot < math.inf or size > most:
            return None
        later = [*row.items()]
        rows[p] = {}
        order.append(p)
        columns[p] = {i: entry / pivot for i, entry in later}
        for i, scaled in columns[p].items():
            other = rows[i]
            del other[p]
            for k, entry in later:
                other[k] = other.get(k, 0.0) - scaled * entry
            heappush(pending, (len(other), i))
    return Factors(order, columns, pivots) if len(order) == len(rows) else None


def order_of(matrix: Matrix, most: int) -> Sequence[int] | None:
    """An order of elimination in which L has few entries, ``most`` at most, if there is one. Along a chain,
    it leads from the ends."""
    larger = [{**row, i: 1.0 + sum(map(abs, row.values()))} for i, row in enumerate(matrix)]
    found = factored(larger, most)
    return found.order if found else None


def full(rows: Sequence[Mapping[int, float]], width: int) -> bool:
    """Whether many rows have hardly any entry that is 0 among so many, and all are doubles."""
    if len(rows) < MANY or 2 * sum(map(len, rows)) < width * len(rows):
        return False
    return all(type(a) is float for row in rows for a in row.values())


def array_of(rows: Sequence[Mapping[int, float]], width: int) -> NDArray[np.float64]:
    """The rows as an array."""
    import numpy as np

    made = np.zeros((len(rows), width))
    for i, row in enumerate(rows):
        made[i, [*row]] = [*row.values()]
    return made


def dense_factors(matrix: Matrix) -> Factors | None:
    """The factors of a matrix without entries that are 0: the same operations, row by row."""
    import numpy as np

    left, count = array_of(matrix, len(matrix)), len(matrix)
    columns, pivots = list[Mapping[int, float]](), list[float]()
    for p in range(count):
        pivot, later = float(left[p, p]), left[p, p + 1 :].copy()
        if not 0.0 < pivot < math.inf:
            return None
        scaled = later / pivot
        left[p + 1 :, p + 1 :] -= np.multiply.outer(scaled, later)
        columns.append(dict(zip(range(p + 1, count), scaled.tolist())))
        pivots.append(pivot)
    return Factors(range(count), columns, pivots)


def products(rows: Sequence[Mapping[int, float]], others: Sequence[Mapping[int, float]]) -> Matrix:
    """The scalar products of rows with as many others."""
    width = 1 + max((k for row in (*rows, *others) for k in row), default=0)
    if full(rows, width) and full(others, width):
        import numpy as np

        one, other = array_of(rows, width), array_of(others, width)
        whole = np.zeros((len(rows), len(others)))
        for k in range(width):  # in this order, with which rounding is that of single rows
            whole += np.multiply.outer(one[:, k], other[:, k])
        return [dict(enumerate(row)) for row in whole.tolist()]
    columns: dict[int, list[tuple[int, float]]] = {}
    for j, row in enumerate(others):
        for k, b in row.items():
            columns.setdefault(k, []).append((j, b))
    made: list[dict[int, float]] = []
    for row in rows:
        total: dict[int, float] = {}
        for k, a in row.items():
            for j, b in columns.get(k, ()):
                total[j] = total.get(j, 0.0) + a * b
        made.append(total)
    return made


def parts_of(matrix: Matrix) -> list[list[int]]:
    """The unknowns that a matrix couples, directly or by others, in their order."""
    part = [-1] * len(matrix)
    made: list[list[int]] = []
    for start in range(len(matrix)):
        if part[start] >= 0:
            continue
        found, part[start] = [start], len(made)
        for one in found:
            for k in matrix[one]:
                if part[k] < 0:
                    part[k] = len(made)
                    found.append(k)
        made.append(sorted(found))
    return made


def within(matrix: Matrix, chosen: Sequence[int]) -> Matrix:
    """The matrix of some unknowns."""
    place = {i: k for k, i in enumerate(chosen)}
    return [{place[k]: a for k, a in matrix[i].items() if k in place} for i in chosen]
