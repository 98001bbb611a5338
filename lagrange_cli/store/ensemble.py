"""``EnsembleWriter``: an HDF5 file with one row a member, filled in whatever order the members end."""

from __future__ import annotations

import binascii
import math
from collections.abc import Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Any

import h5py
import numpy as np

from lagrange_cli.records import replace
from lagrange_cli.store.checkpoint import damaged
from lagrange_cli.store.layout import BYTES, Layout, Series, free_name
from lagrange_cli.store.output import Output, open_file
from lagrange_cli.store.scales import Scales, describe
from lagrange_cli.store.sink import Sink
from lagrange_cli.store.target import Target

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from lagrange_cli.store.resume import Earlier

MEMBER = "member"
TIME = Series("t", long_name="time")
PIECE = 2**24
"""Bytes that are read back at a time."""
BLOCK = 65536
"""Members that are numbered, or get their text, at a time."""


class EnsembleWriter(Output):
    """A context in which ``write`` gives members their values and ``close`` makes the file whole (see
    ``Output``).

    Every dataset has its full size from the start and lies in one piece, so that the bytes do not depend on
    the order in which members are written, and no memory is taken for those that are not.
    Each has ``/member`` attached as the dimension scale of its first axis, and, if it is sampled, the sample
    times ``/t`` as that of its second; for the other axes see ``Scales``. Every member must be written.
    """

    def __init__(
        self, target: Target, layout: Layout, *, members: int, times: NDArray[np.float64] | None
    ) -> None:
        self._members = members
        name = free_name(MEMBER, layout.taken())
        layout = replace(layout, scales=(name,) if times is None else (name, TIME.path))

        def create(sink: Sink) -> Any:
            file = open_file(sink, BLOCK)
            self._scale = create_member_scale(file, name, members)
            leading = [self._scale]
            if times is not None:
                leading.append(file.create_dataset(TIME.path, data=times))
                describe(leading[1], TIME)
                leading[1].make_scale(TIME.path)
            self._scales = Scales(file, layout)
            self._datasets = {one.path: self._create(file, one, leading) for one in layout.series}
            return file

        super().__init__(target, create)

    def _create(self, file: Any, series: Series, leading: Sequence[Any]) -> Any:
        leading = leading if series.sampled else leading[:1]
        shape = (*(len(scale) for scale in leading), *series.shape)
        dataset = file.create_dataset(series.path, shape=shape, dtype=series.kind, dcpl=in_one_piece())
        describe(dataset, series)
        self._scales.attach(dataset, series, *leading)
        return dataset

    def write(self, index: NDArray[np.int64], values: Mapping[str, np.ndarray]) -> None:
        """Give the members ``index`` (b,) their values: ``values[path]`` has shape (b, ...)."""
        order = np.argsort(index, kind="stable")
        index = index[order]
        breaks = np.flatnonzero(np.diff(index) != 1) + 1
        runs = [slice(a, b) for a, b in zip((0, *breaks), (*breaks, len(index)))]
        for path, rows in values.items():
            dataset, rows = self._datasets[path], rows if len(runs) == len(index) == 1 else rows[order]
            for run in runs:
                dataset[index[run.start] : index[run.stop - 1] + 1] = rows[run]
        self.check()

    def regions(self, ended: NDArray[np.bool_]) -> dict[str, list[int]]:
        """Of each dataset its place in the file, and a checksum of the rows of the members that have
        ``ended``; from now on they are in the file."""
        self.file.flush()
        self.check()
        found = {}
        for path, dataset in self._datasets.items():
            place, size, checksum = dataset.id.get_offset(), row_size(dataset), 0
            for rows in pieces(ended, size):
                self.sink.seek(place + rows.start * size)
                piece = bytearray(len(rows) * size)
                self.sink.readinto(piece)
                checksum = binascii.crc32(piece, checksum)
            found[path] = [place, checksum]
        return found

    def restore(self, earlier: Earlier, ended: NDArray[np.bool_]) -> None:
        """Give the members that have ``ended`` in an earlier run what it had; raises ``Unusable``."""
        places = earlier.checkpoint.head.get("regions")
        if not isinstance(places, dict) or list(places) != list(self._datasets):
            raise damaged(earlier.shown)
        for path, dataset in self._datasets.items():
            (place, expected), size, checksum = places[path], row_size(dataset), 0
            for rows in pieces(ended, size):
                piece = earlier.read(place + rows.start * size, len(rows) * size)
                checksum = binascii.crc32(piece, checksum)
                dataset[rows.start : rows.stop] = np.frombuffer(piece, dataset.dtype).reshape(
                    -1, *dataset.shape[1:]
                )
            if checksum != expected:
                raise damaged(earlier.shown)
        self.check()

    def write_texts(self, path: str, long_name: str, texts: Sequence[str], chosen: NDArray[np.int8]) -> None:
        """Add a dataset of text: for each member the one of ``texts`` that ``chosen`` (members,) says."""
        used = np.unique(chosen)
        rows = np.array([text.encode() if i in used else b"" for i, text in enumerate(texts)])
        series = Series(path, long_name=long_name, sampled=False, kind=rows.dtype.str)
        chunk = min(BLOCK, self._members)
        dataset = self.file.create_dataset(
            path, shape=(self._members,), dtype=series.kind, chunks=(chunk,), compression="gzip"
        )
        describe(dataset, series)
        self._scales.attach(dataset, series, self._scale)
        for start in range(0, self._members, BLOCK):
            dataset[start : start + BLOCK] = rows[chosen[start : start + BLOCK]]
        self.check()


def row_size(dataset: Any) -> int:
    """Bytes of a member."""
    size: int = dataset.dtype.itemsize * math.prod(dataset.shape[1:])
    return size


def pieces(ended: NDArray[np.bool_], size: int) -> Iterator[range]:
    """The members that have ``ended``, of ``size`` bytes each, some megabytes of neighbours at a time."""
    edges = np.flatnonzero(np.diff(ended, prepend=False, append=False))
    for start, stop in zip(edges[::2].tolist(), edges[1::2].tolist()):
        most = max(1, PIECE // size)
        for first in range(start, stop, most):
            yield range(first, min(first + most, stop))


def create_member_scale(file: Any, name: str, members: int) -> Any:
    """The dimension scale that counts the members."""
    scale = file.create_dataset(name, shape=(members,), dtype="i8", dcpl=in_one_piece())
    for start in range(0, members, BLOCK):
        scale[start : start + BLOCK] = np.arange(start, min(start + BLOCK, members))
    scale.attrs["long_name"] = "member of the ensemble"
    scale.make_scale(name)
    return scale


def in_one_piece() -> Any:
    """The properties of a dataset that has its place in the file from the start, and is not filled there."""
    properties = h5py.h5p.create(h5py.h5p.DATASET_CREATE)
    properties.set_layout(h5py.h5d.CONTIGUOUS)
    properties.set_alloc_time(h5py.h5d.ALLOC_TIME_EARLY)
    properties.set_fill_time(h5py.h5d.FILL_TIME_NEVER)
    return properties


def bytes_of(layout: Layout, members: int, samples: int) -> int:
    """The size of a file, without what describes it."""
    return sum(
        BYTES * members * (samples if one.sampled else 1) * math.prod(one.shape) for one in layout.series
    )
