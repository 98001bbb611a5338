"""Friction between coordinates of chains and trees, which hold each other while it sticks.

With A for the slopes of relative velocities, and S for 1 where members stick and 0 where they slip, forces f
of friction are multipliers of constraints that are there for a time (see ``closure``):

    M a = F + A^T S f,    (S A M^-1 A^T S + 1 - S) f = -S A M^-1 F.

A is constant. Accelerations of what is held are those of its anchors to the last bit, as where M is diagonal
(``anchoring``).
"""

from __future__ import annotations

from collections.abc import Sequence

from lagrange_cli.expression.node import Node
from lagrange_cli.families.arrays import Array, Total
from lagrange_cli.families.bonds import Bound
from lagrange_cli.families.description import FamilySystem
from lagrange_cli.native.families.constraints.anchoring import Anchoring, AnchorLoops, Rubbing
from lagrange_cli.native.families.constraints.dense import SolvingTables
from lagrange_cli.native.families.corrected import Local
from lagrange_cli.native.families.evaluation import Evaluation, room
from lagrange_cli.native.families.joints.closed import ClosedJet
from lagrange_cli.native.families.joints.closure import Closure
from lagrange_cli.native.families.lasting import Lasting
from lagrange_cli.native.families.series_places import JetSetting


class StickingClosure(Rubbing, Closure):
    """The totals of these forces."""

    def __init__(self, system: FamilySystem, lasting: Lasting) -> None:
        super().__init__(system, lasting)
        self.anchoring = Anchoring(self)

    @property
    def forces_besides(self) -> Total:
        assert self.modes.loose is not None
        return self.modes.loose

    def columns(self, bound: Bound) -> Sequence[Array]:
        return [self.lasting_column(bound.domain, slope) for slope in bound.slopes]

    def sticks(self, bound: Bound) -> Node:
        """1 where members stick."""
        return self.hold(bound.domain, bound.numbers, bound.numbers)

    def multiplier(self, bound: Bound) -> Node:
        return self.sticks(bound) * super().multiplier(bound)

    def right_side(self) -> Total:
        return self.of_bounds(lambda b: -self.sticks(self.bounds[b]) * self.along(b, self.balance))

    def entries(self, number: int) -> Node:
        bound = self.bounds[number]
        held = self.sticks(bound) * super().entries(number)
        return held + self.slips(bound.domain, bound.numbers) * super().multiplier(bound)

    def locals(self) -> Sequence[Local]:
        return []

    @property
    def in_order(self) -> Sequence[Array]:
        return []

    @property
    def in_first(self) -> Sequence[Array]:
        return []


class StickingJointsJet(ClosedJet):
    """The jet of joints with such forces."""

    def __init__(
        self, sticking: StickingClosure, tabled: SolvingTables, setting: JetSetting, name: str
    ) -> None:
        super().__init__(sticking, tabled, setting, name)
        self.sticking = sticking

    def prepared(self) -> Sequence[Total]:
        totals = super().prepared()
        self.listed = self.take(room(self.sticking.count + 1))
        given = self.sticking.anchoring, self.vectors, self.tables
        listed = self.f.place("%work", self.listed, "i64")
        self.anchored = AnchorLoops(*given, lambda one: self.at(one, 0), listed)
        return totals

    def follow_forces(self, evaluation: Evaluation, *, first: bool) -> None:
        if first:
            self.anchored.list()
        super().follow_forces(evaluation, first=first)

    def bind(self, evaluation: Evaluation) -> None:
        self.anchored.spread(evaluation.where(self.balance.rates))
