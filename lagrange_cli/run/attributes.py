"""The attributes of an output: its datasets, its origin, how the run ended, and warnings."""

from __future__ import annotations

import json
import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Any

from lagrange_cli.decimals import decimal, scientific
from lagrange_cli.integrate.precision import DOUBLE
from lagrange_cli.records import replace
from lagrange_cli.run.start import NOTHING
from lagrange_cli.spec.spec import SURFACE, has_units
from lagrange_cli.version import __version__

if TYPE_CHECKING:
    from lagrange_cli.integrate.ensemble.outcome import EnsembleOutcome
    from lagrange_cli.integrate.outcome import Outcome
    from lagrange_cli.integrate.prepared import Prepared
    from lagrange_cli.run.motion import Motion
    from lagrange_cli.run.settings.settings import Settings
    from lagrange_cli.spec.spec import Spec
    from lagrange_cli.store.layout import Series

WARNING = "warning: "
WORTH_A_WORD, LOOSELY = 1e-6, 1e4
"""A drift of h that rounding does not explain, relative to its size, and in units of the tolerance, or of
what rounding of a state changes."""

SMALL, COARSE = 0.01, 1e4
"""A motion is small if no coordinate and no velocity is as large as this, nor as so many errors that are
allowed."""

MOST_NAMES = 4
"""Quantities that a warning names."""

SHARED = (
    " (where several forces of friction hold what constraints join, or constraints depend on each other there"
    ", only a sum of these forces is determined)"
)
"""Why forces of constraint may have no value while the motion goes on."""

UNDETECTED = {
    "narrow": "{} does not detect narrow forces hidden in exp, tanh, sinh, cosh, high powers or quotients: "
    "compare with the Taylor method, which does",
    "switches": "{} does not locate the instants at which abs, sign, min, max or where switch: its error "
    "there is not bounded by the tolerance, and dry friction brings nothing to rest; "
    "compare with the Taylor method, which locates them",
    "cuts": "{} does not locate the jump of atan2(y, x) from pi to -pi, at y = 0 and x < 0: if a potential, "
    "a force or a constraint jumps with it, the motion after it is wrong; "
    "compare with the Taylor method, which locates it",
    "edges": "{} does not notice where a root, a logarithm or an arcsine in the file has no value: "
    "the motion after it is wrong; compare with the Taylor method, which ends there",
}
"""The warnings for systems with such functions, by what ``Outcome.undetected`` has."""


def origin(
    spec: Spec, settings: Settings, parameters: dict[str, float], initial: Any, sampled: bool = True
) -> dict[str, str | int | float]:
    """The root's attributes that say what made the file; ``initial`` stands for the initial state, or
    many."""
    names = ("start", "stop", "count", "step") if sampled else ("start", "stop")
    asked = finite({name: getattr(settings, name) for name in names})
    return {
        "generator": f"lagrange-cli {__version__}",
        "name": spec.name,
        "spec": spec.text,
        "parameters": json.dumps(parameters),
        **({"sizes": json.dumps(dict(spec.sizes))} if spec.sizes else {}),
        "method": settings.method,
        "tolerance": settings.tolerance,
        **({} if settings.precision == DOUBLE else {"precision": settings.precision}),
        **({"portable": 1} if settings.portable else {}),
        **({"proven": 1} if settings.proven else {}),
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
        **({"events": json.dumps(finite(events_told(outcome)))} if outcome.happened else {}),
        **({} if warning is None else {"warning": warning}),
        **({"projections": outcome.projections} if outcome.projections else {}),
        **({"singular": json.dumps(outcome.singular)} if outcome.singular else {}),
        **({"methods": json.dumps(methods_told(outcome))} if outcome.changes else {}),
        **trusted(outcome),
    }


def methods_told(outcome: Outcome) -> list[dict[str, Any]]:
    """The methods that a motion has changed to, as JSON."""
    names = "t", "steps", "method", "tolerance"
    return [{name: getattr(one, name) for name in names} for one in outcome.changes]


