"""The ``solve`` section: defaults of the command line."""

from __future__ import annotations

from lagrange_cli.spec.draft import Draft
from lagrange_cli.spec.problems import Problems
from lagrange_cli.spec.source import WHOLE_FILE, Place
from lagrange_cli.spec.spec import SolveDefaults


def solve_defaults(draft: Draft, problems: Problems) -> SolveDefaults:
    """The section as it is, if its numbers make sense together."""
    given = {key: value for key, value in draft.solve.items() if value is not None and value != ""}
    given.pop("unit", None)  # of t: see ``time_unit``
    solve = SolveDefaults(**given, places=draft.solve_places)
    start = 0.0 if solve.start is None else solve.start
    if solve.stop is not None and solve.stop == start:
        problems.add(
            place_of("stop", draft),
            f"the motion stops where it starts, at t = {start:g}",
            "give another time",
        )
    backward = solve.stop is not None and solve.stop < start
    for key in ("step", "tolerance"):
        value = getattr(solve, key)
        if value is not None and value <= 0 and not (value < 0 and key == "step" and backward):
            problems.add(
                place_of(key, draft), f"{key} must be greater than 0, not {value:g}", f"write {key}: 0.01"
            )
    if solve.samples is not None and solve.samples < 2:
        problems.add(
            place_of("samples", draft),
            f"samples must be at least 2, not {solve.samples}",
            "both ends of the motion count",
        )
    if solve.samples is not None and solve.step is not None:
        problems.add(
            place_of("step", draft), "'samples' and 'step' cannot both be given", "leave one of them out"
        )
    return solve


def place_of(key: str, draft: Draft) -> Place:
    """Where a key of the section is given. One that is misspelt has been noted where it stands."""
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
