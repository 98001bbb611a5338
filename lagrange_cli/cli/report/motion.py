"""The report of a motion: the summary, and the object for ``--json``."""

from __future__ import annotations

import json
import math
from collections.abc import Iterable, Mapping
from typing import TYPE_CHECKING, Any

from lagrange_cli.cli.console import EXIT_STATUS, REPLACED, complain, count_of, emit, emit_json
from lagrange_cli.decimals import decimal, scientific
from lagrange_cli.expression.vocabulary import velocity_name
from lagrange_cli.integrate.ending import DONE
from lagrange_cli.run.attributes import doubt, drifting_name, events_told, final_state, methods_told, notes
from lagrange_cli.run.request import HDF5
from lagrange_cli.spec.spec import freedom

if TYPE_CHECKING:
    from lagrange_cli.cli.output import Invocation
    from lagrange_cli.integrate.outcome import Outcome
    from lagrange_cli.run.certify import Demand
    from lagrange_cli.run.resume import Start
    from lagrange_cli.run.settings.settings import Settings
    from lagrange_cli.run.solve import Solved
    from lagrange_cli.store.resume import Finished

Seconds = Mapping[str, float]
"""The seconds that each stage took, and their ``total``."""

MOST_COORDINATES = 3
"""Coordinates whose final values are shown; where there are more, one less."""
MOST_SINGULAR = 4
"""Singular configurations whose times are shown."""
MOST_CHANGES = 4
"""Changes of the method that are shown."""
MOST_ROUNDED = 4
"""Inputs that are named."""
SURFACE = "where", "every", "direction"
"""Attributes of a section that say how it was taken."""
MOST_DRIFTS = 8
"""Momenta whose drifts are shown one by one."""


def say_solved(
    solved: Solved, outcome: Outcome, seconds: Seconds, began: float, asked: Invocation, demand: Demand | None
) -> int:
    """Say how the motion ended; returns the exit status. Python had ``began`` so many seconds before."""
    start, name, status = solved.start, solved.motion.spec.name, outcome.ending.status
    say = complain if asked.streams else emit
    if asked.as_json:
        emit_json(as_object(solved, outcome, seconds))
    elif not asked.quiet:
        say(as_text(solved, outcome, seconds, demand))
        if asked.timings:
            from lagrange_cli.cli.report.timings import as_table

            say(as_table(seconds, began, cached=solved.cached))
    if status in ("failed", "interrupted"):
        resumable = outcome.progress is not None and asked.request.format == HDF5
        way_on = f"; {resuming(start)} continues from there" if resumable else ""
        complain(f"{name}: {outcome.message}{way_on}")
    if not asked.quiet:
        for note in notes(solved.motion, outcome):
            complain(note)
    return EXIT_STATUS[status]


def say_finished(found: Finished, shown: str, seconds: Seconds, asked: Invocation) -> int:
    """Say that an earlier run left nothing to do, and how it had ended; returns its exit status."""
    told = {name: x.item() if hasattr(x, "item") else x for name, x in found.attributes.items()}
    final: Mapping[str, Any] | None = json.loads(told.get("final", "null"))
    events = json.loads(told.get("events", "{}"))
    if asked.as_json:
        names = "name", "status", "message", "members", "method", "tolerance", "steps", "h_drift", *SURFACE
        listed = {name: told[name] for name in names if name in told}
        where = {"output": shown, "p_drift": json.loads(told["p_drift"]), "resumed_from": None}
        cut = any(name in told for name in SURFACE)
        happened = {"members": told.get("members", 1)} if cut else {"events": events}
        ends = {} if cut or "members" in told else {"t": found.t, "final": final}
        emit_json({**listed, **where, **ends, **happened, "seconds": seconds})
    elif not asked.quiet:
        said = f"{told['name']}: {shown} is finished already: {told['message']}"
        emit("\n".join([said, *final_shown(final), *events_line(events)]))
    return EXIT_STATUS[told["status"]]


