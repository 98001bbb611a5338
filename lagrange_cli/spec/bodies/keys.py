"""The section ``bodies`` of the system file: the keys of a rigid body, a row each, and how they are read."""

from __future__ import annotations

from typing import Any

from lagrange_cli.spec import nodes
from lagrange_cli.spec.bodies.readers import read_inertia, read_orientation, read_solid
from lagrange_cli.spec.body import SOLIDS
from lagrange_cli.spec.draft import WrittenBody
from lagrange_cli.spec.fields import read_named, read_scalar, read_vector
from lagrange_cli.spec.nodes import Node
from lagrange_cli.spec.problems import Problems
from lagrange_cli.spec.table import Row, Table, read_table

BODY = Table(
    "body",
    (
        Row("mass", read_scalar, "its mass, an expression in parameters", also="m"),
        Row(
            "inertia",
            read_inertia,
            "its moments of inertia about the centre of mass: the three principal ones along its axes, or a "
            "symmetric 3x3 matrix, made of parameters",
            also="J moments inertia_tensor moment_of_inertia I moments_of_inertia tensor",
        ),
        Row(
            "solid",
            read_solid,
            "in place of `inertia`, a homogeneous solid with its sizes: "
            + ", ".join(f"`{{{name}: {sizes}}}`" for name, sizes in SOLIDS.items()),
            also="shape form geometry",
        ),
        Row(
            "position",
            read_vector,
            "its centre of mass `[x, y, z]` in q, t, parameters and other positions",
            also="r centre center com origin positions embedding",
        ),
        Row(
            "orientation",
            read_orientation,
            "`{euler: [a, b, c], sequence: zxz}`, `{quaternion: [w, x, y, z]}` or `{matrix: 3x3}`",
            also="rotation attitude angles R pose",
        ),
    ),
    {
        "write 'orientation: {euler: [phi, theta, psi]}'": "euler sequence euler_angles phi theta psi",
        "write 'orientation: {quaternion: [w, x, y, z]}'": "quaternion quat quaternions",
        "write 'orientation: {matrix: [[..], [..], [..]]}'": "matrix rotation_matrix dcm",
        "write 'inertia: [I1, I2, I3]'": "I1 I2 I3 Ixx Iyy Izz Ix Iy Iz A B C",
        "write 'solid: {sphere: r}'": "sphere ball radius",
        "write 'solid: {box: [a, b, c]}'": "box cuboid cube",
        "write 'solid: {cylinder: [r, h]}'": "cylinder",
        "write 'solid: {disc: r}'": "disc disk",
        "write 'solid: {rod: l}'": "rod length",
        "it follows from those of the coordinates": "velocity angular_velocity omega v",
        "write 'position: [x, y, z]'": "x y z",
    },
)
EXAMPLE = "{mass: m, inertia: [I1, I2, I3], position: [0, 0, 0], orientation: {euler: [phi, theta, psi]}}"
NEEDED = {"mass": "m", "position": "[x, y, z]", "orientation": "{euler: [phi, theta, psi]}"}
"""The data of a body besides its inertia, and how they are written."""


def read_bodies(node: Node, where: str, problems: Problems) -> tuple[WrittenBody, ...]:
    """Bodies: a mapping with the keys of ``BODY`` for each name."""
    found = []
    for name, key, value in read_named(
        node, "body", "bodies", f"write 'bodies: {{top: {EXAMPLE}}}'", problems
    ):
        label = f"body '{name.label}'"
        fields: dict[str, Any] = {}
        if isinstance(value, nodes.Mapping):
            fields = read_table(value, BODY, label, problems)
            for needed, example in NEEDED.items():
                if needed not in fields:
                    problems.add(key.place, f"{label} has no {needed}", f"write '{needed}: {example}'")
            if "inertia" in fields and "solid" in fields:
                message = f"{label} has both 'inertia' and 'solid'"
                problems.add(key.place, message, "leave one of them out")
            elif "inertia" not in fields and "solid" not in fields:
                hint = "write 'inertia: [I1, I2, I3]', or a solid such as 'solid: {sphere: r}'"
                problems.add(key.place, f"{label} has no inertia", hint)
        else:
            problems.add(value.place, f"{label} must be a mapping", f"write {name.text}: {EXAMPLE}")
        inertia = fields.get("inertia") or fields.get("solid")
        given = fields.get("mass"), fields.get("position"), inertia, fields.get("orientation")
        found.append(WrittenBody(name.name, key.place, name, key.passage, *given))
    return tuple(found)
