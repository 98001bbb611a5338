"""Where everything of a drawing is along a motion, with numpy."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from functools import reduce

import numpy as np

from lagrange_cli.drawing.along import Along
from lagrange_cli.drawing.drawing import Drawing, Locus
from lagrange_cli.expression.arrays import Array, evaluate
from lagrange_cli.expression.vocabulary import TIME
from lagrange_cli.records import dataclass, replace

MARGIN = 0.1
"""The margin around the bounds of the motion, as a fraction of their size."""
BEYOND = 0.25
"""The part of a curve that is drawn beyond them, likewise."""
SAMPLES, MESH = 193, 33
"""Points of a curve, and of each line of a surface's mesh."""
AT_ONCE = 4_000_000
"""Components of points that are computed together: some 100 MB with what they are computed from."""
TINY = 0.004
"""A body smaller than this part of what is seen is followed instead."""


@dataclass(frozen=True)
class Extent:
    """The least and greatest values of places (dimension,) and of coordinates (n,) so far; parts of a motion
    are ``joined``."""

    least: Array
    greatest: Array
    q_least: Array
    q_greatest: Array

    def joined(self, other: Extent) -> Extent:
        """The extent of both together."""
        return Extent(
            np.fmin(self.least, other.least),
            np.fmax(self.greatest, other.greatest),
            np.fmin(self.q_least, other.q_least),
            np.fmax(self.q_greatest, other.q_greatest),
        )


def points(drawing: Drawing, t: Array, q: Array, parameters: Mapping[str, float]) -> Array:
    """All points (points, dimension, samples) at the times ``t`` (samples,) with ``q`` (samples, n).

    Parameters may change ``Along`` the motion.
    """
    if drawing.located is not None:
        if not isinstance(parameters, Along):
            return drawing.located.at(t, q, parameters)
        parts = [drawing.located.at(t[one], q[one], own) for one, own in parameters.pieces(t)]
        return np.concatenate(parts, axis=-1) if parts else drawing.located.at(t, q, parameters)
    if isinstance(parameters, Along):
        parameters = parameters.at(t)
    values = evaluate(drawing.nodes, _symbols(drawing, t, q, parameters))
    shape = len(drawing.points), drawing.dimension, len(t)
    return np.array([np.broadcast_to(one, t.shape) for one in values]).reshape(shape)


def sizes(drawing: Drawing, parameters: Mapping[str, float]) -> Array:
    """All masses and lengths (sizes,)."""
    return np.array([float(one) for one in evaluate(drawing.sizes, parameters)])


def locus(
    drawing: Drawing, curve: Locus, t: float, q: Sequence[float] | Array, parameters: Mapping[str, float]
) -> Array:
    """A curve (dimension, SAMPLES), or the mesh of a surface (dimension, MESH, MESH), at one state.

    Its ranges must be known: see ``fitted``.
    """
    if isinstance(parameters, Along):
        _, parameters = next(parameters.pieces(np.array([t])))
    count = SAMPLES if len(curve.along) == 1 else MESH
    axes = [np.linspace(*ends, count) for ends in curve.ranges if ends is not None]
    runs = np.meshgrid(*axes, indexing="ij")
    symbols: dict[str, Array | float] = {**parameters, TIME: t}
    symbols |= {name: float(x) for name, x in zip(drawing.coordinates, q)}
    names = drawing.coordinates + drawing.free
    symbols |= {names[k]: run for k, run in zip(curve.along, runs)}
    found = evaluate(drawing.points[curve.point], symbols)
    return np.array([np.broadcast_to(one, runs[0].shape) for one in found])


