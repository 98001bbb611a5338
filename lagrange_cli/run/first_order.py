"""The initial velocities of coordinates without mass, which follow from places: q_dot = f(q, t)."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from typing import TYPE_CHECKING, Any, TypeAlias

from lagrange_cli.decimals import decimal
from lagrange_cli.errors import SpecError
from lagrange_cli.expression.vocabulary import velocity_name
from lagrange_cli.records import replace
from lagrange_cli.spec.content import names_of
from lagrange_cli.spec.source import Source
from lagrange_cli.spec.values import left_open, rounding_of

if TYPE_CHECKING:
    from lagrange_cli.spec.spec import Spec
    from lagrange_cli.spec.values import Values

Moved: TypeAlias = "Mapping[str, tuple[float, float, float]]"


def with_velocities(
    spec: Spec, values: Values, t: float, given: Collection[str], *, forced: bool = False, exact: bool = False
) -> tuple[Values, Moved, Mapping[str, float]]:
    """The values with these velocities; those that are moved, as given and now, with their differences, and
    those that are found, by name (see ``run.start``). ``exact`` computes with many digits.

    Raises ``SpecError`` where one of them is not determined, or is given as another one, unless that is
    ``forced``.
    """
    from lagrange_cli.model.start.nearest import ROUND
    from lagrange_cli.model.start.search import SLIGHTLY

    parameters, q, v = in_full(values, values.remainder)
    known = velocities(spec, parameters, t, q, v, exact=exact or values.remainder is not None)
    names, free = [*names_of(spec.coordinates)], left_open(spec, given)
    usual = max((abs(float(one)) for one in known.values()), default=0.0)
    moved, found = dict[str, tuple[float, float, float]](), dict[str, float]()
    for k, value in known.items():
        name, by = velocity_name(names[k]), float(value - v[k])
        if name in free:
            found |= {name: float(value)} if abs(value) > 2 * ROUND * usual else {}
        elif not abs(by) <= SLIGHTLY * usual and not forced:
            raise contradiction(spec, k, float(v[k]), float(value))
        elif abs(by) > 2 * ROUND * usual:
            moved[name] = float(v[k]), float(value), by
    return with_speeds(values, known), moved, found


def velocities(
    spec: Spec, parameters: Mapping[str, Any], t: Any, q: Sequence[Any], v: Sequence[Any], *, exact: bool
) -> dict[int, Any]:
    """The velocities of these coordinates, by their numbers; with many digits if they are ``exact``.

    Raises ``SpecError`` where an equation does not determine one.
    """
    import numpy as np

    from lagrange_cli.expression.graph_algebra import GraphAlgebra
    from lagrange_cli.families.system import family_system
    from lagrange_cli.families.values import DOUBLES, Doubles, FamilyValues

    kind: Doubles = DOUBLES
    algebra = GraphAlgebra
    if exact:
        from lagrange_cli.expression.exact import ExactGraphAlgebra
        from lagrange_cli.families.long_values import LongNumbers

        kind, algebra = LongNumbers(), ExactGraphAlgebra
    system = family_system(spec, algebra) or family_system(spec)
    assert system is not None and system.first_order is not None
    given = kind.array([parameters[name] for name in names_of(spec.parameters)])
    with np.errstate(all="ignore"):
        state = FamilyValues(system, kind.number(t), kind.array(q), kind.array(v), given, kind=kind)
        found = state.of(system.first_order.velocities)
    known = {k: found[k] for k in system.first_order.rows.tolist()}
    for k, value in known.items():
        if not np.isfinite(float(value)):
            one = spec.coordinates[k]
            message = (
                f"the equation of motion of '{one.name}', which has no mass, does not determine its velocity"
            )
            hint = "give it a mass, or check whether a factor of a velocity is 0 at the start"
            raise Source(spec.filename, spec.text).error(one.place, message, hint)
    return known


def rounding_with_velocities(
    spec: Spec, values: Values, start: float, overrides: Mapping[str, str]
) -> Values:
    """By how much the numbers as they are written exceed ``values``, with the velocities of these places."""
    from lagrange_cli.expression.exact import context, less

    rounding = rounding_of(spec, values, start, overrides)
    parameters, q, v = in_full(values, rounding)
    known = velocities(spec, parameters, context().mpf(start) + rounding.times["start"], q, v, exact=True)
    speeds = [*rounding.v]
    for k, value in known.items():
        speeds[k] = less(value, values.v[k])
    return replace(rounding, v=tuple(speeds))


def contradiction(spec: Spec, k: int, given: float, value: float) -> SpecError:
    """The error of a velocity that is given as another one."""
    one = spec.coordinates[k]
    name = velocity_name(one.name)
    message = (
        f"{name} is {decimal(given, 9)} at the start, but {decimal(value, 9)} by the equations of motion: "
        f"'{one.name}' has no mass"
    )
    hint = "leave the velocity out, or give the coordinate a mass"
    return Source(spec.filename, spec.text).error(one.place, message, hint)


def in_full(values: Values, rest: Values | None) -> tuple[Mapping[str, Any], Sequence[Any], Sequence[Any]]:
    """Parameters, q and v; with many digits where values have a ``rest``."""
    if rest is None:
        return values.parameters, values.q, values.v
    from lagrange_cli.expression.exact import context

    number, low = context().mpf, rest.parameters
    parameters = {name: number(x) + low[name] for name, x in values.parameters.items()}
    q, v = ([number(x) + y for x, y in zip(*both)] for both in ((values.q, rest.q), (values.v, rest.v)))
    return parameters, q, v


def with_speeds(values: Values, known: Mapping[int, Any]) -> Values:
    """The values with these velocities, rounded to as many parts as they have."""
    v = [*values.v]
    for k, value in known.items():
        v[k] = float(value)
    rest = values.remainder
    if rest is None:
        return replace(values, v=tuple(v))
    low = [*rest.v]
    for k, value in known.items():
        low[k] = float(value - v[k])
    return replace(values, v=tuple(v), remainder=replace(rest, v=tuple(low)))
