"""Runs that are written as a table, to a CSV file or to standard output."""

from __future__ import annotations

import sys
from collections.abc import Sequence
from typing import TYPE_CHECKING

from lagrange_cli.cli.console import discard_output
from lagrange_cli.cli.options.certify import certificate_of
from lagrange_cli.cli.signals import Interrupts
from lagrange_cli.errors import FileError, UsageError

if TYPE_CHECKING:
    import numpy as np

    from lagrange_cli.cli.options.certify import Demand
    from lagrange_cli.cli.options.run import Request
    from lagrange_cli.cli.report.progress import Progress
    from lagrange_cli.integrate.outcome import Outcome
    from lagrange_cli.integrate.prepared import Prepared
    from lagrange_cli.integrate.times import Times
    from lagrange_cli.run.timings import Stopwatch
    from lagrange_cli.spec.values import Values
    from lagrange_cli.store.layout import Series
    from lagrange_cli.store.target import Target


def check_table(request: Request) -> None:
    """Refuse what a table cannot have."""
    if request.resume:
        raise UsageError("--resume needs an HDF5 output: a CSV file stores no checkpoint")
    if request.streams and request.as_json:
        raise UsageError("--json and the table would both go to standard output: give --output a name")


def tabulate(
    prepared: Prepared,
    values: Values,
    times: Times,
    series: Sequence[Series],
    target: Target,
    watch: Stopwatch,
    shown: Progress,
    request: Request,
    demand: Demand | None,
    companions: Sequence[Prepared],
) -> Outcome | None:
    """Integrate chunk by chunk into the table, whatever way the motion ends; None where it was streamed to a
    reader that has hung up."""
    from lagrange_cli.integrate.ending import Ending
    from lagrange_cli.integrate.run import integrate
    from lagrange_cli.store.csv_file import CsvFile

    if request.streams and (sys.stdout is None or sys.stdout.closed):
        raise FileError("standard output is closed: give --output a name")
    with Interrupts() as interrupted:
        with watch.stage("write"):
            table = CsvFile(None, series, sys.stdout.buffer) if request.streams else CsvFile(target, series)

        def emit_chunk(chunk: dict[str, np.ndarray]) -> None:
            with watch.stage("write"):
                table.append(chunk)

        with table:
            with watch.stage("integrate"), certificate_of(demand, companions, values, times) as certificate:
                outcome = integrate(
                    prepared,
                    values,
                    times,
                    emit_chunk,
                    lambda: interrupted() or table.gone,
                    shown.show,
                    certificate=certificate,
                )
            shown.clear()
            with watch.stage("write"):
                table.close(complete=outcome.ending is Ending.COMPLETE)
    if table.gone:
        discard_output()
        return None
    return outcome
