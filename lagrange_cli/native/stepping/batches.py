"""Steps in doubles of a large system, whose series are in blocks (see ``recurrences.layout_batches``)."""

from __future__ import annotations

from lagrange_cli.native.interface import LANES
from lagrange_cli.native.llvm.function import Function
from lagrange_cli.native.llvm.vector import Bit, Real
from lagrange_cli.native.recurrences.layout_batches import BEFORE, Blocks
from lagrange_cli.native.stepping.acceptance import DOUBLE
from lagrange_cli.native.stepping.advance import advance
from lagrange_cli.native.stepping.doubles import DoubleSteps
from lagrange_cli.native.stepping.lengths import Lengths
from lagrange_cli.native.stepping.motion import Given, MotionSteps
from lagrange_cli.native.stepping.steps import STRAIGHT
from lagrange_cli.native.stepping.sums import DoubleSums


def stepper(blocks: Blocks, given: Given) -> str:
    """IR of ``@advance`` and its helpers."""
    return advance(BatchSteps(blocks, given))


def lengths_of(blocks: Blocks, degrees: int) -> Lengths:
    """Where the state's series are."""
    rows = len(blocks.program.state)
    return Lengths(
        degrees, rows, blocks.width, blocks.order, LANES, LANES, 1, blocks.span, LANES, LANES * BEFORE
    )


class BatchSteps(DoubleSteps):
    """What steps are made of where the series of eight rows are a block."""

    def __init__(self, blocks: Blocks, given: Given) -> None:
        lengths = lengths_of(blocks, given.state.degrees)
        MotionSteps.__init__(self, given, lengths, DOUBLE, DoubleSums(), 0.0)
        self._work = given.work

    def straighten(self, f: Function) -> None:
        lengths = self.lengths
        with lengths.each(f) as row, f.loop(STRAIGHT, lengths.order + 1, tested=False) as m:
            row.series().put(f.zero(LANES), m)


def accelerate(blocks: Blocks, degrees: int) -> str:
    """``@accelerate``: rates of the velocities and integrals at one state, whose low parts are zeros.

    It returns 0 where the mass matrix is singular.
    """
    given = "ptr noalias %constants, double %t, ptr noalias %state, ptr noalias %work, ptr noalias %out"
    f = Function(f"define i64 @accelerate({given}) #0")
    lengths = lengths_of(blocks, degrees)
    constants, state, work = (f.pointer(f"%{name}") for name in ("constants", "state", "work"))
    regular = f.call(Bit, "jet", constants, Real(f, "%t"), state, work)
    with f.loop(degrees, len(blocks.program.state), tested=False) as i:
        f.store(f.load(lengths.single(f, i), LANES), "%out", i - degrees)
    f.give(regular.to_integer())
    return f.text()
