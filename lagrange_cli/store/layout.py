"""``Layout``: which series an output file holds, and in what pieces they are laid down."""

from __future__ import annotations

import math
from collections.abc import Container, Mapping, Sequence
from typing import TYPE_CHECKING, TypeAlias

from lagrange_cli.decimals import decimal
from lagrange_cli.errors import UsageError
from lagrange_cli.limits import limit, way_out
from lagrange_cli.records import dataclass, field

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

BYTES = 8
"""Bytes of a number: every series is of IEEE doubles."""

ROWS = 65536
"""Samples per HDF5 chunk, where there are so many: half a megabyte per scalar series writes at disk speed."""

MEMORY = 32 * 2**20
"""Bytes that the unfinished chunks of all series may take together."""

CROSSINGS, FEWEST = 1024, 16
"""EventSeries of an event per HDF5 chunk, where they are small, and where they are not."""

EVENTS = "events/"
"""Where the groups of events are."""

AXES = "xyz"
"""The names of a vector's components."""


Indexed: TypeAlias = "tuple[str, int | tuple[tuple[int, ...], ...]]"
"""The name of an axis of a family, and its length; or the indices of the members along it, where others are
missing."""


@dataclass(frozen=True)
class Series:
    """One dataset of shape ``(n, *shape)``: a number, a vector, or a family of either per sample time.
    In the file of an ensemble the dimensions of the members come first, ``(*members, n, *shape)``, and a
    series that is not ``sampled`` has no time axis, ``(*members, *shape)``.

    ``path`` is its place in the file without a leading slash (``diagnostics/p/theta``); ``unit`` is empty
    where it is not known. ``shape`` begins with the lengths of the family's ``axes``, which have names, and
    ends with the number of ``components`` of a vector (0: there is none). A family without some of its
    members has one axis, along which are those with the indices in ``places``. ``kind`` is numpy's name of
    the type.
    """

    path: str
    shape: tuple[int, ...] = ()
    unit: str = ""
    long_name: str = ""
    axes: tuple[str, ...] = ()
    components: int = 0
    sampled: bool = True
    kind: str = "f8"
    places: tuple[tuple[int, ...], ...] = ()

    @property
    def indexed(self) -> tuple[Indexed, ...]:
        """The family's axes: the name of each, and what it counts."""
        return tuple(zip(self.axes, (self.places,) if self.places else self.shape))


@dataclass(frozen=True)
class Dimension:
    """One of the dimensions that the members of an ensemble span: its ``name``, unless something else in the
    file is called so, and its ``values`` (length,), where None stands for 0, 1, 2, ...

    ``path`` is where the values are found besides (``parameters/omega``); empty: nowhere.
    """

    name: str
    length: int
    values: NDArray[np.float64] | None = None
    unit: str = ""
    long_name: str = ""
    path: str = ""


@dataclass(frozen=True)
class EventSeries:
    """The datasets of an event, or of a family of events, each of shape (k, *shape) for its k crossings.

    The first of the ``series`` has their times and is the scale of all others. The ``attributes`` of the
    group ``events/NAME`` say what the event is.
    """

    name: str
    series: tuple[Series, ...]
    attributes: Mapping[str, str] = field(default_factory=dict)

    @property
    def group(self) -> str:
        """The path of its group."""
        return EVENTS + self.name


@dataclass(frozen=True)
class Layout:
    """The series of a file, and those of its ``events``. The scales of their first axes, such as the sample
    times ``/t`` in units of ``time_unit``, are not among the former."""

    series: tuple[Series, ...]
    scales: tuple[str, ...] = ("t",)
    time_unit: str = ""
    events: tuple[EventSeries, ...] = ()

    def chunk_rows(self, expected: int) -> int:
        """Samples per chunk for about ``expected`` samples: large, but bounded over all series."""
        return max(1, min(ROWS, expected, max(64, MEMORY // self.row)))

    @property
    def row(self) -> int:
        """The bytes of a sample of all series, and of its time."""
        return BYTES * (1 + sum(math.prod(series.shape) for series in self.series))

    def check_size(self, samples: int, members: int = 1, *, noun: str = "sample") -> None:
        """Raise ``UsageError`` where so many samples of each of the members take more than is allowed; its
        message calls a sample by this ``noun``."""
        size = samples * members * self.row
        if size > 1e6 * limit("output"):
            many = f" of {members} members" if members > 1 else ""
            fewer = ["members"] * (members > 1) + [f"{noun}s"] * (samples > 1)
            raise UsageError(
                f"{samples} {noun}{'s' * (samples != 1)}{many}, {self.row} bytes each, would take "
                f"{decimal(size / 1e9, 3)} GB: ask for fewer {', '.join(fewer)} or outputs, "
                f"{way_out('output')} (in MB)"
            )

    def crossing_rows(self) -> int:
        """EventSeries per chunk: few, as there may be few in all, and bounded over all events."""
        row = BYTES * sum(math.prod(one.shape) for event in self.events for one in event.series)
        return max(FEWEST, min(CROSSINGS, MEMORY // max(1, row)))

    @property
    def all_series(self) -> tuple[Series, ...]:
        """The series of the samples and those of the events."""
        return (*self.series, *(one for event in self.events for one in event.series))

    @property
    def time(self) -> Series:
        """The sample times."""
        return Series("t", unit=self.time_unit, long_name="time")

    def vector_sizes(self) -> tuple[int, ...]:
        """The numbers of components that occur among vectors of up to three, in ascending order."""
        return tuple(sorted({one.components for one in self.series if 0 < one.components <= len(AXES)}))

    def taken(self) -> set[str]:
        """The names that no further scale can have in every group of the file."""
        return {part for one in self.all_series for part in one.path.split("/")}

    def indices(self) -> dict[Indexed, str]:
        """The families' axes, and what each is called in the file: its name, with underscores behind it where
        something else has that name."""
        taken = self.taken() | {*self.scales, *(AXES[:size] for size in self.vector_sizes())}
        found: dict[Indexed, str] = {}
        for axis in (pair for one in self.all_series for pair in one.indexed):
            if axis not in found:
                found[axis] = free_name(axis[0], taken)
                taken.add(found[axis])
        return found


def labels(counted: int | tuple[tuple[int, ...], ...]) -> Sequence[int | str]:
    """What an axis of a family counts: 0, 1, 2, ..., or the members with these indices, which are numbers, or
    texts such as ``2,1`` where there are several."""
    if isinstance(counted, int):
        return range(counted)
    return [",".join(map(str, place)) if len(place) > 1 else place[0] for place in counted]


def free_name(name: str, taken: Container[str]) -> str:
    """The name, with underscores behind it where it is taken."""
    while name in taken:
        name += "_"
    return name
