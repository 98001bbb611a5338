"""The start of a motion: a state that satisfies the constraints, and how it was found."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from typing import TYPE_CHECKING, Any

from lagrange_cli.errors import Problem, SpecError
from lagrange_cli.expression.vocabulary import velocity_name
from lagrange_cli.records import dataclass, replace

if TYPE_CHECKING:
    from lagrange_cli.families.consistency import WholeEquations
    from lagrange_cli.model.start.consistent import Start
    from lagrange_cli.spec.spec import Spec
    from lagrange_cli.spec.values import Values


@dataclass(frozen=True)
class Begin:
    """How initial values became consistent ones.

    ``moved`` has the values that are given, those of the run, and their differences, by name; ``found`` those
    that are not given.
    ``redundant``, ``undetermined`` and ``singular`` name constraints (see ``model.start.consistent``), and
    ``normalized`` has the lengths of quaternions before they became 1, by body. Constraints that depend on
    others agree with them up to ``rest``, a part of their size. All this is ``by`` constraints, or by the
    equations of motion of coordinates without mass.
    """

    moved: Mapping[str, tuple[float, float, float]] = {}
    found: Mapping[str, float] = {}
    redundant: tuple[str, ...] = ()
    undetermined: tuple[str, ...] = ()
    singular: tuple[str, ...] = ()
    normalized: Mapping[str, float] = {}
    rest: float = 0.0
    by: str = "the constraints"

    def as_data(self) -> dict[str, Any]:
        """The fields in terms of JSON."""
        return {
            "moved": {
                name: {"given": old, "value": new, "by": by} for name, (old, new, by) in self.moved.items()
            },
            "found": dict(self.found),
            "redundant": list(self.redundant),
            "undetermined": list(self.undetermined),
            "singular": list(self.singular),
            "normalized": dict(self.normalized),
        }


NOTHING = Begin()
"""Nothing had to be done."""


def consistent_values(
    spec: Spec, values: Values, t: float, given: Collection[str], *, forced: bool = False, exact: bool = False
) -> tuple[Spec, Values, Begin]:
    """The system without redundant constraints, the values with a consistent initial state, and what was
    done.

    ``given`` are the names of initial values that are given besides those of the file. ``exact`` computes
    with many digits: values are then rounded correctly, and have as many parts as before.

    Raises ``SpecError`` where no consistent state is near.
    """
    if spec.first_order:
        from lagrange_cli.run.first_order import with_velocities

        values, moved, open_ones = with_velocities(spec, values, t, given, forced=forced, exact=exact)
        return spec, values, Begin(moved, open_ones, by="the equations of motion")
    if not spec.all_constraints:
        return spec, values, NOTHING
    from lagrange_cli.run.derive import located

    try:
        with located(spec):
            found = in_doubles(spec, values, t, given, forced=forced)
            if exact:
                found = in_many_digits(spec, values, t, given, found, forced=forced)
    except ArithmeticError as error:
        reason, hint = f"{error}", "check the numbers in them"
        if isinstance(error, OverflowError):
            reason, hint = (
                "a number is too large, or its square",
                "the largest is about 1.8e308: use other units",
            )
        message = f"the constraints cannot be satisfied at the initial state: {reason}"
        raise SpecError(spec.filename, [Problem(0, 0, message, hint=hint)]) from error
    names = [*spec.all_constraints] if found.generic.tied else []
    in_turn = tuple(names[i] for i in found.generic.in_turn)
    tied = tuple(tuple(names[i] for i in group) for group in found.generic.tied)
    spec = replace(spec, left_out=found.redundant, in_turn=in_turn, tied=tied, faint=found.faint)
    return spec, with_state(values, found), replace(begin_of(found), by=said_by(spec))


def said_by(spec: Spec) -> str:
    """What the start has to satisfy."""
    if not spec.massless:
        return "the constraints"
    others = spec.all_constraints.keys() - spec.massless.keys()
    return "the constraints and equations of motion" if others else "the equations of motion"


def in_doubles(spec: Spec, values: Values, t: float, given: Collection[str], *, forced: bool) -> Start:
    """The consistent start, as doubles."""
    from lagrange_cli.model.start.consistent import consistent
    from lagrange_cli.model.start.search import Given
    from lagrange_cli.spec.values import left_open

    begin = Given(t, values.q, values.v, *open_numbers(spec, left_open(spec, given)), forced)
    equations = of_families(spec, values.parameters)
    clear = None if equations is None else equations.satisfied(begin)
    return clear or consistent(spec, values.parameters, begin, equations=equations)


def of_families(spec: Spec, parameters: Mapping[str, Any], *, exact: bool = False) -> WholeEquations | None:
    """The constraints and masses of a large system of families, for all members at once; None of others."""
    if not spec.coordinate_families:
        return None
    from lagrange_cli.families.consistency import equations_of

    return equations_of(spec, parameters, exact=exact)


def in_many_digits(
    spec: Spec, values: Values, t: float, given: Collection[str], near: Start, *, forced: bool
) -> Start:
    """The same with many digits; ``near`` is that of doubles."""
    from lagrange_cli.expression.exact import context

    number, rest = context().mpf, values.remainder

    def long(name: str, high: Any, low: Any) -> Any:
        return number(high) + (0 if low is None else number(low))

    parameters = {
        name: long(name, x, None if rest is None else rest.parameters[name])
        for name, x in values.parameters.items()
    }
    q, v = (
        [long("", x, None if rest is None else low) for x, low in zip(row, lows)]
        for row, lows in (
            (values.q, values.q if rest is None else rest.q),
            (values.v, values.v if rest is None else rest.v),
        )
    )
    return refined(spec, parameters, number(t), (q, v), given, near, forced=forced)


def refined(
    spec: Spec,
    parameters: Mapping[str, Any],
    t: Any,
    state: tuple[list[Any], list[Any]],
    given: Collection[str],
    near: Start,
    *,
    forced: bool,
) -> Start:
    """The consistent start of numbers with many digits."""
    from lagrange_cli.expression.exact import context
    from lagrange_cli.model.start.consistent import consistent
    from lagrange_cli.model.start.search import Given
    from lagrange_cli.spec.values import left_open

    free_q, free_v = open_numbers(spec, left_open(spec, given))
    q = [context().mpf(near.q[k]) if k in free_q else x for k, x in enumerate(state[0])]
    begin = Given(t, q, state[1], free_q, free_v, forced)
    equations = of_families(spec, parameters, exact=True)
    return consistent(spec, parameters, begin, context(), near, equations)


def open_numbers(spec: Spec, names: Collection[str]) -> tuple[frozenset[int], frozenset[int]]:
    """The numbers of the coordinates, and of the velocities, that have these names."""
    from lagrange_cli.spec.content import names_of

    coordinates = [*names_of(spec.coordinates)]
    return (
        frozenset(k for k, name in enumerate(coordinates) if name in names),
        frozenset(k for k, name in enumerate(coordinates) if velocity_name(name) in names),
    )


def with_state(values: Values, found: Start) -> Values:
    """The values with another initial state, rounded to as many parts as they have."""
    rest = values.remainder
    if rest is None:
        return replace(values, q=tuple(map(float, found.q)), v=tuple(map(float, found.v)))
    from lagrange_cli.expression.exact import in_two_parts

    (q, low_q), (v, low_v) = (zip(*map(in_two_parts, row)) for row in (found.q, found.v))
    return replace(values, q=q, v=v, remainder=replace(rest, q=low_q, v=low_v))


def begin_of(found: Start) -> Begin:
    """How it was found."""
    return Begin(
        {one.name: (one.given, one.value, one.by) for one in found.changed if one.given is not None},
        {one.name: one.value for one in found.changed if one.given is None},
        found.redundant,
        found.undetermined,
        found.singular,
        found.normalized,
        found.generic.rest,
    )


def rounding_of_run(
    spec: Spec, values: Values, start: float, overrides: Mapping[str, str], *, forced: bool
) -> Values:
    """By how much the numbers as they are written exceed ``values``; the written initial state is the
    consistent one, to all digits."""
    from lagrange_cli.spec.values import rounding_of

    if spec.first_order:
        from lagrange_cli.run.first_order import rounding_with_velocities

        return rounding_with_velocities(spec, values, start, overrides)
    if not spec.all_constraints:
        return rounding_of(spec, values, start, overrides)
    from lagrange_cli.expression.exact import LongNumberAlgebra, less
    from lagrange_cli.run.derive import located
    from lagrange_cli.spec.values import evaluate_run

    rounding = rounding_of(spec, values, start, overrides)
    algebra = LongNumberAlgebra()
    parameters, q, v, _ = evaluate_run(spec, overrides, algebra, {})
    t = algebra.number(repr(start)) + rounding.times["start"]
    whole = replace(spec, left_out=())
    plain = {name: float(x) for name, x in parameters.items()}
    rounded = replace(values, parameters=plain, q=tuple(map(float, q)), v=tuple(map(float, v)))
    with located(spec):
        near = in_doubles(whole, rounded, start, overrides, forced=forced)
        numbers = [algebra.number(repr(x)) if isinstance(x, float) else x for x in q]
        speeds = [algebra.number(repr(x)) if isinstance(x, float) else x for x in v]
        found = refined(whole, parameters, t, (numbers, speeds), overrides, near, forced=forced)
    return replace(rounding, q=tuple(map(less, found.q, values.q)), v=tuple(map(less, found.v, values.v)))
