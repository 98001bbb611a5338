"""Steps in doubles of a large system, whose series are in blocks (see ``recurrences.batches.layout``)."""

from __future__ import annotations

from lagrange_cli.native.interface import LANES
from lagrange_cli.native.llvm.function import Function
from lagrange_cli.native.recurrences.batches.layout import BEFORE, Blocks
from lagrange_cli.native.stepping.doubles import DoubleSteps
from lagrange_cli.native.stepping.lengths import Lengths
from lagrange_cli.native.stepping.steps import STRAIGHT


def lengths_of(blocks: Blocks, degrees: int) -> Lengths:
    """Where the state's series are."""
    rows = len(blocks.program.state)
    return Lengths(
        degrees, rows, blocks.width, blocks.order, LANES, LANES, blocks.span, LANES, LANES * BEFORE
    )


class BatchSteps(DoubleSteps):
    """The parts of steps where the series of eight rows are a block."""

    def straighten(self, f: Function) -> None:
        lengths = self.lengths
        with lengths.each(f) as row, f.loop(STRAIGHT, lengths.order + 1, tested=False) as m:
            row.series().put(f.zero(LANES), m)
