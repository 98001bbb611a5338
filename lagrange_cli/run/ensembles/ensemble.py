"""``Ensemble``: many motions of a system, and what their file holds."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from lagrange_cli.errors import UsageError
from lagrange_cli.records import dataclass, replace
from lagrange_cli.run.domains import within_domain
from lagrange_cli.run.ensembles.start import consistent_ensemble
from lagrange_cli.run.jumps import check_members
from lagrange_cli.run.monitor import Monitor
from lagrange_cli.run.prepare import prepare_run
from lagrange_cli.run.strength import with_proofs

if TYPE_CHECKING:
    from lagrange_cli.integrate.ensemble.method import Section
    from lagrange_cli.integrate.method import Method
    from lagrange_cli.integrate.prepared import Prepared
    from lagrange_cli.integrate.times import Times
    from lagrange_cli.run.ensembles.members import Members
    from lagrange_cli.run.request import Request
    from lagrange_cli.run.settings.settings import Settings
    from lagrange_cli.spec.ensemble import EnsembleValues
    from lagrange_cli.spec.spec import Family, Spec


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
    sampled = request.options.outputs is not None
    settings = request.settings(spec if sampled else without_samples(spec), values.common)
    given = {*request.overrides, *members.columns}
    spec, values, notes = consistent_ensemble(spec, values, settings.start, given, forced=request.projected)
    values = within_domain(spec, values, settings.start)
    return Ensemble(spec, members, values, settings, sampled, families_of(spec), notes=notes)


def without_samples(spec: Spec) -> Spec:
    """The system without the number of samples, and the time between them, that its file asks for."""
    return replace(spec, solve=replace(spec.solve, samples=None, step=None))


def families_of(spec: Spec) -> tuple[Family, ...]:
    """The families of the coordinates."""
    from lagrange_cli.spec.spec import grouped

    names = [coordinate.name for coordinate in spec.coordinates]
    return grouped(names, spec.coordinate_families)


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

    found = prepared(few=bool(ensemble.spec.coordinate_families))
    if found.machine.follow is None and found.compilation.few and steps_of(ensemble, found) > MOST_STEPS:
        from lagrange_cli.integrate.families import in_loops_if_few

        if in_loops_if_few(ensemble.spec, found.compilation):
            return prepared(few=False)
    return found


def steps_of(ensemble: Ensemble, prepared: Prepared) -> float:
    """About how many steps all motions take together, from those at the beginning of the first one; 0 where
    these are no more than are followed at once."""
    from lagrange_cli.integrate.ensemble.follow import starts_of
    from lagrange_cli.integrate.method import Start
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
        steps = prepared.follower.follow(Start(parameters[0], states[0], times)).steps
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
