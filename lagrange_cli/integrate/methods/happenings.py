"""What is done at events where compiled code leaves it to its caller: actions, rest, and the end of a run.

After an action every event whose expression it has changed is on the side of that expression's sign. Where
this is 0 it is on the side that the motion leads to: a zero that an action leaves is no event.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from lagrange_cli.integrate.ending import Ending
from lagrange_cli.integrate.events import Change, Crossings, parameters_in
from lagrange_cli.integrate.methods.settling import BEGINNING, ROUNDING
from lagrange_cli.limits import limit
from lagrange_cli.native.interface import AFTER, NOTES, RECORDED, SAMPLE
from lagrange_cli.native.state import Clock, Role
from lagrange_cli.records import dataclass

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from lagrange_cli.integrate.arrays import Array
    from lagrange_cli.integrate.events import EventSink
    from lagrange_cli.integrate.methods.settling import Settling

GRAZING = 2.0**-46
"""An argument that goes beyond 0 by no more than this part of its terms may not do so at all."""
NO_TIME, AGAIN = 2.0**-50, 1000
"""So many actions within this part of all time go on for ever."""
SOON = 2.0**-30, 2.0**-44
"""If all further impacts take no longer than this part of a step, the motion rests; in doubles and in
double-double."""


@dataclass(frozen=True)
class Finished:
    """That a motion ends at an event."""

    ending: Ending
    detail: str


class Happenings:
    """The events of a motion that begins at ``start``: their sides and actions.

    ``trial`` and ``info`` are arrays of compiled code, ``outer`` the rows of q, v and the integrals.
    """

    def __init__(
        self,
        settling: Settling,
        trial: Array,
        info: NDArray[np.int64],
        outer: NDArray[np.intp],
        start: float,
        sink: EventSink,
    ) -> None:
        program = settling.machine.program
        self._settling, self._memory, self._program = settling, settling.memory, program
        self._trial, self._info, self._outer, self._start = trial, info, outer, start
        self._names, self._sink = sink.names, sink
        self._layout, self._rows = program.inner, program.rows_of_guards
        self._switches = len(program.guards)
        self._times = self._memory[self._rows.times(self._layout)].reshape(-1, 2)
        """When each event has acted last."""
        self._count, self._most = sink.before, limit("events")
        self._same, self._latest = 0, -np.inf
        self._released: set[int] = set()
        """Events at which the motion has rested, until they happen again: it leaves them with no speed."""
        resting = [j for j, one in enumerate(self._rows.guards) if one.role is Role.REST]
        self._rests = dict(zip((e for e, one in enumerate(program.events) if one[2] >= 0), resting))
        """The guards of resting contact, by event."""

    def begin(self) -> Finished | None:
        """Choose the sides where the motion begins: a zero there is no event."""
        self._times[:] = np.nan
        _, sizes = self._act_on(self._state(self._memory))
        for e, (size, rate) in enumerate(sizes):
            guard = self._rows.guards[e + self._switches]
            values = self._coefficients(e)
            self._choose_side(e, values, ROUNDING * size, rate)
            forbidden = guard.role is not Role.RECORD and self._side(e) == guard.direction
            if forbidden and self._at_zero(e) and abs(values[1]) <= ROUNDING * rate:
                if e not in self._rests:
                    return self._finished(Ending.RECURRING, e)
                self._hold(e, -float(guard.direction))
        return None

    def state(self) -> tuple[float, ...]:
        """What ``memory`` does not hold, to go on from."""
        return (float(self._same), float(self._latest), *map(float, sorted(self._released)))

    def restore(self, state: Sequence[float]) -> None:
        """Go on from there."""
        same, self._latest, *released = state
        self._same = int(same)
        self._released = {int(one) for one in released}

    def drain(self, sample: int) -> Finished | None:
        """Hand over the records that compiled code has made since it was called, before that sample."""
        count, size, first = int(self._info[RECORDED]), self._layout.memory, self._program.records
        if not count:
            return None
        self._info[RECORDED] = 0
        records = self._trial[first : first + count * size].reshape(count, size)
        numbers, rates, bends = records[:, [self._layout.at(one) for one in NOTES]].T
        changed, crossed = np.flatnonzero(numbers == AFTER), numbers != AFTER
        for k in changed:
            before, after = records[k - 1], records[k]
            passed = sample + int(before[self._layout.at(SAMPLE)])
            states = self._state(before), self._state(after)
            parameters = parameters_in(self._program, before), parameters_in(self._program, after)
            self._sink.changed(Change(passed, float(before[self._layout.time]), *states, parameters))
        events = (numbers[crossed] - self._switches).astype(np.int64)
        return self._crossed(records[crossed], events, rates[crossed], bends[crossed])

    def happen(self, due: int, sample: int) -> Finished | None:
        """Do what is to be done at the guard that is due, before the sample of that number."""
        guard, event = self._rows.guards[due], due - self._switches
        if guard.role is Role.REST:
            self._release(due)
            return None
        if self._at_zero(event) and not self._driven_back(event):  # the motion turns where it has come from
            self._settling.modes[due] *= -1.0
            if event not in self._released:
                self._sink.grazed(event, self._now())
            return None
        if self._side(event) * guard.direction > 0.0:
            self._pass(due)
            return None
        _, *rates = self._coefficients(event)[:3, None]
        ended = self._crossed(self._memory[None, :], np.array([event]), *rates)
        self._released.discard(event)
        if ended is not None or guard.role is Role.RECORD:
            self._pass(due)
            return ended
        if all(e != event for e, _ in self._program.changed):
            return self._finished(Ending.STOPPED, event)
        return self._act(event, sample)

    # what is where

    def _finished(self, ending: Ending, event: int) -> Finished:
        return Finished(ending, f"event {self._names[event]!r}")

    def _now(self) -> float:
        return float(self._memory[self._layout.time])

    def _side(self, event: int) -> float:
        return float(self._settling.modes[event + self._switches])

    def _at_zero(self, event: int) -> bool:
        return bool(self._settling.marks[event + self._switches] > 0.0)

    def _driven_back(self, event: int) -> bool:
        """Whether another action takes the motion back to an event that acts, with a speed."""
        if self._rows.guards[event + self._switches].role is Role.RECORD:
            return False
        rate = self._act_on(self._state(self._memory))[1][event, 1]
        return bool(self._coefficients(event)[1] * self._side(event) < -ROUNDING * rate)

    def _coefficients(self, event: int) -> Array:
        return self._settling.coefficients_of(self._rows.guards[event + self._switches].row)[0]

    def _all_coefficients(self) -> list[Array]:
        """Those of every event's argument."""
        first = self._switches
        guards = self._rows.guards[first : first + len(self._times)]
        return self._settling.coefficients_of(*(guard.row for guard in guards))

    def _state(self, memory: Array) -> Array:
        """The rows outside, of all parts."""
        starts = range(0, self._program.parts * self._layout.width, self._layout.width)
        return np.concatenate([memory[start + self._outer] for start in starts])

    def _parameters(self) -> Array:
        return parameters_in(self._program, self._memory)

    # what is done

    def _pass(self, due: int) -> None:
        self._settling.modes[due] *= -1.0
        self._settling.mark([due])

    def _crossed(
        self, memories: Array, events: NDArray[np.int64], rates: Array, bends: Array
    ) -> Finished | None:
        """Hand over that events happened, with the state's memory then. The first coefficients of their
        arguments' series were 0, ``rates`` and ``bends``."""
        layout, program = self._layout, self._program
        t, low = (memories[:, layout.at(part)].copy() for part in (Clock.TIME, Clock.TIME_LOW))
        starts = range(0, program.parts * layout.width, layout.width)
        states = memories[:, np.concatenate([start + self._outer for start in starts])]
        with np.errstate(divide="ignore", invalid="ignore"):
            beyond = rates**2 / (4.0 * np.abs(bends))
        grazing = beyond <= GRAZING * np.fmax(1.0, np.max(np.abs(states[:, : program.rows]), axis=1))
        for k in np.flatnonzero(grazing):
            grazing[k] = beyond[k] <= GRAZING * self._act_on(states[k])[1][events[k], 0]
        self._sink.crossed(Crossings(events, t, low, states, grazing))
        self._count += len(events)
        if self._count > self._most:
            return self._finished(Ending.TOO_MANY_EVENTS, int(events[-1]))
        return None

    def _act(self, event: int, sample: int) -> Finished | None:
        """Change what the event's action changes."""
        memory, settling, now = self._memory, self._settling, self._now()
        parameters, before, length = self._parameters(), self._state(memory), self._last_step()
        rows = self._all_coefficients()
        side, values = self._side(event), self._act_on(before)[0]
        if not self._put(event, values):
            return Finished(Ending.NOT_A_NUMBER, f"the action of event {self._names[event]!r}")
        settling.begin_switches()
        _, sizes = self._act_on(self._state(memory))
        for e, (row, after, (_, rate)) in enumerate(zip(rows, self._all_coefficients(), sizes)):
            if self._side(e) == 0.0:
                self._go_on_resting(e, float(after[1]), ROUNDING * rate)
            elif e == event or after[0] != row[0]:
                self._choose_side(e, after, 2.0 * abs(row[0]) if e == event else 0.0, rate)
        ended = self._recurs(event, now)
        if ended is None and event in self._rests and self._at_zero(event):
            self._settle(event, side, before, float(rows[event][1]), ROUNDING * sizes[event, 1], length)
        self._times[event] = now, memory[self._layout.at(Clock.TIME_LOW)]
        changed = parameters, self._parameters()
        self._sink.changed(Change(sample, now, before, self._state(memory), changed))
        return ended

    def _act_on(self, state: Array) -> tuple[Array, Array]:
        """What actions set, were they all done now (parts, values), and the sizes of arguments
        (events, 2)."""
        machine, program = self._settling.machine, self._program
        assert machine.act is not None
        count, events = len(program.changed), len(program.events)
        found, when = np.empty(program.parts * (count + 2 * events)), np.array([self._now()])
        self._settling.prepare()
        place = self._settling.constants.ctypes.data
        machine.act(place, when.ctypes.data, state.ctypes.data, found.ctypes.data, 1, 1)
        rows = found.reshape(program.parts, -1)
        return rows[:, :count], rows[0, count:].reshape(events, 2)

    def _put(self, event: int, values: Array) -> bool:
        """Set what an action sets; whether it is finite."""
        program, layout, memory = self._program, self._layout, self._memory
        width, motion = self._rows.parameters + self._rows.count, 2 * program.degrees
        chosen = [(i, place) for i, (e, place) in enumerate(program.changed) if e == event]
        if not np.all(np.isfinite(values[:, [i for i, _ in chosen]])):
            return False
        for i, place in chosen:
            if place < motion:
                row = int(self._outer[place])
                memory[[row, layout.width + row, layout.third + row]] = 0.0
                memory[[part * layout.width + row for part in range(program.parts)]] = values[:, i]
            else:
                first = layout.settings.start + place - motion
                memory[[first + part * width for part in range(program.parts)]] = values[:, i]
        self._begin_anew()
        return True

    def _begin_anew(self) -> None:
        """Forget what was known of the motion before: momenta follow from velocities."""
        layout = self._layout
        for start in (0, layout.width, layout.third):
            self._memory[start + layout.cyclic_momenta.start : start + layout.cyclic_momenta.stop] = 0.0
        for number in BEGINNING:
            self._memory[layout.at(number)] = 0.0
        self._settling.prepare()

    def _choose_side(self, event: int, values: Array, noise: float, rate: float) -> None:
        """The side of an event at the state as it is. Its argument's coefficients are ``values``, and up to
        ``noise`` it is 0; its rate's terms are as large as ``rate``."""
        settling, j = self._settling, event + self._switches
        settling.marks[j] = 0.0
        leads = float(values[0])
        if not abs(leads) > noise:
            settling.mark([j])
            speed = float(np.max(np.abs(self._memory[self._layout.part(0)][self._layout.v])))
            scale = settling.scale() * (rate / speed if min(rate, speed) > 0.0 else 1.0)
            sizes = [rate, *np.fmax(scale[1:-1], scale[2:])]
            counting = (one for one, size in zip(values[1:], sizes) if not abs(one) <= ROUNDING * size)
            leads = float(next(counting, -settling.modes[j]))
        settling.modes[j] = 1.0 if leads > 0.0 else -1.0

    def _recurs(self, event: int, now: float) -> Finished | None:
        """Whether actions go on for ever while time does not."""
        at_once = now - self._latest <= NO_TIME * max(abs(now), now - self._start)
        self._same, self._latest = self._same + 1 if at_once else 0, now
        return self._finished(Ending.RECURRING, event) if self._same >= AGAIN else None

    # resting contact

    def _last_step(self) -> float:
        return float(self._memory[self._layout.at(Clock.STEP)])

    def _settle(
        self, event: int, side: float, before: Array, speed: float, noise: float, length: float
    ) -> None:
        """Let the motion rest if all further impacts together take no time that counts. It came from ``side``
        with the argument's ``speed``; up to ``noise`` that is 0; ``length`` was that of a step."""
        now, low = self._now(), float(self._memory[self._layout.at(Clock.TIME_LOW)])
        _, left, bend, *_ = map(float, self._coefficients(event))
        since = (now - self._times[event, 0]) + (low - self._times[event, 1])
        flight = np.divide(-left, bend)
        if abs(left) <= noise:
            self._stop(before, speed, left)
            self._hold(event, side)
        elif 0.0 < flight < since and self._side(event) == side:
            remaining = flight / (1.0 - flight / since)
            if remaining <= SOON[self._program.parts - 1] * min(length, now - self._start):
                self._sink.accumulated(event, now + remaining)
                self._stop(before, speed, left)
                self._hold(event, side)

    def _stop(self, before: Array, speed: float, left: float) -> None:
        """Take the rest of the speed away, in the direction of the impact from ``before``."""
        if left == 0.0 or left == speed:
            return
        n = self._program.degrees
        places = self._outer[n : 2 * n]
        change = self._memory[places] - before[n : 2 * n]
        self._memory[places] -= change * (left / (left - speed))
        self._memory[self._layout.width + places] = 0.0
        self._memory[self._layout.third + places] = 0.0
        self._begin_anew()

    def _hold(self, event: int, side: float) -> None:
        """Rest at an event, if the force that holds the motion pushes to the side that it came from."""
        settling, j, rest = self._settling, event + self._switches, self._rests[event]
        settling.modes[rest], settling.modes[j] = side, 0.0
        force = settling.coefficients_of(self._rows.guards[rest].row)[0][0]
        if not force * side > 0.0:
            settling.modes[rest], settling.modes[j] = 0.0, side
            settling.mark([j])
            settling.prepare()

    def _go_on_resting(self, event: int, speed: float, noise: float) -> None:
        """Rest on after another event's action, if that has given the motion no ``speed`` here."""
        settling, j, rest = self._settling, event + self._switches, self._rests[event]
        side = float(settling.modes[rest])
        settling.modes[rest], settling.modes[j] = 0.0, side
        settling.mark([j])
        if speed * side < -noise:  # towards the contact: an impact
            settling.marks[j] = 0.0
        if abs(speed) <= noise:
            self._hold(event, side)
        else:
            settling.prepare()

    def _release(self, rest: int) -> None:
        """End a contact: the force that holds the motion would have to pull."""
        settling = self._settling
        event = next(e for e, guard in self._rests.items() if guard == rest)
        j = event + self._switches
        settling.modes[j], settling.modes[rest] = settling.modes[rest], 0.0
        settling.mark([j])
        self._released.add(event)
        self._begin_anew()
        settling.begin_switches()
