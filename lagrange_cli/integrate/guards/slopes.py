"""Derivatives of numbers that are linear in velocities, where most depend on a few of these only.

Which ones those are is found once, by changing one velocity after the other. From then on all velocities of
which no number has two are changed at once. A last change of all of them shows whether numbers depend on more
than is known, as where a coefficient was 0 before.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from lagrange_cli.integrate.arrays import Array

CLOSE = 2.0**-40
"""By how much changes may differ from what derivatives say, beside their terms: rounding."""


class LinearSlopes:
    """The derivatives of numbers by ``count`` velocities, at one place after another."""

    def __init__(self, count: int) -> None:
        self._count = count
        self._depends: NDArray[np.bool_] | None = None
        self._groups: list[NDArray[np.intp]] = []

    def at(self, numbers: Callable[[Array], Array]) -> Array:
        """Those of the ``numbers`` (n,) with changed velocities (n, velocities)."""
        here = numbers(np.zeros(self._count))
        found = None if self._depends is None else self._by_groups(numbers, here)
        if found is None:
            found = np.array([numbers(one) - here for one in np.eye(self._count)]).T
            depends = found != 0.0
            self._depends = depends if self._depends is None else depends | self._depends
            self._groups = grouped(self._depends)
        return found

    def _by_groups(self, numbers: Callable[[Array], Array], here: Array) -> Array | None:
        """The same from what numbers are known to depend on; None if that is not all."""
        assert self._depends is not None
        found = np.zeros(self._depends.shape)
        for group in self._groups:
            change = np.zeros(self._count)
            change[group] = 1.0
            changed = numbers(change) - here
            found[:, group] = np.where(self._depends[:, group], changed[:, None], 0.0)
        weights = 1.5 + np.cos(np.arange(self._count) * math.e)
        off, terms = numbers(weights) - here - found @ weights, np.abs(found) @ weights + np.abs(here)
        return found if np.all(np.abs(off) <= CLOSE * terms) else None


def grouped(depends: NDArray[np.bool_]) -> list[NDArray[np.intp]]:
    """The columns of a table in groups, in each of which no row has two entries; without empty columns."""
    taken: list[NDArray[np.bool_]] = []
    groups: list[list[int]] = []
    for k, column in enumerate(depends.T):
        if not column.any():
            continue
        free = next((i for i, rows in enumerate(taken) if not np.any(rows & column)), len(groups))
        if free == len(groups):
            taken.append(np.zeros(len(depends), bool))
            groups.append([])
        taken[free] |= column
        groups[free].append(k)
    return [np.array(one, np.intp) for one in groups]


def connected(depends: NDArray[np.bool_]) -> list[NDArray[np.intp]]:
    """The parts that what depends on itself falls into, by a square table; without what depends on
    nothing."""
    either = depends | depends.T
    labels = np.arange(len(either))
    while True:
        lowest = np.min(np.where(either, labels, labels[:, None]), axis=1)
        if np.array_equal(lowest, labels):
            break
        labels = lowest
    return [np.flatnonzero(labels == one) for one in np.unique(labels[either.any(axis=1)])]


def inverse_of(matrix: Array, least: float = 1e-15) -> Array:
    """The pseudoinverse of a matrix: singular values that are a smaller part of the largest one are 0."""
    found: Array = np.linalg.pinv(matrix, least).astype(np.float64)
    return found
