"""``Writer``: appends chunks of samples to an HDF5 file that appears under its name when whole."""

from __future__ import annotations

import math
from collections.abc import Mapping
from types import TracebackType
from typing import TYPE_CHECKING, Any

import h5py

from lagrange_cli.store.layout import AXES, BYTES, Layout, Series
from lagrange_cli.store.sink import Sink
from lagrange_cli.store.target import Target, unwritable

if TYPE_CHECKING:
    import numpy as np

TIME = Series("t", long_name="time")


class Writer:
    """A context in which ``append`` adds samples and ``finish`` makes the file whole.

    Leaving the context without ``finish`` removes what was written. Nothing in the file depends on when or
    where it was written, so the same calls give the same bytes. Memory is bounded whatever the number of
    samples. Every method raises ``FileError`` where the file cannot be written.

    Every series has the sample times ``/t`` attached as the HDF5 dimension scale of its first axis; a
    family has one for each index, such as ``/N``, and a vector of up to three components ``/x``, ``/xy`` or
    ``/xyz`` as that of its last. Each group holds a soft link to the scales of its series, so that a reader
    that opens one group finds them.
    """

    def __init__(self, target: Target, layout: Layout, *, expected: int) -> None:
        self._target = target
        self._written = 0
        try:
            self._sink = Sink(target.temporary)
        except OSError as error:
            raise unwritable(target.shown, error) from error
        try:
            self._file = open_file(self._sink, layout, expected)
            self._datasets = create_datasets(self._file, layout, layout.chunk_rows(expected))
        except BaseException:
            self._abandon()
            raise

    def append(self, chunk: Mapping[str, np.ndarray]) -> None:
        """Add the samples of a chunk: ``chunk[path]`` has shape (c, *shape) for ``t`` and every series."""
        start, stop = self._written, self._written + len(chunk[TIME.path])
        if start == stop:
            return
        for path, dataset in self._datasets.items():
            dataset.resize(stop, axis=0)
            dataset[start:] = chunk[path]
        self._written = stop
        self._check()

    def finish(self, attributes: Mapping[str, str | int | float]) -> None:
        """Write the root's attributes in their order, close the file and give it its name."""
        for name, value in attributes.items():
            self._file.attrs[name] = value
        self._file.close()
        self._sink.synchronize()
        self._check()
        self._sink.close()
        self._target.publish()

    def __enter__(self) -> Writer:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        if not self._sink.closed:
            self._abandon()

    def _check(self) -> None:
        """Raise what the sink has kept from HDF5."""
        if self._sink.error is not None:
            raise unwritable(self._target.shown, self._sink.error) from self._sink.error

    def _abandon(self) -> None:
        """Close and remove the unfinished file."""
        file = getattr(self, "_file", None)
        if file:
            file.close()
        self._sink.close()
        self._target.discard()


def open_file(sink: Sink, layout: Layout, expected: int) -> Any:
    """An HDF5 file over ``sink`` with one chunk of cache per dataset.

    (By default HDF5 keeps up to a megabyte for each of them, however many they are.)
    """
    largest = BYTES * layout.chunk_rows(expected) * max([1, *(math.prod(s.shape) for s in layout.series)])
    return h5py.File(sink, "w", rdcc_nbytes=largest)


def create_datasets(file: Any, layout: Layout, rows: int) -> dict[str, Any]:
    """The datasets of the layout by path, ``t`` first: empty, and growing in chunks of ``rows`` samples."""
    times = create_series(file, TIME, rows)
    times.make_scale(TIME.path)
    axes = {size: create_axis(file, AXES[:size]) for size in layout.vector_sizes()}
    indices = {axis: create_index(file, name, axis[1]) for axis, name in layout.indices().items()}
    datasets = {TIME.path: times}
    for series in layout.series:
        datasets[series.path] = create_series(file, series, rows)
        attach(datasets[series.path], 0, times)
        for number, axis in enumerate(zip(series.axes, series.shape), 1):
            attach(datasets[series.path], number, indices[axis])
        if series.components in axes:
            attach(datasets[series.path], len(series.shape), axes[series.components])
    return datasets


def attach(dataset: Any, axis: int, scale: Any) -> None:
    """Make ``scale`` the coordinate of one axis, and link it into the dataset's group."""
    dataset.dims[axis].attach_scale(scale)
    name = scale.name.lstrip("/")
    if name not in dataset.parent:
        dataset.parent[name] = h5py.SoftLink(scale.name)


def create_series(file: Any, series: Series, rows: int) -> Any:
    """An empty dataset that can grow along its first axis, with its unit and name."""
    shape = series.shape
    dataset = file.create_dataset(
        series.path, shape=(0, *shape), maxshape=(None, *shape), chunks=(rows, *shape), dtype="f8"
    )
    if series.unit:
        dataset.attrs["unit"] = series.unit
    if series.long_name:
        dataset.attrs["long_name"] = series.long_name
    return dataset


def create_axis(file: Any, letters: str) -> Any:
    """The dimension scale that names a vector's components."""
    axis = file.create_dataset(letters, data=list(letters), dtype=h5py.string_dtype())
    axis.attrs["long_name"] = "component"
    axis.make_scale(letters)
    return axis


def create_index(file: Any, name: str, length: int) -> Any:
    """The dimension scale that counts the members of a family."""
    axis = file.create_dataset(name, data=range(length), dtype="i8")
    axis.attrs["long_name"] = "index"
    axis.make_scale(name)
    return axis
