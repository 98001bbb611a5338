"""``MemberCrossings``: the crossings of an event in the members of an ensemble, until all have ended."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from lagrange_cli.store.layout import EventSeries

MEMBER = "member"
BEGINNING = "crossings/"
"""How the names of their arrays in a checkpoint begin."""


class MemberCrossings:
    """Crossings by dataset, in any order of the members, those of each in the order of time."""

    def __init__(self, event: EventSeries) -> None:
        self._series, self._member = event.series, f"{event.group}/{MEMBER}"
        self._chunks: list[dict[str, np.ndarray]] = []
        self.bytes = 0

    def collect(self, chunk: Mapping[str, np.ndarray]) -> None:
        """Add crossings: ``chunk[path]`` has shape (c, *shape) for every series, or for none."""
        if self._member in chunk:
            own = {one.path: np.array(chunk[one.path], one.kind) for one in self._series}
            self._chunks.append(own)
            self.bytes += sum(rows.nbytes for rows in own.values())

    @property
    def count(self) -> int:
        """The number of crossings."""
        return sum(len(chunk[self._member]) for chunk in self._chunks)

    def in_order(self) -> dict[str, np.ndarray]:
        """All of them, members one by one."""
        found = {
            one.path: np.concatenate(
                [np.empty((0, *one.shape), one.kind), *(chunk[one.path] for chunk in self._chunks)]
            )
            for one in self._series
        }
        order = np.argsort(found[self._member], kind="stable")
        return {path: rows[order] for path, rows in found.items()}

    def arrays(self) -> dict[str, np.ndarray]:
        """Their arrays in a checkpoint."""
        return {BEGINNING + path: rows for path, rows in self.in_order().items()}

    def restore(self, arrays: Mapping[str, np.ndarray]) -> bool:
        """Take them over from a checkpoint; whether they are such arrays."""
        found = {one.path: arrays.get(BEGINNING + one.path) for one in self._series}
        count = None
        for one in self._series:
            rows = found[one.path]
            if rows is None or rows.dtype != one.kind or rows.shape[1:] != one.shape or rows.ndim == 0:
                return False
            count = len(rows) if count is None else count
            if len(rows) != count:
                return False
        self.collect({path: rows for path, rows in found.items() if rows is not None})
        return True
