"""The attributes of the root of an output: what made the file, how the run ended, and warnings about it."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import lagrange_cli
from lagrange_cli.integrate.precision import DOUBLE

if TYPE_CHECKING:
    from lagrange_cli.integrate.outcome import Outcome
    from lagrange_cli.run.settings import Settings
    from lagrange_cli.spec.spec import Spec

WORTH_A_WORD, LOOSELY = 1e-6, 1e4
"""A drift of h, relative to its size, that rounding does not explain, and how many tolerances are."""

UNDETECTED = (
    "{} does not detect narrow forces hidden in exp, tanh, sinh, cosh or high powers: "
    "compare with the Taylor method in double precision, which does"
)
"""The warning for systems with such functions."""


def origin(
    spec: Spec, settings: Settings, parameters: dict[str, float], initial: Any, sampled: bool = True
) -> dict[str, str | int | float]:
    """The root's attributes that say what made the file; ``initial`` stands for the initial state, or
    many."""
    names = ("start", "stop", "count", "step") if sampled else ("start", "stop")
    asked = {name: getattr(settings, name) for name in names}
    return {
        "generator": f"lagrange-cli {lagrange_cli.__version__}",
        "name": spec.name,
        "spec": spec.text,
        "parameters": json.dumps(parameters),
        **({"sizes": json.dumps(dict(spec.sizes))} if spec.sizes else {}),
        "method": settings.method,
        "tolerance": settings.tolerance,
        **({} if settings.precision == DOUBLE else {"precision": settings.precision}),
        **({"portable": 1} if settings.portable else {}),
        "run": json.dumps({**asked, "outputs": sorted(settings.outputs), "initial": initial}),
    }


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


def final_state(outcome: Outcome) -> dict[str, Any] | None:
    """The last sample, in terms of JSON."""
    return None if outcome.final is None else outcome.final.as_data()


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


def finite(content: Any) -> Any:
    """``content`` with None for NaN and infinities, which JSON does not know."""
    if isinstance(content, float):
        return content if math.isfinite(content) else None
    if isinstance(content, Mapping):
        return {str(key): finite(value) for key, value in content.items()}
    if isinstance(content, (list, tuple)):
        return [finite(value) for value in content]
    return content
