"""What ``--set`` can change: parameters, and the initial values of coordinates and velocities."""

from __future__ import annotations

from collections.abc import Iterable, Mapping

from lagrange_cli.errors import UsageError
from lagrange_cli.expression.confusions import rate_of, romanized
from lagrange_cli.expression.indices import integer
from lagrange_cli.expression.near import known_hint, near_hint
from lagrange_cli.expression.parse import parse
from lagrange_cli.expression.syntax import ExpressionError, Name, Tree, names
from lagrange_cli.expression.vocabulary import (
    CONSTANTS,
    VELOCITY_SUFFIX,
    family_name,
    member_name,
    velocity_name,
)
from lagrange_cli.spec.content import groups_by_name, names_of
from lagrange_cli.spec.roles import COORDINATE, PARAMETER, SIZE, VELOCITY, role
from lagrange_cli.spec.spec import Spec

OPTIONS = "start", "stop", "step", "samples", "tolerance", "method", "outputs", "precision"
"""Options that could be taken for names of numbers."""
NUMBERS = "values are numbers, or expressions in parameters"


def settable(spec: Spec, name: str, asked: str) -> str:
    """What ``name`` is called in the spec (``theta[3]`` for ``theta[N - 1]``), if it can be set.

    Raises ``UsageError``, which begins with what was ``asked`` (``--set m=1``), for any other name.
    """
    found = name
    if "[" in name:
        try:
            tree = parse(name)
            if isinstance(tree, Name) and tree.indices:
                found = member_name(tree.identifier, indices_of(spec, tree))
        except ExpressionError as error:
            raise wrong_usage(asked, error) from error
    if family_name(found) in spec.tables:
        raise UsageError(f"{asked}: '{found}' is used as an index, which the file decides; change it there")
    parameters, coordinates = names_of(spec.parameters), names_of(spec.coordinates)
    if found not in parameters and found not in coordinates and moved_by(found) not in coordinates:
        known = [*parameters, *coordinates, *map(velocity_name, coordinates)]
        raise UsageError(f"{asked}: {unsettable(spec, found, asked.partition('=')[2], known)}")
    return found


def named_once(spec: Spec, overrides: Mapping[str, str]) -> dict[str, str]:
    """The texts of ``--set`` by the names of the spec, each of which has one.

    Raises ``UsageError`` for a name that cannot be set, and for a member that is named in two ways."""
    found: dict[str, str] = {}
    for name, text in overrides.items():
        asked = f"--set {name}={text}"
        known = settable(spec, name, asked)
        if known in found:
            raise UsageError(
                f"{asked}: '{known}' is given twice, as {found[known]} and as {text}: leave one out"
            )
        found[known] = text
    return found


def indices_of(spec: Spec, name: Name) -> list[int]:
    """The indices of a member, which may be looked up. Raises ``ExpressionError``."""
    trees: Iterable[Tree] = name.indices
    if spec.tables:
        from lagrange_cli.spec.lookups import with_found

        trees = [with_found(one, lambda name: spec.tables.get(name.identifier), True) for one in trees]
    return [integer(one, spec.sizes) for one in trees]


def unsettable(spec: Spec, name: str, value: str, known: list[str]) -> str:
    """Why a ``name`` cannot be set to a ``value``, and what can be done: those that are ``known`` can."""
    what = role(spec, name)
    if what == SIZE:
        return f"'{name}' is a size; --size {name}={value or '...'} sets it"
    if not what and name in OPTIONS:
        return f"'{name}' is an option; write --{name} {value or '...'}"
    base, component, _ = name.partition(".")
    if what in (PARAMETER, COORDINATE, VELOCITY):
        if component:
            return f"'{base}' is {what} and has no components; write {base}"
        if "[" in name and name.partition("[")[0] in known:
            return f"'{name.partition('[')[0]}' is one number and takes no index"
        if "[" in name:
            return f"unknown name '{name}'; {settable_hint(name, known)}"
        return f"'{name}' is a family; write one of its members, {members_of(name, known)}"
    if what:
        return f"'{base}' is {what}; only parameters and initial values can be set; {known_hint(known)}"
    return f"unknown name '{name}'; {settable_hint(name, known)}"


def parsed(spec: Spec, name: str, text: str) -> Tree:
    """The expression that ``name`` is set to. Raises ``UsageError`` where it is none, or contains more than
    parameters, sizes and definitions that are constant."""
    try:
        tree = parse(text)
        for one in names(tree):
            if one.base in groups_by_name(spec.definitions):
                from lagrange_cli.spec.surface import check_constant

                check_constant(one, spec, NUMBERS)
            else:
                _check_name(spec, one)
    except ExpressionError as error:
        raise wrong_usage(f"--set {name}={text}", error) from error
    return tree


def _check_name(spec: Spec, one: Name) -> None:
    """Raise ExpressionError unless the name stands for a parameter, or may once its index is known."""
    parameters = names_of(spec.parameters)
    if one.identifier in (parameters.bases if one.indices else (*spec.sizes, *CONSTANTS)):
        return
    if not one.indices and one.identifier in parameters:
        return
    if one.identifier.lower() in ("nan", "inf", "infinity"):
        raise ExpressionError(one.span, f"'{one.identifier}' is not a finite number", "write a number")
    known, what = [*parameters], role(spec, one.identifier)
    if what == PARAMETER:
        message = f"'{one.identifier}' is a family"
        raise ExpressionError(
            one.span, message, f"write one of its members, {members_of(one.identifier, known)}"
        )
    if what:
        message = f"'{one.identifier.partition('.')[0]}' is {what}"
        raise ExpressionError(one.span, message, f"{NUMBERS}; {known_hint(known)}" if known else NUMBERS)
    raise ExpressionError(one.span, f"unknown name '{one.identifier}'", settable_hint(one.identifier, known))


def moved_by(velocity: str) -> str:
    """The coordinate that something is the velocity of, if it is one: ``u[1]`` for ``u_dot[1]``."""
    base, bracket, index = velocity.partition("[")
    coordinate = base.removesuffix(VELOCITY_SUFFIX) + bracket + index
    return "" if coordinate == velocity else coordinate


def settable_hint(name: str, known: list[str]) -> str:
    """What could have been named: where it is a family, its first and last member."""
    if members := members_of(name, known):
        return f"it is a family with members {members}"
    every = {*known}
    coordinates = [one for one in known if velocity_name(one) in every]
    moving, order = (name[:-1], 1) if name.endswith("'") else rate_of(name, coordinates)
    if order == 1 and moving in coordinates:
        return f"write {velocity_name(moving)} for the velocity of {moving}"
    if alike := next((one for one in known if romanized(one) == romanized(name)), ""):
        return f"did you mean '{alike}'?"
    return near_hint(name, known) or known_hint(known)


def members_of(name: str, known: list[str]) -> str:
    """The first and the last member of a family; empty for what is none."""
    members = [one for one in known if family_name(one) == family_name(name) and "[" in one]
    return f"{members[0]} to {members[-1]}" if members else ""


def wrong_usage(asked: str, error: ExpressionError) -> UsageError:
    """The error of what was ``asked`` for on the command line."""
    return UsageError(f"{asked}: {error.message}" + (f"; {error.hint}" if error.hint else ""))
