"""``EnsembleWriter``: an HDF5 file with a place for each member, filled in the order in which they end."""

from __future__ import annotations

import binascii
from collections.abc import Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from lagrange_cli.errors import UsageError
from lagrange_cli.records import replace
from lagrange_cli.store.checkpoint import damaged
from lagrange_cli.store.layout import AXES, Dimension, Layout, Series, free_name
from lagrange_cli.store.member_crossings import MemberCrossings
from lagrange_cli.store.output import CHECKPOINT, Output, in_one_piece, open_file
from lagrange_cli.store.scales import Scales, attach, describe, link
from lagrange_cli.store.sink import Sink
from lagrange_cli.store.target import Target

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from lagrange_cli.store.resume import Earlier

NUMBERS = Dimension("member", 0, long_name="member of the ensemble")
MESSAGE = "message"
TIME = "t"
PIECE = 2**24
"""The number of bytes that are read back at a time."""
MOST_CROSSINGS = 2**28
"""Bytes of the crossings of all members: half of what a checkpoint may have."""
BLOCK = 65536
"""About how many members are numbered, or get their text, at a time."""


class EnsembleWriter(Output):
    """A context in which ``write`` stores the values of members and ``close`` completes the file (see
    ``Output``).

    The members, in their order, fill the grid that ``dimensions`` span, the last one fastest. Without any
    they are one dimension, ``/member``. Every dataset begins with these dimensions; that of the sample times
    ``/t`` follows, or the dimension ``samples``, if it is sampled. Each dimension is a scale in the root,
    attached to every dataset; for the other axes see ``Scales``. On a grid ``/member`` numbers the members: a
    coordinate, which every dataset names in its attribute ``coordinates``.

    Every dataset has its full size from the start and lies in one piece, so that the bytes do not depend on
    the order in which members are written, and no memory is taken for those that are not. Every member must
    be written.
    """

    def __init__(
        self,
        target: Target,
        layout: Layout,
        *,
        members: int,
        times: NDArray[np.float64] | None,
        dimensions: Sequence[Dimension] = (),
        samples: Dimension | None = None,
    ) -> None:
        self._members = members
        names = name_dimensions(layout, dimensions)
        scales = names if times is None else (*names, TIME)
        if samples is not None:
            samples = replace(
                samples, name=free_name(samples.name, taken_names(layout, dimensions) | {*names})
            )
            scales = (*names, samples.name)
        self._layout = layout = replace(layout, scales=scales)

        def create(sink: Sink) -> Any:
            file = open_file(sink, BLOCK)
            self._leading: list[Any] = []
            self._numbers: Any = None
            spanned = dimensions or (replace(NUMBERS, length=members),)
            for name, dimension in zip(names, spanned):
                self._leading.append(create_dimension(file, sink, name, dimension))
            if dimensions:
                shape = tuple(one.length for one in dimensions)
                self._numbers = create_numbers(file, sink, names[-1], shape)
                describe(self._numbers, Series(names[-1], long_name=NUMBERS.long_name))
                for axis, scale in enumerate(self._leading):
                    attach(self._numbers, axis, scale)
            self._time = None
            if times is not None:
                self._time = file.create_dataset(TIME, data=times)
                describe(self._time, layout.time)
                self._time.make_scale(TIME)
            if samples is not None:
                self._time = create_dimension(file, sink, samples.name, samples)
            self._scales = Scales(file, layout)
            self._datasets = {one.path: self._create(file, one) for one in layout.series}
            for scale, dimension in zip(self._leading, dimensions):
                if dimension.path:
                    self._show(file, scale, dimension)
            return file

        self._events = {event.group: MemberCrossings(event) for event in layout.events}
        super().__init__(target, create)

    def _create(self, file: Any, series: Series, **properties: Any) -> Any:
        leading = self._leading if self._time is None or not series.sampled else [*self._leading, self._time]
        shape = (*(len(scale) for scale in leading), *series.shape)
        properties = properties or {"dcpl": in_one_piece()}
        dataset = file.create_dataset(series.path, shape=shape, dtype=series.kind, **properties)
        describe(dataset, series)
        self._scales.attach(dataset, series, *leading)
        if self._numbers is not None:
            link(dataset.parent, self._numbers)
            dataset.attrs["coordinates"] = self._numbers.name.lstrip("/")
        return dataset

    def _show(self, file: Any, scale: Any, dimension: Dimension) -> None:
        """Let the values of a dimension be found under its path, too."""
        group, _, name = dimension.path.rpartition("/")
        if scale.name == f"/{name}":
            link(file.require_group(group), scale)
        else:
            dataset = file.create_dataset(dimension.path, data=dimension.values)
            describe(dataset, Series(dimension.path, (), dimension.unit, dimension.long_name))
            attach(dataset, 0, scale)

    def write(self, index: NDArray[np.int64], values: Mapping[str, np.ndarray]) -> None:
        """Give the members ``index`` (b,) their values: ``values[path]`` has shape (b, ...); what is no
        series of the layout is left out. Crossings of events say to which members they belong.

        Raises ``UsageError`` where there are too many crossings.
        """
        order = np.argsort(index, kind="stable")
        index = index[order]
        breaks = np.flatnonzero(np.diff(index) != 1) + 1
        runs = [slice(a, b) for a, b in zip((0, *breaks), (*breaks, len(index)))]
        for path, rows in values.items():
            dataset = self._datasets.get(path)
            if dataset is not None:
                rows = rows if len(runs) == len(index) == 1 else rows[order]
                for run in runs:
                    self._put(dataset, int(index[run.start]), rows[run])
        for event in self._events.values():
            event.collect(values)
        if sum(event.bytes for event in self._events.values()) > MOST_CROSSINGS:
            raise UsageError(
                f"the crossings of events of all members take more than {MOST_CROSSINGS >> 20} MB, and are "
                "kept in memory until the end: sweep fewer members at a time, or a shorter time"
            )
        self.check()

    def _put(self, dataset: Any, first: int, rows: np.ndarray) -> None:
        """Write the rows (b, ...) of the members from ``first``: they lie one behind the other, whatever the
        grid."""
        put(self.sink, dataset, first * self._size(dataset), rows)

    def _size(self, dataset: Any) -> int:
        """Bytes of a member."""
        size: int = dataset.dtype.itemsize * dataset.size // self._members
        return size

    def regions(self, ended: NDArray[np.bool_]) -> dict[str, list[int]]:
        """For each dataset, its place in the file, and a checksum of the rows of the members that have
        ``ended``; from now on they are in the file."""
        self.file.flush()
        self.check()
        found = {}
        for path, dataset in self._datasets.items():
            place, size, checksum = dataset.id.get_offset(), self._size(dataset), 0
            for rows in pieces(ended, size):
                self.sink.seek(place + rows.start * size)
                piece = bytearray(len(rows) * size)
                self.sink.readinto(piece)
                checksum = binascii.crc32(piece, checksum)
            found[path] = [place, checksum]
        return found

    def restore(self, earlier: Earlier, ended: NDArray[np.bool_]) -> None:
        """Give the members that have ``ended`` in an earlier run what it had; raises ``Unusable``."""
        places = earlier.checkpoint.head.get("regions", {})
        if list(places) != list(self._datasets):
            raise damaged(earlier.shown)
        for event in self._events.values():
            if not event.restore(earlier.checkpoint.arrays):
                raise damaged(earlier.shown)
        for path, dataset in self._datasets.items():
            (place, expected), size, checksum = places[path], self._size(dataset), 0
            for rows in pieces(ended, size):
                piece = earlier.read(place + rows.start * size, len(rows) * size)
                checksum = binascii.crc32(piece, checksum)
                self._put(dataset, rows.start, np.frombuffer(piece, dataset.dtype))
            if checksum != expected:
                raise damaged(earlier.shown)
        self.check()

    def crossings_of_events(self) -> dict[str, int]:
        """How many crossings each event has in all members, or each family of events."""
        return {event.name: self._events[event.group].count for event in self._layout.events}

    def crossings(self) -> dict[str, np.ndarray]:
        """The crossings of the members that have ended, for a checkpoint."""
        return {path: rows for event in self._events.values() for path, rows in event.arrays().items()}

    def write_crossings(self) -> None:
        """Add the groups of events, members one by one."""
        self.file.flush()  # as in ``write_messages``
        for event in self._layout.events:
            found = self._events[event.group].in_order()
            times: Any = None
            for series in event.series:
                dataset = self.file.create_dataset(series.path, data=found[series.path])
                describe(dataset, series)
                if series.path.endswith("/t"):
                    dataset.make_scale(TIME)
                    times = dataset if times is None else times
                else:
                    self._scales.attach(dataset, series, times)
            self.file[event.group].attrs.update(event.attributes)
        self.check()

    def write_messages(self, texts: Sequence[str], chosen: NDArray[np.int8]) -> None:
        """Add how each member ended: the one of ``texts`` that ``chosen`` (members,) says."""
        self.file.flush()  # what HDF5 frees from here on has been written by now, checkpoints or not
        used = np.unique(chosen)
        rows = np.array([text.encode() if i in used else b"" for i, text in enumerate(texts)])
        series = Series("message", long_name="how the member ended", sampled=False, kind=rows.dtype.str)
        shape = tuple(len(scale) for scale in self._leading)
        dataset = self._create(self.file, series, chunks=block_of(shape), compression="gzip")
        chosen = chosen.reshape(shape)
        for block in dataset.iter_chunks():
            dataset[block] = rows[chosen[block]]
        self.check()