def as_object(solved: Solved, outcome: Outcome, seconds: Seconds) -> dict[str, Any]:
    """The run for ``--json``."""
    start, settings = solved.start, solved.motion.settings
    return {
        "name": solved.motion.spec.name,
        "output": start.target.shown,
        "replaced": start.replaced,
        "kept": start.target.earlier or None,
        "status": outcome.ending.status,
        "message": outcome.message,
        "warning": doubt(outcome, settings),
        "method": settings.method,
        "tolerance": settings.tolerance,
        **({"methods": methods_told(outcome)} if outcome.changes else {}),
        "steps": outcome.steps,
        "evaluations": outcome.evaluations,
        "threads": outcome.threads,
        "t": outcome.t,
        "final": final_state(outcome),
        "h_drift": outcome.h_drift,
        "p_drift": dict(outcome.p_drift),
        "events": events_told(outcome),
        **(constraints_told(solved, outcome) if solved.motion.spec.all_constraints else {}),
        **estimated(outcome),
        "resumed_from": start.reached,
        "seconds": seconds,
    }


def constraints_told(solved: Solved, outcome: Outcome) -> dict[str, Any]:
    """The effects of constraints, for ``--json``."""
    moved = {"projections": outcome.projections, "singular": list(outcome.singular)}
    return {"initial": solved.motion.begin.as_data(), **moved}


def constraints_shown(outcome: Outcome) -> list[str]:
    """The line of the summary that says how the motion was kept to its constraints."""
    said = [f"projected onto the constraints {count_of(outcome.projections, 'time')}"]
    if outcome.singular:
        shown = ", ".join(decimal(t) for t in outcome.singular[:MOST_SINGULAR])
        more = ", ..." if len(outcome.singular) > MOST_SINGULAR else ""
        said.append(f"{count_of(len(outcome.singular), 'singular configuration')} passed, t = {shown}{more}")
    return [f"  {'; '.join(said)}"]


def final_shown(final: Mapping[str, Any] | None) -> list[str]:
    """The line of the summary that has it: of many coordinates the first ones."""
    if final is None:
        return []
    names = [*final["q"]]
    count = len(names) if len(names) <= MOST_COORDINATES else MOST_COORDINATES - 1
    shown = [
        f"{name} = {'nan' if value is None else decimal(value)}"
        for coordinate in names[:count]
        for name, value in (
            (coordinate, final["q"][coordinate]),
            (velocity_name(coordinate), final["v"][coordinate]),
        )
    ]
    more = len(names) - count
    rest = f" (and {more} more coordinates)" if more else ""
    return [f"  at t = {decimal(final['t'])}: {', '.join(shown)}{rest}"]


def events_line(events: Mapping[str, Any]) -> list[str]:
    """The line of the summary that says how often events happened, if there are any."""
    if not events:
        return []
    from lagrange_cli.cli.report.events import events_shown  # most systems have none

    return events_shown(events)


def ended(outcome: Outcome) -> str:
    """How the motion ended; if it did not reach the end, the reason is on standard error."""
    status: str = outcome.ending.status
    return outcome.message if status in DONE else f"{status}; the results so far are written"


def as_text(solved: Solved, outcome: Outcome, seconds: Seconds, demand: Demand | None) -> str:
    """The run in a few lines."""
    start, spec, settings = solved.start, solved.motion.spec, solved.motion.settings
    return "\n".join(
        (
            f"{spec.name}: {freedom(spec.degrees_of_freedom, spec.of_first_order)}",
            *went_on(start, settings),
            f"  {ended(outcome)}",
            f"  t = {decimal(settings.start)} to {decimal(outcome.t, 10)} in "
            f"{count_of(outcome.steps, 'step')}"
            f"{on_threads(outcome)}, method {settings.method_shown}",
            *changes_shown(outcome),
            *final_shown(final_state(outcome)),
            *events_line(events_told(outcome)),
            *(constraints_shown(outcome) if spec.all_constraints.keys() - spec.massless.keys() else []),
            f"  {drifts_shown(outcome.h_drift, outcome.p_drift.items())}",
            *estimate_shown(outcome, demand),
            wrote(start, seconds["total"]),
        )
    )


