"""``Growing``: datasets of one length that grow chunk by chunk, and ``Crossed``: those of an event."""

from __future__ import annotations

import binascii
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from lagrange_cli.store.scales import Scales, describe

if TYPE_CHECKING:
    from lagrange_cli.store.layout import Layout, Series
    from lagrange_cli.store.sink import Sink


class Growing:
    """Datasets by path with so many ``rows`` per chunk, of which ``written`` rows are in the file."""

    def __init__(self, sink: Sink, datasets: Mapping[str, Any], rows: int) -> None:
        self.rows, self.written = rows, 0
        self._sink, self._datasets = sink, datasets
        self._places: dict[str, list[int]] = {path: [] for path in datasets}
        self._sums: dict[str, list[int]] = {path: [] for path in datasets}

    def write(self, path: str, rows: np.ndarray) -> None:
        """Give a dataset its next chunk (rows, *shape) as it is: HDF5's own way copies it twice and fills
        the chunk with zeros first, which takes longer than the disk does."""
        dataset = self._datasets[path]
        dataset.id.set_extent((self.written + self.rows, *rows.shape[1:]))
        whole = np.ascontiguousarray(rows, dataset.dtype)
        self._sink.expect(whole)
        dataset.id.write_direct_chunk((self.written, *(0 for _ in rows.shape[1:])), whole)
        self._places[path].append(self._sink.found)
        self._sums[path].append(binascii.crc32(whole.data))

    def write_last(self, path: str, rows: np.ndarray, filled: int) -> None:
        """The same for a chunk of which so many rows are ``filled``, and there are no more."""
        rows[filled:] = 0
        self.write(path, rows)
        self._datasets[path].id.set_extent((self.written + filled, *rows.shape[1:]))

    def pieces(self) -> dict[str, np.ndarray]:
        """For each series, the places of its chunks with their checksums (chunks, 2)."""
        return {
            f"places/{path}": np.array([places, self._sums[path]], dtype="i8").T.reshape(-1, 2)
            for path, places in self._places.items()
        }


class Crossed(Growing):
    """The datasets of an event, that of the times first. The crossings that are ``waiting`` are written when
    it is known which chunks of other datasets come before theirs."""

    def __init__(self, sink: Sink, datasets: Mapping[str, Any], rows: int) -> None:
        super().__init__(sink, datasets, rows)
        self.time = next(iter(datasets))
        self.waiting = {path: np.empty(one.shape, one.dtype) for path, one in datasets.items()}

    def collect(self, chunk: Mapping[str, np.ndarray]) -> None:
        """Add crossings: ``chunk[path]`` has shape (c, *shape) for every series, or for none."""
        if self.time in chunk:
            self.waiting = {
                path: np.concatenate([before, chunk[path]], dtype=before.dtype)
                for path, before in self.waiting.items()
            }

    @property
    def complete_at(self) -> float | None:
        """The time of the last crossing of the next chunk, once this is full."""
        times = self.waiting[self.time]
        return float(times[self.rows - 1]) if len(times) >= self.rows else None

    def write_next(self) -> None:
        """Write the next chunk, which is full."""
        for path, rows in self.waiting.items():
            self.write(path, rows[: self.rows])
        self.waiting = {path: rows[self.rows :] for path, rows in self.waiting.items()}
        self.written += self.rows

    def finish(self) -> None:
        """Write all that waits."""
        while self.complete_at is not None:
            self.write_next()
        if filled := len(self.waiting[self.time]):
            for path, rows in self.waiting.items():
                self.write_last(path, np.resize(rows, (self.rows, *rows.shape[1:])), filled)


def create_samples(file: Any, layout: Layout, rows: int) -> tuple[dict[str, Any], Scales]:
    """The datasets of the samples by path, ``t`` first: empty, and growing in chunks of so many ``rows``."""
    times = create_series(file, layout.time, rows)
    times.make_scale("t")
    scales, datasets = Scales(file, layout), {layout.time.path: times}
    for series in layout.series:
        datasets[series.path] = create_series(file, series, rows)
        scales.attach(datasets[series.path], series, times)
    return datasets, scales


def create_events(file: Any, layout: Layout, scales: Scales) -> list[dict[str, Any]]:
    """The same for each event."""
    found, rows = [], layout.crossing_rows()
    for event in layout.events:
        datasets: dict[str, Any] = {}
        for series in event.series:
            one = datasets[series.path] = create_series(file, series, rows)
            if series.path.endswith("/t"):  # also the low part of the times: else readers take ``/t`` for it
                one.make_scale("t")
            else:
                scales.attach(one, series, datasets[event.series[0].path])
        file[event.group].attrs.update(event.attributes)
        found.append(datasets)
    return found


def create_series(file: Any, series: Series, rows: int) -> Any:
    """An empty dataset that can grow along its first axis, with its unit and name."""
    shape = series.shape
    dataset = file.create_dataset(
        series.path, shape=(0, *shape), maxshape=(None, *shape), chunks=(rows, *shape), dtype=series.kind
    )
    describe(dataset, series)
    return dataset
