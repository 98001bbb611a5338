"""``EventLog``: gathers what happens at the events of a motion, and makes crossings into datasets."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from lagrange_cli.integrate.events import Change, Crossings, Happened, HappenedSink
from lagrange_cli.integrate.samples import LOW

if TYPE_CHECKING:
    from lagrange_cli.integrate.prepared import Prepared
    from lagrange_cli.integrate.samples import Samples

MANY, MEMORY = 4096, 2**23
"""Crossings, and bytes of their states, that are gathered before they are handed over, with those that
compiled code has made at once."""


MEMBER = "member"
"""The dataset that says to which member of an ensemble crossings belong."""


class EventLog(HappenedSink):
    """Gathers crossings by event, and hands them over to ``emit`` as datasets by path (see
    ``EventGroup``)."""

    def __init__(self, prepared: Prepared, samples: Samples, emit: Callable[[dict[str, Any]], None]) -> None:
        self._prepared, self._samples, self._emit = prepared, samples, emit
        super().__init__(tuple(name for group in prepared.recording.events for name in group.members))
        self.states = samples.balances
        self._crossings: list[Crossings] = []
        self._gathered = self._bytes = 0

    def crossed(self, crossings: Crossings) -> None:
        super().crossed(crossings)
        self._crossings.append(crossings)
        self._gathered += len(crossings.t)
        self._bytes += crossings.states.nbytes
        if self._gathered >= MANY or self._bytes >= MEMORY:
            self.hand_over()

    def changed(self, change: Change) -> None:
        self._samples.change(change)

    def restore(self, happened: Sequence[Happened]) -> None:
        """Go on from what happened in an earlier run."""
        self._happened, self.before = list(happened), sum(one.count for one in happened)

    def hand_over(self) -> None:
        """Emit what has been gathered since the last time: t, q and v, and in a family its indices."""
        gathered, self._crossings = self._crossings, []
        self._gathered = self._bytes = 0
        if gathered:
            self._emit(crossing_datasets(self._prepared, gathered))


def crossing_datasets(
    prepared: Prepared, gathered: Sequence[Crossings], members: Sequence[int] | None = None
) -> dict[str, Any]:
    """The datasets of crossings by path, of the events that have any; ``members`` are those of an ensemble
    that they belong to."""
    recording, program = prepared.recording, prepared.machine.program
    events, t, low, states = (
        np.concatenate([getattr(one, name) for one in gathered]) for name in ("events", "t", "low", "states")
    )
    found: dict[str, Any] = {}
    first = 0
    for group in recording.events:
        own = (events >= first) & (events < first + len(group.members))
        numbers, first = events[own] - first, first + len(group.members)
        if not len(numbers):
            continue
        found[f"{group.path}/t"] = t[own]
        if members is not None:
            each = np.repeat(np.array(members, np.int64), [len(one.t) for one in gathered])
            found[f"{group.path}/{MEMBER}"] = each[own]
        for index, place in zip(group.indices, group.places(numbers)):
            found[f"{group.path}/{index}"] = np.asarray(place, np.int64)
        parts = states[own].T.reshape(program.parts, program.rows, -1)
        for part, prefix in zip(parts, ("", LOW)):
            for path, row in recording.crossing_series(part).items():
                found[f"{prefix}{group.path}/{path}"] = row
        if program.parts > 1:
            found[f"{LOW}{group.path}/t"] = low[own]
    return found
