"""What is said of a section that was taken: the summary, and the object for ``--json``."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from lagrange_cli.cli.console import EXIT_STATUS, complain, count_of, emit, emit_json
from lagrange_cli.cli.report.motion import Seconds, drifts_shown, wrote

if TYPE_CHECKING:
    from lagrange_cli.cli.output import Invocation
    from lagrange_cli.run.section import Crossed


def say_crossed(crossed: Crossed, seconds: Seconds, began: float, asked: Invocation) -> int:
    """Say what was found; returns the exit status. Python had ``began`` so many seconds before."""
    status = crossed.outcome.status
    if asked.as_json:
        emit_json(as_object(crossed, seconds))
    elif not asked.quiet:
        emit(as_text(crossed, seconds))
        if asked.timings:
            from lagrange_cli.cli.report.timings import as_table

            emit(as_table(seconds, began, cached=crossed.cached))
    if status != "complete":
        complain(f"{crossed.ensemble.spec.name}: {crossed.message}")
    return EXIT_STATUS[status]


def as_object(crossed: Crossed, seconds: Seconds) -> dict[str, Any]:
    """The section for ``--json``."""
    ensemble, outcome, start = crossed.ensemble, crossed.outcome, crossed.start
    assert ensemble.cut is not None
    cut = {name: x for name, x in ensemble.cut.described.items() if name != "crossings"}
    return {
        "name": ensemble.spec.name,
        "output": start.target.shown,
        "replaced": start.replaced,
        "status": outcome.status,
        "message": crossed.message,
        **cut,
        "crossings": crossed.crossings,
        "members": ensemble.values.members,
        **{status: outcome.count(status) for status in ("complete", "failed", "interrupted")},
        "method": ensemble.settings.method,
        "tolerance": ensemble.settings.tolerance,
        "steps": outcome.steps,
        "h_drift": outcome.h_drift,
        "p_drift": dict(outcome.p_drift),
        "seconds": seconds,
    }


def as_text(crossed: Crossed, seconds: Seconds) -> str:
    """The section in a few lines."""
    ensemble, outcome = crossed.ensemble, crossed.outcome
    assert ensemble.cut is not None
    cut, members = ensemble.cut, ensemble.values.members
    what = f"every {cut.every}" if cut.every else f"where {cut.where} = 0, {cut.direction}"
    many = f" of {count_of(members, 'motion')}" if ensemble.members.columns else ""
    return "\n".join(
        (
            f"{ensemble.spec.name}: section{many} {what}",
            f"  {crossed.message}",
            f"  {count_of(outcome.steps, 'step')} in total, method {ensemble.settings.method}",
            f"  largest {drifts_shown(outcome.h_drift, outcome.p_drift.items())}",
            wrote(crossed.start, seconds["total"]),
        )
    )
