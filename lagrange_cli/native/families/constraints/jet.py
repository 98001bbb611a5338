"""``@jet`` of systems with constraints: series of these and of what they pull, order by order (see
``restraint``)."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TypeAlias

from lagrange_cli.families.arrays import Array, Total
from lagrange_cli.native.families.constraints.dense import Dense, DenseTables, SolvingTables
from lagrange_cli.native.families.constraints.restraint import AlongMotion, AtAState
from lagrange_cli.native.families.constraints.saddle import Tabled
from lagrange_cli.native.families.corrected import CorrectedJet
from lagrange_cli.native.families.diagonal import regular_masses
from lagrange_cli.native.families.evaluation import Evaluation, added, room
from lagrange_cli.native.families.loops import needed
from lagrange_cli.native.families.series_places import JetSetting
from lagrange_cli.native.families.spans import Span
from lagrange_cli.native.families.tables import places_at
from lagrange_cli.native.families.vectors import Vectors
from lagrange_cli.native.interface import LANES
from lagrange_cli.native.llvm.vector import Bit, Index, Pointer
from lagrange_cli.native.state import vectors_of

Saddle: TypeAlias = "Tabled | Dense"


def saddle_of(vectors: Vectors, tabled: SolvingTables, base: Pointer | str, first: int) -> Saddle:
    """What solves by these tables."""
    if isinstance(tabled, DenseTables):
        return Dense(vectors, tabled, base, first)
    return Tabled(vectors, tabled, base, first)


class ConstrainedJet(CorrectedJet):
    """The jet of a system with constraints."""

    def __init__(self, motion: AlongMotion, tabled: SolvingTables, setting: JetSetting, name: str) -> None:
        super().__init__(setting, name)
        self.motion, self.tabled = motion, tabled

    def prepared(self) -> Sequence[Total]:
        motion = self.motion
        totals = needed([motion.forces], self.slots, self.lasting.fixed)
        self.arrange(totals)
        for array in motion.arrays:
            self.planes[array] = self.take(room(array.count)), 0
        self.planes[motion.rates] = self.planes[motion.free]
        self.arrange_members(motion.locals)
        self.saddle = saddle_of(self.vectors, self.tabled, "%work", self.work)
        self.take(room(self.tabled.size))
        self.place_kept()
        return totals

    def accelerate(
        self, evaluation: Evaluation, k: Index, phase: int | None, span: Span | None = None
    ) -> None:
        motion, first = self.motion, isinstance(k, int) and k == 0
        given = [motion.rest, *(one for some in motion.slopes for one in some if first)]
        evaluation.clear(added(given, [series.loop for series, _ in self.members]))
        self.evaluate(k, phase)
        if first:
            evaluation.write([motion.square])
            regular = self.f.variable(Bit(self.f, "true", 1))
            self.saddle.factor(self.at(motion.square, 0), motion.placed(self.tabled), regular)
            self.sound = regular.get()
        evaluation.write([motion.free])
        for one in motion.sides:
            evaluation.write([one])
        solve(self.saddle, self.at(motion.sides[-1], 0), self.at(motion.multipliers, 0), zeroed=True)
        evaluation.add([motion.rates])
        if motion.final is not motion.rates:
            evaluation.write([motion.final])
        self.evaluate(k, correcting=True)
        self.advance(evaluation, k, motion.final)
        self.keep(motion.multipliers, k)

    def regular(self) -> Bit:
        return regular_masses(self) & self.sound


def solve(saddle: Saddle, right: Pointer, to: Pointer, *, zeroed: bool = False) -> None:
    """The multipliers with A M^-1 A^T lambda = what is at ``right``; a 0 is put behind it, unless it is
    ``zeroed``."""
    f, vectors, count = saddle.f, saddle.vectors, saddle.tabled.count
    if not zeroed:
        vectors.store(vectors.constant(0.0), right, count)
    saddle.solve(right)
    table = saddle.solution
    with f.loop(0, vectors_of(count), tested=False) as b:
        row = vectors.gather(saddle.base, places_at(f, b * LANES + table))
        vectors.store_row(row, to, b * LANES)


def solved_at_a_state(
    evaluation: Evaluation, restraint: AtAState, tabled: SolvingTables, scratch: Pointer, to: Array
) -> None:
    """Compute the multipliers, with room at ``scratch``."""
    f, vectors, where = evaluation.f, evaluation.vectors, evaluation.where
    saddle = saddle_of(vectors, tabled, scratch, 0)
    saddle.factor(where(restraint.square), restraint.placed(tabled), f.variable(Bit(f, "true", 1)))
    solve(saddle, where(restraint.right), where(to))
