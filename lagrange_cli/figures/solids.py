"""Rigid bodies as faces: corners in their own axes, and which of them a viewer sees."""

from __future__ import annotations

import numpy as np

Array = np.ndarray
ROUND = 32
"""Corners of a circle."""


def faces(shape: str, sizes: Array) -> list[Array]:
    """The faces of a shape, each by its corners (k, 3), seen from outside counterclockwise."""
    if shape == "box":
        return box(*map(float, sizes / 2))
    if shape == "sphere":
        return sphere(float(sizes[0]))
    if shape == "rod":
        half, thick = float(sizes[0]) / 2, float(sizes[0]) / 60
        return cylinder(thick, half, 8)
    height = float(sizes[1]) / 2 if shape == "cylinder" else float(sizes[0]) / 40
    return cylinder(float(sizes[0]), height, ROUND)


def box(a: float, b: float, c: float) -> list[Array]:
    """A box with these half edges."""
    corners = np.array([[x, y, z] for x in (-a, a) for y in (-b, b) for z in (-c, c)])
    order = ((0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3))
    return [corners[list(one)] for one in order]


def cylinder(radius: float, half: float, count: int) -> list[Array]:
    """A cylinder about its third axis."""
    angle = 2 * np.pi * np.arange(count) / count
    ring = np.stack([radius * np.cos(angle), radius * np.sin(angle)], axis=1)
    top = np.column_stack([ring, np.full(count, half)])
    bottom = np.column_stack([ring, np.full(count, -half)])
    after = [*range(1, count), 0]
    sides = [np.array([bottom[k], bottom[j], top[j], top[k]]) for k, j in enumerate(after)]
    # halves of the ends differ in shade, so that a turn about the axis is seen
    part = count // 2
    ends = []
    for first in (0, part):
        run = [k % count for k in range(first, first + part + 1)]
        ends += [top[run], bottom[run[::-1]]]
    return [*ends, *sides]


def sphere(radius: float) -> list[Array]:
    """A sphere as a globe of quadrilaterals."""
    rings, count = 8, 16
    polar = np.pi * np.arange(rings + 1) / rings
    angle = 2 * np.pi * np.arange(count + 1) / count
    points = radius * np.stack(
        [
            np.outer(np.sin(polar), np.cos(angle)),
            np.outer(np.sin(polar), np.sin(angle)),
            np.outer(np.cos(polar), np.ones(count + 1)),
        ],
        axis=2,
    )
    return [
        np.array([points[i, j], points[i + 1, j], points[i + 1, j + 1], points[i, j + 1]])
        for i in range(rings)
        for j in range(count)
    ]


def seen(
    shape: str, sizes: Array, centre: Array, axes: Array, toward: Array
) -> list[tuple[Array, float, float]]:
    """The faces that a viewer in the direction ``toward`` sees: corners (k, 3), depth, brightness (0 to 1).

    ``axes`` (3, 3) has the unit vectors of the body in its rows.
    """
    found = []
    light = toward + np.array([0.3, 0.2, 0.5])
    light = light / np.linalg.norm(light)
    for number, corners in enumerate(faces(shape, sizes)):
        placed = centre + corners @ axes
        normal = np.zeros(3)
        for one, other in zip(placed, np.roll(placed, -1, axis=0)):
            normal += np.cross(one - placed.mean(axis=0), other - placed.mean(axis=0))
        length = float(np.linalg.norm(normal))
        if length == 0 or normal @ toward <= 0:
            continue
        shade = 0.55 + 0.4 * max(float(normal @ light) / length, 0.0)
        if shape in ("cylinder", "disc") and 2 <= number < 4:
            shade *= 0.8
        if shape == "sphere" and (number // 4) % 2:
            shade *= 0.8
        found.append((placed, float(placed.mean(axis=0) @ toward), shade))
    return found
