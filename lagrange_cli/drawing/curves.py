"""Wires, walls and surfaces: the curves and surfaces on which particles move."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np

from lagrange_cli.drawing.bodies import ROUND, rolls, shape_of
from lagrange_cli.drawing.probe import equal, steady
from lagrange_cli.drawing.scene import Place, Scene
from lagrange_cli.drawing.upright import plane_of, up_of
from lagrange_cli.expression.arrays import Array
from lagrange_cli.expression.node import Node, union
from lagrange_cli.mechanics.substitution import substituted
from lagrange_cli.records import dataclass

TURN, RISE = (0.0, 2 * math.pi), (-math.pi / 2, math.pi / 2)
MOST = 8
"""The largest number of curves in a drawing; more of them would hide the moving parts."""


@dataclass(frozen=True)
class Track:
    """``place`` runs along the coordinates of these numbers."""

    name: str
    place: Place
    along: tuple[int, ...]
    ranges: tuple[tuple[float, float] | None, ...]


def tracks_of(scene: Scene, held: set[str]) -> list[Track]:
    """The tracks of all particles that no rod holds, each once."""
    found: list[Track] = []
    seen: list[Array] = []
    for name, place in scene.positions.items():
        if name in scene.flat or name in held or len(found) == MOST:
            continue
        carried = _carried(scene, name, place)
        own = [k for k in scene.depends(place) if k not in carried]
        if not 1 <= len(own) <= scene.dimension - 1:
            continue
        if len(own) == 2 and _plane(scene, place):
            continue
        ground = _ground(scene, name, place, own)
        track = Track(name, ground, tuple(own), tuple(range_of(scene, ground, k) for k in own))
        mark = _mark(scene, track)
        if not any(equal(mark, other) for other in seen):
            seen.append(mark)
            found.append(track)
    return [*found, *_of_constraints(scene, held)]


def _ground(scene: Scene, name: str, place: Place, own: list[int]) -> Place:
    """Where a particle is; under a round body that rolls in a plane, by its radius below its centre."""
    plane = plane_of(scene)
    if name not in scene.spec.bodies or len(own) != 1 or plane not in ("y", "z"):
        return place
    q = scene.coordinates[own[0]]
    shape = shape_of(scene, name, scene.spec.bodies[name])
    if shape.shape not in ROUND or not rolls(scene, name):
        return place
    upward = up_of(scene)
    up = "xyz".index(upward[-1])
    slope = [scene.graph.diff(component, q) for component in place]
    length = scene.graph.function("sqrt", [scene.graph.sum([(one * one, 1.0) for one in slope])])
    side = 1.0 if float(scene.probe([slope[0]])[0, 0]) > 0 else -1.0
    side = -side if upward.startswith("-") else side
    lower = {0: slope[up], up: -slope[0]}
    return tuple(
        one + side * shape.sizes[0] * lower[k] / length if k in lower else one for k, one in enumerate(place)
    )


def _carried(scene: Scene, name: str, place: Place) -> set[int]:
    """The coordinates of another particle that carries this one along."""
    mine = set(scene.depends(place))
    for other, carrier in scene.positions.items():
        theirs = set(scene.depends(carrier))
        if other == name or not theirs or not theirs < mine:
            continue
        relative = scene.difference(place, carrier)
        if not theirs & set(scene.depends(relative)):
            return theirs
    return set()


def range_of(scene: Scene, place: Place, k: int) -> tuple[float, float] | None:
    """The range of one turn if a place returns after 2 pi; None if it does not."""
    name = str(scene.coordinates[k].data)
    q = scene.probe.symbols[name]
    moved = scene.probe(place, {name: q + 2 * math.pi})
    size = float(np.abs(moved[np.isfinite(moved)]).max(initial=0.0))
    return TURN if equal(moved, scene.at(place), size) else None


def _plane(scene: Scene, place: Place) -> bool:
    """Whether a place in space stays in a plane along two axes: the ground, or the plane of a throw."""
    return any(one.is_zero or steady(values) for one, values in zip(place, scene.at(place)))


def _mark(scene: Scene, track: Track) -> Array:
    """The track at some values of its coordinates: tracks with equal marks are the same."""
    symbols = {
        str(scene.coordinates[k].data): np.linspace(0.3, 1.1 + i, 8) for i, k in enumerate(track.along)
    }
    return scene.probe(track.place, symbols)


# ------------------------------------------------------------------ constraints


def _of_constraints(scene: Scene, held: set[str]) -> Iterator[Track]:
    """The curve or surface that a constraint keeps a particle on, or where an event changes how it moves (a
    floor), if it can be solved for a component, or is an ellipse or an ellipsoid. In other coordinates than
    Cartesian ones a constraint is solved for one of them."""
    kept = [scene.scope.scalar(one) for one in scene.spec.constraints.values()]
    floors = [scene.scope.scalar(one.when) for one in scene.spec.events.values() if one.changes]
    for name, place in scene.positions.items():
        if name in held:
            continue
        plain = [one for one in place if one in scene.coordinates]
        cartesian = len(plain) > 1
        symbols = plain[::-1] if cartesian else [scene.coordinates[k] for k in scene.depends(place)]
        for node in (*kept, *floors) if cartesian else kept:
            if node.symbols & scene.moving & ~union(place):
                continue
            solved, rise = _solved(scene, node, symbols), None
            there = {} if solved is None else dict([solved])
            if not there and cartesian:
                there, rise = _round(scene, node, plain)
            if there:
                on = substituted(scene.graph, place, there)
                along = scene.depends(on)
                if 1 <= len(along) <= scene.dimension - 1:
                    angles = [scene.coordinates[k] for k in along]
                    ranges = (
                        RISE if one is rise else range_of(scene, on, k) for k, one in zip(along, angles)
                    )
                    yield Track(name, on, along, tuple(ranges))


def _solved(scene: Scene, node: Node, symbols: list[Node]) -> tuple[Node, Node] | None:
    """One of ``symbols`` and its value where ``node`` is 0, if it is linear in it.

    Of several, the one whose slope stays farthest from 0: a line that turns with t may be upright at times.
    """
    best, found = 0.0, None
    for symbol in symbols:
        slope = scene.graph.diff(node, symbol)
        if slope.is_zero or slope.symbols & scene.moving:
            continue
        (rest,) = scene.without((node,), symbol.symbols)
        least = float(np.abs([*scene.at((slope,))[0], *scene.now((slope,))]).min())
        if least > best and equal(*scene.probe([node, rest + slope * symbol])):
            best, found = least, (symbol, -rest / slope)
    return found


def _round(scene: Scene, node: Node, symbols: list[Node]) -> tuple[dict[Node, Node], Node | None]:
    """The components of the points of an ellipse or an ellipsoid, where ``node`` is 0, and the angle that
    rises. Their angles have the symbols of the first two of them. Empty where it is none along the axes, or
    not seen to be."""
    graph = scene.graph
    used = [one for one in symbols if node.symbols & one.symbols]
    if len(used) < 2:
        return {}, None
    (constant,) = scene.without((node,), union(used))
    whole, rest = constant, -constant
    found = []
    for symbol in used:
        slope = graph.diff(node, symbol)
        curvature = graph.diff(slope, symbol)
        (linear,) = scene.without((slope,), symbol.symbols)
        if curvature.is_zero or (curvature.symbols | linear.symbols) & scene.moving:
            return {}, None
        whole = whole + symbol * (curvature * symbol / graph.constant(2) + linear)
        rest = rest + linear * linear / (graph.constant(2) * curvature)
        found.append((curvature, -linear / curvature))
    squares = [graph.constant(2) * rest / curvature for curvature, _ in found]
    if not equal(*scene.probe([node, whole])) or not min(scene.now(tuple(squares))) > 0:
        return {}, None
    turn, rise = used[:2]
    level = graph.one if len(used) == 2 else graph.function("cos", [rise])
    parts = [graph.function("cos", [turn]) * level, graph.function("sin", [turn]) * level]
    parts += [graph.function("sin", [rise])]
    there = {
        symbol: centre + graph.function("sqrt", [square]) * part
        for symbol, (_, centre), square, part in zip(used, found, squares, parts)
    }
    return there, rise if len(used) > 2 else None


def floors_of(scene: Scene) -> Iterator[tuple[Place, Place]]:
    """The ends of a wall that a particle on a line bounces off: lines across its own."""
    (name,) = scene.flat if len(scene.flat) == len(scene.positions) == 1 else ("",)
    if not name:
        return
    place, half = scene.positions[name], 0.3 * scene.swing()
    along = next((k for k, one in enumerate(place) if one in scene.coordinates), -1)
    for event in scene.spec.events.values():
        node = scene.scope.scalar(event.when)
        if along < 0 or not event.changes or node.symbols & scene.moving != place[along].symbols:
            continue
        solved = _solved(scene, node, [place[along]])
        if solved is not None and not solved[1].symbols & scene.moving:
            ends = (
                tuple(solved[1] if k == along else one + sign * half for k, one in enumerate(place))
                for sign in (-1.0, 1.0)
            )
            low, high = ends
            yield low, high
