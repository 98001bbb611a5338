"""The shapes of rigid bodies: as the file gives them, or the solid that has their moments of inertia."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from lagrange_cli.drawing.scene import Place, Scene
from lagrange_cli.expression.node import Node, union
from lagrange_cli.records import dataclass
from lagrange_cli.spec.body import Body

EQUAL = 1e-6
"""Moments of inertia that differ by less, relatively, are those of a round body."""
THIN = 1e-3
"""A side shorter than this fraction of the longest one counts as 0."""


ROUND = ("sphere", "cylinder", "disc")
"""Shapes that roll."""


@dataclass(frozen=True)
class Shape:
    """A shape, its sizes, and the axes of the body that are its own."""

    shape: str
    sizes: tuple[Node, ...]
    axes: tuple[Place, Place, Place]


def rolls(scene: Scene, name: str) -> bool:
    """Whether a body turns as it moves along, by the same coordinates."""
    turned = 0
    for axis in scene.scope.turning(name).axes:
        turned |= union(axis) & scene.moving
    moved = union(scene.positions[name]) & scene.moving
    return bool(turned) and not turned & ~moved


def shape_of(scene: Scene, name: str, body: Body) -> Shape:
    """How a rigid body is drawn."""
    axes = scene.scope.turning(name).axes
    given = [scene.scope.scalar(one) for one in body.inertia.entries]
    if body.inertia.solid:
        return Shape(body.inertia.solid, tuple(given), (axes[0], axes[1], axes[2]))
    mass = scene.scope.scalar(scene.spec.masses[name])
    if len(given) == 9:
        return _turned(scene, given, mass, axes)
    return _round(scene, given, mass, axes)


def _turned(scene: Scene, given: Sequence[Node], mass: Node, axes: Sequence[Place]) -> Shape:
    """The shape for an inertia matrix, along its principal axes with the present values of the parameters."""
    matrix = scene.probe(given)[:, 0].reshape(3, 3)
    moments, columns = np.linalg.eigh((matrix + matrix.T) / 2)
    principal = [
        tuple(scene.graph.sum([(axis[i], float(c)) for axis, c in zip(axes, column)]) for i in range(3))
        for column in columns.T
    ]
    return _round(scene, [scene.graph.constant(float(one)) for one in moments], mass, principal)


def _round(scene: Scene, moments: Sequence[Node], mass: Node, axes: Sequence[Place]) -> Shape:
    """A sphere, a cylinder about the axis that differs, or a box, with three principal moments."""
    a, b, c = scene.probe(moments)[:, 0]
    scale = max(a, b, c)
    alike = [abs(x - y) <= EQUAL * scale for x, y in ((b, c), (c, a), (a, b))]
    if all(alike):
        radius = scene.graph.function("sqrt", [2.5 * moments[0] / mass])
        return Shape("sphere", (radius,), (axes[0], axes[1], axes[2]))
    if any(alike):
        own = alike.index(True)  # the axis whose moment differs
        other, third = (own + 1) % 3, (own + 2) % 3
        axial, across = moments[own], moments[other]
        turned = axes[other], axes[third], axes[own]
        radius = scene.graph.function("sqrt", [2.0 * axial / mass])
        height = _root(scene, (12.0 * across - 6.0 * axial) / mass)
        flat = not _positive(scene, height, radius)
        return Shape("disc", (radius,), turned) if flat else Shape("cylinder", (radius, height), turned)
    total = scene.graph.sum([(one, 0.5) for one in moments])
    sides = [_root(scene, 12.0 * (total - one) / mass) for one in moments]
    return Shape("box", tuple(sides), (axes[0], axes[1], axes[2]))


def _root(scene: Scene, node: Node) -> Node:
    """The square root of what rounding may have made negative."""
    value = float(scene.probe([node])[0, 0])
    return scene.graph.zero if not value > 0 or math.isinf(value) else scene.graph.function("sqrt", [node])


def _positive(scene: Scene, node: Node, beside: Node) -> bool:
    values = scene.probe([node, beside])[:, 0]
    return bool(values[0] > THIN * values[1])
