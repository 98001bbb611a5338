"""Motions followed backward: a method in reversed time s = -t (see ``mechanics.backward``), seen from
outside in t."""

from __future__ import annotations

from typing import TypeVar

import numpy as np

from lagrange_cli.integrate.arrays import Array
from lagrange_cli.integrate.events import Crossings, EventSink
from lagrange_cli.integrate.method import UNOBSERVED, CheckpointSink, End, Method, Observer, Snapshot, Start
from lagrange_cli.integrate.times import Times
from lagrange_cli.native.interface import Interface
from lagrange_cli.records import dataclass, replace

Time = TypeVar("Time", float, Array)


@dataclass(frozen=True)
class Backward:
    """A method that follows motions backward; ``method`` follows those of the reversed equations, whose
    compiled ``program`` it is given, forward.

    It changes only signs, so that nothing is rounded.
    """

    method: Method
    program: Interface

    def follow(self, start: Start, observer: Observer = UNOBSERVED, threads: int | None = 1) -> End:
        """See ``integrate.method.Method``."""
        reversed_observer = Observer(
            lambda when, states: observer.samples(reversed_time(when), reversed_state(self.program, states)),
            lambda s: observer.interrupt(reversed_time(s)),
            BackwardEvents(self.program, observer.events),
            reversed_checkpoints(observer.checkpoints),
        )
        end = self.method.follow(reversed_start(self.program, start), reversed_observer, threads)
        return replace(
            end,
            t=reversed_time(end.t),
            state=reversed_state(self.program, end.state),
            snapshot=None if end.snapshot is None else reversed_snapshot(end.snapshot),
        )


def reversed_start(program: Interface, start: Start) -> Start:
    """The same beginning in reversed time."""
    return replace(start, state=reversed_state(program, start.state), times=reversed_times(start.times))


class BackwardEvents(EventSink):
    """Passes on the events of reversed time."""

    def __init__(self, program: Interface, sink: EventSink) -> None:
        self._program, self._sink = program, sink
        self.names, self.before, self.states = sink.names, sink.before, sink.states

    def crossed(self, crossings: Crossings) -> None:
        times = {name: reversed_time(getattr(crossings, name)) for name in ("t", "low")}
        states = reversed_state(self._program, crossings.states.T).T
        self._sink.crossed(replace(crossings, **times, states=states))

    def grazed(self, event: int, t: float) -> None:
        self._sink.grazed(event, reversed_time(t))


def reversed_time(t: Time) -> Time:
    """-t, without negative zeros."""
    return 0.0 - t


def reversed_times(times: Times) -> Times:
    """The same instants in reversed time."""
    start, stop, step = map(reversed_time, (times.start, times.stop, times.step))
    return replace(times, start=start, stop=stop, step=step)


def reversed_state(program: Interface, states: Array) -> Array:
    """States (rows, ...), of every part of the numbers, with the signs of the velocities changed."""
    found = np.array(states)
    layout = program.state
    for first in range(0, len(states), layout.rows):
        given, changed = (one[first : first + layout.rows][layout.v] for one in (states, found))
        np.subtract(0.0, given, out=changed)
    return found


def reversed_checkpoints(sink: CheckpointSink) -> CheckpointSink:
    """Snapshots of reversed time for a sink of the motion's."""
    ends = sink.ends
    return replace(
        sink,
        begin=None if sink.begin is None else reversed_snapshot(sink.begin),
        keep=lambda snapshot: sink.keep(reversed_snapshot(snapshot)),
        ends=None if ends is None else lambda snapshot: ends(reversed_snapshot(snapshot)),
    )


def reversed_snapshot(snapshot: Snapshot) -> Snapshot:
    """A snapshot with its time in the other sense; its memory is the method's own."""
    return replace(snapshot, t=reversed_time(snapshot.t))
