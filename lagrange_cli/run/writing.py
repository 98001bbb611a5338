"""The file of a run: its layout, its checkpoints, and its completion."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

from lagrange_cli.records import replace
from lagrange_cli.run.attributes import attributes, series_of

if TYPE_CHECKING:
    from lagrange_cli.integrate.checkpoint import Progress
    from lagrange_cli.integrate.outcome import Outcome
    from lagrange_cli.run.motion import Ready
    from lagrange_cli.run.resume import Start
    from lagrange_cli.run.settings.settings import Settings
    from lagrange_cli.store.checkpoint import Checkpoint
    from lagrange_cli.store.layout import EventSeries, Layout
    from lagrange_cli.store.writer import Writer


def layout_of(ready: Ready, units: Mapping[str, str]) -> Layout:
    """The datasets of the run, with their ``units`` by path, and the groups of its events."""
    from lagrange_cli.store.layout import Layout

    series = series_of(units, ready.prepared)
    if ready.companions:
        from lagrange_cli.run.certify import series_of_errors

        series = series_of_errors(series, series_of(units, ready.companions[0]))
    events: tuple[EventSeries, ...] = ()
    if ready.motion.spec.events:
        from lagrange_cli.run.events import crossings_of

        events = crossings_of(ready.motion.spec, ready.prepared, units)
    return Layout(series, time_unit=units.get("t", ""), events=events)


def checkpoint(start: Start, writer: Writer, reached: Progress, *, inside: bool = False) -> Checkpoint:
    """The checkpoint of a run that has ``reached`` so much, to stand ``inside`` the output or beside it."""
    arrays = {**reached.snapshot.arrays, **writer.state()}
    content = {"reached": reached.snapshot.t, "progress": reached.as_data()}
    return start.checkpoint(content, arrays, inside=inside)


def complete(writer: Writer, start: Start, outcome: Outcome, settings: Settings) -> None:
    """Close the file, with how the motion ended and what it can be continued from."""
    inside: Checkpoint | None = None
    further: Checkpoint | None = None
    if outcome.progress is not None and outcome.ending.status not in ("failed", "stopped"):
        last = checkpoint(start, writer, outcome.progress, inside=True)
        if outcome.ending.status == "interrupted":
            inside = last
        else:
            arrays = outcome.progress.snapshot.arrays
            further = replace(last, head={**last.head, "replace": False}, arrays=arrays)
    writer.close(attributes(start.made_by, outcome, settings), inside, further)
