"""The camera of a drawing in space: which axis is upright, and whether everything moves in one plane."""

from __future__ import annotations

import numpy as np

from lagrange_cli.drawing.drawing import Camera
from lagrange_cli.drawing.probe import equal, steady
from lagrange_cli.drawing.scene import Scene
from lagrange_cli.drawing.springs import terms
from lagrange_cli.expression.node import union
from lagrange_cli.records import replace

MOST = 60
"""The number of coordinates up to which the potential is examined."""
TILT = 12.0
"""The angle, in degrees, under which a plane is seen from the side, so that bodies do not look flat."""


def up_of(scene: Scene) -> str:
    """The axis that points upward, such as ``z`` or ``-y``: against gravity; without it, y in the plane, and
    z in space."""
    plane = plane_of(scene)
    order = (1,) if scene.dimension == 2 or plane == "z" else (2, 1)
    for k in order:
        pull = _pull(scene, k)
        if pull:
            return ("-" if pull < 0 else "") + "xyz"[k]
    return "xyz"[order[0]]


def camera_of(scene: Scene, up: str) -> Camera:
    """A camera that looks at the plane in which all moves, or from a corner of space."""
    camera = Camera()
    if scene.dimension == 2:
        return camera
    across = {"x": 0.0, "y": -90.0, "z": 0.0}.get(plane_of(scene))
    if across is not None:
        camera = Camera(azimuth=across + TILT, elevation=TILT)
    return replace(camera, elevation=camera.elevation + turned(up))


def turned(up: str) -> float:
    """By how much a camera is turned over, so that a negative axis points upward."""
    return 180.0 if up.startswith("-") else 0.0


def plane_of(scene: Scene) -> str:
    """The axis across the plane in space in which all moves; empty where there is no such plane."""
    if scene.dimension == 2:
        return ""
    for k, axis in enumerate("zyx"):
        if all(_stays(scene, name, 2 - k) for name in scene.positions):
            return axis if scene.positions else ""
    return ""


def _stays(scene: Scene, name: str, k: int) -> bool:
    """Whether a particle does not move along an axis, and a body turns about it only."""
    if union((scene.positions[name][k],)) & (scene.moving | scene.time):
        return False
    if name not in scene.spec.bodies:
        return True
    columns = [scene.probe([axis[k]])[0] for axis in scene.scope.turning(name).axes]
    return any(equal(np.abs(one), np.ones_like(one)) for one in columns)


def _pull(scene: Scene, k: int) -> float:
    """g, if all of the potential but springs is g times the sum of masses times their heights along an axis;
    else 0."""
    if not scene.spec.potential or len(scene.coordinates) > MOST:
        return 0.0
    parts = [
        scene.graph.product([(constant, 1), *factors])
        for constant, factors in terms(scene, linear=True)
        if len(factors) > 1 or factors[0][1] != 2
    ]
    potential = scene.graph.sum([(one, 1.0) for one in parts])
    masses = {name: scene.scope.scalar(scene.spec.masses[name]) for name in scene.positions}
    height = scene.graph.sum([(masses[name] * place[k], 1.0) for name, place in scene.positions.items()])
    pull, up = (
        scene.probe([scene.graph.diff(one, q) for q in scene.coordinates]) for one in (potential, height)
    )
    with np.errstate(all="ignore"):
        g = (pull * up).sum(axis=0) / (up * up).sum(axis=0)
    return float(g[0]) if steady(g) and g[0] != 0 and equal(pull, g * up) else 0.0
