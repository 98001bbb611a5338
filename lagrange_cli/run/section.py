"""``section``: where motions cross a surface, or are after multiples of a period, from the system to the
output."""

from __future__ import annotations

import json
import math
from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Any

from lagrange_cli.errors import SpecError, UsageError
from lagrange_cli.integrate.methods.table import TAYLOR
from lagrange_cli.limits import whole
from lagrange_cli.native.interface import SECTION, STROBE
from lagrange_cli.records import dataclass, replace
from lagrange_cli.run.attributes import finite, series_of, units_of
from lagrange_cli.run.ensemble import Cut, Ensemble, dimensions, made_by, series, with_common_times
from lagrange_cli.run.monitor import SILENT, Monitor
from lagrange_cli.run.prepare import prepare_run
from lagrange_cli.run.resume import Start, take_up
from lagrange_cli.spec.spec import SURFACE
from lagrange_cli.spec.surface import with_surface

if TYPE_CHECKING:
    import numpy as np

    from lagrange_cli.integrate.ensemble.method import EnsembleMethod
    from lagrange_cli.integrate.ensemble.outcome import EnsembleOutcome
    from lagrange_cli.integrate.method import Method
    from lagrange_cli.integrate.prepared import Prepared
    from lagrange_cli.run.members import Members
    from lagrange_cli.run.request import Request
    from lagrange_cli.run.settings import Settings
    from lagrange_cli.spec.ensemble import EnsembleValues, Number
    from lagrange_cli.spec.spec import Spec
    from lagrange_cli.store.target import Target

DIRECTIONS = {"rising": 1, "falling": -1, "either": 0}
CROSSINGS = 1000
"""Crossings of each motion that are kept, where nobody says how many."""
LARGEST = 2**28
"""Bytes of one motion's crossings, which are kept in memory until it has ended."""
FAR = 1e300
"""A stop time that no motion reaches, for what needs a number."""


@dataclass(frozen=True)
class Asked:
    """What a section is to be: the surface ``where``, or the period ``every``, as expressions; the
    ``direction`` in which the surface is crossed; and how many ``crossings`` of each motion are kept."""

    where: str = ""
    every: str = ""
    direction: str = "rising"
    crossings: int = CROSSINGS


@dataclass(frozen=True)
class Crossed:
    """A section that was taken: how the run started and how the motions ended; the number of ``crossings``
    found, and of motions that have ``fewer`` than asked for."""

    ensemble: Ensemble
    start: Start
    outcome: EnsembleOutcome
    crossings: int
    fewer: int
    cached: bool

    @property
    def message(self) -> str:
        """How it ended."""
        return sentence(self.ensemble, self.outcome, self.crossings, self.fewer)


def make_section(spec: Spec, members: Members | None, request: Request, asked: Asked) -> Ensemble:
    """The motions of a section: those of ``members``, or the one that the file has, and the settings.

    Raises ``UsageError`` where the request makes no sense, or a value is out of range.
    """
    from lagrange_cli.integrate.ensemble.method import Section
    from lagrange_cli.run.members import Members
    from lagrange_cli.spec.ensemble import EnsembleValues, resolve_ensemble
    from lagrange_cli.spec.spec import grouped
    from lagrange_cli.spec.values import resolve_values

    if members is None:
        members = Members({}, {})
        one = resolve_values(spec, request.overrides)
        values = EnsembleValues(1, one.parameters, one.q, one.v, one.times)
    else:
        values = resolve_ensemble(spec, request.overrides, members.columns)
    spec, values = with_start_only(spec, values, request)
    settings = settings_of(spec, values, request)
    if asked.where:
        direction = DIRECTIONS[asked.direction]
        spec = with_surface(spec, asked.where, direction)
        kept = Section(asked.crossings, direction, None, whole("patience"))
    else:
        kept = Section(asked.crossings, periods=periods(asked.every, spec, values))
    families = grouped(
        [coordinate.name for coordinate in spec.coordinates], spec.families.get("coordinates", {})
    )
    cut = Cut(asked.where, asked.every, asked.direction, kept)
    return Ensemble(spec, members, values, settings, True, families, cut)


def with_start_only(spec: Spec, values: EnsembleValues, request: Request) -> tuple[Spec, EnsembleValues]:
    """The system without those times of its ``solve`` that have no meaning for a section."""
    kept = {name: time for name, time in values.times.items() if name == "start"}
    solve = replace(
        spec.solve,
        stop=FAR,
        step=None,
        samples=None,
        times={name: one for name, one in spec.solve.times.items() if name == "start"},
    )
    spec, values = replace(spec, solve=solve), replace(values, times=kept)
    return (with_common_times(spec, values, request) if kept else spec), values


def settings_of(spec: Spec, values: EnsembleValues, request: Request) -> Settings:
    """The settings of all motions; they stop at no time if none is asked for."""
    request = replace(request, options=replace(request.options, method=TAYLOR))
    settings = request.settings(spec, values.common)
    stop = settings.stop if "stop" in request.times else math.inf
    return replace(settings, stop=stop, step=math.nan)