def events_told(outcome: Outcome) -> dict[str, Any]:
    """What happened at each event, as JSON."""
    return {
        name: {
            "count": one.count,
            "last": one.last,
            "grazing": one.grazing,
            "accumulates": one.accumulates,
            "error": one.error,
        }
        for name, one in outcome.happened.items()
    }


def trusted(outcome: Outcome) -> dict[str, str | int | float]:
    """How long the samples can be trusted, where their error has been estimated."""
    found = outcome.estimated
    if found is None:
        return {}
    return {"trusted_until": found.trusted_until, "trusted_until_as_run": found.trusted_until_as_run}


def final_state(outcome: Outcome) -> dict[str, Any] | None:
    """The last sample, in terms of JSON."""
    return None if outcome.final is None else outcome.final.as_data()


def notes(motion: Motion, outcome: Outcome) -> Iterator[str]:
    """The messages about a motion besides its summary: about its start, its events, and its result."""
    name = motion.spec.name
    if motion.begin != NOTHING:
        from lagrange_cli.run.start_notes import notes as notes_of_start

        yield from (f"{name}: {note}" for note in notes_of_start(motion.begin))
    if outcome.happened:
        from lagrange_cli.run.events import notes as notes_of_events
        from lagrange_cli.run.events import zero_at_start

        told = notes_of_events(motion.spec, outcome.happened, zero_at_start(motion))
        yield from (f"{name}: {note}" for note in told)
    warning = doubt(outcome, motion.settings)
    if warning is not None:
        yield f"{name}: {WARNING}{warning}"


def doubt(outcome: Outcome, settings: Settings) -> str | None:
    """The warnings about the result: a drift of h, a motion too small for the tolerance, forces that may have
    been missed, values that are not finite, outputs that were left out."""
    drifts = not_finite(outcome), drifting(outcome, settings.tolerance), unresolved(outcome, settings)
    unknown = {path: f"at t = {decimal(t, 9)}" for path, t in outcome.unknown.items()}
    return joined(*drifts, *missed(outcome, settings), without_value(unknown), *without_outputs(outcome))


def without_outputs(outcome: Outcome | EnsembleOutcome) -> list[str]:
    """The warnings that there are not all observables, or with ``--outputs all`` not all outputs, and why."""
    undefined = [f"left out of the observables: {one}" for one in outcome.undefined]
    names = outcome.left_out
    if not names:
        return undefined
    them = "it" if len(names) == 1 else "them"
    return [
        *undefined,
        f"left out of --outputs all: {', '.join(names)}, as members of families have to be written out for "
        f"{them}, and are many (--outputs {','.join(names)} does that, or says which limit it exceeds)",
    ]


def without_value(unknown: Mapping[str, str]) -> str | None:
    """The warning for integrals and other quantities that are not finite at some of the samples; of each,
    where the first of these is."""
    listed = [f"/{path} (first {where})" for path, where in unknown.items()]
    told = f"not a finite number at some of the samples: {some(listed)}" if unknown else None
    forces = any(path.startswith(("multipliers/", "reactions/")) for path in unknown)
    return told and told + SHARED * forces


def some(names: Sequence[str]) -> str:
    """A list of names, or of the first ones."""
    return ", ".join([*names[:MOST_NAMES], *(["..."] if len(names) > MOST_NAMES else [])])


def doubt_of_all(outcome: EnsembleOutcome, settings: Settings) -> str | None:
    """The same for an ensemble, without large drifts, whose scale is not known."""
    alone = len(outcome.endings) == 1
    unknown = {
        path: f"{'' if alone else f'in member {member} '}at t = {decimal(t, 9)}"
        for path, (member, t) in outcome.unknown.items()
    }
    told = not_finite(outcome), *missed(outcome, settings), without_value(unknown), *without_outputs(outcome)
    return joined(*told)


def joined(*warnings: str | None) -> str | None:
    """All of them, or None if there is none."""
    return "; ".join(filter(None, warnings)) or None


def missed(outcome: Outcome | EnsembleOutcome, settings: Settings) -> list[str]:
    """The warnings about features that the method may miss."""
    return [UNDETECTED[one].format(settings.method) for one in outcome.undetected]


