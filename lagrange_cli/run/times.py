"""``--start``, ``--stop`` and ``--step``: numbers, or expressions in parameters such as ``10*2*pi/omega``,
and in definitions that are constant."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from typing import TYPE_CHECKING

from lagrange_cli.errors import UsageError
from lagrange_cli.records import replace
from lagrange_cli.spec.content import groups_by_name

if TYPE_CHECKING:
    from lagrange_cli.expression.syntax import Tree
    from lagrange_cli.spec.spec import SolveDefaults, Spec

CONSTANT = "times are numbers, or expressions in parameters"
COMMON = "all members have the same times"


def with_times(
    options: SolveDefaults,
    texts: Mapping[str, str],
    spec: Spec,
    parameters: Mapping[str, float],
    *,
    exact: bool = False,
) -> SolveDefaults:
    """The options with the values of ``texts``, by name (of ``request.TIMES``).

    ``parameters`` are those that the run has; a sweep has those that all members share. ``exact`` numbers are
    rounded once, when the value is known, and so the same on every machine. Raises ``UsageError``.
    """
    found = {name: time_of(name, text, spec, parameters, exact=exact) for name, text in texts.items()}
    return replace(options, **found)


def time_of(name: str, text: str, spec: Spec, parameters: Mapping[str, float], *, exact: bool) -> float:
    """The value of one of them."""
    try:
        value = float(text)  # nan and infinities are refused with the other settings
        if value:
            return value
    except ValueError:
        pass
    from lagrange_cli.expression.parse import parse
    from lagrange_cli.expression.syntax import ExpressionError

    try:
        tree = parse(text)
        check_names(tree, spec, parameters)
        return evaluated(tree, spec, parameters, exact=exact)
    except ExpressionError as error:
        hint = f"; {error.hint}" if error.hint else ""
        raise UsageError(f"--{name} {text}: {error.message}{hint}") from error


def check_names(
    tree: Tree, spec: Spec, parameters: Collection[str], constant: str = CONSTANT, common: str = COMMON
) -> None:
    """Raise ``ExpressionError`` at a name that is not ``constant``, or one in which members differ, where a
    value is ``common`` to them: these are the hints."""
    from lagrange_cli.expression.near import known_hint, near_hint
    from lagrange_cli.expression.syntax import ExpressionError, names
    from lagrange_cli.expression.vocabulary import CONSTANTS, family_name, velocity_name
    from lagrange_cli.spec.constants import made_of
    from lagrange_cli.spec.roles import role
    from lagrange_cli.spec.surface import check_constant

    everything = [one.name for one in spec.parameters]
    plain, families = {*parameters, *spec.sizes, *CONSTANTS}, {*map(family_name, parameters)}
    state = {family_name(one.name) for one in spec.coordinates}
    for one in names(tree):
        if one.identifier in (families if one.indices else plain):
            continue
        if one.base in groups_by_name(spec.definitions):
            check_constant(one, spec, constant)
            differing = made_of([one.base], spec) & {*map(family_name, everything)} - families
            if differing:
                message = f"'{one.base}' differs between the members of the sweep, as '{min(differing)}' does"
                raise ExpressionError(one.span, message, common)
            continue
        if one.identifier in families:
            message = f"'{one.identifier}' is a list of parameters"
            raise ExpressionError(one.span, message, f"take one of them, as {one.identifier}[0]")
        if one.identifier in {*map(family_name, everything)}:
            message = f"'{one.identifier}' differs between the members of the sweep"
            raise ExpressionError(one.span, message, common)
        if one.identifier in state | set(map(velocity_name, state)):
            message = f"'{one.identifier}' is not constant"
            raise ExpressionError(one.span, message, constant)
        if what := role(spec, one.identifier):
            message = f"'{one.identifier.partition('.')[0]}' is {what}"
            raise ExpressionError(one.span, message, constant)
        message = f"unknown name '{one.identifier}'"
        raise ExpressionError(one.span, message, near_hint(one.identifier, plain) or known_hint(everything))


def evaluated(tree: Tree, spec: Spec, parameters: Mapping[str, float], *, exact: bool) -> float:
    """The value of an expression whose names are known."""
    from lagrange_cli.expression.build import NoMember
    from lagrange_cli.expression.numbers import NumberAlgebra
    from lagrange_cli.spec.constants import builder

    algebra = NumberAlgebra()
    if exact:
        from lagrange_cli.expression.exact import LongNumberAlgebra

        algebra = LongNumberAlgebra()

    def scope(name: str) -> float:
        if name not in parameters:
            raise NoMember
        value: float = algebra.number(repr(parameters[name])) if exact else parameters[name]
        return value

    return float(algebra.finite(tree, builder([tree], spec, scope, algebra).build(tree)))
