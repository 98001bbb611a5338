"""``Stepper``: steps one motion from sample to sample; between calls of compiled code it does what is due."""

from __future__ import annotations

import time
from collections.abc import Iterator
from contextlib import AbstractContextManager, contextmanager, nullcontext
from functools import partial
from typing import TYPE_CHECKING

import numpy as np

from lagrange_cli.integrate.arrays import Array
from lagrange_cli.integrate.ending import Ending, Finished
from lagrange_cli.integrate.method import UNOBSERVED, Interrupt, Observer, Snapshot, Start, Unfit
from lagrange_cli.integrate.methods.compiled import CompiledEquations
from lagrange_cli.integrate.methods.crawling import crawls, loses_digits, nothing_moves, steps_to_mark
from lagrange_cli.integrate.workspace import MOST_STEPS, Workspace, padded
from lagrange_cli.native.guards import DUE, HALTED, Role
from lagrange_cli.native.interface import Stop
from lagrange_cli.native.state import CARRIED_COUNT, Clock

if TYPE_CHECKING:
    from lagrange_cli.integrate.guards.settling import Settling
    from lagrange_cli.integrate.impacts.happenings import Happenings
    from lagrange_cli.integrate.methods.helping import Helpers
    from lagrange_cli.integrate.methods.passing import EarlierTimes

POLL_SECONDS = 0.05
"""Seconds of machine code between two looks at the world outside, about."""
HEEDED = 5
"""The number of times that a stop is asked for after a signal."""
FIRST_STEPS = 0.5, 0.8
"""Parts of their first step that companions take."""
PASSED = Stop.SINGULAR, Stop.UNDERFLOW, Stop.NOT_FINITE, Stop.STUCK, Stop.CRAWL
"""How compiled code, or the caller, ends steps before a singular configuration, which may be passed."""
FIRST = 256
"""Steps that are taken before the first."""


