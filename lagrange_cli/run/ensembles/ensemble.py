"""``Ensemble``: many motions of a system, and what their file holds."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from lagrange_cli.errors import UsageError
from lagrange_cli.records import dataclass
from lagrange_cli.run.attributes import doubt_of_all, finite, origin, series_of
from lagrange_cli.run.domains import within_domain
from lagrange_cli.run.ensembles.start import consistent_ensemble
from lagrange_cli.run.jumps import check_members
from lagrange_cli.run.monitor import Monitor
from lagrange_cli.run.prepare import prepare_run
from lagrange_cli.run.singular import in_words
from lagrange_cli.run.strength import with_proofs

if TYPE_CHECKING:
    from lagrange_cli.integrate.ensemble.method import Section
    from lagrange_cli.integrate.ensemble.outcome import EnsembleOutcome
    from lagrange_cli.integrate.method import Method
    from lagrange_cli.integrate.prepared import Prepared
    from lagrange_cli.integrate.times import Times
    from lagrange_cli.run.ensembles.members import Members
    from lagrange_cli.run.request import Request
    from lagrange_cli.run.settings.settings import Settings
    from lagrange_cli.spec.ensemble import EnsembleValues
    from lagrange_cli.spec.spec import Family, Spec
    from lagrange_cli.store.layout import Dimension, Series


MOST_STEPS = 2**19
"""So many steps of all motions together take eight at once as much less time as it takes to compile them.
(Both grow with the terms of a system.)"""
PARTS, SOME_STEPS = (1 / 64, 1 / 8, 1.0), 8
"""The part of a motion whose steps are counted: the first one with so many."""


@dataclass(frozen=True)
class Cut:
    """How a section is taken: the texts of the options ``where`` or ``every``, the ``direction`` (``rising``,
    ``falling`` or ``either``), and what is kept of each motion."""

    where: str
    every: str
    direction: str
    kept: Section

    @property
    def described(self) -> dict[str, str | int]:
        """The root's attributes that say how it was taken."""
        said = {"every": self.every} if self.every else {"where": self.where, "direction": self.direction}
        return {**said, "crossings": self.kept.count}


@dataclass(frozen=True)
class Ensemble:
    """Many motions to be followed: the system, its members with their values, and the settings of each.

    If they are ``sampled``, samples of each motion are written, else its end; if they are ``cut``, its
    crossings. ``families`` are those of the coordinates. ``notes`` say how initial values became
    consistent with constraints.
    """

    spec: Spec
    members: Members
    values: EnsembleValues
    settings: Settings
    sampled: bool
    families: tuple[Family, ...]
    cut: Cut | None = None
    notes: tuple[str, ...] = ()

    @property
    def times(self) -> Times:
        """When members are sampled: as ``solve`` does, or only at start and end."""
        from lagrange_cli.integrate.times import Times

        settings = self.settings
        if self.sampled and self.cut is None:
            return Times(settings.start, settings.stop, settings.count, settings.step)
        return Times(settings.start, settings.stop, 2, settings.stop - settings.start)


def make_ensemble(spec: Spec, members: Members, request: Request) -> Ensemble:
    """The ensemble that ``request`` asks for; its samples are written if it names outputs.

    Raises ``UsageError`` where the request makes no sense, or a value is out of range.
    """
    from lagrange_cli.spec.ensemble import resolve_ensemble

    values = resolve_ensemble(spec, request.overrides, members.columns)
    if values.times:
        spec = with_common_times(spec, values, request)
    settings = request.settings(spec, values.common)
    sampled = request.options.outputs is not None
    given = {*request.overrides, *members.columns}
    spec, values, notes = consistent_ensemble(spec, values, settings.start, given, forced=request.projected)
    values = within_domain(spec, values, settings.start)
    return Ensemble(spec, members, values, settings, sampled, families_of(spec), notes=notes)


def families_of(spec: Spec) -> tuple[Family, ...]:
    """The families of the coordinates."""
    from lagrange_cli.spec.spec import grouped

    names = [coordinate.name for coordinate in spec.coordinates]
    return grouped(names, spec.families.get("coordinates", {}))


