"""The section ``draw`` of the system file: its keys, a row each, and how they are read."""

from __future__ import annotations

from collections.abc import Mapping
from functools import partial
from typing import Any

from lagrange_cli.spec.draw.ranges import read_curves, read_range, read_sliders
from lagrange_cli.spec.draw.readers import (
    read_colours,
    read_degrees,
    read_lines,
    read_names,
    read_point,
    read_points,
    read_up,
)
from lagrange_cli.spec.nodes import Node
from lagrange_cli.spec.problems import Problems
from lagrange_cli.spec.table import Row, Table, read_part

BOUNDS = Table(
    "bounds",
    tuple(Row(axis, read_range, f"the range of {axis} that is shown, `[low, high]`") for axis in "xyz"),
)
CAMERA = Table(
    "camera",
    (
        Row(
            "azimuth",
            read_degrees,
            "the direction from which the camera looks, in degrees about the vertical axis [-60; 12 from "
            "the front if everything moves in a plane]",
        ),
        Row(
            "elevation",
            read_degrees,
            "its angle above the horizontal, in degrees [20; 12 if everything moves in a plane]",
        ),
        Row(
            "bounds",
            partial(read_part, BOUNDS),
            "`{x: [-1, 1], y: [0, 2]}`: the range that is shown along each axis, relative to the point "
            "that is followed, if there is one [everything that moves]",
            also="box window limits extent frame range",
        ),
        Row(
            "follow",
            read_point,
            "the point that stays in the middle",
            also="track center centre target look_at at",
        ),
        Row(
            "up",
            read_up,
            "the axis that points upward: `y`, `z`, `-y` or `-z` [against gravity; without it, y in the "
            "plane and z in space]",
            also="vertical upward upwards",
        ),
    ),
    {
        "write 'bounds: {x: [-1, 1], y: [0, 2]}'": "x y z xlim ylim zlim zoom distance fov "
        "scale size width height",
        "write 'azimuth' and 'elevation', in degrees": "angle angles direction orientation view "
        "position from theta phi rotation eye",
    },
)
DRAW = Table(
    "draw",
    (
        Row(
            "rods",
            read_lines,
            "a list of lines, each through two points or more: `[[0, A], [A, B]]`; `none` for none",
            also="rod bars bar links link lines line sticks",
        ),
        Row("springs", read_lines, "the same for springs", also="spring coils coil"),
        Row(
            "points",
            read_points,
            "a list of further points that are shown, such as `(0, l)` or `plate.at(a, 0, 0)`",
            also="point markers marker marks dots",
        ),
        Row(
            "trails",
            read_names,
            "a list of the points that leave a trail, `all` or `none`",
            also="trail traces trace paths path",
        ),
        Row(
            "hide",
            read_names,
            "a list of particles and bodies that are not shown, or `all`",
            also="hidden invisible without",
        ),
        Row(
            "curves",
            read_curves,
            "name -> a wire, a wall or a surface: `{at: [u, u**2], u: [-1, 1]}`, where one or two parameters "
            "or coordinates run through ranges; or points, `[[-1, 0], [1, 0]]`; `none` for none",
            also="curve wires wire walls wall surfaces surface tracks track shapes ground floor",
        ),
        Row(
            "colours",
            read_colours,
            "name of a particle, a body, a curve or a point, or `rods`, or `springs` -> a colour of CSS, "
            "such as `red`, or `'#rrggbb'` in quotes",
            alias="colors",
            also="colour color",
        ),
        Row(
            "camera",
            partial(read_part, CAMERA),
            "`{azimuth, elevation, bounds, follow, up}`: from where it is seen, and what is seen",
            also="viewpoint perspective view",
        ),
        Row(
            "sliders",
            read_sliders,
            "name of a parameter, a coordinate or a velocity -> the range `[low, high]` of its slider on the "
            "page of `view`",
            also="slider controls ranges",
        ),
    ),
    {
        "write 'camera: {bounds: {x: [-1, 1], y: [0, 2]}}'": "bounds limits range xlim ylim zlim "
        "extent axes window",
        "write 'camera: {azimuth: 30, elevation: 20}'": "azimuth elevation angle angles direction",
        "write 'camera: {follow: bob}'": "follow center centre",
        "write 'camera: {up: z}'": "up",
        "particles are sized by their masses": "size sizes radius radii",
        "everything is shown that is not listed under 'hide'": "show visible bodies particles",
    },
)


def read_draw(node: Node, where: str, problems: Problems) -> Mapping[str, Any]:
    """The section, with the keys of ``DRAW``."""
    return read_part(DRAW, node, where, problems, "write 'draw: {rods: [[0, bob]]}'")