def drifting_name(name: str) -> str:
    """What a drift is of, by the name of the coordinate whose momentum it is, or of another dataset."""
    return name.rpartition("/")[2] if "/" in name else f"p_{name}"


def not_finite(outcome: Outcome | EnsembleOutcome) -> str | None:
    """The warning for conserved quantities that have no finite value somewhere."""
    names = ["h"] if outcome.h_drift is not None and math.isinf(outcome.h_drift) else []
    names += [drifting_name(name) for name, drift in outcome.p_drift.items() if math.isinf(drift)]
    if not names:
        return None
    are = "is" if len(names) == 1 else "are"
    return (
        f"{some(names)} {are} not finite at some of the samples (an overflow, or a singularity): the drift "
        "is not known"
    )


def unresolved(outcome: Outcome, settings: Settings) -> str | None:
    """The warning for a motion so small that a tolerance which is absolute there says little about it."""
    from lagrange_cli.integrate.methods.table import METHODS

    method, tolerance, extent = METHODS[settings.method], settings.tolerance, outcome.extent
    if not (method.absolute and 0.0 < extent < min(SMALL, COARSE * tolerance)):
        return None
    return (
        f"{method.name} allows errors of {scientific(tolerance)} in coordinates and velocities "
        "smaller than 1, and "
        f"none exceeds {scientific(extent)}: choose units in which they are larger, or the "
        "Taylor method, whose "
        "tolerance is relative"
    )


def drifting(outcome: Outcome, tolerance: float) -> str | None:
    """The warning for a drift of h that rounding and the tolerance do not explain."""
    drift, size = outcome.h_drift, outcome.h_size
    if not drift or not size or math.isinf(drift):
        return None
    if drift <= max(max(WORTH_A_WORD, LOOSELY * tolerance) * size, LOOSELY * outcome.h_rounding):
        return None
    return (
        f"h drifted by {scientific(drift)}, {scientific(drift / size)} of its size, although it "
        "is conserved; a narrow force "
        "may have been missed, or h is a small difference of large numbers: do not rely on the result until "
        "a smaller --tolerance, another --method or --certify confirms it"
    )


def finite(content: Any) -> Any:
    """``content`` with None for NaN and infinities, which JSON does not know."""
    if isinstance(content, float):
        return content if math.isfinite(content) else None
    if isinstance(content, Mapping):
        return {
            str(key): value if type(value) is float and math.isfinite(value) else finite(value)
            for key, value in content.items()
        }
    if isinstance(content, (list, tuple)):
        return [finite(value) for value in content]
    return content


def units_of(spec: Spec, tell: Callable[[str], None] | None = None) -> Mapping[str, str]:
    """The units of datasets by path; a file without any unit does not even import what finds them.

    ``tell`` gets a line if they contradict each other, as in sin(theta) with theta in degrees.
    """
    if not has_units(spec):
        return {}
    from lagrange_cli.outputs.units import find_units

    found = find_units(spec)
    if found.conflicts and tell is not None:
        first = found.conflicts[0]
        surface = f" in event '{SURFACE}'"
        if first.message.endswith(surface):  # which is not in the file
            told = f"{SURFACE} {spec.events[SURFACE].when.text}: warning: {first.message[: -len(surface)]}"
            tell(f"{told}; nothing is converted")
        else:
            told = f"{spec.filename}: warning: {first.message}"
            tell(f"{told}; nothing is converted, 'lagrange check' shows the place")
    return found.texts


def series_of(units: Mapping[str, str], prepared: Prepared) -> tuple[Series, ...]:
    """The datasets of the run, with their units."""
    from lagrange_cli.store.layout import Series

    found = [
        Series(
            dataset.path,
            dataset.shape,
            units.get(dataset.path, ""),
            dataset.long_name,
            dataset.axes,
            dataset.components,
            places=dataset.places,
        )
        for dataset in prepared.datasets
        if dataset.path != "t"
    ]
    if prepared.machine.program.parts > 1:
        from lagrange_cli.integrate.samples import LOW

        text = "low part of {}, to be added to /{}"
        found += [
            replace(one, path=LOW + one.path, long_name=text.format(one.long_name, one.path)) for one in found
        ]
    return tuple(found)
