"""``Stepper``: the arrays of one motion that compiled code steps and samples in, and the calls of it."""

from __future__ import annotations

import time
from contextlib import AbstractContextManager, nullcontext
from typing import TYPE_CHECKING

import numpy as np

from lagrange_cli.integrate.arrays import Array, aligned
from lagrange_cli.integrate.ending import Ending
from lagrange_cli.integrate.events import NO_EVENTS, EventSink, Judge, no_energy
from lagrange_cli.integrate.method import Interrupt, Snapshot, Unfit
from lagrange_cli.integrate.methods.crawling import crawls, steps_to_mark
from lagrange_cli.integrate.methods.recompilation import Recompilation
from lagrange_cli.integrate.times import Times
from lagrange_cli.native.compilation.machine import Machine
from lagrange_cli.native.interface import DUE, HALTED, INFO, Interface, Stop
from lagrange_cli.native.state import BEGINNING, CARRIED_COUNT, LANES, Clock, Role
from lagrange_cli.records import dataclass

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from lagrange_cli.integrate.methods.happenings import Finished, Happenings
    from lagrange_cli.integrate.methods.settling import Settling

POLL_SECONDS = 0.05
"""Seconds of machine code between two looks at the world outside, about."""
HEEDED = 5
"""The number of times that a stop is asked for after a signal."""
FIRST_STEPS = 0.5, 0.8
"""Parts of their first step that companions take."""
FIRST = 256
"""Steps that are taken before the first."""
KEPT = 4
"""The beginnings of this many calls of compiled code are kept."""
MOST_STEPS = 1 << 40
"""More than are ever taken at once."""


