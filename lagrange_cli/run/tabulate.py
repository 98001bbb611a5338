"""Runs that are written as a table, to a CSV file or to a stream."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, BinaryIO

from lagrange_cli.run.motion import follow
from lagrange_cli.store.csv_file import CsvFile

if TYPE_CHECKING:
    import numpy as np

    from lagrange_cli.integrate.outcome import Outcome
    from lagrange_cli.run.certify import Demand
    from lagrange_cli.run.monitor import Monitor
    from lagrange_cli.run.motion import Ready
    from lagrange_cli.store.layout import Series
    from lagrange_cli.store.target import Target


def tabulate(
    ready: Ready,
    series: Sequence[Series],
    target: Target,
    monitor: Monitor,
    demand: Demand | None,
    stream: BinaryIO | None,
) -> tuple[Outcome | None, Target]:
    """Integrate chunk by chunk into the table, however the motion ends; None where it was streamed to a
    reader that has hung up."""
    stage = monitor.stage
    if ready.motion.spec.events:
        monitor.tell(f"{ready.motion.spec.name}: events are written to HDF5 files only, not to tables")
    with monitor.interrupts() as interrupted:
        with stage("write"):
            table = CsvFile(target, series) if stream is None else CsvFile(None, series, stream)

        def emit_chunk(chunk: dict[str, np.ndarray]) -> None:
            with stage("write"):
                table.append(chunk)

        with table:
            outcome = follow(ready, demand, monitor, emit_chunk, lambda: interrupted() or table.gone)
            with stage("write"):
                table.close(outcome.ending.status)
    return None if table.gone else outcome, table.target or target
