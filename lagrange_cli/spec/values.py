"""The numbers of a run: parameters, masses and the initial state, with ``--set`` applied."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping
from typing import TYPE_CHECKING, Any

from lagrange_cli.decimals import decimal
from lagrange_cli.expression.numbers import NumberAlgebra
from lagrange_cli.expression.syntax import ExpressionError, Span
from lagrange_cli.expression.vocabulary import family_name, velocity_name
from lagrange_cli.records import dataclass, field, replace
from lagrange_cli.spec.content import groups_by_name, groups_of, named_alike
from lagrange_cli.spec.evaluation import Evaluation
from lagrange_cli.spec.problems import Problems
from lagrange_cli.spec.spec import Coordinate, Expression, Spec
from lagrange_cli.spec.whole import Part, WrittenFamily

if TYPE_CHECKING:
    from lagrange_cli.spec.body import Body, Inertia


@dataclass(frozen=True)
class Values:
    """Parameters by name, and the initial state: ``q`` and ``v`` in the order of the coordinates.

    Values that are not given are 0 until they are found from constraints (``left_open`` has their names).
    ``times`` are those of ``solve`` that depend on parameters. ``remainder`` is the rest of numbers that are
    known to more digits than a double has, and None otherwise.
    """

    parameters: Mapping[str, float]
    q: tuple[float, ...]
    v: tuple[float, ...]
    remainder: Values | None = None
    times: Mapping[str, float] = field(default_factory=dict)


def resolve_values(
    spec: Spec, overrides: Mapping[str, str] | None = None, problems: Problems | None = None
) -> Values:
    """The numbers ``spec`` is run with; ``overrides`` are those of ``--set``, name to expression.

    With ``problems`` those that the numbers have are added to those that the file has already.

    Raises:
        UsageError: an override of an unknown name, or one that cannot be evaluated.
        SpecError: everything in the file that has no finite value, a mass that is not positive, or an
            initial value that is missing; not with ``problems``.
    """
    parameters, q, v, times = evaluate_run(spec, overrides or {}, NumberAlgebra(), {}, problems)
    return Values(parameters, q, v, times=times)


def left_open(spec: Spec, given: Iterable[str]) -> frozenset[str]:
    """The coordinates and velocities whose initial values neither the file has nor those that are ``given``
    by name."""
    from lagrange_cli.spec.settable import settable

    named = {settable(spec, name, f"--set {name}") for name in given}
    found = set[str]()
    for item, names in named_alike(spec.coordinates):
        if item.initial is None:
            found.update(names)
        if item.velocity is None:
            found.update(map(velocity_name, names))
    return frozenset(found - named)


def resolve_long_values(
    spec: Spec, overrides: Mapping[str, str] | None = None, problems: Problems | None = None
) -> Values:
    """The same in double-double: decimals as they are written, functions and pi to as many digits."""
    from lagrange_cli.expression.exact import LongNumberAlgebra, in_two_parts

    parameters, q, v, times = evaluate_run(spec, overrides or {}, LongNumberAlgebra(), {}, problems)

    def part(i: int, remainder: Values | None = None) -> Values:
        named = {name: in_two_parts(value)[i] for name, value in parameters.items()}
        start, speed = (tuple(in_two_parts(x)[i] for x in row) for row in (q, v))
        return Values(named, start, speed, remainder, {name: float(time) for name, time in times.items()})

    return part(0, part(1))


def rounding_of(
    spec: Spec, values: Values, start: float, overrides: Mapping[str, str] | None = None
) -> Values:
    """By how much the numbers as they are written, in the file and in ``overrides``, exceed ``values``.

    So does the time of the ``start``: it is written as an expression in parameters, or as a decimal.
    """
    from lagrange_cli.expression.exact import LongNumberAlgebra, less

    algebra = LongNumberAlgebra()
    parameters, q, v, times = evaluate_run(spec, overrides or {}, algebra, {})
    begins = times.get("start")
    if begins is None or float(begins) != start:
        begins = algebra.number(repr(start))
    return Values(
        {name: less(value, values.parameters[name]) for name, value in parameters.items()},
        tuple(map(less, q, values.q)),
        tuple(map(less, v, values.v)),
        times={"start": less(begins, start)},
    )


def resolve_portable_values(
    spec: Spec, overrides: Mapping[str, str] | None = None, problems: Problems | None = None
) -> Values:
    """The doubles nearest to those: the same on every machine, whatever its C library."""
    return replace(resolve_long_values(spec, overrides, problems), remainder=None)


def resolve_parameters(
    spec: Spec, overrides: Mapping[str, str] | None = None, problems: Problems | None = None
) -> dict[str, float]:
    """The parameters alone, in the file's terms; masses are checked too, the initial state is not.

    Raises:
        UsageError, SpecError: as ``resolve_values``.
    """
    evaluation = constants_of(spec, overrides or {}, NumberAlgebra(), {}, problems)
    if problems is None:
        evaluation.problems.stop_if_any()
    return evaluation.values


def evaluate_run(
    spec: Spec,
    overrides: Mapping[str, str],
    algebra: NumberAlgebra,
    given: Mapping[str, Any],
    problems: Problems | None = None,
) -> tuple[dict[str, Any], tuple[Any, ...], tuple[Any, ...], dict[str, Any]]:
    """Parameters, q, v and times of ``solve`` over any algebra of numbers; ``given`` are values in place of
    the file's, by the names that the spec has for them.

    Raises:
        UsageError, SpecError: as ``resolve_values``.
    """
    evaluation = constants_of(spec, overrides, algebra, given, problems)
    q = all_of(evaluation, str, lambda one: one.initial, None)
    v = all_of(evaluation, velocity_name, lambda one: one.velocity, 0.0)
    if None in q and not spec.constraints:  # else these determine it
        for coordinate in (one for one, value in zip(spec.coordinates, q) if value is None):
            evaluation.problems.add_once(
                coordinate.place,
                f"coordinate '{coordinate.name}' has no initial value",
                initial_hint(
                    coordinate, f"{family_name(coordinate.name)}{'[...]' if '[' in coordinate.name else ''}"
                ),
            )
    if problems is None:
        evaluation.problems.stop_if_any()
    return evaluation.values, tuple([x or 0.0 for x in q]), tuple([x or 0.0 for x in v]), evaluation.times


def initial_hint(coordinate: Coordinate, name: str) -> str:
    """How to give a coordinate, which the file calls by a ``name``, its initial value."""
    velocity = ", velocity: ..." if coordinate.velocity is not None else ""
    return f"write {name}: {{initial: 0.1{velocity}}}, or --set {coordinate.name}=0.1"


def all_of(
    evaluation: Evaluation,
    naming: Callable[[str], str],
    expression: Callable[[Coordinate], Expression | None],
    default: float | None,
) -> list[Any]:
    """The values of all coordinates, or of their velocities, which ``naming`` names and of which
    ``expression`` is given; ``default`` where none is."""
    found: list[Any] = []
    for one in groups_of(evaluation.spec.coordinates):
        if isinstance(one, WrittenFamily):
            found += of_family(evaluation, one, naming(one.name), expression, default)
        else:
            found.append(of_one(evaluation, naming(one.name), expression(one), default))
    return found


def of_family(
    evaluation: Evaluation,
    group: WrittenFamily[Coordinate],
    name: str,
    expression: Callable[[Coordinate], Expression | None],
    default: float | None,
) -> list[Any]:
    """The values of a family of coordinates, or of their velocities, whose ``name`` is that of these."""
    family = group.family.renamed(name)
    made: list[Any] = [default] * len(group)
    others = {
        one: k for one in (*evaluation.given, *evaluation.overrides) if (k := family.number(one)) is not None
    }
    for part in group.parts:
        written = expression(part.item)
        if written is None:
            continue
        numbers = evaluation.together(part, written, fades=True)
        if numbers is not None:
            for k, value in zip(group.numbers_of_part(part), numbers):
                made[k] = value
            continue
        for k, item in zip(group.numbers_of_part(part), group.of_part(part)):
            if family.members[k] not in others:
                made[k] = of_one(evaluation, family.members[k], expression(item), default)
    for one, k in others.items():
        made[k] = of_one(evaluation, one, None, default)
    return made


def of_one(evaluation: Evaluation, name: str, written: Expression | None, default: float | None) -> Any:
    """The initial value of the coordinate or velocity ``name``, or ``default`` where none is given."""
    if name in evaluation.given or name in evaluation.overrides:
        value = evaluation.override(name)
        return 0.0 if value is None else value
    if written is None:
        return default
    value = evaluation.value(written, f"initial value of '{name}'", evaluation.states)
    return 0.0 if value is None else value


def constants_of(
    spec: Spec,
    overrides: Mapping[str, str],
    algebra: NumberAlgebra,
    given: Mapping[str, Any],
    problems: Problems | None,
) -> Evaluation:
    """An evaluation that has all values but the initial state, and has checked the masses."""
    evaluation = Evaluation(spec, overrides, algebra, given, problems)
    evaluation.parameters()
    evaluation.constants()
    check_masses(evaluation)
    evaluation.settle_times()
    return evaluation


def check_masses(evaluation: Evaluation) -> None:
    """Check that each mass is greater than 0, and that the moments of inertia are those of some body."""
    for particle, group in groups_by_name(evaluation.spec.masses).items():
        if not isinstance(group, WrittenFamily):
            _check_mass(evaluation, particle, group)
            continue
        for part in group.parts:
            found = evaluation.together(part, part.item)
            if found is None or min(found) <= 0:
                for name, mass in zip(group.names_of_part(part), group.of_part(part)):
                    _check_mass(evaluation, name, mass)
    for name, bodies in groups_by_name(evaluation.spec.bodies).items():
        if not isinstance(bodies, WrittenFamily):
            _check_inertia(evaluation, name, bodies.inertia)
            continue
        for alike in bodies.parts:
            for member, body in different(evaluation, bodies, alike):
                _check_inertia(evaluation, member, body.inertia)


def different(
    evaluation: Evaluation, group: WrittenFamily[Body], part: Part[Body]
) -> Iterator[tuple[str, Body]]:
    """The bodies of a part of a family, with their names: of those with the same moments of inertia one."""
    members = zip(group.names_of_part(part), group.of_part(part))
    entries = [evaluation.together(part, one) for one in part.item.inertia.entries]
    values = [one for one in entries if one is not None]
    if len(values) < len(entries):
        yield from members
        return
    seen: set[tuple[float, ...]] = set()
    for moments, member in zip(zip(*values), members):
        if moments not in seen:
            seen.add(moments)
            yield member


def _check_mass(evaluation: Evaluation, particle: str, mass: Expression) -> None:
    value = evaluation.value(mass, f"mass of '{particle}'")
    if value is not None and not evaluation.algebra.positive(value):
        span = Span(0, len(mass.text))
        hint = "masses are greater than 0; leave out a particle without mass"
        error = ExpressionError(span, f"the value {decimal(float(value))} is not positive", hint)
        evaluation.blame(mass, error, f"mass of '{particle}'")


def _check_inertia(evaluation: Evaluation, name: str, inertia: Inertia) -> None:
    """Check that a solid has sizes greater than 0, and that moments of inertia are those of some body."""
    from lagrange_cli.spec.bodies.inertia import flaw, size_flaw

    where = f"{inertia.solid or 'inertia'} of body '{name}'"
    given = [evaluation.value(one, where) for one in inertia.entries]
    if any(one is None for one in given):
        return
    found = evaluation.algebra.fault(size_flaw if inertia.solid else flaw, given)
    if found is not None:
        place, message, hint = found
        entry = inertia.entries[place]
        evaluation.blame(entry, ExpressionError(Span(0, len(entry.text)), message, hint), where)
