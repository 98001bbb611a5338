"""L D L^T of symmetric matrices that are not positive, in an order that is chosen before: those of masses and
constraints (see ``sparse.eliminated``)."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np

from lagrange_cli.model.sparse import SparseElimination, eliminated
from lagrange_cli.records import dataclass

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Values = NDArray[np.float64]
    Places = NDArray[np.int64]

FILLED = 100
"""Numbers of L for each unknown up to which a matrix is sparse."""


@dataclass(frozen=True, eq=False)
class IndefiniteFactors:
    """``pivots`` D, and what L has below each: ``lower`` from its ``starts`` on, in the rows ``later``."""

    order: Sequence[int]
    pivots: Values
    starts: Places
    later: Places
    lower: Values

    @property
    def regular(self) -> bool:
        """Whether all numbers are finite."""
        return bool(np.all(np.isfinite(self.pivots)) and np.all(self.pivots))

    def column(self, p: int) -> slice:
        """Where a column of L is."""
        return slice(self.starts[p], self.starts[p + 1])

    def solve(self, right: Values) -> Values:
        """x with L D L^T x = ``right``."""
        x = right.copy()
        for p in self.order:
            column = self.column(p)
            x[self.later[column]] -= self.lower[column] * x[p]
        x /= self.pivots
        for p in reversed(self.order):
            column = self.column(p)
            x[p] -= self.lower[column] @ x[self.later[column]]
        return np.asarray(x)


def factors_of(elimination: SparseElimination, places: Places, entries: Values) -> IndefiniteFactors:
    """The factors of a matrix with ``entries`` at ``places`` (entries, 2), on the diagonal and below."""
    count, order = len(elimination.columns), [p for one in elimination.rounds for p in one]
    position, pivots = np.empty(count, dtype=np.int64), np.zeros(count)
    position[order] = np.arange(count)
    starts = np.cumsum([0, *map(len, elimination.columns)])
    later = np.array([i for one in elimination.columns for i in one], dtype=np.int64)
    keys = np.repeat(np.arange(count), np.diff(starts)) * count + later  # in ascending order
    lower = np.zeros(len(keys))
    found = IndefiniteFactors(order, pivots, starts, later, lower)
    i, j = places.T
    same = i == j
    np.add.at(pivots, i[same], entries[same])
    first, second = (np.where(position[i] < position[j], *both)[~same] for both in ((i, j), (j, i)))
    np.add.at(lower, np.searchsorted(keys, first * count + second), entries[~same])
    with np.errstate(all="ignore"):
        for p in order:
            column = found.column(p)
            around, value = later[column], lower[column].copy()
            scaled = value / pivots[p]
            pivots[around] -= scaled * value
            above, below = np.nonzero(position[around][:, None] < position[around])
            targets = np.searchsorted(keys, around[above] * count + around[below])
            lower[targets] -= scaled[above] * value[below]
            lower[column] = scaled
    return found


def saddle_solved(
    matter: Sequence[Mapping[int, float]], rows: Sequence[Mapping[int, float]], right: Values
) -> Values | None:
    """x and -mu with M x = g + A^T mu, A x = r, from the rows of M and A, and g and r one behind the other;
    None where the matrix is not sparse, or singular as it is eliminated."""
    count, size = len(matter), len(matter) + len(rows)
    listed = [(j, k, m) for j, row in enumerate(matter) for k, m in row.items() if k <= j and m]
    listed += [(count + i, k, a) for i, row in enumerate(rows) for k, a in row.items() if a]
    if len(listed) > FILLED * size:
        return None
    neighbours: list[set[int]] = [set() for _ in range(size)]
    for j, k, _ in listed:
        if j != k:
            neighbours[j].add(k)
            neighbours[k].add(j)
    elimination = eliminated(neighbours, FILLED * size, count)
    if elimination is None:
        return None
    places = np.array([(j, k) for j, k, _ in listed], dtype=np.int64).reshape(-1, 2)
    entries = np.array([x for _, _, x in listed], dtype=np.float64)
    factors = factors_of(elimination, places, entries)
    if not factors.regular:
        return None
    i, j = places.T
    found, rest = np.zeros(size), right
    for _ in range(2):
        found = found + factors.solve(rest)
        product = np.bincount(i, entries * found[j], size)
        product += np.bincount(j, np.where(i == j, 0.0, entries) * found[i], size)
        rest = right - product
    largest = float(np.max(np.abs(right), initial=0.0))
    return found if np.max(np.abs(rest), initial=0.0) <= 1e-9 * largest else None