def with_common_times(spec: Spec, values: EnsembleValues, request: Request) -> Spec:
    """The system with the times of ``solve`` that depend on parameters, which all members must share.

    Raises:
        UsageError: members differ in a time that the request does not replace.
        SpecError: the times make no sense.
    """
    from lagrange_cli.run.settings.settings import check_defaults
    from lagrange_cli.spec.defaults import with_times
    from lagrange_cli.spec.problems import Problems
    from lagrange_cli.spec.source import Source

    common = {name: time for name, time in values.times.items() if isinstance(time, float)}
    replaced = {*request.times}
    if "step" in replaced or request.options.samples is not None or request.options.outputs is None:
        replaced.add("step")
    for name in values.times:
        if name not in common and name not in replaced:
            raise UsageError(
                f"'{name}: {spec.solve.times[name].text}' in solve differs between the members of the sweep: "
                f"all members have the same times; add --{name} with a number"
            )
    problems = Problems(Source(spec.filename, spec.text))
    spec = with_times(spec, common, problems)
    check_defaults(spec, problems)
    problems.stop_if_any()
    return spec


def series(ensemble: Ensemble, prepared: Prepared, units: Mapping[str, str]) -> tuple[Series, ...]:
    """The datasets of the ensemble, in the file's order."""
    from lagrange_cli.expression.vocabulary import family_name
    from lagrange_cli.integrate.ensemble.datasets import drift_path
    from lagrange_cli.integrate.ensemble.outcome import STATUS
    from lagrange_cli.records import replace
    from lagrange_cli.store.layout import Series

    swept = {name for name, values in ensemble.members.axes if not isinstance(values, int)}
    found = [
        Series(path, unit=units.get(path, ""), long_name=one.description or f"parameter {one.name}")
        for one in ensemble.spec.parameters
        if one.name in ensemble.values.differing and one.name not in swept
        for path in (f"parameters/{one.name}",)
    ]
    for kind, text in (("q", "coordinate {}"), ("v", "velocity d{}/dt")):
        for family in ensemble.families:
            unit, name = units.get(f"{kind}/{family.name}", ""), f"initial {text.format(family.label)}"
            found.append(Series(f"initial/{kind}/{family.name}", family.shape, unit, name, axes=family.axes))
    change = "max |{0} - {0}(0)|" if ensemble.sampled else "|{0} - {0}(0)| at the end"
    found += [
        Series("t_end", unit=units.get("t", ""), long_name="time at which the member ended"),
        Series("steps", long_name="number of steps", kind="i8"),
        Series("status", long_name="status of the member", kind=STATUS),
        *(
            Series(path, (), units.get(family_name(path.replace("drift/", "", 1)), ""), change.format(name))
            for name in prepared.recording.conserved
            for path in (drift_path(name),)
        ),
    ]
    made = [replace(one, sampled=ensemble.sampled) for one in series_of(units, prepared)]
    if ensemble.cut is not None:
        found.append(Series("crossings", long_name="number of crossings", kind="i8"))
        made.insert(0, Series("t", unit=units.get("t", ""), long_name="time"))
    return (*(replace(one, sampled=False) for one in found), *made)


def dimensions(ensemble: Ensemble, units: Mapping[str, str]) -> tuple[Dimension, ...]:
    """The dimensions that the members span: a parameter's has its name, that of an initial value ``_0``
    behind it; ``row`` counts those of a table, ``draw`` the random ones."""
    from lagrange_cli.expression.vocabulary import family_name, velocity_name
    from lagrange_cli.store.layout import Dimension

    spec, found = ensemble.spec, []
    parameters = {one.name: one for one in spec.parameters}
    paths = {each.name: f"q/{family_name(each.name)}" for each in spec.coordinates}
    paths |= {velocity_name(each.name): f"v/{family_name(each.name)}" for each in spec.coordinates}
    for name, values in ensemble.members.axes:
        if isinstance(values, int):
            text = "row of the table" if name == "row" else "draw of the random numbers"
            found.append(Dimension(name, values, long_name=text))
        elif name in parameters:
            text, path = parameters[name].description or f"parameter {name}", f"parameters/{name}"
            found.append(Dimension(name, len(values), values, units.get(path, ""), text, path))
        else:
            unit = units.get(paths[name], "")
            found.append(Dimension(f"{name}_0", len(values), values, unit, f"initial {name}"))
    return tuple(found)


def made_by(ensemble: Ensemble) -> dict[str, str | int | float]:
    """The root's attributes that say what made the file."""
    import binascii

    import numpy as np

    values, members = ensemble.values, ensemble.members
    described = {"shape": dict(members.shape), **members.described}
    checksum = 0
    exact = values.remainder
    rest = () if exact is None else (*exact.parameters.values(), *exact.q, *exact.v)
    for column in (*values.differing.values(), *values.q, *values.v, *rest):
        checksum = binascii.crc32(np.asarray(column, dtype="f8").tobytes(), checksum)
    sampled = ensemble.sampled and ensemble.cut is None
    return {
        **origin(ensemble.spec, ensemble.settings, values.common, f"crc32 {checksum:08x}", sampled),
        **({} if ensemble.cut is None else ensemble.cut.described),
        "sweep": json.dumps({name: value for name, value in described.items() if value not in ({}, None)}),
        "members": values.members,
    }


