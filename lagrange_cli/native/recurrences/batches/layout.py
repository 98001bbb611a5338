"""Where the coefficients of batches of series lie in memory.

Eight series side by side are a *block*: their coefficients follow one another as vectors, behind a few
vectors of what belongs to the series besides. The state's rows come first, then the batches, each in blocks
of its own, then a block of zeros.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property

from lagrange_cli.native.interface import LANES
from lagrange_cli.native.state import width_of
from lagrange_cli.records import dataclass
from lagrange_cli.series.batches import Batch
from lagrange_cli.series.program import SeriesProgram

INVERSE, SLOPE, CHANGE, LOW = -4, -3, -2, -1
"""Vectors before the coefficients: of powers 1/x and dp/dx, what a correction has added, remainders."""
BEFORE = 4


@dataclass(frozen=True)
class Blocks:
    """The places of the series of ``batches`` in ``%work``, for q's series to ``order``."""

    program: SeriesProgram
    batches: Sequence[Batch]
    order: int

    @property
    def span(self) -> int:
        """Vectors of a block."""
        return BEFORE + self.order + 1

    @property
    def width(self) -> int:
        """Rows of the state, in whole blocks."""
        return LANES * -(-width_of(len(self.program.state)) // LANES)

    @cached_property
    def first(self) -> tuple[int, ...]:
        """The first block of each batch, and that of zeros."""
        blocks, found = self.width // LANES, []
        for batch in self.batches:
            found.append(blocks)
            blocks += count(batch.members)
        return (*found, blocks)

    @cached_property
    def offsets(self) -> dict[int, int]:
        """Where coefficient 0 of each series is."""
        return {
            index: self.offset(first, place)
            for first, batch in zip(self.first, self.batches)
            for place, index in enumerate(batch.members)
        }

    def offset(self, block: int, lane: int) -> int:
        """Where coefficient 0 is of the series in a lane, counted from the beginning of a block."""
        return LANES * (self.span * (block + lane // LANES) + BEFORE) + lane % LANES

    @property
    def zero(self) -> int:
        """A series of zeros."""
        return self.offset(self.first[-1], 0)

    @property
    def doubles(self) -> int:
        """Size of ``%work``."""
        return LANES * self.span * (self.first[-1] + 1)


def count(members: Sequence[object]) -> int:
    """The number of blocks that they take."""
    return -(-len(members) // LANES)
