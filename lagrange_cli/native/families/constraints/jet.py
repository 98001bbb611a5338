"""``@jet`` of systems with constraints: series of these and of what they pull, order by order (see
``restraint``)."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TypeAlias

from lagrange_cli.families.arrays import Total
from lagrange_cli.native.families.constraints.dense import Dense, DenseTables, SolvingTables
from lagrange_cli.native.families.constraints.in_turn import DependentTables, InTurn
from lagrange_cli.native.families.constraints.restraint import AlongMotion
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

Saddle: TypeAlias = "Tabled | Dense | InTurn"


def saddle_of(vectors: Vectors, tabled: SolvingTables, base: Pointer | str, first: int) -> Saddle:
    """What solves by these tables."""
    if isinstance(tabled, DenseTables):
        return Dense(vectors, tabled, base, first)
    if isinstance(tabled, DependentTables):
        return InTurn(vectors, tabled, base, first)
    return Tabled(vectors, tabled, base, first)


class ConstrainedJet(CorrectedJet):
    """The jet of a system with constraints."""

    def __init__(self, motion: AlongMotion, tabled: SolvingTables, setting: JetSetting, name: str) -> None:
        super().__init__(setting, name)
        self.motion, self.tabled = motion, tabled
        self.sound = self.f.variable(Bit(self.f, "true", 1))
        """Whether what is factored is regular."""

    def prepared(self) -> Sequence[Total]:
        motion = self.motion
        sums = (self.slots.of[one].array for local in motion.locals for one in local.sums)
        read = [one for one in sums if isinstance(one, Total)]
        totals = needed([motion.forces, *read], self.slots, self.lasting.fixed)
        self.arrange(totals)
        for array in motion.arrays:
            self.planes[array] = self.take(room(array.count)), 0
        self.place_rates()
        self.arrange_members(motion.locals)
        self.place_saddle()
        self.place_kept()
        return totals

    def place_rates(self) -> None:
        """Find a place for the accelerations."""
        self.planes[self.motion.rates] = self.planes[self.motion.free]

    def place_saddle(self) -> None:
        """The same for what solves."""
        self.saddle = saddle_of(self.vectors, self.tabled, "%work", self.work)
        self.take(room(self.tabled.size))

    def accelerate(
        self, evaluation: Evaluation, k: Index, phase: int | None, span: Span | None = None
    ) -> None:
        self.force(evaluation, k, phase)
        self.advance(evaluation, k, self.motion.final)
        self.keep(self.motion.multipliers, k)

    def force(self, evaluation: Evaluation, k: Index, phase: int | None) -> None:
        """Coefficients k of multipliers and of accelerations, and what series have of them."""
        motion, first = self.motion, isinstance(k, int) and k == 0
        given = [motion.rest, *(motion.columns_at_first if first else ())]
        evaluation.clear(added(given, [series.loop for series, _ in self.members]))
        self.evaluate(k, phase)
        if first:
            self.factor(evaluation)
        self.find(evaluation)
        self.evaluate(k, correcting=True)

    def factor(self, evaluation: Evaluation) -> None:
        """Factor what is solved with at all orders."""
        evaluation.write([self.motion.square])
        self.saddle.factor(self.at(self.motion.square, 0), self.motion.placed(self.tabled), self.sound)

    def find(self, evaluation: Evaluation) -> None:
        """Find the multipliers, and the accelerations from these."""
        motion = self.motion
        evaluation.write([motion.free])
        for one in motion.sides:
            evaluation.write([one])
        solve(self.saddle, self.at(motion.sides[-1], 0), self.at(motion.multipliers, 0), zeroed=True)
        evaluation.add([motion.rates])
        self.finish(evaluation)

    def finish(self, evaluation: Evaluation) -> None:
        """The accelerations as they are followed."""
        motion = self.motion
        if motion.final is not motion.rates and isinstance(motion.final, Total):
            evaluation.write([motion.final])

    def regular(self) -> Bit:
        return regular_masses(self) & self.sound.get()


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
