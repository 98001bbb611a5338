"""What happened at events: crossings, which are recorded, and what actions changed."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from lagrange_cli.records import dataclass, field

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from lagrange_cli.integrate.arrays import Array
    from lagrange_cli.integrate.prepared import Prepared
    from lagrange_cli.integrate.samples import Samples
    from lagrange_cli.native.interface import Interface


@dataclass(frozen=True)
class Crossings:
    """That events happened, one after the other: their numbers (k,), t with its low part (k,), and the
    ``states`` before any action (k, rows of all parts). Where one is ``grazing``, rounding may have decided
    that it happened."""

    events: NDArray[np.int64]
    t: Array
    low: Array
    states: Array
    grazing: NDArray[np.bool_]


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

    def crossed(self, crossings: Crossings) -> None:
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
        self._crossings: list[Crossings] = []

    def crossed(self, crossings: Crossings) -> None:
        import numpy as np

        self._crossings.append(crossings)
        for event in np.unique(crossings.events):
            own = crossings.events == event
            happened = self.happened[self.names[event]]
            happened.count += int(own.sum())
            happened.last = float(crossings.t[own][-1])
            happened.grazing += crossings.t[own & crossings.grazing].tolist()

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
        gathered, self._crossings = self._crossings, []
        if not gathered:
            return found
        recording, program = self._prepared.recording, self._prepared.machine.program
        events, t, low, states = (
            np.concatenate([getattr(one, name) for one in gathered])
            for name in ("events", "t", "low", "states")
        )
        first = 0
        for group in self._groups:
            own = (events >= first) & (events < first + len(group.members))
            numbers, first = events[own] - first, first + len(group.members)
            if not len(numbers):
                continue
            found[f"{group.path}/t"] = t[own]
            for axis, place in zip(group.axes, np.unravel_index(numbers, group.shape or (1,))):
                found[f"{group.path}/{axis}"] = np.asarray(place, np.int64)
            parts = states[own].T.reshape(program.parts, program.rows, -1)
            for part, prefix in zip(parts, ("", LOW)):
                for path, row in recording.state_series(part).items():
                    found[f"{prefix}{group.path}/{path}"] = row
            if program.parts > 1:
                found[f"{LOW}{group.path}/t"] = low[own]
        return found


@dataclass
class Happened:
    """All that is to be said of an event at the end of a run."""

    count: int = 0
    last: float | None = None
    grazing: list[float] = field(default_factory=list)
    accumulated: list[float] = field(default_factory=list)
