"""``solve``: one motion, from the system and its numbers to the output."""

from __future__ import annotations

from contextlib import nullcontext
from typing import TYPE_CHECKING, Any, BinaryIO

from lagrange_cli.records import dataclass, replace
from lagrange_cli.run.attributes import origin, units_of
from lagrange_cli.run.monitor import SILENT, Monitor
from lagrange_cli.run.motion import Motion, Ready, follow, initial_state, prepare_all
from lagrange_cli.run.prepare import prepare_run
from lagrange_cli.run.request import CSV
from lagrange_cli.run.resume import Start, begun
from lagrange_cli.run.settings.settings import tell_empty
from lagrange_cli.run.writing import checkpoint, complete, layout_of

if TYPE_CHECKING:
    import numpy as np

    from lagrange_cli.integrate.checkpoint import Progress
    from lagrange_cli.integrate.outcome import Outcome
    from lagrange_cli.integrate.prepared import Prepared
    from lagrange_cli.integrate.times import Times
    from lagrange_cli.run.certify import Demand
    from lagrange_cli.run.request import Request
    from lagrange_cli.store.layout import Layout
    from lagrange_cli.store.resume import Earlier
    from lagrange_cli.store.target import Target
    from lagrange_cli.store.writer import Writer


@dataclass(frozen=True)
class Solved:
    """A motion that was followed: how the run started, and how it ended.

    ``start`` has the target that was written. ``outcome`` is None if an earlier run had ``finished`` (see
    ``start``), or if the reader of the table has gone. ``cached`` tells that the compiled code is that of an
    earlier run.
    """

    motion: Motion
    start: Start
    outcome: Outcome | None = None
    cached: bool = False


def solve(
    motion: Motion,
    target: Target,
    request: Request,
    monitor: Monitor = SILENT,
    *,
    demand: Demand | None = None,
    stream: BinaryIO | None = None,
) -> Solved:
    """Derive, compile and integrate a motion, and write it to ``target``, or as a table to ``stream``.

    With a ``demand`` the output holds an estimate of the error of every sample. However the motion ends, what
    was computed is written.

    Raises:
        SpecError: no equations of motion can be derived, or they are too large.
        FileError: the output cannot be written, or an earlier run is in the way.
    """
    if request.resume:
        from lagrange_cli.run.extend import as_before

        motion = replace(motion, settings=as_before(target, motion.settings, request))
    prepare = prepare_run
    if demand is None and motion.may_be_stiff:
        from lagrange_cli.run.trial import settled

        motion, prepare = settled(motion, request, monitor.stage)
    made_by = origin(
        motion.spec, motion.settings, dict(motion.values.parameters), initial_state(motion.values)
    )
    if demand is not None:
        made_by |= demand.attributes()
    with nullcontext() if stream is not None else target.claimed():
        start = begun(target, made_by, request, monitor)
        if start.finished is not None:
            return Solved(motion, start)
        ready = prepare_all(motion, request, demand, monitor.stage, prepare)
        outcome, written = integrate_and_write(ready, start, request, monitor, demand, stream)
    return Solved(motion, replace(start, target=written), outcome, ready.prepared.cached)


def integrate_and_write(
    ready: Ready,
    start: Start,
    request: Request,
    monitor: Monitor,
    demand: Demand | None,
    stream: BinaryIO | None,
) -> tuple[Outcome | None, Target]:
    """Integrate chunk by chunk into the output, however the motion ends; None if its reader has gone.

    The output may have another name than that of the start (see ``Target.publish``).
    """
    with monitor.stage("write"):
        layout = layout_of(ready, units_of(ready.motion.spec, monitor.tell))
        if stream is None:
            layout.check_size(ready.times.count)
    tell_empty(ready.motion.spec, ready.motion.settings, monitor.tell)
    if ready.motion.spec.forces.get("dissipation"):
        from lagrange_cli.run.doubtful import tell_dissipation

        tell_dissipation(ready.motion.spec, ready.motion.values.parameters, monitor.tell)
    if request.format == CSV:
        from lagrange_cli.run.tabulate import tabulate

        return tabulate(ready, layout.series, start.target, monitor, demand, stream)
    return record(ready, layout, start, request, monitor, demand)


def record(
    ready: Ready, layout: Layout, start: Start, request: Request, monitor: Monitor, demand: Demand | None
) -> tuple[Outcome, Target]:
    """Integrate into an HDF5 file, with checkpoints."""
    from lagrange_cli.integrate.checkpoint import Checkpointing, Schedule
    from lagrange_cli.store.writer import Writer

    prepared, times, stage = ready.prepared, ready.times, monitor.stage
    with monitor.interrupts() as interrupted:
        with stage("write"):
            writer = Writer(start.target, layout, times)

        def emit_chunk(chunk: dict[str, np.ndarray]) -> None:
            with stage("write"):
                writer.append(chunk)

        def emit_events(chunk: dict[str, np.ndarray]) -> None:
            with stage("write"):
                writer.append_crossings(chunk)

        def write_checkpoint(reached: Progress) -> None:
            with stage("write"):
                writer.keep(checkpoint(start, writer, reached))

        with writer:
            begin = None
            if start.earlier is not None:
                with stage("write"):
                    begin = replay(start.earlier, writer, layout, prepared, times)
            steps = 0 if begin is None else begin.snapshot.steps
            schedule = Schedule(request.checkpoint, request.checkpoint_count, steps)
            checkpointing = None if demand is not None else Checkpointing(begin, schedule, write_checkpoint)
            outcome = follow(ready, demand, monitor, emit_chunk, interrupted, emit_events, checkpointing)
            with stage("write"):
                complete(writer, start, outcome, ready.motion.settings)
    return outcome, writer.target


def in_force(prepared: Prepared, data: Any) -> Prepared:
    """What the method is prepared with that an earlier run has come by to such progress; raises
    ``ValueError``."""
    from lagrange_cli.integrate.checkpoint import changes_in

    changes = changes_in(data)
    if not changes:
        return prepared
    from lagrange_cli.integrate.changing import Changing

    if not isinstance(prepared.follower, Changing):
        raise ValueError("of another method")
    return prepared.follower.prepared(changes)


def replay(earlier: Earlier, writer: Writer, layout: Layout, prepared: Prepared, times: Times) -> Progress:
    """Append what an earlier run had written; returns how far it had come."""
    from lagrange_cli.integrate.checkpoint import Progress
    from lagrange_cli.run.extend import samples_before
    from lagrange_cli.store.checkpoint import damaged

    rows = layout.chunk_rows(samples_before(earlier))
    checkpoint = earlier.checkpoint
    data, arrays = checkpoint.head.get("progress"), checkpoint.arrays
    try:
        program = in_force(prepared, data).machine.program
        progress = Progress.from_data(data, arrays, program, prepared.recording.conserved, times)
    except ValueError as error:
        raise damaged(earlier.shown) from error
    crossings: list[int] = []
    if progress.happened:
        from lagrange_cli.run.events import counts

        crossings = counts(prepared, progress.happened)
    writer.restore(earlier, rows, progress.snapshot.samples, crossings)
    return progress
