"""From samples of the state to the datasets of the output: ``integrate`` computes a prepared motion."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import partial
from typing import TYPE_CHECKING

import numpy as np

from lagrange_cli.expression.vocabulary import velocity_name
from lagrange_cli.integrate.background import Behind
from lagrange_cli.integrate.checkpoint import Keeping, Progress
from lagrange_cli.integrate.ending import Ending, Outcome, State
from lagrange_cli.integrate.method import Array, End, Keeper, Snapshot, aligned
from lagrange_cli.integrate.prepared import Prepared
from lagrange_cli.integrate.times import Times
from lagrange_cli.records import replace

if TYPE_CHECKING:
    from lagrange_cli.integrate.certify.certificate import Certificate
    from lagrange_cli.spec.values import Values

__all__ = ["Ending", "Outcome", "Prepared", "Times", "integrate"]

EARLY, RARELY = 4096, 256
"""The size of h's terms is taken from each of the first ``EARLY`` samples, then from every ``RARELY``-th."""


def integrate(
    prepared: Prepared,
    values: Values,
    times: Times,
    emit: Callable[[dict[str, Array]], None],
    interrupted: Callable[[], bool],
    progress: Callable[[float], None] = lambda t: None,
    keeping: Keeping[Progress] | None = None,
    certificate: Certificate | None = None,
) -> Outcome:
    """Follow the motion from the initial state of ``values``; ``emit`` gets chunks {path: samples},
    ``t`` among them.

    ``interrupted`` is asked and ``progress`` told the time reached several times a second. ``emit`` is
    called in another thread, one chunk at a time, while the next one is computed; the arrays are valid during
    the call only. However the motion ends, all samples up to then have been emitted. With ``keeping`` the
    motion goes on where an earlier run has got to; with a ``certificate`` its estimates are emitted, too, and
    the motion ends where that misses its target.
    """
    assert prepared.backward == times.backward
    program = prepared.machine.program
    given = [values] if values.low is None else [values, values.low]
    parameters = np.array([one.parameters[name] for one in given for name in program.parameters], np.float64)
    state = np.concatenate([x for one in given for x in (one.q, one.v, np.zeros(len(program.integrals)))])

    def watch(t: float) -> bool:
        progress(t)
        return interrupted() or (certificate is not None and certificate.missed is not None)

    further: Progress | None = None
    with Behind() as behind:

        def emit_behind(chunk: dict[str, Array]) -> None:
            behind.call(partial(emit, chunk if certificate is None else {**chunk, **certificate.errors}))

        def accept(times: Array, states: Array) -> None:
            count = len(times) if certificate is None else certificate.judge(times, states, interrupted)
            if count:
                samples.final = state_of(float(times[count - 1]), states[:, count - 1], prepared)
            samples.accept(times[:count], states[:, :count])

        samples = samples_of(prepared)(prepared, parameters, emit_behind)
        following = partial(prepared.follower.follow, parameters, state, times, accept, watch)
        if keeping is None:
            end = following()
        else:

            def keep(snapshot: Snapshot) -> None:
                behind.wait()
                keeping.keep(samples.progress(snapshot), snapshot.steps)

            def ends(snapshot: Snapshot) -> None:
                nonlocal further
                further = samples.progress(snapshot)

            begin = None if keeping.begin is None else samples.restore(keeping.begin)
            end = following(Keeper(begin, keeping.due, keep, ends))
    if certificate is not None:
        end = certified(end, certificate)
    h_drift, p_drift = samples.drifts()
    return Outcome(
        ending=end.ending,
        message=sentence(end, prepared.recording.coordinates),
        t=end.t,
        steps=end.steps,
        evaluations=end.evaluations,
        h_drift=h_drift,
        h_size=samples.size,
        p_drift=p_drift,
        undetected=prepared.recording.undetected,
        progress=further if end.snapshot is None else samples.progress(end.snapshot),
        trusted_until=None if certificate is None else certificate.trusted_until,
        error=None if certificate is None else certificate.error,
        final=samples.final or state_of(end.t, end.state, prepared),
    )


def state_of(t: float, state: Array, prepared: Prepared) -> State:
    """A state by names; ``state`` (rows,) begins with q and v."""
    names = prepared.recording.coordinates
    q, v = state[: len(names)].tolist(), state[len(names) : 2 * len(names)].tolist()
    return State(t, dict(zip(names, q)), dict(zip(names, v)))


def samples_of(prepared: Prepared) -> type[Samples]:
    """What makes datasets of numbers of that many parts."""
    if prepared.machine.program.parts == 1:
        return Samples
    from lagrange_cli.integrate.samples import DoubleDoubleSamples

    return DoubleDoubleSamples


def certified(end: End, certificate: Certificate) -> End:
    """How the motion ended, with its certificate taken into account. It cannot be continued, as companions
    have no snapshot."""
    if certificate.missed is not None:
        return replace(end, ending=Ending.TARGET_MISSED, t=certificate.missed, snapshot=None)
    ending = Ending.INTERRUPTED if certificate.cut and end.ending is Ending.COMPLETE else end.ending
    return replace(end, ending=ending, snapshot=None)


