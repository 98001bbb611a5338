"""From samples of the state to the datasets of the output: ``integrate`` computes a prepared motion."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import TYPE_CHECKING

from lagrange_cli.decimals import decimal
from lagrange_cli.expression.vocabulary import velocity_name
from lagrange_cli.integrate.arrays import Array
from lagrange_cli.integrate.background import Pipelined
from lagrange_cli.integrate.checkpoint import Checkpointing, Progress
from lagrange_cli.integrate.ending import Ending, State
from lagrange_cli.integrate.event_log import EventLog
from lagrange_cli.integrate.method import Cause, CheckpointSink, End, Observer, Snapshot, Start
from lagrange_cli.integrate.outcome import Estimated, Outcome
from lagrange_cli.integrate.prepared import Prepared
from lagrange_cli.integrate.samples import samples_of
from lagrange_cli.integrate.times import Times
from lagrange_cli.records import replace

if TYPE_CHECKING:
    from lagrange_cli.integrate.certify.certificate import Certificate
    from lagrange_cli.spec.values import Values

__all__ = ["Ending", "Outcome", "Prepared", "Times", "integrate"]

USUAL = 1e-9
"""A drift of h of up to this part of its size needs no explanation."""


def integrate(
    prepared: Prepared,
    values: Values,
    times: Times,
    emit: Callable[[dict[str, Array]], None],
    interrupted: Callable[[], bool],
    progress: Callable[[float], None] = lambda t: None,
    checkpointing: Checkpointing[Progress] | None = None,
    certificate: Certificate | None = None,
    explain: Callable[[End], Cause | None] = lambda end: None,
    emit_events: Callable[[dict[str, Array]], None] = lambda chunk: None,
    threads: int | None = 1,
) -> Outcome:
    """Follow the motion from the initial state of ``values``; ``emit`` gets chunks {path: samples},
    ``t`` among them.

    ``interrupted`` and ``progress`` are called with the time reached several times a second. ``emit`` is
    called in another thread, one chunk at a time, while the next one is computed; the arrays are valid during
    the call only. However the motion ends, all samples up to then have been emitted. With ``checkpointing``
    the motion goes on where an earlier run has got to. With a ``certificate`` its estimates are emitted, too,
    and the motion ends where that misses its target. ``explain`` says what in the system ended a motion that
    could not go on. Crossings of events go to ``emit_events`` in the same way as chunks, as {path: rows}:
    those up to a sample before this sample. So many ``threads`` may share the work of a large system (None:
    one on each processor); nothing else depends on them.
    """
    assert prepared.compilation.backward == times.backward
    start = Start.of(prepared.machine.program, values, times)

    def interrupt(t: float) -> bool:
        progress(t)
        return interrupted() or (certificate is not None and certificate.missed is not None)

    further: Progress | None = None
    with Pipelined() as pipeline:

        def emit_pipelined(chunk: dict[str, Array]) -> None:
            pipeline.call(partial(emit, chunk if certificate is None else {**chunk, **certificate.errors}))

        def accept(times: Array, states: Array) -> None:
            log.hand_over()
            judge = None
            if certificate is not None:
                judge = partial(certificate.judge, times, states, interrupted=interrupted)
            count = samples.accept(times, states, judge)
            if count:
                samples.final = state_of(float(times[count - 1]), states[:, count - 1], prepared)

        def reached(snapshot: Snapshot) -> Progress:
            return replace(samples.progress(snapshot), happened=log.happened)

        samples = samples_of(prepared)(prepared, start.parameters, emit_pipelined)
        log = EventLog(prepared, samples, lambda chunk: pipeline.call(partial(emit_events, chunk)))
        observer = Observer(accept, interrupt, log)
        if checkpointing is not None:

            def keep(snapshot: Snapshot) -> None:
                log.hand_over()
                pipeline.wait()
                checkpointing.keep(reached(snapshot), snapshot.steps)

            def ends(snapshot: Snapshot) -> None:
                nonlocal further
                further = reached(snapshot)

            begin = None
            if checkpointing.begin is not None:
                begin = samples.restore(checkpointing.begin)
                log.restore(checkpointing.begin.happened)
            observer = replace(observer, checkpoints=CheckpointSink(begin, checkpointing.due, keep, ends))
        end = prepared.follower.follow(start, observer, threads)
        log.hand_over()
    own_end = (end.ending is not Ending.COMPLETE and certificate is None) or samples.final is None
    if certificate is not None:
        end = certified(end, certificate)
    h_drift, p_drift = samples.drifts()
    return Outcome(
        ending=end.ending,
        message=sentence(replace(end, cause=explain(end)), prepared.recording.coordinates, times.start),
        t=end.t,
        steps=end.steps,
        evaluations=end.evaluations,
        h_drift=h_drift,
        h_size=samples.size,
        h_rounding=samples.rounding() if h_drift and h_drift > USUAL * samples.size else 0.0,
        p_drift=p_drift,
        undetected=prepared.recording.undetected,
        left_out=prepared.recording.left_out,
        undefined=prepared.recording.undefined,
        unknown=samples.unknown,
        happened=dict(zip(log.names, log.happened)),
        progress=further if end.snapshot is None else reached(end.snapshot),
        estimated=None if certificate is None else estimated(certificate),
        projections=end.projections,
        singular=end.singular,
        threads=end.threads,
        extent=samples.extent,
        changes=end.changes,
        final=state_of(end.t, end.state, prepared) if own_end else samples.final,
    )


def state_of(t: float, state: Array, prepared: Prepared) -> State:
    """A state by names; ``state`` (rows,) begins with q and v."""
    names, layout = prepared.recording.coordinates, prepared.machine.program.state
    q, v = state[layout.q].tolist(), state[layout.v].tolist()
    return State(t, dict(zip(names, q)), dict(zip(names, v)))


def estimated(certificate: Certificate) -> Estimated:
    """The results of a certificate for the run as a whole."""
    written, run = certificate.written, certificate.run
    return Estimated(
        written.trusted_until,
        written.error,
        run.trusted_until,
        run.error,
        certificate.rounded if certificate.prevailing else None,
        certificate.staying,
    )


def certified(end: End, certificate: Certificate) -> End:
    """How the motion ended, with its certificate taken into account. It cannot be continued, as companions
    have no snapshot."""
    if certificate.missed is not None:
        return replace(end, ending=Ending.TARGET_MISSED, t=certificate.missed, snapshot=None)
    ending = Ending.INTERRUPTED if certificate.cut and end.ending is Ending.COMPLETE else end.ending
    return replace(end, ending=ending, snapshot=None)


def sentence(end: End, coordinates: tuple[str, ...], start: float) -> str:
    """How the motion that began at ``start`` ended, for the user, with time and state where it went wrong."""
    if end.ending is Ending.COMPLETE:
        return f"{end.ending.value}, t = {decimal(end.t)}"
    if end.ending is Ending.STOPPED:
        return f"{end.ending.value}, {end.detail}, at t = {decimal(end.t, 9)}"
    if end.ending in (Ending.INTERRUPTED, Ending.TARGET_MISSED):
        return f"{end.ending.value} at t = {decimal(end.t)}"
    if end.ending is Ending.INCONSISTENT:
        return f"{end.ending.value}"
    shown = [f"{name} = {decimal(value)}" for name, value in zip(coordinates, end.state)]
    shown += [
        f"{velocity_name(name)} = {decimal(value)}"
        for name, value in zip(coordinates, end.state[len(coordinates) :])
    ]
    listed = ", ".join(shown[:8]) + (", ..." if len(shown) > 8 else "")
    detail = f" ({end.detail})" if end.detail else ""
    ending = (end.cause and end.cause.ending) or end.ending
    way_out = ending.way_out(at_start=end.t == start)
    if end.cause is not None:
        return f"{end.cause.text} at t = {decimal(end.cause.t, 9)}, where {listed}; {way_out}"
    return f"{end.ending.value} at t = {decimal(end.t, 9)}, where {listed}{detail}; {way_out}"