def periods(text: str, spec: Spec, values: EnsembleValues) -> np.ndarray:
    """The period of each member: an expression in parameters. Raises ``UsageError``."""
    import numpy as np

    from lagrange_cli.expression.build import Builder, NoMember
    from lagrange_cli.expression.columns import ColumnAlgebra
    from lagrange_cli.expression.parse import parse
    from lagrange_cli.expression.syntax import ExpressionError
    from lagrange_cli.run.times import check_names
    from lagrange_cli.spec.ensemble import plain

    algebra = ColumnAlgebra(values.members)

    def scope(name: str) -> Any:
        if name not in values.parameters:
            raise NoMember
        value = values.parameters[name]
        return value if isinstance(value, float) else algebra.column(value)

    try:
        tree = parse(text)
        check_names(tree, spec, dict.fromkeys(values.parameters, 0.0))
        with np.errstate(all="ignore"):
            found: Number = plain(algebra.finite(tree, Builder(scope, algebra, spec.sizes).build(tree)))
    except ExpressionError as error:
        hint = f"; {error.hint}" if error.hint else ""
        raise UsageError(f"--every {text}: {error.message}{hint}") from error
    made = np.array(np.broadcast_to(found, values.members), dtype=np.float64)
    wrong = algebra.failed | ~(made > 0.0)
    if wrong.any():
        member = int(wrong.argmax())
        place = f" for member {member}" if values.members > 1 else ""
        raise UsageError(f"--every {text}: a period is a positive number, not {made[member]:g}{place}")
    return made


def take_section(
    ensemble: Ensemble, target: Target, request: Request, monitor: Monitor = SILENT, *, threads: int = 1
) -> Crossed:
    """Derive, compile and follow all motions, so many ``threads`` at a time, and write their crossings to
    ``target``.

    However they end, what was found of those that have ended is written. The results do not depend on
    ``threads``.

    Raises:
        SpecError: no equations of motion can be derived, or they are too large.
        UsageError: a section of this system cannot be taken, or its crossings do not fit into memory.
        FileError: the output cannot be written, or an earlier run is in the way.
    """
    assert ensemble.cut is not None
    with target.claimed():
        with monitor.stage("import"):
            start = take_up(target, origin_of(ensemble), resume=False, tell=monitor.tell)
        prepared = prepare(ensemble, request, monitor)
        program, count = prepared.machine.program, ensemble.cut.kept.count
        most = LARGEST // (8 * (program.rows + 1 + len(program.observed)))
        if count > most:
            raise UsageError(
                f"{count} crossings of a motion exceed the limit of {most}, as they are kept in memory: "
                "ask for fewer --crossings, of more motions"
            )
        return follow_and_write(ensemble, prepared, start, request, monitor, threads)


def origin_of(ensemble: Ensemble) -> dict[str, str | int | float]:
    """The root's attributes that say what made the file."""
    said = made_by(ensemble)
    return said if is_many(ensemble) else {n: x for n, x in said.items() if n not in ("members", "sweep")}


def is_many(ensemble: Ensemble) -> bool:
    """Whether it is a sweep, if only of one member."""
    return bool(ensemble.members.columns)


def prepare(ensemble: Ensemble, request: Request, monitor: Monitor) -> Prepared:
    """The compiled system. Raises ``UsageError`` for a surface that turns out to be the same everywhere."""
    assert ensemble.cut is not None
    kind = SECTION if ensemble.cut.where else STROBE
    try:
        return prepare_run(
            ensemble.spec,
            ensemble.settings,
            monitor.stage,
            cached=request.cache,
            ensemble=True,
            section=kind,
            meanwhile=import_the_rest,
        )
    except SpecError as error:
        if any(SURFACE in one.message for one in error.problems):  # it is not in the file
            raise UsageError(f"{SURFACE} {ensemble.cut.where}: this never changes") from error
        raise


def method_of(prepared: Prepared, alone: Callable[[], Method]) -> EnsembleMethod:
    """What follows the motions: eight at once, or each by itself."""
    if prepared.machine.follow is not None:
        from lagrange_cli.integrate.ensemble.lanes import LanesMethod

        return LanesMethod(prepared.machine, alone, prepared.compilation.backward)
    from lagrange_cli.integrate.ensemble.section import SectionOneByOne

    names = tuple(name for group in prepared.recording.events for name in group.members)
    return SectionOneByOne(prepared.follower, True, names)


def import_the_rest() -> None:
    """Import what the integration needs."""
    import lagrange_cli.integrate.ensemble.datasets
    import lagrange_cli.integrate.ensemble.lanes
    import lagrange_cli.store.ensemble  # noqa: F401


