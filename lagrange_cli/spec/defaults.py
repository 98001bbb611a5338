"""The ``solve`` section: defaults of the command line."""

from __future__ import annotations

from collections.abc import Mapping

from lagrange_cli.decimals import decimal
from lagrange_cli.expression.numbers import evaluate
from lagrange_cli.expression.syntax import ExpressionError, names
from lagrange_cli.expression.vocabulary import CONSTANTS
from lagrange_cli.records import replace
from lagrange_cli.spec.draft import Draft
from lagrange_cli.spec.names import Names
from lagrange_cli.spec.problems import Problems
from lagrange_cli.spec.settling import check_scalar
from lagrange_cli.spec.source import WHOLE_FILE, Place
from lagrange_cli.spec.spec import Expression, SolveDefaults, Spec

TIMES = ("start", "stop", "step")
"""The times that may be expressions in parameters."""


def solve_defaults(draft: Draft, names: Names, problems: Problems) -> SolveDefaults:
    """The section as it is, if its numbers make sense together."""
    given = {key: value for key, value in draft.solve.items() if value is not None and value != ""}
    given.pop("unit", None)  # of t: see ``time_unit``
    times = {key: given.pop(key) for key in TIMES if key in given}
    given |= numbers_of(times, names, problems)
    times = {key: time for key, time in times.items() if key not in given and problems.trusts(time.tree)}
    whole = draft.places.get("solve", WHOLE_FILE)  # for a misspelt key, which has been reported
    places = dict.fromkeys(draft.solve, whole) | dict(draft.solve_places)
    solve = SolveDefaults(**given, places=places, times=times)
    judge(solve, problems)
    return solve


def judge(solve: SolveDefaults, problems: Problems) -> None:
    """Report mistakes in the numbers that are known, each once."""
    places = solve.places
    start = 0.0 if solve.start is None else solve.start
    if solve.stop == start and "start" not in solve.pending:
        message = f"the motion stops where it starts, at t = {decimal(start)}"
        problems.add_once(places["stop"], message, "give another time")
    backward = solve.stop is not None and solve.stop < start
    for key in ("step", "tolerance"):
        value = getattr(solve, key)
        backward_step = key == "step" and value is not None and value < 0 and (backward or solve.pending)
        if value is not None and value <= 0 and not backward_step:
            example = {"step": "0.01", "tolerance": "1e-12"}[key]
            problems.add_once(
                places[key], f"{key} must be greater than 0, not {decimal(value)}", f"write {key}: {example}"
            )
    if solve.samples is not None and solve.samples < 2:
        problems.add_once(
            places["samples"],
            f"samples must be at least 2, not {solve.samples}",
            "both ends of the motion count",
        )
    if solve.samples is not None and solve.step is not None:
        problems.add_once(
            places["step"], "'samples' and 'step' cannot both be given", "leave one of them out"
        )


def numbers_of(times: Mapping[str, Expression], known: Names, problems: Problems) -> dict[str, float]:
    """The values of those that depend on no parameter; mistakes in them are reported."""
    found = {}
    for key, time in times.items():
        where = f"{key} of solve"
        check_scalar(known, time, "solve", where)
        if problems.trusts(time.tree) and all(one.identifier in CONSTANTS for one in names(time.tree)):
            try:
                found[key] = evaluate(time.tree)
            except ExpressionError as error:
                problems.add_expression(time, error, where)
    return found


def with_times(spec: Spec, times: Mapping[str, float], problems: Problems) -> Spec:
    """The system with the values of the times that depend on parameters; mistakes in them are reported."""
    solve = replace(spec.solve, **times)
    judge(solve, problems)
    return replace(spec, solve=solve)


def place_of(key: str, draft: Draft) -> Place:
    """The place of a key of the section. A misspelt one has been reported there."""
    return draft.solve_places.get(key, draft.places.get("solve", WHOLE_FILE))


def time_unit(draft: Draft, problems: Problems) -> str:
    """The unit of t, which may stand in either of two places."""
    unit, other = draft.text("time"), draft.solve.get("unit", "")
    if unit and other and unit != other:
        problems.add(
            place_of("unit", draft),
            f"the unit of t is '{other}' in solve and '{unit}' in time",
            "leave one of them out",
        )
    return unit or other
