"""Rods: what holds two points at a fixed distance, by the embedding or by a constraint.

A point of the embedding hangs on a rod if the terms of its position that one coordinate enters have a fixed
length: the other terms are where the rod begins. This is another particle, or a pivot. Terms, not all pairs
of particles, are looked at, so that a chain takes time in proportion to its length.
"""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Mapping, Sequence
from heapq import nsmallest
from itertools import combinations, pairwise

from lagrange_cli.drawing.bodies import rolls
from lagrange_cli.drawing.distances import End, distance_in, owners_of
from lagrange_cli.drawing.probe import equal, steady
from lagrange_cli.drawing.scene import Place, Scene, lengths
from lagrange_cli.expression.node import Node, bits, union
from lagrange_cli.records import dataclass
from lagrange_cli.spec.spec import Spec

PAIRS = 24
"""Up to this many particles, all pairs are compared; otherwise neighbours in the file's order."""
ON_A_WIRE = ("bead", "ring", "hoop", "car", "block", "marble", "puck", "slider", "skier", "wagon")
"""Names of particles that slide on a circle."""
WIRES = re.compile(
    r"\b(loops?|hoops?|bowls?|tracks?|wires?|rails?|grooves?|rims?|troughs?|half-pipes?)\b", re.I
)
"""Words in a system's name or description for a wire on which particles slide."""
TRIES = 3
"""Coordinates that are tried for one particle."""


@dataclass(frozen=True)
class Rod:
    """What it holds, and where it begins: at a particle, or at the place of a pivot. A ``bar`` only keeps two
    particles apart, wherever they go."""

    start: End
    end: str
    bar: bool = False


def rods_of(scene: Scene) -> list[Rod]:
    """All rods, those of the embedding first."""
    found = [*_hanging(scene)]
    joined = {frozenset((rod.start, rod.end)) for rod in found if isinstance(rod.start, str)}
    held = {rod.end for rod in found}
    for a, b in _pairs(scene, held):
        if frozenset((a, b)) not in joined:
            joined.add(frozenset((a, b)))
            found.append(Rod(a, b, bar=True))
    for rod in constrained(scene):
        both = frozenset((rod.start, rod.end)) if isinstance(rod.start, str) else None
        if both is None or both not in joined:
            found.append(rod)
    return found


def _hanging(scene: Scene) -> list[Rod]:
    """The rods by which a position hangs on something."""
    found = []
    places = {place: name for name, place in reversed(scene.positions.items())}
    alike: dict[int, list[str]] = {}
    for place, name in places.items():
        alike.setdefault(union(place) & scene.moving, []).append(name)
    used = Counter(bit for place in scene.positions.values() for bit in bits(union(place)))
    for name, place in scene.positions.items():
        if name in scene.flat:
            continue
        rare = nsmallest(TRIES, bits(union(place) & scene.moving), key=used.__getitem__)
        own = [scene.coordinates[scene.bits[bit]] for bit in rare]
        rod = next((rod for q in own if (rod := _rod_along(scene, name, place, q, places, alike))), None)
        if rod is not None:
            found.append(rod)
    return found


def _rod_along(
    scene: Scene,
    name: str,
    place: Place,
    q: Node,
    places: Mapping[Place, str],
    alike: Mapping[int, Sequence[str]],
) -> Rod | None:
    """The rod that ``place`` swings on as ``q`` changes; ``alike`` are the particles that depend on the same
    coordinates."""
    joint = scene.without(place, q.symbols)
    reach = lengths(scene.at(scene.difference(place, joint)))
    if not steady(reach) or reach[0] == 0:
        return None
    owner = places.get(joint)
    if owner is None:
        others = alike.get(union(joint) & scene.moving, ())
        owner = next((one for one in others if _same(scene, scene.positions[one], joint)), None)
    if owner is not None:
        return Rod(owner, name)
    if union(joint) & scene.moving:
        return None
    if _on_a_hoop(scene, name, place, joint) or _rolls_around(scene, name, joint):
        return None
    return Rod(joint, name)


def _rolls_around(scene: Scene, name: str, joint: Place) -> bool:
    """Whether a body rolls along a circle rather than turns about its middle as one piece with a rod."""
    if name not in scene.spec.bodies or not rolls(scene, name):
        return False
    away = scene.at(scene.difference(scene.positions[name], joint))
    turns = [(scene.at(axis) * away).sum(axis=0) for axis in scene.scope.turning(name).axes]
    return not all(steady(one, float(lengths(away).max())) for one in turns)


def _same(scene: Scene, a: Place, b: Place) -> bool:
    """Whether two places in the same coordinates are the same, however they are written."""
    return equal(scene.at(a), scene.at(b), 1e-3)


def _on_a_hoop(scene: Scene, name: str, place: Place, joint: Place) -> bool:
    """Whether a point at a fixed distance from ``joint`` slides on a hoop rather than swings on a rod."""
    if slides(scene.spec, name):
        return True
    turned = union(scene.difference(place, joint)) & scene.time
    return bool(turned) and len(scene.depends(place)) == 1


def _pairs(scene: Scene, held: set[str]) -> list[tuple[str, str]]:
    """Pairs of particles at a fixed distance that are not both held already."""
    names = [name for name in scene.positions if name not in scene.flat]
    pairs = combinations(names, 2) if len(names) <= PAIRS else pairwise(names)
    found = []
    for a, b in pairs:
        one, other = scene.positions[a], scene.positions[b]
        turning = union(one) & union(other) & scene.moving
        if not turning or (a in held and b in held):
            continue
        values = scene.at(one) - scene.at(other)
        apart = lengths(values)
        if steady(apart) and apart[0] > 0:
            found.append((a, b))
    return found


def constrained(scene: Scene) -> list[Rod]:
    """The rods given by constraints."""
    owners = owners_of(scene)
    found = []
    for expression in scene.spec.constraints.values():
        ends = distance_in(scene, scene.scope.scalar(expression), owners)
        if ends is not None and not (isinstance(ends[0], tuple) and slides(scene.spec, ends[1])):
            found.append(Rod(*ends))
    return found


def slides(spec: Spec, name: str) -> bool:
    """Whether a particle is called like one that slides on a wire, or the system like one that has a wire."""
    told = f"{spec.name}. {spec.description}"
    wired = WIRES.search(told) is not None and "pendul" not in told.lower()
    return wired or any(word in name.lower() for word in ON_A_WIRE)
