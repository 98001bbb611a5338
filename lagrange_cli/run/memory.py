"""``Followed``: a motion that is followed without a file, and written to one later if at all."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from math import inf
from typing import TYPE_CHECKING

import numpy as np

from lagrange_cli.integrate.checkpoint import Checkpointing, Progress, Schedule
from lagrange_cli.records import dataclass
from lagrange_cli.run.attributes import origin
from lagrange_cli.run.monitor import SILENT, Monitor
from lagrange_cli.run.motion import Ready, initial_state
from lagrange_cli.run.motion import follow as follow_motion
from lagrange_cli.run.request import CSV
from lagrange_cli.run.resume import Start, take_up
from lagrange_cli.run.writing import complete, layout_of

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from lagrange_cli.integrate.outcome import Outcome
    from lagrange_cli.integrate.times import Times
    from lagrange_cli.run.certify import Demand
    from lagrange_cli.run.motion import Motion
    from lagrange_cli.store.layout import Layout
    from lagrange_cli.store.target import Target


@dataclass(frozen=True)
class Followed:
    """A motion that was followed: how it ended, and what was computed, by path.

    ``samples`` (n, ...) has ``t`` and all that the file of the run would hold for the sample times,
    ``crossings`` (k, ...) the same for the crossings of events. The arrays cannot be written to.
    ``layout`` is that of the file.
    """

    motion: Motion
    times: Times
    layout: Layout
    outcome: Outcome
    samples: Mapping[str, NDArray[np.float64]]
    crossings: Mapping[str, NDArray[np.float64]]
    demand: Demand | None = None

    @property
    def made_by(self) -> dict[str, str | int | float]:
        """The root's attributes that say what makes the file."""
        motion = self.motion
        said = origin(
            motion.spec, motion.settings, dict(motion.values.parameters), initial_state(motion.values)
        )
        return said if self.demand is None else {**said, **self.demand.attributes()}


class Collector:
    """Collects chunks {path: rows}; a chunk is valid only while it is handed over."""

    def __init__(self) -> None:
        self._chunks: dict[str, list[NDArray[np.float64]]] = {}

    def add(self, chunk: Mapping[str, NDArray[np.float64]]) -> None:
        """Keep a copy of the rows."""
        for path, rows in chunk.items():
            self._chunks.setdefault(path, []).append(np.array(rows))

    def whole(self) -> dict[str, NDArray[np.float64]]:
        """All rows by path, for reading."""
        found = {path: joined(chunks) for path, chunks in self._chunks.items()}
        for rows in found.values():
            rows.flags.writeable = False
        return found


def joined(chunks: Sequence[NDArray[np.float64]]) -> NDArray[np.float64]:
    """One array of them; a single one is not copied."""
    return chunks[0] if len(chunks) == 1 else np.concatenate(chunks)


def follow(
    ready: Ready, units: Mapping[str, str], monitor: Monitor = SILENT, demand: Demand | None = None
) -> Followed:
    """Integrate a motion into memory. However it ends, what was computed is kept. ``units`` are by path.

    Raises ``UsageError`` where samples take more than is allowed, ``MemoryError`` where they do not fit.
    """
    layout = layout_of(ready, units)
    layout.check_size(ready.times.count)
    samples, crossings = Collector(), Collector()
    never = {one.path: np.empty((0, *one.shape)) for event in layout.events for one in event.series}
    whole = None if demand is not None else Checkpointing[Progress](None, Schedule(inf, inf), ignore)
    with monitor.interrupts() as interrupted:
        outcome = follow_motion(ready, demand, monitor, samples.add, interrupted, crossings.add, whole)
    happened = {**never, **crossings.whole()}
    return Followed(ready.motion, ready.times, layout, outcome, samples.whole(), happened, demand)


def ignore(reached: Progress) -> None:
    """No checkpoint is written: there is no file to go on with."""


def save(followed: Followed, target: Target, form: str) -> None:
    """Write the file that ``solve`` writes of such a run, to the last byte.

    Raises ``FileError`` where it cannot be written.
    """
    outcome, layout = followed.outcome, followed.layout
    with target.claimed():
        if form == CSV:
            from lagrange_cli.store.csv_file import CsvFile

            with CsvFile(target, layout.series) as table:
                if followed.samples:
                    table.append(followed.samples)
                table.close(outcome.ending.status)
            return
        from lagrange_cli.store.writer import Writer

        made_by = followed.made_by
        start: Start = take_up(target, made_by, resume=False, tell=lambda text: None)
        writer = Writer(target, layout, followed.times)
        with writer:
            writer.append_crossings(followed.crossings)
            if followed.samples:
                writer.append(followed.samples)
            complete(writer, start, outcome, followed.motion.settings)