class Samples:
    """Turns states into the datasets of the plan, and keeps how far the conserved quantities have drifted.

    What is emitted stays as it is until ``emit`` has been called again.
    """

    def __init__(
        self, prepared: Prepared, parameters: Array, emit: Callable[[dict[str, Array]], None]
    ) -> None:
        self._prepared, self._emit = prepared, emit
        self._constants = aligned(max(1, prepared.machine.program.constants))
        prepared.machine.prepare(np.ascontiguousarray(parameters).ctypes.data, self._constants.ctypes.data)
        self._wide = self._other = np.empty((0, 0))
        self._first: dict[str, float] = {}
        self._drift = dict.fromkeys(prepared.recording.conserved, 0.0)
        self._size, self._count = 0.0, 0
        self.final: State | None = None
        """The last sample, once there is one."""

    def accept(self, times: Array, states: Array) -> None:
        """Compute, emit and forget one chunk: times (c,), states (rows, c)."""
        if not len(times):
            return
        program, recording = self._prepared.machine.program, self._prepared.recording
        observed = self._observe(times, states)
        if not self._first:
            self._first = {name: float(row[0]) for name, row in observed.items()}
        with np.errstate(invalid="ignore"):  # where a quantity has no finite value, neither has its drift
            for name, drift in self._drift.items():
                row, first = observed[name], self._first[name]
                self._drift[name] = max(drift, float(np.max(row)) - first, first - float(np.min(row)))
        self._measure(observed, states)
        self._emit({"t": times, **recording.series(states, program.integrals, observed, self._first)})

    def _measure(self, observed: Mapping[str, Array], states: Array) -> None:
        """Update the size of h's terms from the first samples and some of the others, which do not depend on
        the chunks. Does nothing if the momenta are not observed."""
        coordinates = self._prepared.recording.coordinates
        names = [f"p_{name}" for name in coordinates]
        if "h" not in self._drift or not observed.keys() >= set(names):
            return
        before, count = self._count, states.shape[1]
        self._count += count
        early = min(max(0, EARLY - before), count)
        for part in (slice(early), slice(early + -(before + early) % RARELY, None, RARELY)):
            velocities = states[len(coordinates) : 2 * len(coordinates), part]
            terms = sum(np.abs(observed[name][part] * v) for name, v in zip(names, velocities))
            sizes = np.maximum(np.abs(observed["h"][part]), terms)
            self._size = float(np.max(sizes, initial=self._size))

    def _observe(self, times: Array, states: Array) -> Mapping[str, Array]:
        machine = self._prepared.machine
        names, count = machine.program.quantities, len(times)
        states = states if states.strides[1] == 8 else np.ascontiguousarray(states)
        stride = states.strides[0] // 8
        self._wide, self._other = self._other, self._wide
        if self._wide.shape[1] != stride:  # kept: fresh memory costs as much as what is computed into it
            self._wide = np.empty((len(names), stride))
        if names:
            machine.observe(
                self._constants.ctypes.data, np.ascontiguousarray(times).ctypes.data, states.ctypes.data,
                self._wide.ctypes.data, stride, count,
            )  # fmt: skip
        return dict(zip(names, self._wide[:, :count]))

    def progress(self, snapshot: Snapshot) -> Progress:
        """The progress of the run when the method is at ``snapshot``."""
        return Progress(snapshot, dict(self._first), dict(self._drift), self._size, self.final)

    def restore(self, progress: Progress) -> Snapshot:
        """Continue from the progress of another run."""
        self._first, self._drift = dict(progress.first), dict(progress.drift)
        self._size, self._count = progress.size, progress.snapshot.samples
        self.final = progress.final
        return progress.snapshot

    def drifts(self) -> tuple[float | None, dict[str, float]]:
        """max |x - x(0)| for h (None where it is not conserved or not computed) and for each conserved
        p_k."""
        momenta = {name.removeprefix("p_"): drift for name, drift in self._drift.items() if name != "h"}
        return self._drift.get("h"), momenta

    @property
    def size(self) -> float:
        """How large |h| and sum |p_k q_dot_k| have been, which tells whether a drift of h is rounding; else
        0."""
        return self._size


def sentence(end: End, coordinates: tuple[str, ...]) -> str:
    """How the motion ended, for the user, with time and state where it went wrong."""
    if end.ending is Ending.COMPLETE:
        return f"{end.ending.value}, t = {end.t:.6g}"
    if end.ending in (Ending.INTERRUPTED, Ending.TARGET_MISSED):
        return f"{end.ending.value} at t = {end.t:.6g}"
    shown = [f"{name} = {value:.6g}" for name, value in zip(coordinates, end.state)]
    shown += [
        f"{velocity_name(name)} = {value:.6g}"
        for name, value in zip(coordinates, end.state[len(coordinates) :])
    ]
    listed = ", ".join(shown[:8]) + (", ..." if len(shown) > 8 else "")
    detail = f" ({end.detail})" if end.detail else ""
    return f"{end.ending.value} at t = {end.t:.9g}, where {listed}{detail}; {end.ending.way_out}"
