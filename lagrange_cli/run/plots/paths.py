"""The paths of particles in space, as a panel of a plot."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from lagrange_cli.figures.panels import Array, Curve, Panel
from lagrange_cli.records import replace

SAME = 1e-13
"""Coordinates that differ by this part of the largest one are the same but for rounding."""
SEEN = 1e-3
"""The part of a picture that is seen as more than a point."""


def in_space(curves: tuple[Curve, ...], axes: Sequence[str]) -> Panel:
    """Paths in space or, if they are all in one plane across an axis, in this plane."""
    if not any(one.z is not None for one in curves):
        return Panel("path in space", axes[0], axes[1], curves, equal=True)
    if (across := normal(curves)) is None:
        return Panel("path in space", axes[0], axes[1], curves, z=axes[2], equal=True)
    x, y = (axis for axis in range(3) if axis != across)
    flat = tuple(replace(one, x=seen[x], y=seen[y], z=None) for one in curves for seen in [coordinates(one)])
    return Panel("path in space", axes[x], axes[y], flat, equal=True)


def coordinates(curve: Curve) -> tuple[Array, ...]:
    """The components of a path."""
    return curve.x, curve.y, np.zeros_like(curve.x) if curve.z is None else curve.z


def standing(curves: Sequence[Curve]) -> tuple[Curve, ...]:
    """The paths, each as a line. That of a particle that does not move is a point, which is seen, and so are
    both ends of one that is too short to be seen beside the others."""
    whole = [np.concatenate([coordinates(one)[axis] for one in curves]) for axis in range(3)]
    spans = [np.ptp(one[np.isfinite(one)]) for one in whole if np.isfinite(one).any()]
    short = SEEN * float(max(spans, default=0.0))

    def drawn(curve: Curve) -> Curve:
        if at_rest(curve, SAME * size([curve])):
            return ends(curve, [0])
        return ends(curve, [0, -1]) if at_rest(curve, short) else curve

    return tuple(map(drawn, curves))


def at_rest(curve: Curve, least: float) -> bool:
    """Whether a particle moves by no more than this along each axis."""
    parts = coordinates(curve)
    return all(one.size and np.isfinite(one).all() and np.ptp(one) <= least for one in parts)


def ends(curve: Curve, places: Sequence[int]) -> Curve:
    """Some places of a path as points."""
    x, y, z = (None if one is None else one[places] for one in (curve.x, curve.y, curve.z))
    assert x is not None and y is not None
    return replace(curve, x=x, y=y, z=z, faded=None, points=True)


def normal(curves: Sequence[Curve]) -> int | None:
    """The axis, from the last on, along which nothing moves; None if there is no such axis."""
    scale = size(curves)
    for axis in (2, 1, 0):
        values = np.concatenate([coordinates(one)[axis] for one in curves])
        if np.isfinite(values).all() and np.ptp(values) <= SAME * scale:
            return axis
    return None


def size(curves: Sequence[Curve]) -> float:
    """The largest of all coordinates."""
    return max(float(np.abs(one).max(initial=0)) for curve in curves for one in coordinates(curve))
