"""What happened at events: crossings, which are recorded, and what actions changed."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from lagrange_cli.records import dataclass, field

if TYPE_CHECKING:
    from lagrange_cli.integrate.arrays import Array
    from lagrange_cli.integrate.prepared import Prepared
    from lagrange_cli.integrate.samples import Samples
    from lagrange_cli.native.interface import Interface


@dataclass(frozen=True)
class Crossing:
    """That an event happened: its number, t with its low part, and the ``state`` before any action (rows of
    all parts). If it is ``grazing``, rounding may have decided that it happened."""

    event: int
    t: float
    low: float
    state: Array
    grazing: bool = False


@dataclass(frozen=True)
class Change:
    """What an action changed: the states ``before`` and ``after`` at ``t`` (rows of all parts), and the
    ``parameters`` before and after. ``sample`` is the number of the first sample after it."""

    sample: int
    t: float
    before: Array
    after: Array
    parameters: tuple[Array, Array]


class EventSink:
    """Takes what happens: crossings in order, changes before the samples that follow them. This one forgets
    it."""

    names: tuple[str, ...] = ()
    """Of the events, by number."""

    def crossed(self, crossings: Sequence[Crossing]) -> None:
        """Events have happened."""

    def changed(self, change: Change) -> None:
        """An action has changed something."""

    def grazed(self, event: int, t: float) -> None:
        """An event's expression has become 0 without changing its sign, as far as rounding can tell."""

    def accumulated(self, event: int, t: float) -> None:
        """Infinitely many of these events end at ``t``; from then on the motion rests there."""


NO_EVENTS = EventSink()


def parameters_in(program: Interface, memory: Array) -> Array:
    """The parameters of a motion, of all parts, in the memory of a state: actions may change them."""
    rows = program.rows_of_guards
    width = rows.parameters + rows.count
    settings = memory[program.inner.settings][: program.parts * width]
    return settings.reshape(-1, width)[:, : rows.parameters].flatten()


class EventLog(EventSink):
    """Gathers crossings by event, and hands them over as datasets (see ``EventGroup``)."""

    def __init__(self, prepared: Prepared, samples: Samples) -> None:
        self._prepared, self._samples = prepared, samples
        self._groups = prepared.recording.events
        self.names = tuple(name for group in self._groups for name in group.members)
        self.happened = {name: Happened() for name in self.names}
        self._crossings: list[Crossing] = []

    def crossed(self, crossings: Sequence[Crossing]) -> None:
        self._crossings += crossings
        for one in crossings:
            happened = self.happened[self.names[one.event]]
            happened.count += 1
            happened.last = one.t
            if one.grazing:
                happened.grazing.append(one.t)

    def changed(self, change: Change) -> None:
        self._samples.change(change)

    def grazed(self, event: int, t: float) -> None:
        self.happened[self.names[event]].grazing.append(t)

    def accumulated(self, event: int, t: float) -> None:
        self.happened[self.names[event]].accumulated.append(t)

    def counts(self) -> tuple[int, ...]:
        """How often each event has happened."""
        return tuple(one.count for one in self.happened.values())

    def take(self) -> dict[str, Any]:
        """What has been gathered since the last call, by path: t, q and v, and in a family its indices."""
        import numpy as np

        from lagrange_cli.integrate.samples import LOW

        found: dict[str, Any] = {}
        recording, program = self._prepared.recording, self._prepared.machine.program
        gathered, self._crossings = self._crossings, []
        first = 0
        for group in self._groups:
            numbers = range(first, first + len(group.members))
            first = numbers.stop
            own = [one for one in gathered if one.event in numbers]
            if not own:
                continue
            found[f"{group.path}/t"] = np.array([one.t for one in own])
            places = np.unravel_index([one.event - numbers.start for one in own], group.shape or (1,))
            for axis, place in zip(group.axes, places):
                found[f"{group.path}/{axis}"] = np.asarray(place, np.int64)
            states = np.array([one.state for one in own]).T
            for part, prefix in zip(states.reshape(program.parts, program.rows, -1), ("", LOW)):
                for path, row in recording.state_series(part).items():
                    found[f"{prefix}{group.path}/{path}"] = row
            if program.parts > 1:
                found[f"{LOW}{group.path}/t"] = np.array([one.low for one in own])
        return found


@dataclass
class Happened:
    """All that is to be said of an event at the end of a run."""

    count: int = 0
    last: float | None = None
    grazing: list[float] = field(default_factory=list)
    accumulated: list[float] = field(default_factory=list)
