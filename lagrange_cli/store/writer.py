"""``Writer``: appends chunks of samples to an HDF5 file that appears under its name when whole."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

import numpy as np

from lagrange_cli.store.layout import BYTES, Layout, Series
from lagrange_cli.store.output import Output, open_file
from lagrange_cli.store.scales import Scales, describe
from lagrange_cli.store.sink import Sink
from lagrange_cli.store.target import Target

TIME = Series("t", long_name="time")


class Writer(Output):
    """A context in which ``append`` adds samples and ``close`` makes the file whole (see ``Output``).

    Memory is bounded whatever the number of samples. Every series has the sample times ``/t`` attached as
    the HDF5 dimension scale of its first axis; for the other axes see ``Scales``.
    """

    def __init__(self, target: Target, layout: Layout, *, expected: int) -> None:
        self._written = 0
        rows = layout.chunk_rows(expected)

        def create(sink: Sink) -> Any:
            largest = max([1, *(math.prod(series.shape) for series in layout.series)])
            file = open_file(sink, BYTES * rows * largest)
            self._datasets = create_datasets(file, layout, rows)
            return file

        super().__init__(target, create)

    def append(self, chunk: Mapping[str, np.ndarray]) -> None:
        """Add the samples of a chunk: ``chunk[path]`` has shape (c, *shape) for ``t`` and every series."""
        start, stop = self._written, self._written + len(chunk[TIME.path])
        if start == stop:
            return
        for path, dataset in self._datasets.items():
            extend(dataset, start, chunk[path])
        self._written = stop
        self.check()


def extend(dataset: Any, start: int, samples: np.ndarray) -> None:
    """Put samples (c, *shape) behind the first ``start`` of a dataset.

    What fills a chunk of the file goes there as it is: HDF5's own way copies it twice and fills the chunk
    with zeros first, which takes longer than the disk does.
    """
    rows, others = dataset.chunks[0], (0,) * (samples.ndim - 1)
    stop = start + len(samples)
    dataset.id.set_extent((stop, *samples.shape[1:]))
    while start % rows == 0 and start + rows <= stop:
        whole, samples = samples[:rows], samples[rows:]
        dataset.id.write_direct_chunk((start, *others), np.ascontiguousarray(whole, dataset.dtype))
        start += rows
    if start < stop:
        dataset[start:] = samples


def create_datasets(file: Any, layout: Layout, rows: int) -> dict[str, Any]:
    """The datasets of the layout by path, ``t`` first: empty, and growing in chunks of ``rows`` samples."""
    times = create_series(file, TIME, rows)
    times.make_scale(TIME.path)
    scales = Scales(file, layout)
    datasets = {TIME.path: times}
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
