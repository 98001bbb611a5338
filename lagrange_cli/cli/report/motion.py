"""What is said of a run that has ended: to the user, in JSON and in the file."""

from __future__ import annotations

import json
from collections.abc import Iterable, Mapping
from typing import TYPE_CHECKING, Any

from lagrange_cli.cli.console import count_of, finite
from lagrange_cli.cli.options.certify import Demand, certified_shown
from lagrange_cli.expression.vocabulary import velocity_name
from lagrange_cli.integrate.precision import DOUBLE

if TYPE_CHECKING:
    from lagrange_cli.integrate.outcome import Outcome
    from lagrange_cli.run.resume import Start
    from lagrange_cli.run.settings import Settings
    from lagrange_cli.run.timings import Stopwatch
    from lagrange_cli.spec.spec import Spec

MOST_COORDINATES = 3
"""Coordinates whose final values are shown; where there are more, one less."""
MOST_DRIFTS = 8
"""Momenta whose drifts are shown one by one."""

WORTH_A_WORD, LOOSELY = 1e-6, 1e4
"""A drift of h, relative to its size, that rounding does not explain, and how many tolerances are."""

UNDETECTED = (
    "{} does not detect narrow forces hidden in exp, tanh, sinh, cosh or high powers: "
    "compare with the Taylor method in double precision, which does"
)
"""The warning for systems with such functions."""


def attributes(
    made_by: Mapping[str, str | int | float], outcome: Outcome, settings: Settings
) -> dict[str, str | int | float]:
    """The root's attributes: everything that made the file, and how the run ended."""
    warning = doubt(outcome, settings)
    return {
        **made_by,
        "steps": outcome.steps,
        "status": outcome.ending.status,
        "message": outcome.message,
        "h_drift": float("nan") if outcome.h_drift is None else outcome.h_drift,
        "p_drift": json.dumps(finite(outcome.p_drift)),
        "final": json.dumps(finite(final_state(outcome))),
        **({} if warning is None else {"warning": warning}),
        **({} if outcome.trusted_until is None else {"trusted_until": outcome.trusted_until}),
    }


def as_object(
    spec: Spec, settings: Settings, start: Start, outcome: Outcome, watch: Stopwatch
) -> dict[str, Any]:
    """The run for ``--json``."""
    return {
        "name": spec.name,
        "output": start.target.shown,
        "replaced": start.replaced,
        "status": outcome.ending.status,
        "message": outcome.message,
        "warning": doubt(outcome, settings),
        "method": settings.method,
        "tolerance": settings.tolerance,
        "steps": outcome.steps,
        "evaluations": outcome.evaluations,
        "t": outcome.t,
        "final": final_state(outcome),
        "h_drift": outcome.h_drift,
        "p_drift": dict(outcome.p_drift),
        "trusted_until": outcome.trusted_until,
        "error": outcome.error,
        "resumed_from": start.reached,
        "seconds": watch.report(),
    }


def final_state(outcome: Outcome) -> dict[str, Any] | None:
    """The last sample, in terms of JSON."""
    return None if outcome.final is None else outcome.final.as_data()


def final_shown(final: Mapping[str, Any] | None) -> list[str]:
    """The line of the summary that has it: of many coordinates the first ones."""
    if final is None:
        return []
    names = [*final["q"]]
    count = len(names) if len(names) <= MOST_COORDINATES else MOST_COORDINATES - 1
    shown = [
        f"{name} = {'nan' if value is None else format(value, '.6g')}"
        for coordinate in names[:count]
        for name, value in (
            (coordinate, final["q"][coordinate]),
            (velocity_name(coordinate), final["v"][coordinate]),
        )
    ]
    more = len(names) - count
    rest = f" (and {more} more coordinates)" if more else ""
    return [f"  at t = {final['t']:.6g}: {', '.join(shown)}{rest}"]


def ended(outcome: Outcome) -> str:
    """How the motion ended; why, if it did not reach the end, is said on standard error."""
    status: str = outcome.ending.status
    return outcome.message if status == "complete" else f"{status}; the results so far are written"


def as_text(
    spec: Spec, settings: Settings, start: Start, outcome: Outcome, watch: Stopwatch, demand: Demand | None
) -> str:
    """The run in a few lines."""
    seconds = watch.report()
    return "\n".join(
        (
            f"{spec.name}: {count_of(len(spec.coordinates), 'degree')} of freedom",
            *went_on(start, settings),
            f"  {ended(outcome)}",
            f"  t = {settings.start:g} to {outcome.t:.10g} in {count_of(outcome.steps, 'step')}, "
            f"method {settings.method}",
            *final_shown(final_state(outcome)),
            f"  {drifts_shown(outcome.h_drift, outcome.p_drift.items())}",
            *certified_shown(outcome, demand),
            wrote(start, seconds["total"]),
        )
    )


def went_on(start: Start, settings: Settings) -> list[str]:
    """The line of the summary that says with what the run has begun, if not at the start."""
    if start.earlier is None:
        return []
    spacing = f", with a sample every {abs(settings.step):g} as before" if start.extends else ""
    return [f"  continued from t = {start.reached:.10g}{spacing}"]


def wrote(start: Start, seconds: float) -> str:
    """The line of the summary that says what is written."""
    replaced = " (replaced the result of an earlier run of this file)" if start.replaced else ""
    return f"  wrote {start.target.shown} in {seconds:.3f} s{replaced}"


def doubt(outcome: Outcome, settings: Settings) -> str | None:
    """The warnings about the result: a drift of h, forces that may have been missed."""
    method = settings.method if settings.precision == DOUBLE else settings.precision
    undetected = UNDETECTED.format(method) if outcome.undetected else None
    return "; ".join(filter(None, (drifting(outcome, settings.tolerance), undetected))) or None


def drifting(outcome: Outcome, tolerance: float) -> str | None:
    """The warning for a drift of h that rounding and the tolerance do not explain."""
    drift, size = outcome.h_drift, outcome.h_size
    if not drift or not size or drift <= max(WORTH_A_WORD, LOOSELY * tolerance) * size:
        return None
    return (
        f"h drifted by {drift:.1e}, {drift / size:.1e} of its size, although it is conserved; a narrow force "
        "may have been missed, or h is a small difference of large numbers: do not rely on the result before "
        "a smaller --tolerance, another --method or --certify confirms it"
    )


def drifts_shown(h_drift: float | None, p_drift: Iterable[tuple[str, float]]) -> str:
    """The drifts in the summary; of many momenta only the largest."""
    drifts = {} if h_drift is None else {"h": h_drift}
    momenta = {f"p_{coordinate}": drift for coordinate, drift in p_drift}
    if len(momenta) <= MOST_DRIFTS:
        drifts |= momenta
    else:
        name = max(momenta, key=lambda one: momenta[one])
        drifts[f"largest of {len(momenta)} momenta, {name}"] = momenta[name]
    shown = ", ".join(f"{name} {drift:.1e}" for name, drift in drifts.items())
    return f"drift: {shown or 'not computed, as nothing that is written is conserved'}"
