"""Checks the section ``bodies``: what its expressions may depend on, and the number of their components."""

from __future__ import annotations

from collections.abc import Mapping

from lagrange_cli.expression.bounds import Bounds
from lagrange_cli.expression.vocabulary import TIME, family_name
from lagrange_cli.spec.content import by_name, groups_of, parts_by_name
from lagrange_cli.spec.draft import Draft, WrittenBody
from lagrange_cli.spec.kinds import Kind
from lagrange_cli.spec.names import Names
from lagrange_cli.spec.problems import Problems
from lagrange_cli.spec.settling import Settling, check_scalar
from lagrange_cli.spec.spec import Body, Expression, Orientation
from lagrange_cli.spec.whole import WrittenFamily


def check_bodies(draft: Draft, names: Names, problems: Problems) -> Mapping[str, Body]:
    """The bodies by name; mistakes are added to ``problems``. Members of a family that are alike are checked
    at once."""
    groups = groups_of(draft.bodies)
    for group in groups:
        check_centres(names, group)
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


def check_centres(names: Names, group: WrittenBody | WrittenFamily[WrittenBody]) -> None:
    """Check and settle the centre of mass of a body, or those of a family."""
    if not isinstance(group, WrittenFamily):
        check_centre(names, group)
        return
    known = is_body(names, group.name)
    for part in group.parts:
        first, found = next(group.of_part(part)), None
        if first.position is not None and known and names.has_many(part):
            where = f"position of body '{first.key.label}'"
            found = names.check_alike(first.position, "bodies", where)
        if found is not None and isinstance(found[1], tuple) and len(found[1]) == 3:
            Settling(names).settle_part(group.family, part, Kind.BODY, frozenset({Kind.PARTICLE}), found[1])
        else:
            for body in group.of_part(part):
                check_centre(names, body)


def check_centre(names: Names, body: WrittenBody) -> None:
    """The same of one body."""
    bounds = None
    if body.position is not None:
        label = f"position of body '{body.key.label}'"
        _, bounds = names.check(body.position, "bodies", label)
        if bounds is not None and (not isinstance(bounds, tuple) or len(bounds) != 3):
            given = len(bounds) if isinstance(bounds, tuple) else 1
            message = f"the {label} has {given} component{'s' if given > 1 else ''}, not 3"
            names.problems.add_once(body.position.place, message, "write [x, y, z]")
            bounds = None
    if is_body(names, family_name(body.name)):
        names.settle(body.name, frozenset({Kind.PARTICLE}), bounds or (Bounds(), Bounds(), Bounds()))


def is_body(names: Names, name: str) -> bool:
    """Whether a name is entered as that of a body."""
    meaning = names.table.get(name)
    return meaning is not None and meaning.what is Kind.BODY


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
