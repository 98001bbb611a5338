"""``sweep``: many motions, from an ensemble to the output."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import partial
from typing import TYPE_CHECKING, Any

from lagrange_cli.errors import UsageError
from lagrange_cli.records import dataclass, field, replace
from lagrange_cli.run.attributes import units_of
from lagrange_cli.run.ensembles.contents import dimensions, how_they_ended, made_by, series, told
from lagrange_cli.run.ensembles.ensemble import Ensemble, alone, prepare_ensemble
from lagrange_cli.run.ensembles.kept import MembersKept
from lagrange_cli.run.monitor import SILENT, Monitor, watched
from lagrange_cli.run.resume import Start, begun
from lagrange_cli.run.settings.settings import tell_empty
from lagrange_cli.run.singular import in_words

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from lagrange_cli.integrate.ensemble.outcome import EnsembleOutcome
    from lagrange_cli.integrate.prepared import Prepared
    from lagrange_cli.run.request import Request
    from lagrange_cli.store.layout import Layout
    from lagrange_cli.store.target import Target

LARGEST = 2**26
"""Bytes of one member's samples, which are kept in memory until it has ended."""


@dataclass(frozen=True)
class Swept:
    """An ensemble that was followed: how the run started, and how the members ended.

    ``start`` has the target that was written. ``outcome`` is None where an earlier run had ``finished`` (see
    ``start``). ``cached`` tells that the compiled code is that of an earlier run. ``events`` are how often
    each event happened in all members.
    """

    ensemble: Ensemble
    start: Start
    outcome: EnsembleOutcome | None = None
    cached: bool = False
    events: Mapping[str, int] = field(default_factory=dict)


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
        start = begun(target, made_by(ensemble), request, monitor)
        if start.finished is not None:
            return Swept(ensemble, start)
        for note in ensemble.notes:
            monitor.tell(f"{ensemble.spec.name}: {note}")
        groups = grouped(ensemble, request, monitor)
        ensemble, prepared = groups[0].ensemble, groups[0].prepared
        refuse_long_samples(ensemble, prepared)
        outcome, events, written = follow_and_write(groups, start, request, monitor, threads)
    return Swept(ensemble, replace(start, target=written), outcome, prepared.cached, events)


@dataclass(frozen=True)
class Group:
    """The ``chosen`` members (members,) of an ensemble, whose constraints depend on each other in the same
    way, and their system, compiled."""

    ensemble: Ensemble
    prepared: Prepared
    chosen: NDArray[np.bool_]


def grouped(ensemble: Ensemble, request: Request, monitor: Monitor) -> list[Group]:
    """The members by which constraints depend on others. Members are refused whose outputs are not those of
    the first ones, as something else is conserved.

    Raises ``SpecError`` as ``prepare_ensemble``.
    """
    import numpy as np

    prepared, otherwise = prepare_ensemble(ensemble, request, monitor), ensemble.values.otherwise
    values = ensemble.values
    made: dict[tuple[str, ...], Prepared] = {}
    for left_out in dict.fromkeys(otherwise.values()):
        spec = replace(ensemble.spec, left_out=left_out)
        other = prepare_ensemble(replace(ensemble, spec=spec), request, monitor)
        if other.recording == prepared.recording:
            made[left_out] = other
        else:
            values = values.without(one for one, names in otherwise.items() if names == left_out)
    ensemble, keys = replace(ensemble, values=values), [ensemble.spec.left_out, *made]
    of_member = [values.otherwise.get(member, keys[0]) for member in range(values.members)]
    return [
        Group(
            replace(ensemble, spec=replace(ensemble.spec, left_out=left_out)),
            made.get(left_out, prepared),
            np.array([one == left_out for one in of_member]),
        )
        for left_out in keys
    ]


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
    groups: Sequence[Group], start: Start, request: Request, monitor: Monitor, threads: int
) -> tuple[EnsembleOutcome, dict[str, int], Target]:
    """Integrate all members into the output file, however they end; how often events happened in all, and
    the target that was written."""
    from lagrange_cli.integrate.checkpoint import Checkpointing, Schedule
    from lagrange_cli.integrate.ending import Ending
    from lagrange_cli.integrate.ensemble.follow import ensemble_method, follow_ensemble
    from lagrange_cli.store.ensemble import EnsembleWriter

    ensemble, prepared = groups[0].ensemble, groups[0].prepared
    times, sampled, members = ensemble.times, ensemble.sampled, ensemble.values.members
    units = units_of(ensemble.spec, monitor.tell)
    tell_empty(ensemble.spec, ensemble.settings, monitor.tell)
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

        kept = MembersKept(start, writer, members)

        def write_checkpoint(outcome: EnsembleOutcome) -> None:
            with stage("write"):
                writer.keep(kept.checkpoint(outcome, writer.crossings()))

        with writer:
            with stage("write"):
                begin = kept.restored()
            schedule = Schedule(request.checkpoint, request.checkpoint_count, start.reached or 0)
            with stage("integrate"):
                for group in groups:
                    begin = outcome = follow_ensemble(
                        group.prepared,
                        ensemble_method(group.prepared, partial(alone, group.ensemble, request)),
                        ensemble.values,
                        ensemble.families,
                        times,
                        write,
                        watched(progress, interrupted),
                        sampled=sampled,
                        threads=threads,
                        checkpointing=Checkpointing(begin, schedule, write_checkpoint),
                        chosen=group.chosen,
                    )
            progress.clear()
            with stage("write"):
                last = None
                if outcome.status == "interrupted":
                    last = kept.checkpoint(outcome, writer.crossings(), inside=True)
                sentences = [in_words(ensemble.spec, ending.value) for ending in Ending]
                events = writer.crossings_of_events()
                writer.write_crossings()
                writer.write_messages(sentences, outcome.endings)
                writer.close(
                    {**start.made_by, **told(ensemble, outcome, how_they_ended(ensemble, outcome), events)},
                    last,
                )
    return outcome, events, writer.target