def changes_shown(outcome: Outcome) -> list[str]:
    """The lines of the summary that say where the motion has changed its method; of many the first ones."""
    said = [
        f"  from t = {decimal(one.t)}, after {count_of(one.steps, 'step')}, {one.method}, as a step of Radau "
        f"replaces some {decimal(float(scientific(one.replaces, 0)))} Taylor steps"
        for one in outcome.changes[:MOST_CHANGES]
    ]
    more = len(outcome.changes) - MOST_CHANGES
    return [*said, *([f"  and {count_of(more, 'more change')} of the method"] if more > 0 else [])]


def on_threads(outcome: Outcome) -> str:
    """How many threads have shared the work, if there were several."""
    return f" on {outcome.threads} threads" if outcome.threads > 1 else ""


def estimated(outcome: Outcome) -> dict[str, Any]:
    """The error estimate for ``--json``, or None."""
    names = "trusted_until", "error", "trusted_until_as_run", "error_as_run"
    return {name: None if outcome.estimated is None else getattr(outcome.estimated, name) for name in names}


def estimate_shown(outcome: Outcome, demand: Demand | None) -> list[str]:
    """The lines of the summary that have the error estimate, and whether roundings of inputs prevail."""
    found = outcome.estimated
    if demand is None or found is None:
        return []
    until = f"{decimal(demand.digits)} digits up to t = {decimal(found.trusted_until, 10)}"
    lines = [f"  estimated error: {scientific(found.error)} at the end, {until}"]
    if found.rounded is not None:
        *some, more = *found.rounded[:MOST_ROUNDED], len(found.rounded) - MOST_ROUNDED
        named = ", ".join([*some, *([f"{more} more"] if more > 0 else [])]) or "numbers in expressions"
        if found.staying:
            lines.append(
                "  the motion begins at an unstable equilibrium: as written it stays there; with "
                f"{named} rounded to doubles it leaves after t = {decimal(found.trusted_until)}"
            )
        else:
            lines.append(
                f"  the rounding of {named} to doubles has grown to this error: with the rounded values, "
                f"{decimal(demand.digits)} digits hold up to t = {decimal(found.trusted_until_as_run, 10)}"
            )
    return lines


def went_on(start: Start, settings: Settings) -> list[str]:
    """The line of the summary that says with what the run has begun, if not at the start."""
    if start.earlier is None:
        return []
    spacing = f", with a sample every {decimal(abs(settings.step))} as before" if start.extends else ""
    return [f"  continued from t = {decimal(start.reached, 10)}{spacing}"]


def wrote(start: Start, seconds: float) -> str:
    """The line of the summary that says what is written."""
    replaced = REPLACED if start.replaced else ""
    if start.target.earlier:
        replaced = f"; {start.target.earlier} is still the result of an earlier run"
    return f"  wrote {start.target.shown} in {seconds:.3f} s{replaced}"


def resuming(start: Start) -> str:
    """The options that continue an interrupted run."""
    return f"--resume --output {start.target.shown}" if start.target.earlier else "--resume"


def drifts_shown(h_drift: float | None, p_drift: Iterable[tuple[str, float]]) -> str:
    """The drifts in the summary; of many momenta only the largest. ``p_drift`` is by coordinate, or by the
    dataset of another conserved quantity."""
    drifts = {} if h_drift is None else {"h": h_drift}
    momenta = {drifting_name(one): drift for one, drift in p_drift}
    if len(momenta) <= MOST_DRIFTS:
        drifts |= momenta
    else:
        name = max(momenta, key=lambda one: momenta[one])
        kind = "momenta" if all(one.startswith("p_") for one in momenta) else "conserved quantities"
        drifts[f"largest of {len(momenta)} {kind}, {name}"] = momenta[name]
    if not drifts:
        return "drift: not computed, as no output is conserved"
    shown = ", ".join(
        f"{name} {scientific(drift)}" for name, drift in drifts.items() if not math.isnan(drift)
    )
    return f"drift: {shown or 'not known, as there are no samples'}"
