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


class Newton:
    """Newton's method for accelerations at the nodes of a way, which ``once`` integrates. Forces depend on
    velocities as ``rates`` (t, places, speeds) says; the vectors have these ``pivots``."""

    def __init__(
        self, pivots: Sequence[Sequence[int]], once: Array, rates: Callable[[float, Array, Array], Array]
    ) -> None:
        self._pivots, self._once, self._rates = pivots, once, rates
        self._depends: NDArray[np.bool_] | None = None
        """Which accelerations depend on which velocities, where that is known."""
        self._groups: list[NDArray[np.intp]] = []
        """The velocities that are changed together then."""

    def _slope(self, stage: Stage, nudge: Array) -> Array:
        """By how much accelerations differ on both sides of the velocities there."""
        ahead, behind = (
            self._rates(stage.t, stage.places, stage.speeds + sign * nudge)[: len(nudge)] for sign in (1, -1)
        )
        return ahead - behind

    def apart(self, stages: Sequence[Stage], off: Array) -> Array:
        """A step at these nodes: the change of the accelerations (nodes, velocities) that are ``off`` by so
        much. Those of vectors change by Newton's method, as they depend on their own velocities, and others
        by iteration. Nan where forces have no value."""
        width = max(map(len, self._pivots), default=0)
        slopes = [np.zeros((STAGES, len(one), len(one))) for one in self._pivots]
        for i, stage in enumerate(stages):
            for p in range(width):
                nudge = np.zeros(off.shape[1])
                for one, size in zip(self._pivots, stage.nudges):
                    if p < len(one):
                        nudge[one[p]] = size
                change = self._slope(stage, nudge)
                for one, slope in zip(self._pivots, slopes):
                    if p < len(one):
                        slope[i, :, p] = change[list(one)] / (2.0 * nudge[one[p]])
        if not all(np.all(np.isfinite(slope)) for slope in slopes):
            return np.full(off.shape, np.nan)
        return self._solved(off, zip(self._pivots, slopes))

    def whole(self, stages: Sequence[Stage], off: Array) -> Array:
        """The same where vectors are not apart: by Newton's method in all velocities. In the first step they
        are changed one by one at the last node. What that shows to depend on different ones is found together
        from then on."""
        slopes = np.zeros((STAGES, off.shape[1], off.shape[1]))
        for i in reversed(range(STAGES)):
            slopes[i] = self._slopes(stages[i], off.shape[1])
            if self._depends is None:
                self._depends = slopes[i] != 0.0
                self._groups = grouped(self._depends)
        if self._depends is None or not np.all(np.isfinite(slopes)):
            return np.full(off.shape, np.nan)
        parts = connected(self._depends)
        return self._solved(off, ((one, slopes[:, one[:, None], one]) for one in parts))

    def _slopes(self, stage: Stage, own: int) -> Array:
        """The derivatives of accelerations by so many velocities."""
        depends, groups, slopes = self._depends, self._groups, np.zeros((own, own))
        if depends is None:
            depends, groups = np.ones((own, own), bool), [np.array([k]) for k in range(own)]
        for group in groups:
            nudge = np.zeros(own)
            nudge[group] = np.min(stage.nudges)
            slope = self._slope(stage, nudge) / (2.0 * nudge[group[0]])
            slopes[:, group] = np.where(depends[:, group], slope[:, None], 0.0)
        return slopes

    def _solved(self, off: Array, parts: Iterable[tuple[Sequence[int] | NDArray[np.intp], Array]]) -> Array:
        """The changes of accelerations that are ``off`` by so much. Each of some parts of them depends on its
        own velocities, with such slopes (nodes, part, part), others on none."""
        found: Array = off.copy()
        for part, slopes in parts:
            own = list(part)
            count = STAGES * len(own)
            coupled = np.einsum("im,irp->irmp", self._once, slopes).reshape(count, count)
            change = np.linalg.solve(np.eye(count) - coupled, off[:, own].ravel())
            found[:, own] = change.reshape(STAGES, len(own))
        return found