def follow_and_write(
    ensemble: Ensemble,
    prepared: Prepared,
    start: Start,
    request: Request,
    monitor: Monitor,
    threads: int,
) -> Crossed:
    """Follow all motions and write what is found, however they end."""
    from lagrange_cli.integrate.ending import Ending
    from lagrange_cli.integrate.ensemble.datasets import follow_ensemble

    assert ensemble.cut is not None
    kept = ensemble.cut.kept
    progress, stage = monitor.progress(), monitor.stage
    crossings, fewer = 0, 0
    with monitor.interrupts() as interrupted:
        with stage("write"):
            output: Grid | Single = (Grid if is_many(ensemble) else Single)(ensemble, prepared, start)

        def write(index: np.ndarray, values: dict[str, Any]) -> None:
            nonlocal crossings, fewer
            if "crossings" in values:
                crossings += int(values["crossings"].sum())
                fewer += int((values["crossings"] < kept.count).sum())
            with stage("write"):
                output.write(index, values)

        def alone() -> Method:
            return prepare_run(ensemble.spec, ensemble.settings, cached=request.cache).follower

        def report(done: int) -> bool:
            progress.show(done)
            return interrupted()

        with output.output:
            with stage("integrate"):
                outcome = follow_ensemble(
                    prepared,
                    method_of(prepared, alone),
                    ensemble.values,
                    ensemble.families,
                    ensemble.times,
                    write,
                    report,
                    sampled=False,
                    threads=threads,
                    section=kept,
                )
            progress.clear()
            with stage("write"):
                said = attributes(ensemble, outcome, crossings, fewer)
                output.close({**start.made_by, **said}, [one.value for one in Ending], outcome)
    return Crossed(ensemble, start, outcome, crossings, fewer, prepared.cached)


class Grid:
    """The file of many motions: like that of a sweep, with the dimension ``crossing`` in place of a time."""

    def __init__(self, ensemble: Ensemble, prepared: Prepared, start: Start) -> None:
        from lagrange_cli.store.ensemble import EnsembleWriter
        from lagrange_cli.store.layout import Dimension, Layout

        assert ensemble.cut is not None
        units = units_of(ensemble.spec)
        self.output = EnsembleWriter(
            start.target,
            Layout(series(ensemble, prepared, units)),
            members=ensemble.values.members,
            times=None,
            dimensions=dimensions(ensemble, units),
            samples=Dimension("crossing", ensemble.cut.kept.count, long_name="crossing of the motion"),
        )

    def write(self, index: np.ndarray, values: Mapping[str, Any]) -> None:
        """See ``EnsembleWriter``."""
        self.output.write(index, values)

    def close(self, attributes: dict[str, Any], endings: list[str], outcome: EnsembleOutcome) -> None:
        """Complete the file."""
        self.output.write_texts("message", "how the member ended", endings, outcome.endings)
        self.output.close(attributes)


class Single:
    """The file of one motion: like that of ``solve``, with its crossings as the samples."""

    def __init__(self, ensemble: Ensemble, prepared: Prepared, start: Start) -> None:
        from lagrange_cli.store.layout import Layout
        from lagrange_cli.store.writer import Writer

        assert ensemble.cut is not None
        units = units_of(ensemble.spec)
        layout = Layout(series_of(units, prepared), time_unit=units.get("t", ""))
        times = replace(ensemble.times, count=ensemble.cut.kept.count, step=0.0)
        self.output = Writer(start.target, layout, times)
        self._paths = ["t", *(one.path for one in layout.series)]
        self._end: dict[str, float] = {}

    def write(self, index: np.ndarray, values: Mapping[str, Any]) -> None:
        """The crossings of the motion."""
        if "crossings" in values:
            count = int(values["crossings"][0])
            self.output.append({path: values[path][0][:count] for path in self._paths})
            self._end = {"t_end": float(values["t_end"][0])}

    def close(self, attributes: dict[str, Any], endings: list[str], outcome: EnsembleOutcome) -> None:
        """Complete the file."""
        self.output.close({**attributes, **finite(self._end)})


def attributes(
    ensemble: Ensemble, outcome: EnsembleOutcome, crossings: int, fewer: int
) -> dict[str, str | int | float]:
    """The root's attributes that say how the motions ended."""
    return {
        "steps": outcome.steps,
        "status": outcome.status,
        "message": sentence(ensemble, outcome, crossings, fewer),
        "h_drift": float("nan") if outcome.h_drift is None else outcome.h_drift,
        "p_drift": json.dumps(finite(outcome.p_drift)),
    }


def sentence(ensemble: Ensemble, outcome: EnsembleOutcome, crossings: int, fewer: int) -> str:
    """What was found, and how motions ended that have fewer crossings than were asked for."""
    from lagrange_cli.run.ensemble import sentence as how_they_ended

    assert ensemble.cut is not None
    members, many = ensemble.values.members, is_many(ensemble)
    found = f"{crossings} crossing{'' if crossings == 1 else 's'}" + (
        f" by {members} members" if many else ""
    )
    if outcome.status == "complete":
        stopped = f"{fewer} of them" if many else "the motion"
        return f"{found}; {stopped} reached the stop time before the last one" if fewer else found
    if many:
        return f"{found}; {how_they_ended(ensemble, outcome)}"
    return f"{found}; {'interrupted' if outcome.failed is None else outcome.failed[1]}"
