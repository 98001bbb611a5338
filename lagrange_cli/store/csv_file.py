"""``CsvFile``: appends chunks of samples to a CSV file that appears when it is whole, or to a stream.

The first line has the names of the columns: ``t``, then those of each series, which are called as in
expressions where that is possible (``theta``, ``theta_dot``, ``p_theta``, ``bob[0].x``). Numbers are written
with as few digits as give the same double again.
"""

from __future__ import annotations

import csv
import io
import os
from collections.abc import Mapping, Sequence
from contextlib import suppress
from itertools import product
from math import prod
from types import TracebackType
from typing import BinaryIO

import numpy as np

from lagrange_cli.expression.vocabulary import velocity_name
from lagrange_cli.store.layout import AXES, Series
from lagrange_cli.store.target import Target, unwritable

TIME = "t"
PREFIXES = {
    "low/": "low_",
    "diagnostics/error/as_run/": "error_as_run_",
    "diagnostics/error/": "error_",
    "diagnostics/ledger/": "ledger_",
    "diagnostics/p/": "p_",
    "p/": "p_",
    "diagnostics/": "",
    "positions/": "",
    "observables/": "",
    "q/": "",
}
"""The names of columns in place of the beginnings of their datasets' paths."""


class CsvFile:
    """A context in which ``append`` adds samples and ``close`` makes the file whole; leaving it before that
    removes what was written. Every method raises ``FileError`` where the file cannot be written.

    Without a ``target`` everything goes to ``stream``; where its reader has hung up, it is ``gone``, and what
    is appended goes nowhere.
    """

    def __init__(
        self, target: Target | None, series: Sequence[Series], stream: BinaryIO | None = None
    ) -> None:
        self.target, self._paths = target, [TIME, *(one.path for one in series)]
        self._name = "standard output" if target is None else target.shown
        self.gone = False
        if target is not None:
            target.discard()
            try:
                stream = open(target.temporary, "xb")  # noqa: SIM115 - closed by ``close``
            except OSError as error:
                raise unwritable(self._name, error) from error
        assert stream is not None
        self._stream = stream
        header = io.StringIO()
        csv.writer(header, lineterminator="\n").writerow(column_names(series))
        self._write(header.getvalue())

    def append(self, chunk: Mapping[str, np.ndarray]) -> None:
        """Add the samples of a chunk: ``chunk[path]`` has shape (c, *shape) for ``t`` and every series."""
        count = len(chunk[TIME])
        parts = [chunk[path].reshape(count, prod(chunk[path].shape[1:])) for path in self._paths]
        rows = np.concatenate(parts, axis=1).tolist()
        self._write("".join([",".join(map(repr, row)) + "\n" for row in rows]))

    def _write(self, text: str) -> None:
        if self.gone:
            return
        try:
            self._stream.write(text.encode())
            if self.target is None:
                self._stream.flush()
        except BrokenPipeError:
            self.gone = True
        except OSError as error:
            raise unwritable(self._name, error) from error

    def close(self, status: str) -> None:
        """Put the file on disk and give it its name, which depends on the ``status`` of the run."""
        if self.target is None:
            return
        try:
            self._stream.flush()
            os.fsync(self._stream.fileno())
            self._stream.close()
        except OSError as error:
            raise unwritable(self._name, error) from error
        self.target = self.target.publish(status)

    def __enter__(self) -> CsvFile:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        if self.target is not None and not self._stream.closed:
            with suppress(OSError):
                self._stream.close()
            self.target.discard()


def column_names(series: Sequence[Series]) -> list[str]:
    """The names of all columns; where two would be the same, the later has the path of its dataset."""
    found = [TIME]
    for one in series:
        names = columns_of(one, short_name(one.path))
        if set(names) & set(found):
            names = columns_of(one, one.path)
        found += names
    return found


def short_name(path: str) -> str:
    """The name of a series in a table: ``theta_dot`` for ``v/theta``."""
    for prefix, instead in PREFIXES.items():
        if path.startswith(prefix):
            return instead + short_name(path.removeprefix(prefix))
    return velocity_name(path.removeprefix("v/")) if path.startswith("v/") else path


def columns_of(series: Series, name: str) -> list[str]:
    """The columns of a series that is called ``name``: one for each member of a family and component."""
    family = series.shape[: len(series.shape) - (series.components > 0)]
    places = series.places or product(*map(range, family))
    members = [f"[{','.join(map(str, index))}]" if index else "" for index in places]
    components = [f".{axis}" for axis in AXES[: series.components]] or [""]
    return [name + member + component for member in members for component in components]
