"""``sweep``: many motions, from an ensemble to the output."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from lagrange_cli.errors import UsageError
from lagrange_cli.records import dataclass
from lagrange_cli.run.attributes import units_of
from lagrange_cli.run.derive import check_energies
from lagrange_cli.run.ensemble import Ensemble, attributes, dimensions, made_by, series
from lagrange_cli.run.monitor import SILENT, Monitor
from lagrange_cli.run.prepare import prepare_run
from lagrange_cli.run.resume import Start, take_up
from lagrange_cli.run.strength import with_proofs

if TYPE_CHECKING:
    import numpy as np

    from lagrange_cli.integrate.ensemble.outcome import EnsembleOutcome
    from lagrange_cli.integrate.method import Method
    from lagrange_cli.integrate.prepared import Prepared
    from lagrange_cli.run.request import Request
    from lagrange_cli.store.checkpoint import Checkpoint
    from lagrange_cli.store.layout import Layout
    from lagrange_cli.store.resume import Earlier
    from lagrange_cli.store.target import Target

LARGEST = 2**26
"""Bytes of one member's samples, which are kept in memory until it has ended."""


@dataclass(frozen=True)
class Swept:
    """An ensemble that was followed: how the run started, and how the members ended.

    ``outcome`` is None where an earlier run had ``finished`` (see ``start``). ``cached`` tells that the
    compiled code is that of an earlier run.
    """

    ensemble: Ensemble
    start: Start
    outcome: EnsembleOutcome | None = None
    cached: bool = False


def sweep(
    ensemble: Ensemble, target: Target, request: Request, monitor: Monitor = SILENT, *, threads: int = 1
) -> Swept:
    """Derive, compile and integrate all members, so many ``threads`` at a time, and write them to ``target``.

    However the members end, what was computed is written. The results do not depend on ``threads``.

    Raises:
        SpecError: no equations of motion can be derived, or they are too large.
        UsageError: the samples of a member do not fit into memory.
        FileError: the output cannot be written, or an earlier run is in the way.
    """
    with target.claimed():
        with monitor.stage("import"):
            start = take_up(target, made_by(ensemble), resume=request.resume, tell=monitor.tell)
        if start.finished is not None:
            return Swept(ensemble, start)
        for values in ensemble.values.several():
            check_energies(ensemble.spec, values.parameters)
        prepared = prepare_run(
            ensemble.spec,
            with_proofs(ensemble.spec, ensemble.settings, ensemble.values.several()),
            monitor.stage,
            cached=request.cache,
            ensemble=True,
            meanwhile=import_the_rest,
        )
        refuse_long_samples(ensemble, prepared)
        outcome = follow_and_write(ensemble, prepared, start, request, monitor, threads)
    return Swept(ensemble, start, outcome, prepared.cached)


def import_the_rest() -> None:
    """Import what the integration needs."""
    import lagrange_cli.integrate.ensemble.datasets
    import lagrange_cli.integrate.ensemble.lanes
    import lagrange_cli.store.ensemble  # noqa: F401


def refuse_long_samples(ensemble: Ensemble, prepared: Prepared) -> None:
    """Raise ``UsageError`` unless the samples of several members fit into memory."""
    program, count = prepared.machine.program, ensemble.settings.count
    most = LARGEST // (8 * (program.rows + len(program.observed)))
    if ensemble.sampled and count > most:
        raise UsageError(
            f"{count} samples per member exceed the limit of {most}, as they are kept in memory: "
            "use fewer --samples, or solve the members one by one"
        )


def layout_of(ensemble: Ensemble, prepared: Prepared, units: Mapping[str, str]) -> Layout:
    """The datasets of the ensemble, and the groups of its events."""
    from lagrange_cli.store.layout import EventSeries, Layout

    events: tuple[EventSeries, ...] = ()
    if ensemble.spec.events:
        from lagrange_cli.run.events import crossings_of

        events = crossings_of(ensemble.spec, prepared, units, ensemble=True)
    return Layout(series(ensemble, prepared, units), time_unit=units.get("t", ""), events=events)


def follow_and_write(
    ensemble: Ensemble,
    prepared: Prepared,
    start: Start,
    request: Request,
    monitor: Monitor,
    threads: int,
) -> EnsembleOutcome:
    """Integrate all members into the output file, however they end."""
    from lagrange_cli.integrate.checkpoint import Checkpointing, Schedule
    from lagrange_cli.integrate.ending import Ending
    from lagrange_cli.integrate.ensemble.datasets import follow_ensemble
    from lagrange_cli.integrate.ensemble.outcome import UNFINISHED, EnsembleOutcome
    from lagrange_cli.integrate.ensemble.selection import ensemble_method
    from lagrange_cli.store.ensemble import EnsembleWriter

    times, sampled, members = ensemble.times, ensemble.sampled, ensemble.values.members
    units = units_of(ensemble.spec, monitor.tell)
    progress, stage = monitor.progress(), monitor.stage
    with monitor.interrupts() as interrupted:
        with stage("write"):
            layout = layout_of(ensemble, prepared, units)
            writer = EnsembleWriter(
                start.target,
                layout,
                members=members,
                times=times.chunk(0, times.count) if sampled else None,
                dimensions=dimensions(ensemble, units),
            )

        def write(index: np.ndarray, values: dict[str, Any]) -> None:
            with stage("write"):
                writer.write(index, values)

        def alone() -> Method:
            return prepare_run(ensemble.spec, ensemble.settings, cached=request.cache).follower

        def report(done: int) -> bool:
            progress.show(done)
            return interrupted()

        def checkpoint(outcome: EnsembleOutcome, *, inside: bool = False) -> Checkpoint:
            ended = outcome.endings != UNFINISHED
            content = {"outcome": outcome.as_data(), "regions": writer.regions(ended)}
            reached = members - outcome.count("interrupted")
            arrays = {"endings": outcome.endings, **writer.crossings()}
            return start.checkpoint({"reached": reached, **content}, arrays, inside=inside)

        def write_checkpoint(outcome: EnsembleOutcome) -> None:
            with stage("write"):
                writer.keep(checkpoint(outcome))

        def restored(earlier: Earlier) -> EnsembleOutcome:
            head, endings = earlier.checkpoint.head, earlier.checkpoint.arrays.get("endings")
            try:
                begin = EnsembleOutcome.from_data(head.get("outcome"), endings, members)
            except ValueError as error:
                raise damaged(earlier.shown) from error
            writer.restore(earlier, begin.endings != UNFINISHED)
            return begin

        with writer:
            begin = None
            if start.earlier is not None:
                from lagrange_cli.store.checkpoint import damaged

                with stage("write"):
                    begin = restored(start.earlier)
            schedule = Schedule(request.checkpoint, request.checkpoint_count, start.reached or 0)
            with stage("integrate"):
                outcome = follow_ensemble(
                    prepared,
                    ensemble_method(prepared, alone),
                    ensemble.values,
                    ensemble.families,
                    times,
                    write,
                    report,
                    sampled=sampled,
                    threads=threads,
                    checkpointing=Checkpointing(begin, schedule, write_checkpoint),
                )
            progress.clear()
            with stage("write"):
                last = checkpoint(outcome, inside=True) if outcome.status == "interrupted" else None
                sentences = [ending.value for ending in Ending]
                writer.write_crossings()
                writer.write_texts("message", "how the member ended", sentences, outcome.endings)
                writer.close({**start.made_by, **attributes(ensemble, outcome)}, last)
    return outcome
