"""Events that compiled code leaves to its caller: actions, rest, and the end of a run.

After an action every event whose expression it has changed is on the side of that expression's sign. Where
this is 0 it is on the side that the motion leads to: a zero that an action leaves is no event.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from types import MappingProxyType
from typing import TYPE_CHECKING

import numpy as np

from lagrange_cli.integrate.arrays import largest_of
from lagrange_cli.integrate.ending import Ending, Finished
from lagrange_cli.integrate.events import Change
from lagrange_cli.integrate.guards.modes import ROUNDING
from lagrange_cli.integrate.impacts.reports import Reports
from lagrange_cli.integrate.impacts.resting import Impact, Resting
from lagrange_cli.integrate.impacts.sides import Sides
from lagrange_cli.integrate.impacts.standstill import Moving, Standstill
from lagrange_cli.native.guards import NOTES, Role

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from lagrange_cli.integrate.arrays import Array
    from lagrange_cli.integrate.events import EventSink, Judge

ALSO = 64
"""Impacts that happen at the same time are followed at once, so many at most."""
NONE: Mapping[int, float] = MappingProxyType({})
"""No values."""


class Happenings:
    """The events of a motion that begins at ``start``; ``trial`` and ``info`` are arrays of compiled code."""

    def __init__(
        self,
        sides: Sides,
        trial: Array,
        info: NDArray[np.int64],
        start: float,
        sink: EventSink,
        jumping: Judge,
    ) -> None:
        self._sides, self._sink, self._jumping = sides, sink, jumping
        self._program, self._guards = sides.program, sides.guards.guards
        self._resting = Resting(sides, start, trial)
        self._standstill = Standstill(sides, self._resting)
        self._reports = Reports(sides, trial, info, sink, self._resting, self._standstill)

    def begin(self) -> Finished | None:
        """Choose the sides where the motion begins: a zero there is no event, unless an action turns the
        motion back there."""
        sides = self._sides
        self._resting.times[:] = np.nan
        held = self._resting.held()
        new, sizes = sides.act_now()
        rows = sides.all_coefficients()
        for e, (size, rate) in enumerate(sizes):
            direction, values = self._guards[e + sides.first].direction, rows[e]
            leads = sides.choose_side(e, values, ROUNDING * size, rate)
            still = sides.at_zero(e) and abs(values[1]) <= ROUNDING * rate
            if not leads and direction:  # as for bodies that touch, and move together
                sides.settling.modes[e + sides.first] = -float(direction)
            elif still and direction and sides.side(e) == direction:
                if e in self._resting.guards:
                    self._resting.hold(e, -float(direction))
                    rows = sides.all_coefficients()
                elif sides.changes_nothing(e, new):  # an elastic impact without any speed
                    return self._reports.finished(Ending.IDLE, e)
            elif sides.at_zero(e) and direction and sides.side(e) == direction and sides.turns(e, new):
                sides.settling.modes[e + sides.first] = -float(direction)
        self._resting.together()
        self._choose_switches(held)
        if self._standstill.possible:
            self._standstill.hold()
        return None

    @property
    def left(self) -> int:
        """How many events, each of which ends a step, it takes for them to be too many."""
        return self._reports.left

    def moving(self) -> Moving | None:
        """How the motion is before switches are looked at."""
        return self._standstill.now() if self._standstill.possible else None

    def stop(self, before: Moving | None, sample: int) -> Finished | None:
        """Handle the events that happen because friction stops the motion, which was as ``before``."""
        if before is None:
            return None
        stopped = self._standstill.stopped(before).items()
        counting = [event for event, side in stopped if not side * self._sides.directions[event] > 0.0]
        for event in sorted(counting, key=self._turn):
            ended = self._done(event, before.rows[event, 1 : len(NOTES)], sample)
            if ended is not None:
                return ended
        return None

    def _turn(self, event: int) -> tuple[bool, bool, int]:
        """Of what happens at the same time, records come first, and impacts last; then the file's order
        counts."""
        return event in self._sides.sets, event in self._resting.impacts, event

    def state(self) -> tuple[float, ...]:
        """The state besides ``memory`` that a continued run needs."""
        sides = self._sides
        chosen = np.flatnonzero(sides.at_once(sides.chosen) & (sides.marks > 0.0))
        numbers = float(sides.settling.last_step[0]), *sorted(self._resting.released), *(-1 - chosen)
        return (*self._resting.at_once.state(), *map(float, numbers))

    def restore(self, state: Sequence[float]) -> None:
        """Go on from there."""
        sides = self._sides
        sides.settling.last_step[0], *numbers = self._resting.at_once.restore(state)
        self._resting.released = {int(one) for one in numbers if one >= 0}
        chosen = np.isin(-1 - np.arange(len(sides.chosen)), numbers)
        sides.chosen[:] = np.where(chosen, sides.now, np.nan)

    def drain(self, sample: int) -> Finished | None:
        """Hand over the records that compiled code has made since it was called, before that sample."""
        return self._reports.drain(sample)

    def happen(self, due: int, sample: int) -> Finished | None:
        """Handle the guard that has changed its sign, before the sample of that number."""
        guard, event, sides = self._guards[due], due - self._sides.first, self._sides
        if guard.role is Role.REST:
            self._resting.release(due)
            return None
        if self._standstill.leaving(event, sides.now):
            sides.flip(event)
            return self._recurs(event, sides.now)
        if self._resting.has_jumped(event):
            sides.settling.modes[due] *= -1.0
            return self._recurs(event, sides.now)
        if self._resting.stands(event):
            self._resting.let_stand(event)
            return self._recurs(event, sides.now)
        near = np.inf if event in self._resting.impacts else self._resting.near(event)
        if sides.leaves_zero(event, near) and not sides.at_zero(event):  # a root of rounding errors
            sides.settling.mark([due])
            return self._recurs(event, sides.now)
        event = self._resting.fastest(event)
        if self._resting.touches(event):
            held, goes_on = self._resting.held(), self._resting.touch(event)
            self._choose_switches(held)
            return (
                self._recurs(event, sides.now) if goes_on else self._reports.finished(Ending.RECURRING, event)
            )
        turns = sides.at_zero(event) and not self._driven_back(event)  # to where the motion has come from
        if turns and not self._crosses_back(event):
            sides.flip(event)
            if event not in self._resting.released:
                self._sink.grazed(event, sides.now)
            return self._recurs(event, sides.now)
        if sides.side(event) * sides.directions[event] > 0.0:
            sides.flip(event)
            return None
        others, passed = list[int](), list[int]()  # before the action changes their way
        if event in sides.sets:
            others = [e for e in sides.together(event) if e not in self._resting.impacts]
            passed = sides.passed(event, self._resting.times[:, 0])
            passed = [e for e in passed if e not in self._resting.impacts]
        values = sides.all_coefficients()[:, 0].copy()
        at_zero = {e: float(values[e]) for e in (*others, *passed, event)}
        counting = (e for e in others if sides.side(e) * sides.directions[e] <= 0.0)
        side = sides.side(event)
        for one in sorted([*counting, event], key=self._turn):
            if others and one in self._resting.impacts and sides.coefficients(one)[1] * side >= 0.0:
                break  # another action has turned the motion
            ended = self._done(one, sides.coefficients(one)[1 : len(NOTES)], sample, at_zero)
            if ended is not None:
                return ended
            if one in sides.sets:  # another action may drive the motion back to it
                del at_zero[one]
        ended = None
        for _ in range(ALSO if self._program.carried else 0):  # steps on rates may not see what begins at 0
            other = self._resting.due()
            if ended is not None or other is None:
                break
            ended = self._done(other, sides.coefficients(other)[1 : len(NOTES)], sample)
        return ended

    def _done(
        self, event: int, rates: Array, sample: int, at_zero: Mapping[int, float] = NONE
    ) -> Finished | None:
        """Hand over that an event happens, with the ``rates`` of its argument, and do what it does. Events
        whose arguments are ``at_zero`` now had these values, beside 0, before others happened."""
        sides, role = self._sides, self._guards[event + self._sides.first].role
        again = sides.at_zero(event) and event in self._resting.impacts  # its time is that of others
        rates = np.array([1.0, 0.0, 0.0]) if again or not np.all(np.isfinite(rates)) else rates
        ended = self._reports.crossed(sides.memory[None, :], np.array([event]), rates[:, None])
        self._resting.released.discard(event)
        if ended is not None or role is Role.RECORD:
            sides.flip(event)
            return ended
        if event not in sides.sets:
            return self._reports.finished(Ending.STOPPED, event)
        return self._act(event, sample, at_zero)

    def _crosses_back(self, event: int) -> bool:
        """Whether another crossing is recorded where the motion turns back at 0: rounding has led the
        argument beyond 0 there, and it comes back. (None has led it to a side that was chosen at 0.)"""
        sides = self._sides
        recorded = self._guards[event + sides.first].role is Role.RECORD
        return recorded and not sides.at_once(sides.chosen[event])

    def _driven_back(self, event: int) -> bool:
        """Whether another action takes the motion back to an event that acts, with a speed."""
        sides = self._sides
        if self._guards[event + sides.first].role is Role.RECORD:
            return False
        rate = sides.act_now()[1][event, 1]
        return bool(sides.coefficients(event)[1] * sides.side(event) < -ROUNDING * rate)

    def _act(self, event: int, sample: int, at_zero: Mapping[int, float]) -> Finished | None:
        """Change what the event's action changes."""
        sides, now = self._sides, self._sides.now
        parameters, before = sides.parameters(), sides.state(sides.memory)
        length, held = sides.settling.length(), self._resting.held()
        side, rows, (values, _) = sides.side(event), sides.all_coefficients(), sides.act_now()
        self._resting.noise()
        switches = sides.switches()
        memory = sides.memory.copy()
        if not sides.put(event, values):
            return Finished(Ending.NOT_A_NUMBER, f"the action of event {self._reports.names[event]!r}")
        refused = self._refused(event, parameters)
        if refused is not None:
            sides.memory[:] = memory
            sides.settling.prepare()
            return refused
        sides.settling.marks[: len(switches)][sides.switches() != switches] = 0.0  # these were 0, perhaps
        sides.settling.begin_switches()
        _, sizes = sides.act_now()
        after, noise = sides.all_coefficients(), self._resting.noise()
        least_rate = float(sides.least_sizes()[1])
        # constraints move all arguments by rounding errors
        moved = self._resting.nears() if self._program.constraints else np.zeros(len(after))
        chosen = ~(np.abs(after[:, 0] - rows[:, 0]) <= moved) | (sides.modes == 0.0)
        chosen[[event, *at_zero]] = True
        resting = np.flatnonzero((sides.modes == 0.0) & self._resting.rests)
        chosen[resting] = False
        self._resting.go_on(resting, after[:, 1] - rows[:, 1], noise)
        for e in np.flatnonzero(chosen).tolist():
            near = 2.0 * abs(at_zero.get(e, rows[e, 0])) if e == event or e in at_zero else 0.0
            if e == event and self._program.constraints:  # which have moved it by rounding errors
                near = max(near, ROUNDING * float(sizes[e, 0]), float(moved[e]))
            sides.choose_side(e, after[e], near, max(float(sizes[e, 1]), least_rate))
        if self._standstill.possible:
            self._standstill.hold()
        ended = self._recurs(event, now)
        if ended is None and event in self._resting.impacts and sides.at_zero(event):
            speed, least, size = map(float, (rows[event][1], noise[event], sizes[event, 0]))
            ends = self._resting.settle(Impact(event, side, before, speed, least, length, size))
            if ends is not None:
                if self._resting.at_once.first(event, ends):
                    self._sink.accumulated(event, ends)
                if self._drags(event, before):
                    ended = self._reports.finished(Ending.DRAGGED, event)
        self._resting.together()
        self._choose_switches(held)
        self._resting.note(event)
        changed = parameters, sides.parameters()
        self._sink.changed(Change(sample, now, before, sides.state(sides.memory), changed))
        return ended

    def _choose_switches(self, held: Array) -> None:
        """Choose the modes of switches where other contacts hold bodies together than those that were
        ``held``: arguments may stay 0 from now on."""
        if self._sides.settling.count and not np.array_equal(held, self._resting.held()):
            self._sides.settling.begin_switches()

    def _refused(self, event: int, parameters: Array) -> Finished | None:
        """Why the motion cannot go on from where an action has put it, which had these ``parameters``."""
        name, now = f"event {self._reports.names[event]!r}", self._sides.parameters()
        if not self._sides.close(event):
            return Finished(Ending.OFF_CONSTRAINTS, name)
        lost = self._sides.without_mass()
        if lost:
            return Finished(Ending.NO_MASS, f"{name} makes {lost}")
        jumps = "" if np.array_equal(parameters, now) else self._jumping(now)
        return Finished(Ending.JUMP, f"{name} makes {jumps!r} jump") if jumps else None

    def _drags(self, event: int, before: Array) -> bool:
        """Whether an impact that has no speed would change velocities, too, beside what they were ``before``
        the last one: where infinitely many do so, the limit is not that of those that are counted."""
        sides, n = self._sides, self._program.degrees
        there = sides.state(sides.memory)
        values = sides.act_on(there)[0][0]
        least = ROUNDING * largest_of(before[n : 2 * n])
        own = [(i, place) for i, place in sides.sets[event] if n <= place < 2 * n]
        return any(abs(values[i] - there[place]) > least for i, place in own)

    def _recurs(self, event: int, now: float) -> Finished | None:
        """Whether infinitely many actions happen at one time."""
        return self._reports.finished(Ending.RECURRING, event) if self._resting.recurs() else None
