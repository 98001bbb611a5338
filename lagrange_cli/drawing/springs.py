"""Springs: terms k (d - l)^2/2 of the potential, with a distance d between two points.

A square may stand for a whole distance, or for one component of it: k ((x1 - x2)^2 + (y1 - y2)^2)/2.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from lagrange_cli.drawing.distances import MOST, End, Owners, apart, near, owners_of, pairs, place_of, reached
from lagrange_cli.drawing.probe import equal, steady
from lagrange_cli.drawing.scene import Place, Scene
from lagrange_cli.expression.node import Kind, Node, factors_of, union
from lagrange_cli.records import dataclass


@dataclass(frozen=True)
class Spring:
    """Its two ends, and whether it has no length at rest."""

    start: End
    end: str
    slack: bool = False


def springs_of(scene: Scene) -> list[Spring]:
    """All springs of the potential."""
    owners = owners_of(scene)
    found: dict[tuple[End, str], Spring] = {}
    parts: dict[tuple[End, str], set[int]] = {}
    left = []
    for stretch in squares(scene):
        spring = _whole(scene, stretch, owners)
        if spring is not None:
            found.setdefault((spring.start, spring.end), spring)
        else:
            left.append(stretch)
    for stretch in left:
        for ends, component in _components(scene, stretch, owners):
            parts.setdefault(ends, set()).add(component)
    crooked = fields(scene) if parts else 0
    for ends, components in parts.items():
        across = scene.difference(place_of(scene, ends[0]), place_of(scene, ends[1]))
        due = {i for i, one in enumerate(across) if one.symbols & scene.moving}
        if due <= components and not union(across) & crooked:
            found.setdefault(ends, Spring(*ends, slack=True))
    return list(found.values())


def terms(scene: Scene, linear: bool = False) -> Iterator[tuple[Node, list[tuple[Node, float]]]]:
    """The terms of the potential, factors before sums multiplied out: what is constant of each, and the other
    factors with their exponents. Those with one factor to the first power, such as weights,
    are among them only if ``linear``."""
    graph = scene.graph
    for expression in scene.spec.potential.values():
        pending = [(graph.one, scene.scope.scalar(expression))]
        while pending:
            constant, node = pending.pop()
            if node.kind is Kind.SUM:
                pairs = zip(node.arguments, node.data[1])
                pending += [
                    (c * constant, one) for one, c in pairs if linear or one.kind in (Kind.SUM, Kind.PRODUCT)
                ]
                continue
            factors = factors_of(node)
            moving = [(one, e) for one, e in factors if one.symbols & scene.moving]
            fixed = [(one, e) for one, e in factors if not one.symbols & scene.moving]
            single = len(moving) == 1 and moving[0][1] == 1
            if not moving or (single and not linear and moving[0][0].kind is not Kind.SUM):
                continue
            constant = graph.product([(constant, 1), *fixed])
            if single and moving[0][0].kind is Kind.SUM:
                pending.append((constant, moving[0][0]))
            else:
                yield constant, moving


def squares(scene: Scene) -> Iterator[Node]:
    """u for each term k u^2 of the potential with a positive k."""
    for constant, factors in terms(scene):
        square = len(factors) == 1 and factors[0][1] == 2 and not constant.symbols & scene.time
        if square and np.all(scene.probe([constant]) > 0):
            yield factors[0][0]


def fields(scene: Scene) -> int:
    """The coordinates of terms that are products or higher powers: a field of force, not springs."""
    found = 0
    for _, factors in terms(scene):
        if len(factors) > 1 or (factors[0][0] in scene.coordinates and factors[0][1] not in (1, 2)):
            for one, _ in factors:
                found |= one.symbols & scene.moving
    return found


def _whole(scene: Scene, stretch: Node, owners: Owners) -> Spring | None:
    """The spring whose elongation ``stretch`` is, up to its sign."""
    along = _along_a_line(scene, stretch, owners)
    if along is not None:
        return along
    moved = scene.without_constants(stretch)
    values = np.abs(scene.probe([moved, stretch]))
    for a, b in (*pairs(scene, moved, owners), *reached(scene, stretch, owners)):
        distance = apart(scene, a, b)
        if equal(values[0], distance) or equal(values[1], distance):
            return Spring(a, b, slack=moved is stretch)
    return None


def _along_a_line(scene: Scene, stretch: Node, owners: Owners) -> Spring | None:
    """The spring of ``L - x - l``, where a particle moves along x: what has the sign of x is the length at
    rest, so that the spring is held at L."""
    if stretch.kind is not Kind.SUM:
        return None
    constant, coefficients = stretch.data
    terms = [*zip(stretch.arguments, coefficients), *([(scene.graph.one, constant)] if constant else [])]
    moving = [(x, c) for x, c in terms if x.symbols & (scene.moving | scene.time)]
    if len(moving) != 1 or moving[0][0] not in scene.coordinates:
        return None
    ((x, sign),) = moving
    fixed = [(y, c / sign) for y, c in terms if y is not x]
    values = [float(c * scene.probe([y])[0, 0]) for y, c in fixed]
    if not any(value > 0 for value in values):
        return None
    for name in near(scene, x, owners)[:MOST]:
        place = scene.positions[name]
        if not union(place) & scene.moving & ~x.symbols and place.count(x) == 1:
            wall = scene.graph.sum([(y, -c) for (y, c), value in zip(fixed, values) if value < 0])
            return Spring(tuple(wall if one is x else one for one in place), name)
    return None


def _components(scene: Scene, stretch: Node, owners: Owners) -> Iterator[tuple[tuple[End, str], int]]:
    """The pairs of points with a component of whose distance ``stretch`` is, up to its sign; two particles
    may be measured from places of their own, where they rest."""
    names = near(scene, stretch, owners)[:MOST]
    (values,) = scene.probe([stretch])
    for k, b in enumerate(names):
        for i, component in enumerate(scene.positions[b]):
            if not component.symbols & scene.moving:
                continue
            (own,) = scene.probe([component])
            for a in names[:k]:
                (other,) = scene.probe([scene.positions[a][i]])
                if any(steady(own - other - sign * values, float(np.abs(own).max())) for sign in (1.0, -1.0)):
                    yield (a, b), i
            for sign in (1.0, -1.0):
                if steady(own - sign * values, float(np.abs(own).max())):
                    yield (_fixed(scene, b, i, component - sign * stretch), b), i
                    break


def _fixed(scene: Scene, name: str, component: int, value: Node) -> Place:
    """The fixed point beside a particle whose distance is measured along one component."""
    place = scene.positions[name]
    fixed = [scene.graph.zero if one.symbols & scene.moving else one for one in place]
    if not value.symbols & scene.moving:
        fixed[component] = value
    return tuple(fixed)