def name_dimensions(layout: Layout, dimensions: Sequence[Dimension]) -> tuple[str, ...]:
    """The names of the dimensions in the file, then the name of the numbers of members, with
    underscores behind those that something else has."""
    taken = taken_names(layout, dimensions)
    names: list[str] = []
    for name in (*(one.name for one in dimensions), NUMBERS.name):
        names.append(free_name(name, taken | {*names}))
    return tuple(names)


def taken_names(layout: Layout, dimensions: Sequence[Dimension]) -> set[str]:
    """Names that no dimension can have."""
    groups = {part for one in dimensions for part in one.path.split("/")[:-1]}
    taken = replace(layout, events=()).taken() | groups | {TIME, MESSAGE, CHECKPOINT}
    taken |= {one.group.partition("/")[0] for one in layout.events}
    return taken | {AXES[:size] for size in layout.vector_sizes()}


def create_dimension(file: Any, sink: Sink, name: str, dimension: Dimension) -> Any:
    """The dimension scale of one dimension."""
    if dimension.values is None:
        scale = create_numbers(file, sink, name, (dimension.length,))
    else:
        scale = file.create_dataset(name, data=dimension.values)
    describe(scale, Series(name, (), dimension.unit, dimension.long_name))
    scale.make_scale(name)
    return scale