class Stepper:
    """Steps the motion in a workspace (``space``); ``fill`` makes samples, ``size`` of them at most."""

    def __init__(
        self, equations: CompiledEquations, start: Start, size: int, observer: Observer = UNOBSERVED
    ) -> None:
        machine, beside, events = equations.machine, equations.beside, observer.events
        parameters, times = start.parameters, start.times
        self.space = space = Workspace(machine, start.state, times.start, size)
        program, layout = machine.program, space.layout
        self._recompilation, self._stop = equations.recompilation, times.stop
        if beside is not None:
            space.memory[layout.at(Clock.TIME_LOW)] = beside.late
        self._settling: Settling | None = None
        self._happenings: Happenings | None = None
        self.finished: Finished | None = None
        """Set when an event has ended the motion."""
        if not program.guarded:
            machine.prepare(np.ascontiguousarray(parameters).ctypes.data, space.constants.ctypes.data)
        else:
            from lagrange_cli.integrate.guards.settling import Settling

            self._settling = Settling(machine, space.constants, space.memory, space.work)
            self._settling.span, self._settling.end = abs(times.stop - times.start), times.stop
            self._settling.begin(parameters)
            space.resume = self._settling.resume
            if self._settling.begins_beyond():
                self.finished = Finished(Ending.CUT)
            elif self._settling.is_beyond_edge():
                self.finished = Finished(Ending.EDGE)
        if program.events:
            assert self._settling is not None
            from lagrange_cli.integrate.impacts.happenings import Happenings
            from lagrange_cli.integrate.impacts.sides import Sides

            sides = Sides(self._settling, space.outer)
            given = space.trial, space.info, times.start, events, equations.jumping
            self._happenings = Happenings(sides, *given)
            self.finished = self.finished or self._happenings.begin()
        if beside is not None:
            from lagrange_cli.integrate.methods.perturbation import perturb

            space.rates()  # computes the cyclic momenta
            perturb(space.memory[layout.cyclic_momenta], parameters)
        self.limited = self._settling is not None and self._settling.limited
        """Whether a step that was taken, or tried, might have been another one if the motion ended later."""
        self._pause = 1 if program.integrals else FIRST  # a step may be divided very often for integrals
        self._first = None if beside is None else self._short_step(beside.number)
        self._helpers: Helpers | None = None
        self.steps, self._every = 0, observer.checkpoints.every
        self._start, self._marked = times.start, 0
        self._earlier: EarlierTimes | None = None
        if program.constraints:
            from lagrange_cli.integrate.methods.passing import EarlierTimes

            self._earlier = EarlierTimes(space, equations.tolerance)

    def snapshot(self, samples: int) -> Snapshot:
        """The present place of the motion, after that many samples."""
        actions = () if self._happenings is None else self._happenings.state()
        taken = self.space.memory.copy(), self.space.t, self.steps, samples, self.limited
        earlier = self._earlier.memories if self._earlier else ()
        return Snapshot(*taken, actions, earlier, self.singular)

    def restore(self, snapshot: Snapshot) -> None:
        """Go on from there; raises ``Unfit``."""
        if any(one.shape != self.space.memory.shape for one in (snapshot.memory, *snapshot.marks)):
            raise Unfit
        if self._earlier is not None:
            self._earlier.memories, self._earlier.singular = snapshot.marks, snapshot.singular
        self.space.memory[:], self.steps, self.limited = snapshot.memory, snapshot.steps, snapshot.limited
        self._marked = self.steps
        if self._settling is not None:
            self._settling.resume()
            self._settling.resumed = True
        if self._happenings is not None:
            self._happenings.restore(snapshot.actions)

    def at(self, snapshot: Snapshot) -> bool:
        """Whether the motion is still where it was; if not, what a signal has left is gone on with."""
        there = self.space.memory.tobytes() == snapshot.memory.tobytes()
        if not there:
            self.space.info[HALTED] = 0
        return there

    @property
    def evaluations(self) -> int:
        """How often series, or rates, were computed for the steps taken."""
        layout = self.space.layout
        more = int(self.space.memory[layout.carried_at + CARRIED_COUNT]) if layout.carried else 0
        return self.steps + more

    @property
    def projections(self) -> int:
        """How often the state was moved back to the constraints."""
        return int(self.space.memory[self.space.layout.at(Clock.PROJECTIONS)])

    @property
    def singular(self) -> tuple[float, ...]:
        """The times at which the motion passed singular configurations."""
        return self._earlier.singular if self._earlier else ()

    def finite(self) -> bool:
        """Whether the accelerations are finite at the state reached."""
        return bool(np.all(np.isfinite(self.space.rates()[self.space.layout.q])))

    def touching(self) -> bool:
        """Whether a contact has just begun, or is just ending."""
        return self._settling is not None and bool(self._settling.touching())

    def accelerations(self) -> Array:
        """The accelerations of the coordinates at the state reached."""
        return self.space.rates()[: self.space.machine.program.degrees]

    def _short_step(self, number: int) -> float | None:
        """Where the first step of the ``number``-th companion ends: what all have rounded alike at the start,
        of the same state, counts for less the shorter it is."""
        space = self.space
        start, memory = space.t, space.memory.copy()
        space.advance(self._stop, padded(np.empty(0)), 0, 0, True, 1)
        reached, self._usual = space.t, space.memory[space.layout.remembered].copy()
        space.memory[:], space.info[:] = memory, 0
        if self._settling is not None:
            self._settling.resume()  # the step may have changed modes
        return start + FIRST_STEPS[number - 1] * (reached - start) if reached > start else None

    def fill(
        self, wanted: Array, first: int, last: bool, interrupt: Interrupt, halt: Interrupt
    ) -> tuple[Stop, int]:
        """Step until all of ``wanted``, the samples from ``first`` on, are taken (``last``: until the end);
        why it stopped, and how many are. An event may have ``finished`` the motion. ``interrupt`` is asked
        between steps, ``halt`` where the motion could not go on from there without doing its work again."""
        if self.finished is not None:
            return Stop.GUARD, 0
        space, times, done = self.space, padded(wanted), 0
        while True:
            if self._settling and self._settling.onset and space.passed(np.array([self._stop]))[0]:
                self.limited = True  # sliding has begun so late that no step is left to take
                space.samples[:, done : len(wanted)] = space.whole_state[:, None]
                return Stop.END if last else Stop.SAMPLES, len(wanted)
            if self._settling and (self._settling.onset or self._settling.resumed):
                reached = space.memory.copy()
                if self._settling.creeps():
                    passed = self._between(reached, wanted[done:])
                    space.samples[:, done : done + passed.shape[1]] = passed
                    done, self.steps = done + passed.shape[1], self.steps + 1
                    if interrupt(space.t):
                        return Stop.PAUSE, done
                    continue
            began, computed, before_it = time.perf_counter(), self.evaluations, self.steps
            used = time.thread_time() if self._helpers is not None else 0.0
            if self._earlier is not None:
                self._earlier.keep(self.steps)
            if self._first is None:
                pause = min(self._pause, steps_to_mark(self.steps))
                if self._earlier is not None:
                    pause = min(pause, self._earlier.steps_to_mark(self.steps))
                if self._every:
                    pause = min(pause, self._every - self.steps % self._every)
                if self._happenings is not None:
                    pause = min(pause, self._happenings.left)
                stop = space.advance(self._stop, times, done, len(wanted) - done, last, pause)
            else:
                early = np.where(times <= self._first, times, np.nan)
                count = int(np.count_nonzero(np.isfinite(early)))
                stop = space.advance(self._first, early, done, count - done, True, 1)
                space.memory[space.layout.remembered] = self._usual
                self._first = None
                stop = Stop.PAUSE if stop is Stop.END else stop
            before = first + done
            done, self.steps = done + int(space.info[0]), self.steps + int(space.info[1])
            self.limited |= bool(space.info[2])
            near = stop is Stop.PAUSE and self._earlier is not None and self._earlier.near(self.steps)
            if stop is Stop.PAUSE and self._marks(self.steps):
                stop = Stop.CRAWL
                if self._earlier is None:
                    return stop, done
            if self._settling is not None:
                self._settling.onset = None
            reached = space.memory.copy() if self._settling is not None else None
            if reached is not None and stop is not Stop.CRAWL and self._goes_on(stop, before, first + done):
                self.limited |= self._settling is not None and self._settling.limited
                if space.t > reached[space.layout.time]:
                    crossed = self._between(reached, wanted[done:])
                    space.samples[:, done : done + crossed.shape[1]] = crossed
                    done += crossed.shape[1]
                if not interrupt(space.t):
                    continue
                stop = Stop.PAUSE
            if stop is Stop.PAUSE and self.finished is not None:
                return Stop.GUARD, done
            if self._earlier and (stop in PASSED or near):
                given = times[done : len(wanted)], self._stop, lambda t: 0 if halt(t) else self._pause
                steps = self.steps if near or stop is Stop.CRAWL else None
                on_the_way, self.limited = self._earlier.passed(*given, steps, limited=self.limited)
                if on_the_way is None and halt(space.t):
                    stop = Stop.PAUSE
                if on_the_way is not None:
                    space.samples[:, done : done + on_the_way.shape[1]] = on_the_way
                    done, self.steps = done + on_the_way.shape[1], self.steps + 1
                    stop = Stop.PAUSE
            if stop is not Stop.PAUSE or interrupt(space.t) or self._halted(interrupt):
                return stop, done
            spent = time.perf_counter() - began
            if self._helpers is not None:
                used = time.thread_time() - used
                self._helpers.judge(self.evaluations - computed, spent, used)
            if self._recompilation is not None:
                space.machine = self._recompilation.after(spent) or space.machine
            if self._helpers is None or not self._helpers.unsure:
                taken = max(1, self.steps - before_it)  # fewer than were allowed, where a mark is due
                usual = taken * POLL_SECONDS / max(spent, 1e-6)
                self._pause = int(max(1, min(4 * self._pause, MOST_STEPS, usual)))

    def _between(self, reached: Array, wanted: Array) -> Array:
        """The samples that the motion has passed since the memory ``reached``, without steps."""
        path = None if self._settling is None else self._settling.along(reached)
        if self._settling is not None and path is not None:
            return self._settling.samples_along(path, wanted[self.space.passed(wanted)])
        if self._settling is None or self._settling.onset is None:
            return self.space.between(reached, wanted)
        return self._settling.samples(self._settling.onset, wanted[wanted < self.space.t])

    def _marks(self, steps: int) -> bool:
        """Record the progress of the motion, if that is due. Returns whether it crawls."""
        if steps == self._marked or steps_to_mark(steps - 1) != 1:
            return False
        self._marked = steps
        clock = self.space.memory[self.space.layout.clock]
        elapsed = abs(self.space.t - self._start)
        looks = partial(loses_digits, self.space), partial(nothing_moves, self.space)
        return crawls(clock, steps, elapsed, self._stop, *looks)

    def heard(self) -> AbstractContextManager[None]:
        """A context in which a signal ends a step that is divided for integrals, which may take long."""
        if not self.space.machine.program.integrals:
            return nullcontext()
        from lagrange_cli.integrate.hearing import asked_by

        return asked_by(self.space.info)

    @contextmanager
    def helped(self, threads: int | None) -> Iterator[None]:
        """A context in which so many threads share the work, if there is enough of it."""
        if threads == 1 or not self.space.machine.program.strips:
            yield
            return
        from lagrange_cli.integrate.methods.helping import Helpers

        self._pause, self._helpers = 1, Helpers(self.space.machine, self.space.constants, threads)
        with self._helpers:
            yield

    @property
    def threads(self) -> int:
        """How many share the work."""
        return 1 if self._helpers is None else self._helpers.threads

    def _halted(self, interrupt: Interrupt) -> bool:
        """Whether a signal that a step was left for ends the run. In another thread than the main one, this
        is known a little later."""
        for _ in range(HEEDED if self.space.info[HALTED] else 0):
            if interrupt(self.space.t):
                return True
            time.sleep(POLL_SECONDS)
        self.space.info[HALTED] = 0
        return False

    def _goes_on(self, stop: Stop, began: int, sample: int) -> bool:
        """Whether the motion goes on from where compiled code has stopped, before that sample; it was called
        before the one where it ``began``."""
        assert self._settling is not None
        due = int(self.space.info[DUE])
        if stop is Stop.GUARD and self._earlier:
            self._earlier.memories = ()  # singular configurations are passed from behind all that happens
        if self._happenings is not None:
            self.finished = self._happenings.drain(began)
            if stop is Stop.GUARD and due >= self._settling.count and self.finished is None:
                self.finished = self._happenings.happen(due, sample)
                if self.finished is None and self._settling.is_beyond_edge():
                    self.finished = Finished(Ending.EDGE)
                return self.finished is None
            if self.finished is not None:
                return False
        if stop is Stop.PAUSE and self.steps != self._marked:  # others depend on how fast the machine is
            return False
        before = self._happenings and self._happenings.moving()
        goes_on = self._settling.goes_on(stop, due)
        if goes_on and self._happenings is not None:
            self.finished = self._happenings.stop(before or None, sample)
            goes_on = self.finished is None
        guards = self.space.machine.program.rows_of_guards.guards
        cut = stop is Stop.GUARD and guards[due].role is Role.BREAK
        if not goes_on and stop is Stop.GUARD and guards[due].role is Role.EDGE:
            self.finished = Finished(Ending.EDGE)
        elif not goes_on and (cut or self._settling.undetermined):
            self.finished = Finished(Ending.CUT if cut else Ending.UNDETERMINED)
        return goes_on
