"""``@jet`` of series that threads share: by rounds of blocks, or chunks of rows (see ``sharing``)."""

from __future__ import annotations

from collections.abc import Sequence

from lagrange_cli.families.arrays import Total
from lagrange_cli.native.board import Board
from lagrange_cli.native.families.chunks import Chunks, add_chunks, chunks_of
from lagrange_cli.native.families.diagonal import DiagonalJet
from lagrange_cli.native.families.loops import Loop
from lagrange_cli.native.families.series import LoopSeries
from lagrange_cli.native.families.series_places import JetSetting
from lagrange_cli.native.families.sharing import STRIP, Part, Parts, given
from lagrange_cli.native.families.stage import SeriesWriter
from lagrange_cli.native.families.tiling import SHARED, Tiling
from lagrange_cli.native.families.windows import Turn, Windows
from lagrange_cli.native.llvm.function import Function
from lagrange_cli.native.llvm.vector import Index, Integer


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
