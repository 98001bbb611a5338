"""Series, and steps by series, whose work threads share (see ``sharing``).

Of the series, these are rounds of blocks or chunks of rows, and rows of the choice of a step and of its end.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

from lagrange_cli.families.arrays import Total
from lagrange_cli.native.board import Board
from lagrange_cli.native.families.chunks import Chunks, add_chunks, chunks_of
from lagrange_cli.native.families.diagonal import DiagonalJet
from lagrange_cli.native.families.loops import Loop
from lagrange_cli.native.families.series import LoopSeries
from lagrange_cli.native.families.series_places import JetSetting
from lagrange_cli.native.families.sharing import STRIP, Part, Parts, Pieces, given
from lagrange_cli.native.families.spans import Span
from lagrange_cli.native.families.stage import SeriesWriter
from lagrange_cli.native.families.steps import VelocitySteps
from lagrange_cli.native.families.tiling import SHARED, Tiling
from lagrange_cli.native.families.windows import Turn, Windows
from lagrange_cli.native.interface import LANES
from lagrange_cli.native.llvm.function import Function
from lagrange_cli.native.llvm.vector import Bit, Index, Integer, Real
from lagrange_cli.native.stepping.acceptance import Allowance
from lagrange_cli.native.stepping.given import Given
from lagrange_cli.native.stepping.lengths import Lengths
from lagrange_cli.native.stepping.step_size import StepSize, split_terms
from lagrange_cli.native.stepping.steps import Now
from lagrange_cli.records import dataclass, fields_of


class SharedJet(DiagonalJet):
    """The jet of a system whose ``parts`` threads share, where there is enough work."""

    shared = True

    def __init__(self, parts: Parts, setting: JetSetting, name: str) -> None:
        super().__init__(setting, name)
        self.parts = parts
        self.chunks: dict[Loop, Chunks] = {}
        """Loops that threads share, a chunk each."""

    def arrange(self, totals: Sequence[Total]) -> None:
        super().arrange(totals)
        for series, _ in self.series if self.tiling is None else ():
            chunks = chunks_of(series.loop) if series.doubles >= SHARED else None
            if chunks is not None:
                self.chunks[series.loop] = chunks

    def rounds(self, tiling: Tiling) -> int:
        if tiling.flight == 1:
            return super().rounds(tiling)
        number = len(self.parts.listed)
        rounds = Part(tiling.rounds + tiling.ring, tiling.flight, tiling.orders, all_count=False)
        outer, inner = self.f, Function(STRIP.format(number))
        outer.call(None, f"share{number}", *given(outer))
        self.enter(inner)
        made = self.parts.strip(inner)
        turn = Turn(made, rounds, tiling.ring)
        turn.begin()
        operations = self.stages(Windows(inner, self.tables, tiling, made.strip, turn))
        inner.give()
        self.enter(outer)
        self.parts.add(rounds, inner.text())
        return operations

    def apart(self, series: LoopSeries) -> bool:
        return series.loop in self.chunks

    def write_apart(self, series: LoopSeries, place: int, k: Index, phase: int | None) -> None:
        outer = self.f

        def within(f: Function) -> SeriesWriter:
            self.enter(f)
            order = f.load_integer(self.parts.board(f), Board.ORDER) if isinstance(k, Integer) else k
            begins = phase == 0 and isinstance(k, Integer)
            return SeriesWriter(self.evaluation(order), series, place, order, phase, begins=begins)

        number, operations = add_chunks(self.parts, self.chunks[series.loop], self.tables, within)
        self.enter(outer)
        outer.operations += operations
        if isinstance(k, Integer):
            outer.store(k, self.parts.board(outer), Board.ORDER)
        outer.call(None, f"share{number}", *given(outer))


HEIGHT = 1024
"""Rows that a thread takes at a time: whole vectors."""


@dataclass(frozen=True)
class SharedStepSize(StepSize):
    """The choice of a step; ``together`` is what threads share. ``%work`` has the address of ``%constants``
    at the place of that name."""

    together: Parts | None = None
    constants: int = 0

    def compared(self, f: Function, span: Real, rows: Span | None = None) -> tuple[Real, list[Real]]:
        assert self.together is not None
        pieces = Pieces(*self.lengths.speeds, HEIGHT)

        def compare(f: Function, rows: Span) -> list[Real]:
            met, greatest = StepSize.compared(self, f, Real(f, "%t", 1), rows)
            return [met, *greatest]

        number = self.together.add_pieces(pieces, compare)
        constants = f.load_pointer("%work", self.constants)
        f.call(None, f"share{number}", constants, span, *f.pointers("state", "work"))
        zero, board = f.constant(0.0), self.together.board(f, constants)
        met, greatest = f.variable(zero), [f.variable(zero) for _ in split_terms(self.lengths.top)]
        with f.loop(0, pieces.strips, tested=False) as strip:
            left = pieces.left(f, board, strip)
            met.set(met.get() + f.load(left))
            for i, one in enumerate(greatest, 1):
                one.set(f.larger(one.get(), f.load(left, i)))
        return met.get(), [one.get() for one in greatest]


class SharedSteps(VelocitySteps):
    """Steps; ``together`` is what threads share."""

    def __init__(self, lengths: Lengths, given: Given, together: Parts) -> None:
        super().__init__(lengths, given)
        self.together, self.constants = together, given.work - 1
        values = {name: getattr(self.sizes, name) for name in fields_of(StepSize)}
        self.sizes = SharedStepSize(**values, together=together, constants=self.constants)

    def expand(self, f: Function, now: Now, brief: Callable[[], Bit] | None = None) -> tuple[Now, Bit]:
        f.store(f.pointer("%constants"), f.place("%work", self.constants, "double"))
        return super().expand(f, now, brief)

    def move_all(self, f: Function, h: Real, allowed: Allowance) -> Real:
        """Whole vectors of coordinates by several threads. The last vector, of which a part may be
        velocities, comes behind them."""
        if self.noise or self.proof:
            return super().move_all(f, h, allowed)
        degrees, together, expected = self.lengths.degrees, self.together, self.expected(f)[:2]
        pieces = Pieces(0, degrees - degrees % LANES, HEIGHT)

        def move(f: Function, rows: Span) -> list[Real]:
            board = together.board(f)
            rates = f.load_pointer(board, Board.RATES)
            change, speed = (f.load(board, one) for one in (Board.CHANGE, Board.SPEED))
            to = rates, f.place(rates, self.state.width, "double")
            return [self.move_some(f, Real(f, "%t", 1), Allowance(change, speed, speed), rows, to)]

        number, board = together.add_pieces(pieces, move), together.board(f)
        given = (Board.RATES, expected[0]), (Board.CHANGE, allowed.change), (Board.SPEED, allowed.speed)
        for place, value in given:
            f.store(value, f.place(board, place, "double"))
        f.call(None, f"share{number}", f.pointer("%constants"), h, *f.pointers("state", "work"))
        farthest = f.variable(f.constant(0.0))
        with f.loop(0, pieces.strips, tested=False) as strip:
            farthest.set(f.larger(farthest.get(), f.load(pieces.left(f, board, strip))))
        if degrees % LANES:
            rest = self.move_some(f, h, allowed, (f.count(pieces.last), f.count(degrees)), expected)
            farthest.set(f.larger(farthest.get(), rest))
        return farthest.get()
