"""Vectors of velocities that friction holds apart from one another: each has coordinates of its own, and what
holds it follows from the other forces alone, as in families whose mass matrix is diagonal.

How forces depend on the velocities of all of them is found together, so that this does not grow with their
number; how they depend on others is found by iteration.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING

import numpy as np

from lagrange_cli.integrate.guards.collocation import STAGES
from lagrange_cli.records import dataclass

if TYPE_CHECKING:
    from lagrange_cli.integrate.arrays import Array


@dataclass(frozen=True)
class Stage:
    """A node of a way: the time, and by how much places and velocities have changed; the ``sizes`` of the
    vectors there."""

    t: float
    places: Array
    speeds: Array
    sizes: Array


def unit_slopes(pivots: Sequence[Sequence[int]], count: int) -> Array:
    """The derivatives of the components of vectors by ``count`` velocities: each is one of these, less a
    constant."""
    rows = [k for one in pivots for k in one]
    found = np.zeros((len(rows), count))
    found[np.arange(len(rows)), rows] = 1.0
    return found


def newton_change(
    off: Array,
    stages: Sequence[Stage],
    pivots: Sequence[Sequence[int]],
    once: Array,
    rates: Callable[[float, Array, Array], Array],
    nudged: float,
) -> Array:
    """The change of the accelerations (nodes, velocities) that are ``off`` by so much: of those of vectors
    with these ``pivots`` by Newton's method, as they depend on their own velocities, changed by a part of
    their sizes to find out; and of others by iteration. ``once`` integrates over the nodes."""
    width = max(map(len, pivots), default=0)
    slopes = [np.zeros((STAGES, len(one), len(one))) for one in pivots]
    for i, stage in enumerate(stages):
        for p in range(width):
            nudge = np.zeros(off.shape[1])
            for one, size in zip(pivots, stage.sizes):
                if p < len(one):
                    nudge[one[p]] = nudged * size
            ahead, behind = (
                rates(stage.t, stage.places, stage.speeds + sign * nudge)[: len(nudge)] for sign in (1, -1)
            )
            change = ahead - behind
            for one, slope in zip(pivots, slopes):
                if p < len(one):
                    slope[i, :, p] = change[list(one)] / (2.0 * nudge[one[p]])
    found: Array = off.copy()
    if not all(np.all(np.isfinite(slope)) for slope in slopes):
        return np.full(off.shape, np.nan)
    for one, slope in zip(pivots, slopes):
        count = STAGES * len(one)
        coupled = np.einsum("im,irp->irmp", once, slope).reshape(count, count)
        own = np.linalg.solve(np.eye(count) - coupled, off[:, list(one)].ravel())
        found[:, list(one)] = own.reshape(STAGES, len(one))
    return found


def whole_newton_change(
    off: Array,
    stages: Sequence[Stage],
    pivots: Sequence[Sequence[int]],
    once: Array,
    rates: Callable[[float, Array, Array], Array],
    nudged: float,
) -> Array:
    """The same where vectors are not apart: by Newton's method in all velocities."""
    own = off.shape[1]
    matrix = np.eye(STAGES * own)
    for i, one in enumerate(stages):
        for k in range(own):
            nudge = nudged * np.min(one.sizes) * np.eye(own)[k]
            sides = [rates(one.t, one.places, v)[:own] for v in (one.speeds + nudge, one.speeds - nudge)]
            slope = (sides[0] - sides[1]) / (2.0 * nudge[k])
            for m in range(own):
                matrix[i * own + m, k::own] -= once[i] * slope[m]
    if not np.all(np.isfinite(matrix)):
        return np.full(off.shape, np.nan)
    return np.array(np.linalg.solve(matrix, off.ravel())).reshape(off.shape)
