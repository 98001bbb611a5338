"""Distances in expressions: the points between which a distance is taken, however it is written."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from itertools import combinations

import numpy as np

from lagrange_cli.drawing.probe import equal
from lagrange_cli.drawing.scene import Place, Scene, lengths
from lagrange_cli.expression.arrays import Array
from lagrange_cli.expression.graph import Graph
from lagrange_cli.expression.node import Kind, Node, bits, reachable, union

MOST = 10
"""Particles that are compared with one expression."""

Owners = Mapping[int, Sequence[str]]
"""The particles that depend on each symbol, by its bit."""
End = str | Place


def owners_of(scene: Scene) -> dict[int, list[str]]:
    """Which particles depend on which coordinate."""
    found: dict[int, list[str]] = {}
    for name, place in scene.positions.items():
        for bit in bits(union(place) & scene.moving):
            found.setdefault(bit, []).append(name)
    return found


def near(scene: Scene, node: Node, owners: Owners) -> list[str]:
    """Particles whose places depend on a coordinate that ``node`` depends on."""
    names: dict[str, None] = {}
    for bit in bits(node.symbols & scene.moving):
        names |= dict.fromkeys(owners.get(bit, ())[: 8 * MOST])
    return [*names]


def candidates(scene: Scene, node: Node, owners: Owners) -> list[str]:
    """Particles whose places depend only on coordinates that ``node`` depends on, too."""
    others = scene.moving & ~node.symbols
    found = [name for name in near(scene, node, owners) if not union(scene.positions[name]) & others]
    return found[:MOST]


def pairs(scene: Scene, node: Node, owners: Owners) -> Iterator[tuple[End, str]]:
    """The possible ends of the distance ``node``: two particles, or one and a fixed point."""
    moving = node.symbols & scene.moving
    names = candidates(scene, node, owners)
    whole = [name for name in names if union(scene.positions[name]) & scene.moving == moving]
    for name in whole:
        for centre in centres(scene, node, scene.positions[name]):
            yield centre, name
    for a, b in combinations(names, 2):
        if (union(scene.positions[a]) | union(scene.positions[b])) & scene.moving == moving:
            yield a, b
    for name in whole:
        yield scene.zero, name


def reached(scene: Scene, stretch: Node, owners: Owners) -> Iterator[tuple[End, str]]:
    """Pairs of points whose distance is a coordinate itself, or a function of it, while others turn the line
    between them: two particles, or one and the point that it is at a distance from."""
    names = near(scene, stretch, owners)[:MOST]
    for b in names:
        joint = scene.without(scene.positions[b], stretch.symbols & scene.moving)
        owner = next((name for name, other in scene.positions.items() if other == joint), None)
        if owner is not None or not union(joint) & scene.moving:
            yield joint if owner is None else owner, b
    for a, b in combinations(names, 2):
        yield a, b


def centres(scene: Scene, node: Node, place: Place) -> Iterator[Place]:
    """The points from which ``node`` may be the distance of a particle at ``place``, as it is written."""
    inner = [node, *(one.arguments[0] for one in reachable([node]) if is_root(one))]
    for one in inner:
        centre = centre_of(
            scene.graph,
            one,
            place,
            lambda one: bool(one.symbols & scene.moving),
            scene.coordinates.__contains__,
        )
        if centre is not None:
            yield centre


def is_root(node: Node) -> bool:
    """Whether it is the square root of a sum."""
    return node.kind is Kind.PRODUCT and node.data in ((0.5,), (-0.5,)) and node.arguments[0].kind is Kind.SUM


def centre_of(
    graph: Graph,
    node: Node,
    place: Place,
    moves: Callable[[Node], bool],
    is_coordinate: Callable[[Node], bool],
) -> Place | None:
    """The fixed point c if ``node`` is |r - c|^2 with a factor, in coordinates that are the components of the
    ``place`` r."""
    found = list[Node]()
    for component in place:
        if not moves(component):
            found.append(component)
            continue
        if not is_coordinate(component):
            return None
        slope = graph.diff(node, component)
        curvature = graph.diff(slope, component)
        if curvature.is_zero or moves(curvature):
            return None
        found.append(component - slope / curvature)
    return None if any(map(moves, found)) else tuple(found)


def place_of(scene: Scene, end: End) -> Place:
    """The place of an end."""
    return scene.positions[end] if isinstance(end, str) else end


def apart(scene: Scene, a: End, b: End) -> Array:
    """How far two ends are apart at the random states (STATES,)."""
    return lengths(scene.at(place_of(scene, a)) - scene.at(place_of(scene, b)))


def distance_in(scene: Scene, node: Node, owners: Owners) -> tuple[End, str] | None:
    """The points whose distance is the only quantity in coordinates that ``node`` depends on.

    It is one if its gradient is parallel to that of the square of the distance. Of several pairs of points,
    as there are on a rod, those farthest apart are taken.
    """
    for ends in (pairs, reached):
        found = {
            (a, b): float(np.nanmax(apart(scene, a, b)))
            for a, b in ends(scene, node, owners)
            if _is_distance(scene, node, a, b)
        }
        if found:
            return max(found, key=found.__getitem__)
    return None


def _is_distance(scene: Scene, node: Node, a: End, b: End) -> bool:
    """Whether ``node`` is a function of the distance of two points, which more than one coordinate moves."""
    across = scene.difference(place_of(scene, a), place_of(scene, b))
    symbols = [q for q in scene.coordinates if q.symbols & (node.symbols | union(across))]
    if len(symbols) < 2:
        return False
    square = scene.graph.sum([(one * one, 1.0) for one in across])
    slopes, others = (scene.probe([scene.graph.diff(one, q) for q in symbols]) for one in (node, square))
    return _parallel(slopes, others)


def _parallel(a: Array, b: Array) -> bool:
    """Whether the columns of two tables (components, STATES) are parallel, one by one."""
    sizes = lengths(a) * lengths(b)
    dots = np.abs((a * b).sum(axis=0))
    return bool(np.any(sizes[np.isfinite(sizes)] > 0)) and equal(sizes, dots)
