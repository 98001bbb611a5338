"""Checks the section ``bodies``: what its expressions may depend on, and the number of their components."""

from __future__ import annotations

from lagrange_cli.expression.bounds import Bounds
from lagrange_cli.expression.vocabulary import TIME, family_name
from lagrange_cli.spec.draft import Draft, WrittenBody
from lagrange_cli.spec.kinds import Kind
from lagrange_cli.spec.names import Names
from lagrange_cli.spec.problems import Problems
from lagrange_cli.spec.settling import check_scalar
from lagrange_cli.spec.spec import Body, Expression, Orientation


def check_bodies(draft: Draft, names: Names, problems: Problems) -> dict[str, Body]:
    """The bodies by name, members of families one by one; mistakes are added to ``problems``."""
    found: dict[str, Body] = {}
    for body in draft.bodies:
        label = f"body '{body.key.label}'"
        if body.mass is not None:
            constant(names, body.mass, f"mass of {label}")
        bounds = None
        if body.position is not None:
            _, bounds = names.check(body.position, "bodies", f"position of {label}")
            if bounds is not None and (not isinstance(bounds, tuple) or len(bounds) != 3):
                given = len(bounds) if isinstance(bounds, tuple) else 1
                message = f"the position of {label} has {given} component{'s' if given > 1 else ''}, not 3"
                problems.add_once(body.position.place, message, "write [x, y, z]")
                bounds = None
        meaning = names.table.get(family_name(body.name))
        if meaning is not None and meaning.what is Kind.BODY:
            centre = bounds or (Bounds(), Bounds(), Bounds())
            names.settle(body.name, frozenset({Kind.PARTICLE}), centre)
        for one in () if body.inertia is None else body.inertia.entries:
            constant(names, one, f"inertia of {label}")
        for one in () if body.orientation is None else body.orientation.entries:
            check_scalar(names, one, "bodies", f"orientation of {label}")
        if body.inertia is not None and body.orientation is not None:
            found[body.name] = Body(body.inertia, body.orientation, body.place)
            check_norm(body, body.orientation, names, problems)
    return found


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
