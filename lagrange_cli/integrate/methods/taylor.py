"""The Taylor method: compiled code steps and samples, this module hands it buffers."""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import TYPE_CHECKING

import numpy as np

from lagrange_cli.integrate.arrays import Array, aligned, chunk_size
from lagrange_cli.integrate.compilation import Compilation
from lagrange_cli.integrate.ending import Ending
from lagrange_cli.integrate.events import NO_EVENTS, EventSink
from lagrange_cli.integrate.method import NO_CHECKPOINTS, Accept, CheckpointSink, End, Interrupt, Snapshot
from lagrange_cli.integrate.methods.recompilation import Recompilation
from lagrange_cli.integrate.times import Times
from lagrange_cli.native.compilation.machine import Machine
from lagrange_cli.native.interface import DUE, INFO, Interface, Stop
from lagrange_cli.native.state import LANES, Clock
from lagrange_cli.records import dataclass, replace

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from lagrange_cli.integrate.methods.happenings import Finished, Happenings
    from lagrange_cli.integrate.methods.settling import Settling

ENDINGS = {
    Stop.END: Ending.COMPLETE,
    Stop.SINGULAR: Ending.SINGULAR_MASS_MATRIX,
    Stop.NOT_FINITE: Ending.NOT_A_NUMBER,
    Stop.UNDERFLOW: Ending.STEP_UNDERFLOW,
    Stop.GUARD: Ending.STEP_UNDERFLOW,
}
GREAT = 1e280
"""Where coordinates or velocities are as large as this, coefficients of their series overflow."""
POLL_SECONDS = 0.05
"""Seconds of machine code between two looks at the world outside, about."""
FIRST_STEPS = 0.5, 0.8
"""Parts of their first step that companions take."""
FEWEST = 64
"""Steps that are taken at least between them."""


@dataclass(frozen=True)
class Beside:
    """How the ``number``-th companion of a run differs from it (see ``integrate.certify.companion``): its
    first step is shorter, the momenta that it keeps are rounded otherwise (``perturbation``), and it begins
    ``late`` by so little time."""

    number: int
    late: float = 0.0


@dataclass(frozen=True)
class TaylorMethod:
    """Follows a motion by its Taylor series (``native.stepping``); steps do not depend on sample times."""

    machine: Machine
    recompilation: Recompilation | None = None
    """Code for long runs, where that of ``machine`` was compiled in a hurry."""
    beside: Beside | None = None
    """How it differs from that of a run, if it is for a companion."""

    def follow(
        self,
        parameters: Array,
        state: Array,
        times: Times,
        accept: Accept,
        interrupt: Interrupt,
        checkpoints: CheckpointSink = NO_CHECKPOINTS,
        events: EventSink = NO_EVENTS,
    ) -> End:
        """See ``integrate.method.Method``; ``evaluations`` counts series, one a step."""
        program = self.machine.program
        size = min(chunk_size(program.parts * (program.rows + len(program.observed))), times.count)
        stepper = Stepper(
            self.machine,
            parameters,
            state,
            times,
            size,
            self.recompilation,
            beside=self.beside,
            events=events,
        )
        first = 0
        if checkpoints.begin is not None:
            first = checkpoints.begin.samples
            stepper.restore(checkpoints.begin)
        halted = False

        def pause(t: float) -> bool:
            nonlocal halted
            halted = interrupt(t)
            return halted or checkpoints.due(stepper.steps)

        while True:
            wanted = times.chunk(first, size)
            last = first + len(wanted) == times.count
            before_end = last and checkpoints.ends is not None and program.parts == 1 and len(wanted) > 0
            stop, done = stepper.fill(wanted, first, last and not before_end, pause)
            first += done
            samples = stepper.taken(done)
            if before_end and stop is Stop.SAMPLES:
                kept = int(np.count_nonzero(stepper.passed(wanted)))
                accept(wanted[:kept], samples[:, :kept])
                begin = first - done
                known = kept > 0 or begin == 0 or bool(stepper.passed(times.chunk(begin - 1, 1))[0])
                if checkpoints.ends is not None and known and not stepper.limited:
                    checkpoints.ends(stepper.snapshot(begin + kept))
                wanted, samples, done = wanted[kept:], samples[:, kept:], done - kept
                stop, _ = stepper.fill(wanted[done:], first, True, pause)
            accept(wanted[:done], samples)
            if stepper.finished is not None:
                ending, detail = stepper.finished.ending, stepper.finished.detail
                return End(ending, stepper.t, stepper.state, stepper.steps, stepper.steps, detail)
            if stop is Stop.NOT_FINITE and stepper.finite():
                stop = (
                    Stop.UNDERFLOW
                )  # the equations are, but a singularity is so near that the series is not
            if stop in ENDINGS:
                end = End(ENDINGS[stop], stepper.t, stepper.state, stepper.steps, stepper.steps)
                return end if stop is Stop.END else stopped(end, stepper.accelerations())
            if stop is Stop.PAUSE or pause(stepper.t):
                snapshot = stepper.snapshot(first)
                if halted:
                    t, state = stepper.t, stepper.state
                    if stop is not Stop.PAUSE:  # the step that holds the last sample began before it
                        t, state = float(wanted[-1]), samples[:, -1].copy()
                    return End(Ending.INTERRUPTED, t, state, stepper.steps, stepper.steps, snapshot=snapshot)
                checkpoints.keep(snapshot)
            stepper.swap()


