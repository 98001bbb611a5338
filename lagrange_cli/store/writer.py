"""``Writer``: appends samples, and crossings of events, to an HDF5 file, which gets its name when it is
complete."""

from __future__ import annotations

import binascii
import heapq
import math
from collections.abc import Iterator, Mapping, Sequence
from operator import itemgetter
from typing import TYPE_CHECKING, Any

import numpy as np

from lagrange_cli.records import replace
from lagrange_cli.store.layout import Layout
from lagrange_cli.store.output import Output, open_file
from lagrange_cli.store.scales import Scales, describe
from lagrange_cli.store.sink import Sink
from lagrange_cli.store.target import Target

if TYPE_CHECKING:
    from lagrange_cli.integrate.times import Times
    from lagrange_cli.store.checkpoint import Checkpoint
    from lagrange_cli.store.layout import Layout, Series
    from lagrange_cli.store.resume import Earlier


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


TIME = "t"


class Writer(Output):
    """A context in which ``append`` adds samples, ``append_crossings`` adds crossings of events, and
    ``close`` completes the file (see ``Output``).

    Memory is bounded for any number of samples, and the bytes do not depend on how many are appended at a
    time: the chunks of the file are in the order of the times at which they are full, those of events before
    those of samples. Every series has the sample times ``/t`` attached as the HDF5 dimension scale of its
    first axis, those of an event have the times of its crossings; for the other axes see ``Scales``.
    """

    def __init__(self, target: Target, layout: Layout, times: Times) -> None:
        rows, self._layout, self._times = layout.chunk_rows(times.count), layout, times
        self._sense, self._filled = (-1.0 if times.backward else 1.0), 0
        self._latest = -math.inf

        def create(sink: Sink) -> Any:
            file = open_file(sink, 0)
            samples, scales = create_samples(file, layout, rows)
            events = create_events(file, layout, scales)
            self._samples = Growing(sink, samples, rows)
            self._events = [Crossed(sink, one, layout.crossing_rows()) for one in events]
            return file

        super().__init__(target, create)
        self._rest = {one.path: np.zeros((rows, *one.shape)) for one in (layout.time, *layout.series)}

    def append(self, chunk: Mapping[str, np.ndarray]) -> None:
        """Add the samples of a chunk: ``chunk[path]`` has shape (c, *shape) for ``t`` and every series.

        All crossings up to the last of them must have been appended.
        """
        done, count, rows = 0, len(chunk[TIME]), self._samples.rows
        if count:
            self.last = float(chunk[TIME][-1])
        while done < count:
            part = slice(done, min(count, done + rows - self._filled))
            taken = part.stop - part.start
            if taken < rows:
                for path, rest in self._rest.items():
                    rest[self._filled : self._filled + taken] = chunk[path][part]
            self._filled, done = (self._filled + taken) % rows, part.stop
            if self._filled == 0:
                self._write_crossings(self._next_full())
                for path, rest in self._rest.items():
                    self._samples.write(path, rest if taken < rows else chunk[path][part])
                self._samples.written += rows
        self._write_known()
        self.check()

    def append_crossings(self, chunk: Mapping[str, np.ndarray]) -> None:
        """Add crossings: ``chunk[path]`` has shape (c, *shape) for every series of an event, or for none.

        Those of each event are in the order of time, and later ones are not before the last of these.
        """
        for event in self._events:
            event.collect(chunk)
            if len(chunk.get(event.time, ())):
                self._latest = max(self._latest, self._sense * float(chunk[event.time][-1]))
        self._write_known()
        self.check()

    def _write_known(self) -> None:
        """Write the chunks of events that come before everything to be appended."""
        self._write_crossings(min(self._next_full(), math.nextafter(self._latest, -math.inf)))

    def _next_full(self) -> float:
        """When the chunk of samples that is being filled will be full."""
        last = self._times.chunk(self._samples.written + self._samples.rows - 1, 1)
        return self._sense * float(last[0]) if len(last) else math.inf

    def _write_crossings(self, until: float) -> None:
        """Write the chunks of events that are full by then."""
        while True:
            full = ((event.complete_at, i) for i, event in enumerate(self._events))
            found = [(self._sense * time, i) for time, i in full if time is not None]
            if not found or min(found)[0] > until:
                return
            self._events[min(found)[1]].write_next()

    def finish(self) -> None:
        """Write what does not fill a chunk."""
        self._write_crossings(math.inf)
        if self._filled:
            for path, rest in self._rest.items():
                self._samples.write_last(path, rest, self._filled)
        for event in self._events:
            event.finish()

    def restore(self, earlier: Earlier, rows: int, samples: int, crossings: Sequence[int]) -> None:
        """Append what an earlier run had: so many ``samples``, in chunks of ``rows``, and so many
        ``crossings`` of each event; raises ``Unusable``."""
        series, per_chunk = (self._layout.time, *self._layout.series), self._layout.crossing_rows()
        tables = [(event.series, per_chunk, count) for event, count in zip(self._layout.events, crossings)]

        def timed(table: int) -> Iterator[tuple[float, int, dict[str, np.ndarray]]]:
            columns, size, count = tables[table]
            for chunk in earlier.chunks(size, columns, count):
                yield self._sense * float(chunk[columns[0].path][-1]), table, chunk

        tables.append((series, rows, samples))
        for _, table, chunk in heapq.merge(*map(timed, range(len(tables))), key=itemgetter(0, 1)):
            (self.append if table == len(crossings) else self.append_crossings)(chunk)

    def state(self) -> dict[str, np.ndarray]:
        """Where the samples and the crossings are: the ``pieces``, and the rest itself."""
        rest = {f"rest/{path}": rest[: self._filled].copy() for path, rest in self._rest.items()}
        crossings = {f"rest/{path}": rows for one in self._events for path, rows in one.waiting.items()}
        return {**self.pieces(), **rest, **crossings}

    def pieces(self) -> dict[str, np.ndarray]:
        """For each series, the places of its chunks with their checksums (chunks, 2)."""
        return {path: one for table in (self._samples, *self._events) for path, one in table.pieces().items()}

    def close(
        self,
        attributes: Mapping[str, str | int | float],
        checkpoint: Checkpoint | None = None,
        further: Checkpoint | None = None,
    ) -> None:
        """See ``Output``; ``further`` is completed by where the samples are."""
        self.finish()
        if further is not None:
            further = replace(further, arrays={**further.arrays, **self.pieces()})
        super().close(attributes, checkpoint, further)
