"""The report of a section: the summary, and the object for ``--json``."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from lagrange_cli.cli.console import EXIT_STATUS, complain, count_of, emit, emit_json
from lagrange_cli.cli.report.ensemble import figures, warn
from lagrange_cli.cli.report.motion import Seconds, drifts_shown, resuming, wrote
from lagrange_cli.run.request import HDF5

if TYPE_CHECKING:
    from lagrange_cli.cli.output import Invocation
    from lagrange_cli.integrate.ensemble.outcome import EnsembleOutcome
    from lagrange_cli.run.sections.section import Crossed


def say_crossed(crossed: Crossed, seconds: Seconds, began: float, asked: Invocation) -> int:
    """Say what was found; returns the exit status. Python had ``began`` so many seconds before."""
    assert crossed.outcome is not None
    status = crossed.outcome.status
    say = complain if asked.streams else emit
    if asked.as_json:
        emit_json(as_object(crossed, crossed.outcome, seconds))
    elif not asked.quiet:
        say(as_text(crossed, crossed.outcome, seconds, asked.streams))
        if asked.timings:
            from lagrange_cli.cli.report.timings import as_table

            say(as_table(seconds, began, cached=crossed.cached))
    if status != "complete":
        resumable = status == "interrupted" and asked.request.format == HDF5
        way_on = f"; {resuming(crossed.start)} continues it" if resumable else ""
        complain(f"{crossed.ensemble.spec.name}: {crossed.message}{way_on}")
    warn(crossed.ensemble, crossed.outcome, asked)
    return EXIT_STATUS[status]


def as_object(crossed: Crossed, outcome: EnsembleOutcome, seconds: Seconds) -> dict[str, Any]:
    """The section for ``--json``."""
    ensemble = crossed.ensemble
    assert ensemble.cut is not None
    return {
        **figures(ensemble, crossed.start, outcome, crossed.message),
        **ensemble.cut.described,
        "crossings": crossed.crossings,  # that were found, not asked for
        "resumed_from": crossed.start.reached,
        "seconds": seconds,
    }


def as_text(crossed: Crossed, outcome: EnsembleOutcome, seconds: Seconds, streamed: bool) -> str:
    """The section in a few lines; what it is written to is not said if it was ``streamed``."""
    ensemble, start = crossed.ensemble, crossed.start
    assert ensemble.cut is not None
    cut, members = ensemble.cut, ensemble.values.members
    what = f"every {cut.every}" if cut.every else f"where {cut.where} = 0, {cut.direction}"
    many = f" of {count_of(members, 'motion')}" if ensemble.members.columns else ""
    unit = "motion" if ensemble.members.columns else "crossing"
    return "\n".join(
        (
            f"{ensemble.spec.name}: section{many} {what}",
            *([] if start.earlier is None else [f"  resumed after {count_of(start.reached, unit)}"]),
            f"  {crossed.message}",
            f"  {count_of(outcome.steps, 'step')} in total, method {ensemble.settings.method}",
            f"  largest {drifts_shown(outcome.h_drift, outcome.p_drift.items())}",
            *([] if streamed else [wrote(start, seconds["total"])]),
        )
    )
