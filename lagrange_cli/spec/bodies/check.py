"""Checks the section ``bodies``: masses, moments of inertia and orientations (positions: ``settling``)."""

from __future__ import annotations

from collections.abc import Mapping

from lagrange_cli.expression.vocabulary import TIME
from lagrange_cli.spec.body import Body, Orientation
from lagrange_cli.spec.content import by_name, groups_of, parts_by_name
from lagrange_cli.spec.draft import Draft, WrittenBody
from lagrange_cli.spec.kinds import Kind
from lagrange_cli.spec.names import Names
from lagrange_cli.spec.problems import Problems
from lagrange_cli.spec.settling import check_scalar
from lagrange_cli.spec.spec import Expression


def check_bodies(draft: Draft, names: Names, problems: Problems) -> Mapping[str, Body]:
    """The bodies by name; mistakes are added to ``problems``. Members of a family that are alike are checked
    at once."""
    groups = groups_of(draft.bodies)
    for group in groups:
        for body in names.apart(group):
            check_matter(names, body)
            if body.inertia is not None and body.orientation is not None:
                check_norm(body, body.orientation, names, problems)
    return by_name(parts_by_name(groups, body_of))


def body_of(written: WrittenBody) -> Body | None:
    """A body that has all it needs."""
    if written.inertia is None or written.orientation is None:
        return None
    return Body(written.inertia, written.orientation, written.place)


def check_matter(names: Names, body: WrittenBody) -> None:
    """Check the mass, the inertia and the orientation of a body."""
    label = f"body '{body.key.label}'"
    if body.mass is not None:
        constant(names, body.mass, f"mass of {label}")
    for one in () if body.inertia is None else body.inertia.entries:
        constant(names, one, f"inertia of {label}")
    for one in () if body.orientation is None else body.orientation.entries:
        check_scalar(names, one, "bodies", f"orientation of {label}")


def constant(names: Names, expression: Expression, where: str) -> None:
    """Check a scalar that is made of parameters."""
    check_scalar(names, expression, "masses", where)


def check_norm(body: WrittenBody, orientation: Orientation, names: Names, problems: Problems) -> None:
    """Note a quaternion that is not made of coordinates."""
    if orientation.form != "quaternion":
        return
    used = frozenset[Kind]().union(*(names.check(one, "bodies", "")[0] for one in orientation.entries))
    if problems.found or Kind.COORDINATE in used:
        return
    message = f"the quaternion of body '{body.key.label}' contains no coordinate"
    hint = f"write four coordinates; a body that turns by {TIME} alone is given by angles or a matrix"
    problems.add_once(orientation.place, message, hint)
