"""The report of many motions: the summary, and the object for ``--json``."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from lagrange_cli.cli.console import EXIT_STATUS, complain, count_of, emit, emit_json
from lagrange_cli.cli.report.motion import Seconds, drifts_shown, events_line, resuming, wrote
from lagrange_cli.decimals import decimal
from lagrange_cli.run.attributes import doubt_of_all
from lagrange_cli.run.ensembles.contents import events_counted, how_they_ended

if TYPE_CHECKING:
    from lagrange_cli.cli.output import Invocation
    from lagrange_cli.integrate.ensemble.outcome import EnsembleOutcome
    from lagrange_cli.run.ensembles.ensemble import Ensemble
    from lagrange_cli.run.ensembles.sweep import Swept
    from lagrange_cli.run.resume import Start

STATUSES = ("complete", "stopped", "failed", "interrupted")


def say_swept(
    swept: Swept, outcome: EnsembleOutcome, seconds: Seconds, began: float, asked: Invocation
) -> int:
    """Say how the members ended; returns the exit status. Python had ``began`` so many seconds before."""
    if asked.as_json:
        emit_json(as_object(swept, outcome, seconds))
    elif not asked.quiet:
        emit(as_text(swept, outcome, seconds))
        if asked.timings:
            from lagrange_cli.cli.report.timings import as_table

            emit(as_table(seconds, began, cached=swept.cached))
    if outcome.status != "complete":
        way_on = (
            f"; {resuming(swept.start)} continues with the others" if outcome.status == "interrupted" else ""
        )
        complain(f"{swept.ensemble.spec.name}: {how_they_ended(swept.ensemble, outcome)}{way_on}")
    warn(swept.ensemble, outcome, asked)
    for name, count in swept.events.items():
        if not count and not asked.quiet:
            complain(f"{swept.ensemble.spec.name}: event '{name}' did not occur in any member")
    if outcome.doubtful and not asked.quiet:
        from lagrange_cli.run.events import notes_of_members

        for note in notes_of_members(outcome.doubtful):
            complain(f"{swept.ensemble.spec.name}: {note}")
    return EXIT_STATUS[outcome.status]


def warn(ensemble: Ensemble, outcome: EnsembleOutcome, asked: Invocation) -> None:
    """Print the warnings about the result."""
    warning = doubt_of_all(outcome, ensemble.settings)
    if warning is not None and not asked.quiet:
        complain(f"{ensemble.spec.name}: warning: {warning}")


def as_object(swept: Swept, outcome: EnsembleOutcome, seconds: Seconds) -> dict[str, Any]:
    """The ensemble for ``--json``."""
    ensemble, start = swept.ensemble, swept.start
    return {
        **figures(ensemble, start, outcome, how_they_ended(ensemble, outcome)),
        "events": events_counted(swept.events),
        "resumed_from": start.reached,
        "seconds": seconds,
    }


def figures(ensemble: Ensemble, start: Start, outcome: EnsembleOutcome, message: str) -> dict[str, Any]:
    """The part of the object for ``--json`` that all ensembles share."""
    return {
        "name": ensemble.spec.name,
        "output": start.target.shown,
        "replaced": start.replaced,
        "kept": start.target.earlier or None,
        "status": outcome.status,
        "message": message,
        "warning": doubt_of_all(outcome, ensemble.settings),
        "members": ensemble.values.members,
        **{status: outcome.count(status) for status in STATUSES},
        "method": ensemble.settings.method,
        "tolerance": ensemble.settings.tolerance,
        "steps": outcome.steps,
        "h_drift": outcome.h_drift,
        "p_drift": dict(outcome.p_drift),
    }


def as_text(swept: Swept, outcome: EnsembleOutcome, seconds: Seconds) -> str:
    """The ensemble in a few lines."""
    ensemble, start = swept.ensemble, swept.start
    settings, members = ensemble.settings, ensemble.values.members
    shape = ensemble.members.in_words
    ended = [f"{outcome.count('complete')} reached the end"]
    ended += [f"{n} {status}" for status in STATUSES[1:] if (n := outcome.count(status))]
    seed = ensemble.members.seed
    seeded = "" if seed is None else f", seed {seed}"
    return "\n".join(
        (
            f"{ensemble.spec.name}: {count_of(members, 'member')} ({shape}{seeded})",
            *([] if start.earlier is None else [f"  resumed after {start.reached} members"]),
            f"  {', '.join(ended)}",
            f"  t = {decimal(settings.start)} to {decimal(settings.stop, 10)} in "
            f"{count_of(outcome.steps, 'step')} "
            f"in total, method {settings.method_shown}",
            *events_line(events_counted(swept.events)),
            f"  largest {drifts_shown(outcome.h_drift, outcome.p_drift.items())}",
            wrote(start, seconds["total"]),
        )
    )
