"""What is handed over of events: those that happen, and those that compiled code has recorded."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from lagrange_cli.integrate.ending import Ending, Finished
from lagrange_cli.integrate.events import Change, Crossings, parameters_in
from lagrange_cli.integrate.impacts.doubts import ULP, doubts
from lagrange_cli.integrate.impacts.resting import Resting
from lagrange_cli.integrate.impacts.sides import Sides
from lagrange_cli.integrate.impacts.standstill import Standstill
from lagrange_cli.limits import limit
from lagrange_cli.native.guards import AFTER, ENDLESS, ENDS, NOTES, RECORDED, SAMPLE
from lagrange_cli.native.state import Clock

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from lagrange_cli.integrate.arrays import Array
    from lagrange_cli.integrate.events import EventSink


class Reports:
    """The reports of a motion's events to a ``sink``; ``trial`` and ``info`` are arrays of compiled code."""

    def __init__(
        self,
        sides: Sides,
        trial: Array,
        info: NDArray[np.int64],
        sink: EventSink,
        resting: Resting,
        standstill: Standstill,
    ) -> None:
        self._sides, self._trial, self._info, self._sink = sides, trial, info, sink
        self._program, self._layout = sides.program, sides.layout
        self._resting, self._standstill = resting, standstill
        self.names = sink.names or tuple(map(str, range(len(sides.program.events))))
        """Those of all events."""
        self._count, self._most = sink.before, limit("events")
        motion = 2 * self._program.degrees
        self._matter = sink.states or any(place >= motion for _, place in self._program.changed)
        """Whether what compiled code does matters to the sink."""

    @property
    def left(self) -> int:
        """How many events it takes for them to be too many."""
        return max(1, int(self._most) - self._count + 1)

    def finished(self, ending: Ending, event: int) -> Finished:
        """The end of the motion because of an event."""
        return Finished(ending, f"event {self.names[event]!r}")

    def drain(self, sample: int) -> Finished | None:
        """Hand over the records that compiled code has made since it was called, before that sample."""
        count, size, first = int(self._info[RECORDED]), self._layout.memory, self._program.records
        if not count:
            return None
        self._info[RECORDED] = 0
        records = self._trial[first : first + count * size].reshape(count, size)
        numbers = records[:, self._layout.at(NOTES[0])]
        crossed, start = numbers != AFTER, 0
        for k in np.flatnonzero(~crossed).tolist() if self._matter else ():
            before, after = records[k - 1], records[k]
            if self._sink.in_turn:
                ended = self._hand_over(records[start:k][crossed[start:k]])
                if ended is not None:
                    return ended
                start = k
            passed = sample + int(before[self._layout.at(SAMPLE)])
            states = self._sides.state(before), self._sides.state(after)
            parameters = parameters_in(self._program, before), parameters_in(self._program, after)
            self._sink.changed(Change(passed, float(before[self._layout.time]), *states, parameters))
        if self._program.joined:
            self._accumulate(records, ~crossed)
        return self._hand_over(records[start:][crossed[start:]])

    def _accumulate(self, records: Array, after: NDArray[np.bool_]) -> None:
        """Hand over where infinitely many impacts end, as compiled code has recorded ``after`` them."""
        ends, endless = (records[:, self._layout.at(one)] for one in (ENDS, ENDLESS))
        for k in np.flatnonzero(after & (endless > 0.0)).tolist():
            event = int(records[k - 1, self._layout.at(NOTES[0])]) - self._sides.first
            if self._resting.at_once.first(event, float(ends[k])):
                self._sink.accumulated(event, float(ends[k]))

    def _hand_over(self, records: Array) -> Finished | None:
        """Hand over crossings that compiled code has recorded."""
        guards = records[:, self._layout.at(NOTES[0])]
        events = (guards - self._sides.first).astype(np.int64)
        if self._standstill.released:
            pairs = zip(events, records[:, self._layout.time])
            crossed = np.array([not self._standstill.leaving(int(e), float(t)) for e, t in pairs], dtype=bool)
            records, events = records[crossed], events[crossed]
        if not len(events):
            return None
        self._resting.released.difference_update(events.tolist())
        for event, time in zip(events.tolist(), records[:, self._layout.time].tolist()):
            if event in self._sides.sets and event not in self._resting.impacts:
                self._resting.times[event] = time, 0.0
        rates = [records[:, self._layout.at(one)] for one in NOTES[1:]]
        return self.crossed(records, events, np.array(rates))

    def crossed(self, memories: Array, events: NDArray[np.int64], rates: Array) -> Finished | None:
        """Hand over that events happened, with the state's memory then (k, memory). The first coefficients of
        their arguments' series were 0 and ``rates`` (3, k)."""
        layout, program, sides = self._layout, self._program, self._sides
        t, low = (memories[:, layout.at(one)].copy() for one in (Clock.TIME, Clock.TIME_LOW))
        lengths = memories[:, layout.at(Clock.LENGTH)]
        states = memories.take(sides.places, axis=1)
        reached = np.max(np.abs(states[:, : program.rows]), axis=1)
        grazing, errors = doubts(
            rates, lengths, t, reached, ULP[program.parts],
            lambda k: float(sides.sizes_then(memories[k])[events[k], 0]),
        )  # fmt: skip
        self._sink.crossed(Crossings(events, t, low, states, grazing, errors))
        self._count += len(events)
        if self._count > self._most:
            return self.finished(Ending.TOO_MANY_EVENTS, int(events[-1]))
        return None