def prepare_ensemble(ensemble: Ensemble, request: Request, monitor: Monitor, section: str = "") -> Prepared:
    """Compile the system for all motions, through a ``section`` of a kind if that is given.

    Raises ``SpecError`` where no equations of motion can be derived, they are too large, or an energy jumps.
    """
    check_members(ensemble.spec, ensemble.values)
    settings = with_proofs(ensemble.spec, ensemble.settings, ensemble.values.several())

    def prepared(*, few: bool) -> Prepared:
        return prepare_run(
            ensemble.spec,
            settings,
            monitor.stage,
            cached=request.cache,
            ensemble=True,
            few=few,
            section=section,
            meanwhile=import_the_rest,
        )

    found = prepared(few=bool(ensemble.spec.families.get("coordinates")))
    if found.machine.follow is None and found.compilation.few and steps_of(ensemble, found) > MOST_STEPS:
        from lagrange_cli.integrate.families import in_loops_if_few

        if in_loops_if_few(ensemble.spec, found.compilation):
            return prepared(few=False)
    return found


def steps_of(ensemble: Ensemble, prepared: Prepared) -> float:
    """About how many steps all motions take together, from those at the beginning of the first one; 0 where
    these are no more than are followed at once."""
    from lagrange_cli.integrate.ensemble.follow import starts_of
    from lagrange_cli.integrate.times import Times
    from lagrange_cli.native.interface import LANES

    members, start, stop = ensemble.values.members, ensemble.settings.start, ensemble.settings.stop
    if members <= LANES:
        return 0.0
    if not math.isfinite(stop):
        return math.inf
    parameters, states = starts_of(ensemble.values, prepared.machine.program, slice(0, 1))
    part, steps = 1.0, 0
    for part in PARTS:
        length = (stop - start) * part
        times = Times(start, start + length, 2, length)
        given = parameters[0], states[0], times, lambda when, chunk: None, lambda t: False
        steps = prepared.follower.follow(*given).steps
        if steps >= SOME_STEPS:
            break
    return members * steps / part


def import_the_rest() -> None:
    """Import what the integration needs."""
    import lagrange_cli.integrate.ensemble.follow
    import lagrange_cli.integrate.ensemble.lanes
    import lagrange_cli.store.ensemble  # noqa: F401


def alone(ensemble: Ensemble, request: Request) -> Method:
    """The method that follows one of the motions alone."""
    return prepare_run(ensemble.spec, ensemble.settings, cached=request.cache).follower


def told(
    ensemble: Ensemble, outcome: EnsembleOutcome, message: str, events: Mapping[str, int] | None = None
) -> dict[str, str | int | float]:
    """The root's attributes that say how the members ended, and how often ``events`` happened in all."""
    warning = doubt_of_all(outcome, ensemble.settings)
    return {
        "steps": outcome.steps,
        "status": outcome.status,
        "message": message,
        "h_drift": float("nan") if outcome.h_drift is None else outcome.h_drift,
        "p_drift": json.dumps(finite(outcome.p_drift)),
        **({} if warning is None else {"warning": warning}),
        **({"events": json.dumps(events_counted(events))} if events else {}),
    }


def events_counted(events: Mapping[str, int]) -> dict[str, Any]:
    """How often events happened, in terms of JSON: as of one motion, without what members do not share."""
    return {name: {"count": count} for name, count in events.items()}


def how_they_ended(ensemble: Ensemble, outcome: EnsembleOutcome) -> str:
    """How the members ended."""
    members, failed = ensemble.values.members, outcome.count("failed")
    stopped = outcome.count("stopped")
    if outcome.status == "complete" and stopped:
        return f"{members - stopped} of {members} members reached the end, events stopped {stopped}"
    if outcome.status == "complete":
        return "the member reached the end" if members == 1 else f"all {members} members reached the end"
    parts = []
    if outcome.status == "interrupted":
        parts.append(f"interrupted after {members - outcome.count('interrupted')} of {members} members")
    if outcome.failed is not None:
        member, how = outcome.failed
        how = ensemble.values.refused.get(member, in_words(ensemble.spec, how))
        own = ", ".join(f"{name} = {x[member]:.6g}" for name, x in ensemble.members.columns.items())
        those = "the first is member" if failed > 1 else "member"
        parts.append(f"{failed} of {members} members failed; {those} {member} ({own}): {how}")
    return "; ".join(parts)