def extent(drawing: Drawing, t: Array, q: Array, parameters: Mapping[str, float]) -> Extent:
    """The bounds of a motion, or of a part of it: its moving points, relative to the followed point if there
    is one."""
    most = max(1, AT_ONCE // max(1, drawing.count * drawing.dimension))
    if len(t) > most:
        rows = [slice(first, first + most) for first in range(0, len(t), most)]
        return reduce(Extent.joined, (extent(drawing, t[one], q[one], parameters) for one in rows))
    places, shown = points(drawing, t, q, parameters), list(drawing.places)
    if drawing.camera.follow is not None:
        places = places - places[drawing.camera.follow]
        held = {one.point for one in drawing.pivots}
        shown = [one for one in shown if one not in held]
    places = places[shown]
    finite = np.where(np.isfinite(places), places, np.nan)
    along = q if len(q) else np.full((1, len(drawing.coordinates)), np.nan)
    if not finite.size:
        nothing = np.full(drawing.dimension, np.nan)
        return Extent(nothing, nothing, np.fmin.reduce(along), np.fmax.reduce(along))
    flat = finite.transpose(1, 0, 2).reshape(drawing.dimension, -1)
    return Extent(
        np.fmin.reduce(flat, axis=1),
        np.fmax.reduce(flat, axis=1),
        np.fmin.reduce(along),
        np.fmax.reduce(along),
    )


def fitted(drawing: Drawing, seen: Extent, parameters: Mapping[str, float]) -> Drawing:
    """The drawing with all ranges of its curves, and with the bounds of what is seen.

    The bounds hold all places, the solids around them, and curves with ranges of their own; along some axes
    they are those that the file gives.
    """
    curves = tuple(
        replace(one, ranges=tuple(_range(ends, k, seen) for ends, k in zip(one.ranges, one.along)))
        for one in drawing.curves
    )
    if drawing.camera.bounds is not None:
        return replace(drawing, curves=curves)
    least, greatest = np.nan_to_num(seen.least), np.nan_to_num(seen.greatest)
    middle = [(a + b) / 2 for a, b in zip(seen.q_least, seen.q_greatest)]
    for given, one in zip(drawing.curves, curves):
        if None not in given.ranges and drawing.camera.follow is None:
            around = locus(drawing, one, 0.0, middle, parameters).reshape(drawing.dimension, -1)
            least, greatest = (
                np.fmin(least, np.fmin.reduce(around, 1)),
                np.fmax(greatest, np.fmax.reduce(around, 1)),
            )
    reach = _reach(drawing, parameters)
    spread = float((greatest - least).max())
    camera = drawing.camera
    if drawing.solids and camera.follow is None and reach < TINY * spread:
        camera = replace(camera, follow=drawing.solids[0].centre)
        least, greatest = -reach * np.ones(drawing.dimension), reach * np.ones(drawing.dimension)
    least, greatest = least - reach, greatest + reach
    size = float((greatest - least).max()) or 1.0
    pad = np.maximum(MARGIN * size, (0.25 * size - (greatest - least)) / 2)
    least, greatest = least - pad, greatest + pad
    for k, ends in enumerate(camera.window):
        if ends is not None:
            least[k], greatest[k] = ends
    bounds = tuple(map(float, least)), tuple(map(float, greatest))
    return replace(drawing, curves=curves, camera=replace(camera, bounds=bounds))


def _reach(drawing: Drawing, parameters: Mapping[str, float]) -> float:
    """How far solids reach around their centres."""
    lengths = sizes(drawing, parameters)
    return max((_half(one.shape, lengths[list(one.sizes)]) for one in drawing.solids), default=0.0)


def _half(shape: str, of: Array) -> float:
    """Half of the largest extent of a shape."""
    if shape in ("sphere", "disc"):
        return float(of[0])
    if shape == "cylinder":
        return math.hypot(of[0], of[1] / 2)
    return float(np.sqrt((of * of).sum())) / 2


def _range(ends: tuple[float, float] | None, k: int, seen: Extent) -> tuple[float, float]:
    """The range of one coordinate of a curve."""
    if ends is not None:
        return ends
    low, high = float(np.nan_to_num(seen.q_least[k])), float(np.nan_to_num(seen.q_greatest[k]))
    more = BEYOND * (high - low) or max(1.0, abs(low))
    return low - more, high + more


def _symbols(
    drawing: Drawing, t: Array, q: Array, parameters: Mapping[str, float]
) -> dict[str, Array | float]:
    """The values of all symbols along a motion."""
    free = dict.fromkeys(drawing.free, 0.0)
    return {**parameters, **free, TIME: t, **{name: q[:, k] for k, name in enumerate(drawing.coordinates)}}
