"""What happened at events: crossings, which are recorded, and what actions changed."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, TypeAlias

from lagrange_cli.records import dataclass, fields_of, replace

if TYPE_CHECKING:
    from collections.abc import Callable

    import numpy as np
    from numpy.typing import NDArray

    from lagrange_cli.integrate.arrays import Array
    from lagrange_cli.native.interface import Interface


Judge: TypeAlias = "Callable[[Array], str]"
"""Finds which energy jumps with values of the parameters; an empty text if none does."""


def no_energy(parameters: Array) -> str:
    """None jumps."""
    return ""


@dataclass(frozen=True)
class Crossings:
    """That events happened, one after the other: their numbers (k,), t with its low part (k,), and the
    ``states`` before any action (k, rows of all parts). Where one is ``grazing``, rounding may have decided
    that it happened; where its expression is 0 together with its rate, the ``errors`` of t are large (else
    0)."""

    events: NDArray[np.int64]
    t: Array
    low: Array
    states: Array
    grazing: NDArray[np.bool_]
    errors: Array


@dataclass(frozen=True)
class Change:
    """What an action changed: the states ``before`` and ``after`` at ``t`` (rows of all parts), and the
    ``parameters`` before and after. ``sample`` is the number of the first sample after it."""

    sample: int
    t: float
    before: Array
    after: Array
    parameters: tuple[Array, Array]


@dataclass(frozen=True)
class Happened:
    """The record of an event: how often it has happened, and when ``last``; how many of its zeros were
    ``grazing``, with the time of the first; how many times infinitely many of them have come to an end,
    ``accumulates`` being the first such time; and the largest of the ``error``s of times that rounding makes
    large, with that time, ``blurred``."""

    count: int = 0
    last: float | None = None
    grazing: int = 0
    grazes: float | None = None
    accumulations: int = 0
    accumulates: float | None = None
    error: float = 0.0
    blurred: float | None = None

    @property
    def doubtful(self) -> bool:
        """Whether rounding may have decided when, or whether, it has happened."""
        return self.blurred is not None or self.grazes is not None

    def as_data(self) -> list[Any]:
        """The fields in terms of JSON."""
        return [getattr(self, name) for name in fields_of(self)]


class EventSink:
    """Takes what happens: crossings in order, changes before the samples that follow them. This one forgets
    it."""

    names: tuple[str, ...] = ()
    """The names of the events, by number."""
    before = 0
    """Crossings in an earlier run, which this one continues."""
    states = True
    """Whether changes of the state alone matter, or those of parameters only."""
    in_turn = False
    """Whether a change is told between the crossings before and behind it: else, as soon as it is known."""

    def crossed(self, crossings: Crossings) -> None:
        """Events have happened."""

    def changed(self, change: Change) -> None:
        """An action has changed something."""

    def grazed(self, event: int, t: float) -> None:
        """An event's expression has become 0 without changing its sign, as far as rounding can tell."""

    def accumulated(self, event: int, t: float) -> None:
        """Infinitely many of these events end at ``t``; from then on the motion rests there."""


NO_EVENTS = EventSink()


class HappenedSink(EventSink):
    """Keeps the record of each event."""

    def __init__(self, names: tuple[str, ...]) -> None:
        import numpy as np

        self.names, self._happened = names, [Happened() for _ in names]
        self._counts, self._last = np.zeros(len(names), dtype=np.int64), np.full(len(names), np.nan)

    @property
    def happened(self) -> tuple[Happened, ...]:
        """The record of each event, by number."""
        for event in self._counts.nonzero()[0].tolist():
            before, count = self._happened[event], int(self._counts[event])
            last = float(self._last[event])
            self._happened[event] = replace(before, count=before.count + count, last=last)
        self._counts[:] = 0
        return tuple(self._happened)

    def crossed(self, crossings: Crossings) -> None:
        import numpy as np

        np.add.at(self._counts, crossings.events, 1)
        self._last[crossings.events] = crossings.t  # of those of one event the last
        for k in crossings.errors.nonzero()[0].tolist():
            event, error = int(crossings.events[k]), float(crossings.errors[k])
            if error > self._happened[event].error:
                blurred = float(crossings.t[k])
                self._happened[event] = replace(self._happened[event], error=error, blurred=blurred)
        for k in crossings.grazing.nonzero()[0].tolist():
            self.grazed(int(crossings.events[k]), float(crossings.t[k]))

    def grazed(self, event: int, t: float) -> None:
        before = self._happened[event]
        first = t if before.grazes is None else before.grazes
        self._happened[event] = replace(before, grazing=before.grazing + 1, grazes=first)

    def accumulated(self, event: int, t: float) -> None:
        before = self._happened[event]
        first = t if before.accumulates is None else before.accumulates
        times = before.accumulations + 1
        self._happened[event] = replace(before, accumulations=times, accumulates=first)


def kept_at_once(count: int) -> int:
    """How many numbers a continued run needs of what happens at one time, for so many events, and of the last
    step; the first of them is whole."""
    return 4 + 2 * count


def parameters_in(program: Interface, memory: Array) -> Array:
    """The parameters of a motion, of all parts, in the memory of a state: actions may change them."""
    rows = program.rows_of_guards
    width = rows.parameters + rows.count
    settings = memory[program.inner.settings][: program.given * width]
    return settings.reshape(-1, width)[:, : rows.parameters].flatten()
