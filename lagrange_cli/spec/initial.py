"""The numbers of a run over any algebra: parameters, and the initial state."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

from lagrange_cli.expression.numbers import NumberAlgebra
from lagrange_cli.expression.vocabulary import family_name, velocity_name
from lagrange_cli.spec.content import groups_of
from lagrange_cli.spec.evaluation import Evaluation, constants_of
from lagrange_cli.spec.problems import Problems
from lagrange_cli.spec.spec import Coordinate, Expression, Spec
from lagrange_cli.spec.whole import WrittenFamily


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
                f"write {family_name(coordinate.name)}{'[...]' if '[' in coordinate.name else ''}: "
                f"{{initial: 0.1}}, or --set {coordinate.name}=0.1",
            )
    if problems is None:
        evaluation.problems.stop_if_any()
    return evaluation.values, tuple([x or 0.0 for x in q]), tuple([x or 0.0 for x in v]), evaluation.times


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
