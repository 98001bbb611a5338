"""The start of a motion: a state that satisfies the constraints, and how it was found."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping
from typing import TYPE_CHECKING, Any

from lagrange_cli.errors import Problem, SpecError
from lagrange_cli.expression.vocabulary import velocity_name
from lagrange_cli.records import dataclass, replace

if TYPE_CHECKING:
    from lagrange_cli.model.start.consistent import Start
    from lagrange_cli.spec.ensemble import EnsembleValues
    from lagrange_cli.spec.spec import Spec
    from lagrange_cli.spec.values import Values

MOST_TOLD = 8
"""Values that are named."""


@dataclass(frozen=True)
class Begin:
    """How initial values became consistent ones.

    ``moved`` has the values that are given, those of the run, and their differences, by name; ``found`` those
    that are not given.
    ``redundant``, ``undetermined`` and ``singular`` name constraints (see ``model.start.consistent``), and
    ``normalized`` has the lengths of quaternions before they became 1, by body. Constraints that depend on
    others agree with them up to ``rest``, a part of their size.
    """

    moved: Mapping[str, tuple[float, float, float]] = {}
    found: Mapping[str, float] = {}
    redundant: tuple[str, ...] = ()
    undetermined: tuple[str, ...] = ()
    singular: tuple[str, ...] = ()
    normalized: Mapping[str, float] = {}
    rest: float = 0.0

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
    spec = replace(spec, left_out=found.redundant, faint=found.faint)
    return spec, with_state(values, found), begin_of(found)


def in_doubles(spec: Spec, values: Values, t: float, given: Collection[str], *, forced: bool) -> Start:
    """The consistent start, as doubles."""
    from lagrange_cli.model.start.consistent import consistent
    from lagrange_cli.model.start.search import Given
    from lagrange_cli.spec.values import left_open

    begin = Given(t, values.q, values.v, *open_numbers(spec, left_open(spec, given)), forced)
    if spec.families.get("constraints"):
        from lagrange_cli.families.consistency import WholeEquations, satisfied, whole

        found = whole(spec)
        if found is not None:
            equations = WholeEquations(found, spec, values.parameters)
            return satisfied(equations, begin) or consistent(
                spec, values.parameters, begin, equations=equations
            )
    return consistent(spec, values.parameters, begin)


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
    return consistent(spec, parameters, begin, context(), near.generic)


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
    """The messages about it."""
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


def consistent_ensemble(
    spec: Spec, values: EnsembleValues, t: float, given: Collection[str], *, forced: bool = False
) -> tuple[Spec, EnsembleValues, tuple[str, ...]]:
    """The same for each member of an ensemble; and what the user is told.

    A member that has no consistent start is refused, and the others go on. The system is that without the
    constraints that depend on others in the first member.

    Raises ``SpecError`` where no member has one.
    """
    if not spec.all_constraints:
        return spec, values, ()
    if values.remainder is not None:
        long = replace(values.of(0), remainder=values.remainder)
        spec, long, begin = consistent_values(spec, long, t, given, forced=forced, exact=True)
        return spec, replace(values, q=long.q, v=long.v, remainder=long.remainder), tuple(notes(begin))
    import numpy as np

    refused: dict[int, str] = {}
    otherwise: dict[int, tuple[str, ...]] = {}
    states = np.array([np.broadcast_to(x, values.members) for x in (*values.q, *values.v)], dtype=np.float64)
    begins: list[Begin] = []
    faint: set[str] = set()
    first: tuple[str, ...] | None = None
    error: SpecError | None = None
    for member in range(values.members):
        try:
            one, found, begin = consistent_values(spec, values.of(member), t, given, forced=forced)
        except SpecError as problem:
            error, refused[member] = error or problem, problem.problems[0].message
            continue
        if first is None:
            first = one.left_out
        if one.left_out != first:
            otherwise[member] = one.left_out
        faint.update(one.faint)
        states[:, member] = (*found.q, *found.v)
        begins.append(begin)
    if first is None:
        assert error is not None
        raise error
    rows = [row if np.ptp(row) else float(row[0]) for row in states]
    size = len(values.q)
    values = replace(values, q=tuple(rows[:size]), v=tuple(rows[size:]), refused=refused, otherwise=otherwise)
    spec = replace(spec, left_out=first, faint=tuple(sorted(faint)))
    return spec, values, tuple(notes_of_members(begins))


def notes_of_members(begins: Collection[Begin]) -> Iterator[str]:
    """The messages about the starts of many motions."""
    if len(begins) == 1:
        yield from notes(next(iter(begins)))
        return
    moved, found = sum(bool(one.moved) for one in begins), sum(bool(one.found) for one in begins)
    if moved:
        yield f"initial values of {members(moved)} moved to satisfy the constraints"
    if found:
        yield f"initial values of {members(found)} found from the constraints"
    dependent = [(one.redundant, one.undetermined) for one in begins]
    for redundant, undetermined in dict.fromkeys(dependent):
        (said,) = [*notes(replace(NOTHING, redundant=redundant, undetermined=undetermined)), ""][:1]
        if len({*dependent}) > 1:
            count = dependent.count((redundant, undetermined))
            said = said.replace("warning: ", f"warning: in {members(count)} ")
        if said:
            yield said
    singular = sum(bool(one.singular) for one in begins)
    if singular:
        yield f"warning: constraints of {members(singular)} depend on each other at the start, and only there"


def members(count: int) -> str:
    """So many of them."""
    return f"{count} member{'' if count == 1 else 's'}"


def notes(begin: Begin) -> Iterator[str]:
    """The messages about the start."""
    if begin.normalized:
        lengths = [f"{body} (its length was {length:.9g})" for body, length in begin.normalized.items()]
        noun, rates = ("quaternion", "its rates") if len(lengths) == 1 else ("quaternions", "their rates")
        moved = [f"{name} {old:.9g} -> {new:.9g}" for name, (old, new, _) in begin.moved.items()]
        yield (
            f"initial {noun} of {in_short(lengths)} normalized, and {rates} divided by that length, which "
            f"keeps the angular velocity: {in_short(moved)}"
        )
    elif begin.moved:
        shown = [f"{name} {old:.9g} by {by:.1e}" for name, (old, _, by) in begin.moved.items()]
        yield f"initial values moved to satisfy the constraints: {in_short(shown)}"
    if begin.found:
        shown = [f"{name} = {value:.9g}" for name, value in begin.found.items()]
        yield f"initial values found from the constraints: {in_short(shown)}"
    if begin.redundant:
        noun, verb = ("constraint", "depends") if len(begin.redundant) == 1 else ("constraints", "depend")
        but = f" (up to {begin.rest:.0e} of its size, which is taken for rounding)" if begin.rest else ""
        yield (
            f"warning: the {noun} {in_short(begin.redundant)} {verb} on the others{but}: the multipliers of "
            f"{in_short(begin.undetermined)} are not unique, and the ones of least norm are written; the "
            "motion is unique"
        )
    if begin.singular:
        one = len(begin.singular) == 1
        noun, verb, whose = ("constraint", "depends", "its") if one else ("constraints", "depend", "their")
        yield (
            f"warning: the {noun} {in_short(begin.singular)} {verb} on the others at the start, or {whose} "
            "derivatives are 0 there: a singular configuration, from which the motion may not be unique"
        )


def in_short(words: Collection[str]) -> str:
    """The first of them."""
    listed = [*words]
    more = len(listed) - MOST_TOLD
    return ", ".join(listed[:MOST_TOLD]) + (f" and {more} more" if more > 0 else "")
