"""``Layout``: which series an output file holds, and in what pieces they are laid down."""

from __future__ import annotations

import math

from lagrange_cli.records import dataclass

BYTES = 8
"""Bytes of a number: every series is of IEEE doubles."""

ROWS = 65536
"""Samples per HDF5 chunk, where there are so many: half a megabyte per scalar series writes at disk speed."""

MEMORY = 32 * 2**20
"""Bytes that the unfinished chunks of all series may take together."""

AXES = "xyz"
"""The names of a vector's components."""


@dataclass(frozen=True)
class Series:
    """One dataset of shape ``(n, *shape)``: a number, a vector, or a family of either per sample time.

    ``path`` is its place in the file without a leading slash (``diagnostics/p/theta``); ``unit`` is empty
    where it is not known. ``shape`` begins with the lengths of the family's ``axes``, which have names, and
    ends with the number of ``components`` of a vector (0: there is none).
    """

    path: str
    shape: tuple[int, ...] = ()
    unit: str = ""
    long_name: str = ""
    axes: tuple[str, ...] = ()
    components: int = 0


@dataclass(frozen=True)
class Layout:
    """The series of a file; the sample times ``/t`` are always there and are not among them."""

    series: tuple[Series, ...]

    def chunk_rows(self, expected: int) -> int:
        """Samples per chunk for about ``expected`` samples: large, but bounded over all series."""
        row = BYTES * (1 + sum(math.prod(series.shape) for series in self.series))
        return max(1, min(ROWS, expected, max(64, MEMORY // row)))

    def vector_sizes(self) -> tuple[int, ...]:
        """The numbers of components that occur among vectors of up to three, in ascending order."""
        return tuple(sorted({one.components for one in self.series if 0 < one.components <= len(AXES)}))

    def indices(self) -> dict[tuple[str, int], str]:
        """The families' axes, by name and length, and what each is called in the file: its name, with
        underscores behind it where something else has that name."""
        taken = {part for one in self.series for part in one.path.split("/")}
        taken |= {"t", *(AXES[:size] for size in self.vector_sizes())}
        found: dict[tuple[str, int], str] = {}
        for axis in (pair for one in self.series for pair in zip(one.axes, one.shape)):
            name = found.get(axis, axis[0])
            while axis not in found and name in taken:
                name += "_"
            found[axis] = name
            taken.add(name)
        return found