@dataclass(frozen=True)
class Beside:
    """How the ``number``-th companion of a run differs from it (see ``integrate.certify.companion``): its
    first step is shorter, the momenta that it keeps are rounded otherwise (``perturbation``), and it begins
    ``late`` by so little time."""

    number: int
    late: float = 0.0


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
        jumping: Judge = no_energy,
        every: int = 0,
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
        """Set when an event has ended the motion."""
        self._info = np.zeros(INFO, dtype=np.int64)
        if not program.guarded:
            machine.prepare(np.ascontiguousarray(parameters).ctypes.data, self._constants.ctypes.data)
        else:
            from lagrange_cli.integrate.methods.settling import Settling

            self._settling = Settling(machine, self._constants, self._memory, self._work)
            self._settling.span = abs(times.stop - times.start)
            self._settling.begin(parameters)
            if self._settling.begins_beyond():
                from lagrange_cli.integrate.methods.happenings import Finished

                self.finished = Finished(Ending.CUT, "")
        if program.events:
            assert self._settling is not None
            from lagrange_cli.integrate.methods.happenings import Happenings
            from lagrange_cli.integrate.methods.sides import Sides

            sides = Sides(self._settling, self._outer)
            self._happenings = Happenings(sides, self._trial, self._info, times.start, events, jumping)
            self.finished = self.finished or self._happenings.begin()
        if beside is not None:
            from lagrange_cli.integrate.methods.perturbation import perturb

            self._rates()  # computes the cyclic momenta
            perturb(self._memory[self._layout.cyclic_momenta], parameters)
        self.limited = False
        """Whether a step that was taken, or tried, might have been another one if the motion ended later."""
        self._pause = 1 if program.integrals else FIRST  # a step may be divided very often for integrals
        self.samples = np.empty((program.parts * self._layout.rows, size + LANES))
        self._first = None if beside is None else self._short_step(beside.number)
        self._spare: Array | None = None
        self.steps, self._every = 0, every
        self._start, self._marked = times.start, 0
        self._earlier: list[Array] = []
        """The memory at the last calls of compiled code."""
        self.singular: tuple[float, ...] = ()
        """The times at which the motion passed singular configurations."""

    def swap(self) -> None:
        """Leave ``samples`` as they are until the next ``swap``: go on in other memory."""
        spare = np.empty_like(self.samples) if self._spare is None else self._spare
        self.samples, self._spare = spare, self.samples

    def snapshot(self, samples: int) -> Snapshot:
        """The present place of the motion, after that many samples."""
        actions = self.singular if self._happenings is None else self._happenings.state()
        return Snapshot(self._memory.copy(), self.t, self.steps, samples, self.limited, actions)

    def restore(self, snapshot: Snapshot) -> None:
        """Go on from there; raises ``Unfit``."""
        if snapshot.memory.shape != self._memory.shape:
            raise Unfit
        self._memory[:], self.steps, self.limited = snapshot.memory, snapshot.steps, snapshot.limited
        self._marked = self.steps
        if self._settling is not None:
            self._settling.resume()
        if self._happenings is not None:
            self._happenings.restore(snapshot.actions)
        else:
            self.singular = snapshot.actions

    @property
    def evaluations(self) -> int:
        """How often series, or rates, were computed for the steps taken."""
        at = self._layout.carried_at + CARRIED_COUNT
        return self.steps + (int(self._memory[at]) if self._layout.carried else 0)

    @property
    def projections(self) -> int:
        """How often the state was moved back to the constraints."""
        return int(self._memory[self._layout.at(Clock.PROJECTIONS)])

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
        """The accelerations of the coordinates at the state reached."""
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
            if self._passes:
                self._earlier = [*self._earlier[1 - KEPT :], self._memory.copy()]
            if self._first is None:
                pause = min(self._pause, steps_to_mark(self.steps))
                if self._every:
                    pause = min(pause, self._every - self.steps % self._every)
                stop = self._advance(self._stop, padded, done, len(wanted) - done, last, pause)
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
            if stop is Stop.PAUSE and self._marks(self.steps):
                return Stop.CRAWL, done
            if self._settling is not None and self._goes_on(stop, before, first + done):
                if not interrupt(self.t):
                    continue
                stop = Stop.PAUSE
            if self._passes and stop in (Stop.SINGULAR, Stop.UNDERFLOW, Stop.NOT_FINITE):
                passed = self._passed(padded[done : len(wanted)])
                if passed is not None:
                    self.samples[:, done : done + passed.shape[1]] = passed
                    done += passed.shape[1]
                    stop = Stop.PAUSE
            if stop is not Stop.PAUSE or interrupt(self.t) or self._halted(interrupt):
                return stop, done
            spent = time.perf_counter() - began
            if self._recompilation is not None:
                self._machine = self._recompilation.after(spent) or self._machine
                assert self._machine.advance is not None
            self._pause = int(
                max(1, min(4 * self._pause, MOST_STEPS, self._pause * POLL_SECONDS / max(spent, 1e-6)))
            )

    def _marks(self, steps: int) -> bool:
        """Record the progress of the motion, if that is due. Returns whether it crawls."""
        if steps == self._marked or steps_to_mark(steps - 1) != 1:
            return False
        self._marked = steps
        clock = self._memory[self._layout.clock]
        return crawls(clock, steps, abs(self.t - self._start), self._stop)

    def heard(self) -> AbstractContextManager[None]:
        """A context in which a signal ends a step that is divided for integrals, which may take long."""
        if not self._machine.program.integrals:
            return nullcontext()
        from lagrange_cli.integrate.hearing import asked_by

        return asked_by(self._info)

    def _halted(self, interrupt: Interrupt) -> bool:
        """Whether a signal that a step was left for ends the run. In another thread than the main one, this
        is known a little later."""
        for _ in range(HEEDED if self._info[HALTED] else 0):
            if interrupt(self.t):
                return True
            time.sleep(POLL_SECONDS)
        self._info[HALTED] = 0
        return False

    @property
    def _passes(self) -> bool:
        """Whether it is tried to pass singular configurations: of smooth motions in doubles."""
        program = self._machine.program
        return program.constraints > 0 and program.parts == 1 and self._settling is None

    def _passed(self, wanted: Array) -> Array | None:
        """Pass a singular configuration; the samples (rows, n) on the way."""
        from lagrange_cli.integrate.methods.passing import ACCELERATED, SATISFIED, passages

        layout, there = self._layout, self._memory.copy()
        origin = next((one for one in self._earlier if one[layout.time] < self.t), None)
        if origin is None:
            return None
        longest = self.t - float(origin[layout.time])
        place = layout.at(Clock.PROJECTIONS)
        for way in passages(self.t, longest, lambda times: self._again(origin, times)):
            if not way.stop < self._stop:
                continue
            reached = way.at(np.array([way.stop]))[:, 0]
            self._memory[:] = there
            self._memory[layout.part(0)] = reached
            for rest in (layout.part(1), slice(layout.third, layout.third + layout.width)):
                self._memory[rest] = 0.0
            self._memory[[layout.at(one) for one in (*BEGINNING, Clock.REFUSED, Clock.REFUSED_BEYOND)]] = 0.0
            self._memory[layout.time], self._memory[layout.at(Clock.TIME_LOW)] = way.stop, 0.0
            assert self._machine.project is not None
            for _ in range(KEPT):
                self._machine.project(self._constants.ctypes.data, self._memory.ctypes.data)
            moved = np.abs(self._memory[layout.motion] - reached[layout.motion])
            scale = float(np.max(np.abs(reached[layout.motion])))
            rates, due = self._rates()[layout.q], way.rates(way.stop)[layout.v]
            size = float(np.max(np.abs(due))) + scale
            near = float(np.max(moved)) <= SATISFIED * scale
            if near and float(np.max(np.abs(rates - due))) <= ACCELERATED * size:
                self._memory[place] = there[place] + 1
                self.steps += 1
                self.singular = (*self.singular, float(there[layout.time]))
                self._earlier = []
                return way.at(wanted[wanted <= way.stop])
        self._memory[:] = there
        return None

    def _again(self, origin: Array, times: Array) -> Array | None:
        """The states (rows, n) at times, on the way from the memory ``origin`` once more."""
        info, samples, memory = self._info.copy(), self.samples, self._memory.copy()
        self._memory[:], self._info[:] = origin, 0
        self.samples = np.empty((self._layout.rows, len(times) + LANES))
        padded = np.concatenate([times, np.full(LANES, np.nan)])
        stop = self._advance(float(times[-1]), padded, 0, len(times), True, MOST_STEPS)
        found = self.samples[:, : len(times)]
        complete = stop is Stop.END and int(self._info[0]) == len(times)
        self._memory[:], self._info[:], self.samples = memory, info, samples
        return found if complete else None

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
        goes_on = self._settling.goes_on(stop, due)
        guards = self._machine.program.rows_of_guards.guards
        if stop is Stop.GUARD and guards[due].role is Role.BREAK and not goes_on:
            from lagrange_cli.integrate.methods.happenings import Finished

            self.finished = Finished(Ending.CUT, "")
        return goes_on


def outer_rows(program: Interface) -> NDArray[np.intp]:
    """The rows of q, v and the integrals among those that steps have."""
    inner, own = program.inner, program.degrees
    integrals = np.arange(inner.integrals.start, inner.rows)
    return np.concatenate([np.arange(own), inner.degrees + np.arange(own), integrals])
