"""Vectors of velocities that friction holds apart from one another: each has coordinates of its own, and what
holds it follows from the other forces alone, as in families whose mass matrix is diagonal.

How forces depend on the velocities of all of them is found together, so that this does not grow with their
number; how they depend on others is found by iteration.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from typing import TYPE_CHECKING

import numpy as np

from lagrange_cli.integrate.guards.collocation import STAGES
from lagrange_cli.integrate.guards.slopes import connected, grouped
from lagrange_cli.records import dataclass

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from lagrange_cli.integrate.arrays import Array


@dataclass(frozen=True)
class Stage:
    """A node of a way: the time, and by how much places and velocities have changed; by how much velocities
    are changed, for each vector, to find how forces depend on them: ``nudges``."""

    t: float
    places: Array
    speeds: Array
    nudges: Array


def unit_slopes(pivots: Sequence[Sequence[int]], count: int) -> Array:
    """The derivatives of the components of vectors by ``count`` velocities: each is one of these, less a
    constant."""
    rows = [k for one in pivots for k in one]
    found = np.zeros((len(rows), count))
    found[np.arange(len(rows)), rows] = 1.0
    return found


@dataclass(frozen=True)
class Newton:
    """A step of Newton's method for accelerations at the nodes of a way, which ``once`` integrates. Forces
    depend on velocities as ``rates`` (t, places, speeds) says; the vectors have these ``pivots``."""

    stages: Sequence[Stage]
    pivots: Sequence[Sequence[int]]
    once: Array
    rates: Callable[[float, Array, Array], Array]

    def _slope(self, stage: Stage, nudge: Array) -> Array:
        """By how much accelerations differ on both sides of the velocities there."""
        ahead, behind = (
            self.rates(stage.t, stage.places, stage.speeds + sign * nudge)[: len(nudge)] for sign in (1, -1)
        )
        return ahead - behind

    def apart(self, off: Array) -> Array:
        """The change of the accelerations (nodes, velocities) that are ``off`` by so much: of those of
        vectors by Newton's method, as they depend on their own velocities, and of others by iteration. Nan
        where forces have no value."""
        width = max(map(len, self.pivots), default=0)
        slopes = [np.zeros((STAGES, len(one), len(one))) for one in self.pivots]
        for i, stage in enumerate(self.stages):
            for p in range(width):
                nudge = np.zeros(off.shape[1])
                for one, size in zip(self.pivots, stage.nudges):
                    if p < len(one):
                        nudge[one[p]] = size
                change = self._slope(stage, nudge)
                for one, slope in zip(self.pivots, slopes):
                    if p < len(one):
                        slope[i, :, p] = change[list(one)] / (2.0 * nudge[one[p]])
        if not all(np.all(np.isfinite(slope)) for slope in slopes):
            return np.full(off.shape, np.nan)
        return self._solved(off, zip(self.pivots, slopes))

    def whole(self, off: Array) -> Array:
        """The same where vectors are not apart: by Newton's method in all velocities. At the last node these
        are changed one by one; what that shows to depend on different ones is found together at others."""
        own = off.shape[1]
        slopes, groups = np.zeros((STAGES, own, own)), [np.array([k]) for k in range(own)]
        depends = np.ones((own, own), bool)
        for i in reversed(range(STAGES)):
            stage = self.stages[i]
            for group in groups:
                nudge = np.zeros(own)
                nudge[group] = np.min(stage.nudges)
                slope = self._slope(stage, nudge) / (2.0 * nudge[group[0]])
                slopes[i][:, group] = np.where(depends[:, group], slope[:, None], 0.0)
            if i == STAGES - 1:
                depends = slopes[i] != 0.0
                groups = grouped(depends)
        if not np.all(np.isfinite(slopes)):
            return np.full(off.shape, np.nan)
        parts = connected(depends)
        return self._solved(off, ((one, slopes[:, one[:, None], one]) for one in parts))

    def _solved(self, off: Array, parts: Iterable[tuple[Sequence[int] | NDArray[np.intp], Array]]) -> Array:
        """The changes of accelerations that are ``off`` by so much. Each of some parts of them depends on its
        own velocities, with such slopes (nodes, part, part), others on none."""
        found: Array = off.copy()
        for part, slopes in parts:
            own = list(part)
            count = STAGES * len(own)
            coupled = np.einsum("im,irp->irmp", self.once, slopes).reshape(count, count)
            change = np.linalg.solve(np.eye(count) - coupled, off[:, own].ravel())
            found[:, own] = change.reshape(STAGES, len(own))
        return found