def create_numbers(file: Any, sink: Sink, name: str, shape: tuple[int, ...]) -> Any:
    """A dataset of that shape with 0, 1, 2, ..., the last axis fastest."""
    numbers = file.create_dataset(name, shape=shape, dtype="i8", dcpl=in_one_piece())
    for start in range(0, numbers.size, BLOCK):
        put(sink, numbers, 8 * start, np.arange(start, min(start + BLOCK, numbers.size)))
    return numbers


def put(sink: Sink, dataset: Any, place: int, values: np.ndarray) -> None:
    """Write values into a dataset that lies in one piece, so many bytes from where it begins."""
    sink.seek(dataset.id.get_offset() + place)
    sink.write(np.ascontiguousarray(values, dataset.dtype).view("u1"))


def block_of(shape: tuple[int, ...]) -> tuple[int, ...]:
    """The shape of a chunk of about ``BLOCK`` members."""
    block, room = [], BLOCK
    for length in reversed(shape):
        block.append(min(length, room))
        room = max(1, room // length)
    return tuple(reversed(block))


def pieces(ended: NDArray[np.bool_], size: int) -> Iterator[range]:
    """The members that have ``ended``, of ``size`` bytes each, some megabytes of neighbours at a time."""
    edges = np.flatnonzero(np.diff(ended, prepend=False, append=False))
    for start, stop in zip(edges[::2].tolist(), edges[1::2].tolist()):
        most = max(1, PIECE // size)
        for first in range(start, stop, most):
            yield range(first, min(first + most, stop))
