"""``Writer``: appends chunks of samples to an HDF5 file, which gets its name when it is complete."""

from __future__ import annotations

import binascii
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from lagrange_cli.records import replace
from lagrange_cli.store.layout import Layout, Series
from lagrange_cli.store.output import Output, open_file
from lagrange_cli.store.scales import Scales, describe
from lagrange_cli.store.sink import Sink
from lagrange_cli.store.target import Target

if TYPE_CHECKING:
    from lagrange_cli.store.checkpoint import Checkpoint

TIME = "t"


class Writer(Output):
    """A context in which ``append`` adds samples and ``close`` completes the file (see ``Output``).

    Memory is bounded for any number of samples, and the bytes do not depend on how many are appended at a
    time. Every series has the sample times ``/t`` attached as the HDF5 dimension scale of its first
    axis; for the other axes see ``Scales``.
    """

    def __init__(self, target: Target, layout: Layout, *, expected: int) -> None:
        self.rows = layout.chunk_rows(expected)
        self._written = self._filled = 0
        self._places: dict[str, list[int]] = {}
        self._sums: dict[str, list[int]] = {}

        def create(sink: Sink) -> Any:
            file = open_file(sink, 0)
            self._datasets = create_datasets(file, layout, self.rows)
            return file

        super().__init__(target, create)
        self.shapes = {TIME: (), **{one.path: one.shape for one in layout.series}}
        self._places = {path: [] for path in self.shapes}
        self._sums = {path: [] for path in self.shapes}
        self._rest = {path: np.zeros((self.rows, *shape)) for path, shape in self.shapes.items()}

    def append(self, chunk: Mapping[str, np.ndarray]) -> None:
        """Add the samples of a chunk: ``chunk[path]`` has shape (c, *shape) for ``t`` and every series."""
        done, count = 0, len(chunk[TIME])
        if count:
            self.last = float(chunk[TIME][-1])
        while done < count:
            part = slice(done, min(count, done + self.rows - self._filled))
            taken = part.stop - part.start
            if taken < self.rows:
                for path, rest in self._rest.items():
                    rest[self._filled : self._filled + taken] = chunk[path][part]
            self._filled, done = (self._filled + taken) % self.rows, part.stop
            if self._filled == 0:
                for path, rest in self._rest.items():
                    self._write(path, rest if taken < self.rows else chunk[path][part])
                self._written += self.rows
        self.check()

    def _write(self, path: str, samples: np.ndarray) -> None:
        """Give a dataset its next chunk (rows, *shape) as it is: HDF5's own way copies it twice and fills
        the chunk with zeros first, which takes longer than the disk does."""
        dataset = self._datasets[path]
        dataset.id.set_extent((self._written + self.rows, *samples.shape[1:]))
        whole = np.ascontiguousarray(samples, dataset.dtype)
        self.sink.expect(whole)
        dataset.id.write_direct_chunk((self._written, *(0 for _ in samples.shape[1:])), whole)
        self._places[path].append(self.sink.found)
        self._sums[path].append(binascii.crc32(whole.data))

    def finish(self) -> None:
        """Write the samples that do not fill a chunk."""
        if self._filled:
            for path, rest in self._rest.items():
                rest[self._filled :] = 0
                self._write(path, rest)
                self._datasets[path].id.set_extent((self._written + self._filled, *rest.shape[1:]))

    @property
    def samples(self) -> int:
        """How many have been appended."""
        return self._written + self._filled

    def state(self) -> dict[str, np.ndarray]:
        """Where the samples are: the ``pieces``, and the rest itself."""
        rest = {f"rest/{path}": rest[: self._filled].copy() for path, rest in self._rest.items()}
        return {**self.pieces(), **rest}

    def pieces(self) -> dict[str, np.ndarray]:
        """Of each series the places of its chunks with their checksums (chunks, 2)."""
        return {
            f"places/{path}": np.array([places, self._sums[path]], dtype="i8").T.reshape(-1, 2)
            for path, places in self._places.items()
        }

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


def create_datasets(file: Any, layout: Layout, rows: int) -> dict[str, Any]:
    """The datasets of the layout by path, ``t`` first: empty, and growing in chunks of ``rows`` samples."""
    times = create_series(file, layout.time, rows)
    times.make_scale(TIME)
    scales = Scales(file, layout)
    datasets = {TIME: times}
    for series in layout.series:
        datasets[series.path] = create_series(file, series, rows)
        scales.attach(datasets[series.path], series, times)
    return datasets


def create_series(file: Any, series: Series, rows: int) -> Any:
    """An empty dataset that can grow along its first axis, with its unit and name."""
    shape = series.shape
    dataset = file.create_dataset(
        series.path, shape=(0, *shape), maxshape=(None, *shape), chunks=(rows, *shape), dtype=series.kind
    )
    describe(dataset, series)
    return dataset