class Stepper:
    """The arrays that ``@advance`` works on; ``samples`` (rows, size + LANES) holds what ``fill`` has
    made."""

    def __init__(
        self,
        machine: Machine,
        parameters: Array,
        state: Array,
        times: Times,
        size: int,
        recompilation: Recompilation | None = None,
        *,
        beside: Beside | None = None,
        events: EventSink = NO_EVENTS,
    ) -> None:
        program = machine.program
        self._machine, self._recompilation = machine, recompilation
        self._layout, self._stop = program.inner, times.stop
        self._constants = aligned(max(1, program.constants))
        self._memory, self._work = aligned(self._layout.memory), aligned(program.work)
        self._trial = aligned(program.trial)
        self._outer = outer_rows(program)
        for part, given in enumerate(state.reshape(program.parts, -1)):
            self._memory[self._layout.part(part)][self._outer] = given
        self._memory[self._layout.time] = times.start
        if beside is not None:
            self._memory[self._layout.at(Clock.TIME_LOW)] = beside.late
        self._settling: Settling | None = None
        self._happenings: Happenings | None = None
        self.finished: Finished | None = None
        """That an event has ended the motion, if one has."""
        self._info = np.zeros(INFO, dtype=np.int64)
        if not program.guarded:
            machine.prepare(np.ascontiguousarray(parameters).ctypes.data, self._constants.ctypes.data)
        else:
            from lagrange_cli.integrate.methods.settling import Settling

            self._settling = Settling(machine, self._constants, self._memory, self._work)
            self._settling.begin(parameters)
        if program.events:
            assert self._settling is not None
            from lagrange_cli.integrate.methods.happenings import Happenings
            from lagrange_cli.integrate.methods.sides import Sides

            sides = Sides(self._settling, self._outer)
            self._happenings = Happenings(sides, self._trial, self._info, times.start, events)
            self.finished = self._happenings.begin()
        if beside is not None:
            from lagrange_cli.integrate.methods.perturbation import perturb

            self._rates()  # computes the cyclic momenta
            perturb(self._memory[self._layout.cyclic_momenta], parameters)
        self.limited = False
        """Whether a step that was taken, or tried, might have been another one if the motion ended later."""
        self._pause = 4 * FEWEST
        self.samples = np.empty((program.parts * self._layout.rows, size + LANES))
        self._first = None if beside is None else self._short_step(beside.number)
        self._spare: Array | None = None
        self.steps = 0

    def swap(self) -> None:
        """Leave ``samples`` as they are until the next ``swap``: go on in other memory."""
        spare = np.empty_like(self.samples) if self._spare is None else self._spare
        self.samples, self._spare = spare, self.samples

    def snapshot(self, samples: int) -> Snapshot:
        """Where the motion is, so many samples having been handed over."""
        actions = () if self._happenings is None else self._happenings.state()
        return Snapshot(self._memory.copy(), self.t, self.steps, samples, self.limited, actions)

    def restore(self, snapshot: Snapshot) -> None:
        """Go on from there."""
        self._memory[:], self.steps, self.limited = snapshot.memory, snapshot.steps, snapshot.limited
        if self._settling is not None:
            self._settling.resume()
        if self._happenings is not None:
            self._happenings.restore(snapshot.actions)

    @property
    def t(self) -> float:
        """The time reached."""
        return float(self._memory[self._layout.time])

    def passed(self, times: Array) -> NDArray[np.bool_]:
        """Which of some instants are not after the time reached."""
        return np.asarray(times - self.t - self._memory[self._layout.at(Clock.TIME_LOW)] <= 0)

    @property
    def state(self) -> Array:
        """q, v and the integrals at that time."""
        return np.array(self._memory[self._layout.part(0)][self._outer])

    def taken(self, done: int) -> Array:
        """The samples that ``fill`` has made: rows q, v and the integrals, of every part."""
        samples = self.samples[:, :done]
        if not self._machine.program.auxiliary:
            return samples
        parts = self._machine.program.parts
        rows = samples.reshape(parts, self._layout.rows, done)[:, self._outer]
        return np.ascontiguousarray(rows.reshape(parts * len(self._outer), done))

    def finite(self) -> bool:
        """Whether the accelerations are finite at the state reached."""
        return bool(np.all(np.isfinite(self._rates()[self._layout.q])))

    def accelerations(self) -> Array:
        """Those of the coordinates at the state reached."""
        return self._rates()[: self._machine.program.degrees]

    def _rates(self) -> Array:
        """The rates of velocities and integrals there."""
        self._work[:] = 0.0  # what is not finite would spread
        rates = np.empty(self._layout.rows)
        self._machine.accelerate(
            self._constants.ctypes.data,
            self.t,
            self._memory.ctypes.data,
            self._work.ctypes.data,
            rates.ctypes.data,
        )
        return rates

    def _advance(self, stop: float, wanted: Array, done: int, count: int, last: bool, pause: int) -> Stop:
        assert self._machine.advance is not None
        return Stop(
            self._machine.advance(
                self._constants.ctypes.data, self._memory.ctypes.data, self._work.ctypes.data,
                self._trial.ctypes.data, stop, wanted.ctypes.data + 8 * done, count,
                self.samples.ctypes.data + 8 * done, self.samples.shape[1], last, pause,
                self._info.ctypes.data,
            )
        )  # fmt: skip

    def _short_step(self, number: int) -> float | None:
        """Where the first step of the ``number``-th companion ends: what all have rounded alike at the start,
        of the same state, counts for less the shorter it is."""
        start, memory = self.t, self._memory.copy()
        self._advance(self._stop, np.full(LANES, np.nan), 0, 0, True, 1)
        reached, self._usual = self.t, self._memory[self._layout.remembered].copy()
        self._memory[:], self._info[:] = memory, 0
        if self._settling is not None:
            self._settling.resume()  # the step may have changed modes
        return start + FIRST_STEPS[number - 1] * (reached - start) if reached > start else None

    def fill(self, wanted: Array, first: int, last: bool, interrupt: Interrupt) -> tuple[Stop, int]:
        """Step until all of ``wanted``, the samples from ``first`` on, are taken (``last``: until the end);
        why it stopped, and how many are. An event may have ``finished`` the motion."""
        if self.finished is not None:
            return Stop.GUARD, 0
        padded = np.concatenate([wanted, np.full(LANES, np.nan)])
        done = 0
        while True:
            began = time.perf_counter()
            if self._first is None:
                stop = self._advance(self._stop, padded, done, len(wanted) - done, last, self._pause)
            else:
                early = np.where(padded <= self._first, padded, np.nan)
                count = int(np.count_nonzero(np.isfinite(early)))
                stop = self._advance(self._first, early, done, count - done, True, 1)
                self._memory[self._layout.remembered] = self._usual
                self._first = None
                stop = Stop.PAUSE if stop is Stop.END else stop
            before = first + done
            done, self.steps = done + int(self._info[0]), self.steps + int(self._info[1])
            self.limited |= bool(self._info[2])
            if self._settling is not None and self._goes_on(stop, before, first + done):
                if not interrupt(self.t):
                    continue
                stop = Stop.PAUSE
            if stop is not Stop.PAUSE or interrupt(self.t):
                return stop, done
            spent = time.perf_counter() - began
            if self._recompilation is not None:
                self._machine = self._recompilation.after(spent) or self._machine
                assert self._machine.advance is not None
            self._pause = int(
                max(FEWEST, min(4 * self._pause, self._pause * POLL_SECONDS / max(spent, 1e-6)))
            )

    def _goes_on(self, stop: Stop, began: int, sample: int) -> bool:
        """Whether the motion goes on from where compiled code has stopped, before that sample; it was called
        before the one where it ``began``."""
        assert self._settling is not None
        due = int(self._info[DUE])
        if self._happenings is not None:
            self.finished = self._happenings.drain(began)
            if stop is Stop.GUARD and due >= self._settling.count and self.finished is None:
                self.finished = self._happenings.happen(due, sample)
                return self.finished is None
            if self.finished is not None:
                return False
        return self._settling.goes_on(stop, due)


def stopped(end: End, accelerations: Array) -> End:
    """How a motion ended that could not go on."""
    if end.ending in (Ending.STEP_UNDERFLOW, Ending.NOT_A_NUMBER) and np.max(np.abs(end.state)) > GREAT:
        return replace(end, ending=Ending.OVERFLOW)
    return replace(end, accelerations=accelerations)


def outer_rows(program: Interface) -> NDArray[np.intp]:
    """The rows of q, v and the integrals among those that steps have."""
    inner, own = program.inner, program.degrees
    integrals = np.arange(inner.integrals.start, inner.rows)
    return np.concatenate([np.arange(own), inner.degrees + np.arange(own), integrals])


def follower(
    machine: Machine, compilation: Compilation, improve: Callable[[], Machine] | None
) -> TaylorMethod:
    """The method on a compiled program; ``improve`` makes better code for a long run, if any."""
    return TaylorMethod(machine, None if improve is None else Recompilation(improve))
