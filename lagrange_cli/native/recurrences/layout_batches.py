"""Where the coefficients of batches of series lie in memory.

Eight series side by side are a *block*: their coefficients follow one another as vectors, behind a few
vectors of what belongs to the series besides. The state's rows come first, then the batches, each in blocks
of its own, then a block of zeros.
"""

from __future__ import annotations

from array import array
from collections.abc import Sequence
from functools import cached_property
from typing import TypeVar

from lagrange_cli.expression.node import Node
from lagrange_cli.native.interface import LANES
from lagrange_cli.native.recurrences.evaluation import Constants
from lagrange_cli.native.state import width_of
from lagrange_cli.records import dataclass, field
from lagrange_cli.series.batches import Batch
from lagrange_cli.series.program import SeriesProgram

N = TypeVar("N", int, float)

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
    """How many blocks they take."""
    return -(-len(members) // LANES)


@dataclass
class Tables:
    """Constant tables of the code: places in ``%work`` and ``%constants``, and numbers; and how many doubles
    of ``@scratch`` it takes."""

    constants: Constants
    places: array[int] = field(default_factory=lambda: array("i"))
    numbers: array[float] = field(default_factory=lambda: array("d"))
    seen: dict[tuple[object, ...], int] = field(default_factory=dict)
    scratch: int = 0

    def of_places(self, listed: Sequence[int]) -> int:
        """Where the table has these places, in whole vectors: the last one is repeated."""
        key = (int, *listed)
        if key not in self.seen:
            self.seen[key] = len(self.places)
            self.places.extend(filled(listed))
        return self.seen[key]

    def of_numbers(self, listed: Sequence[float]) -> int:
        """The same for numbers."""
        key = (float, *listed)
        if key not in self.seen:
            self.seen[key] = len(self.numbers)
            self.numbers.extend(filled(listed))
        return self.seen[key]

    def of_constants(self, nodes: Sequence[Node]) -> int:
        """The places of constants of the motion in ``%constants``."""
        return self.of_places([self.constants.slot(node) for node in nodes])

    def text(self) -> str:
        """Both tables."""
        rows = (("places", self.places), ("factors", self.numbers))
        return "".join(data(name, row.tobytes() or bytes(8)) for name, row in rows)


def filled(listed: Sequence[N]) -> list[N]:
    """Whole vectors of these."""
    return list(listed) + list(listed[-1:]) * (-len(listed) % LANES)


def data(name: str, content: bytes) -> str:
    """A constant array of bytes."""
    text = "\\" + content.hex("\\").upper()
    return f'@{name} = private constant [{len(content)} x i8] c"{text}", align 64\n'
