"""``@jet`` of chains and trees with constraints (see ``closure``)."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from lagrange_cli.families.arrays import Array, Total
from lagrange_cli.native.families.constraints.dense import SolvingTables
from lagrange_cli.native.families.constraints.jet import saddle_of, solve
from lagrange_cli.native.families.corrected import Local
from lagrange_cli.native.families.evaluation import Evaluation, room
from lagrange_cli.native.families.joints.articulated import ArticulatedJet, swept
from lagrange_cli.native.families.joints.balance import Balance
from lagrange_cli.native.families.joints.closure import Closure
from lagrange_cli.native.families.joints.contacts import JointContacts
from lagrange_cli.native.families.joints.sweeps import Sweeps
from lagrange_cli.native.families.series_places import JetSetting
from lagrange_cli.native.families.spans import Span
from lagrange_cli.native.families.tables import place_at
from lagrange_cli.native.llvm.vector import Bit, Index


class ClosedJet(ArticulatedJet):
    """The jet of a system of joints with constraints."""

    def __init__(
        self,
        closure: Closure,
        tabled: SolvingTables,
        setting: JetSetting,
        name: str,
        touch: JointContacts | None = None,
    ) -> None:
        super().__init__(closure.balance, setting, name, touch)
        self.closure, self.tabled = closure, tabled

    @property
    def held(self) -> frozenset[int]:
        return self.closure.components

    def of_joints(self) -> tuple[Sequence[Total], Sequence[Array], Sequence[Local]]:
        closure, given = self.closure, self.closure.given
        arrays = [one for one in (*self.balance.arrays, *closure.arrays) if one not in given]
        return given, arrays, [*self.balance.series, *closure.series]

    def prepared(self) -> Sequence[Total]:
        totals = super().prepared()
        self.first = self.take(room(self.tabled.size))
        self.saddle = saddle_of(self.vectors, self.tabled, "%work", self.first)
        if self.touch is None:
            self.place_kept()
        return totals

    def accelerate(
        self, evaluation: Evaluation, k: Index, phase: int | None, span: Span | None = None
    ) -> None:
        super().accelerate(evaluation, k, phase, span)
        if self.touch is None:
            self.keep(self.closure.multipliers, k)

    def given(self, *, first: bool) -> list[Array]:
        own = [*self.closure.in_order, *(self.closure.in_first if first else ())]
        return [*super().given(first=first), *own]

    def follow_forces(self, evaluation: Evaluation, *, first: bool) -> None:
        closure, balance = self.closure, self.balance
        if first:
            self._couple(evaluation)
        zero = self.vectors.constant(0.0)
        with self.f.loop(0, closure.count, tested=False) as i:
            self.vectors.store(zero, evaluation.where(closure.multipliers), i)
        self._act(evaluation, closure.acting, balance)
        evaluation.write([closure.right])
        solve(self.saddle, evaluation.where(closure.right), evaluation.where(closure.multipliers))
        evaluation.write(self.moving(closure.acting))
        super().follow_forces(evaluation, first=first)

    def _couple(self, evaluation: Evaluation) -> None:
        """A M^-1 A^T, the columns of each color together, and its factors."""
        f, vectors, closure, where = self.f, self.vectors, self.closure, evaluation.where
        felt, square, multipliers = closure.responses, where(closure.square), where(closure.multipliers)
        owners = felt.colors[felt.places[:, 1]]
        members, listed = (np.argsort(one, kind="stable") for one in (felt.colors, owners))
        tables = [self.tables.of_array(one) for one in (members, felt.places[listed, 0], listed)]
        colors = np.arange(int(felt.colors.max()) + 2)
        begins = [
            self.tables.of_array(np.searchsorted(np.sort(one), colors)) for one in (felt.colors, owners)
        ]
        with f.loop(0, len(colors) - 1, tested=False) as color:
            with f.loop(0, closure.count, tested=False) as i:
                vectors.store(vectors.constant(0.0), multipliers, i)
            mine, entries = (
                (place_at(f, color + begin), place_at(f, color + (begin + 1))) for begin in begins
            )
            with f.loop(*mine, tested=False) as k:
                vectors.store(vectors.constant(1.0), multipliers, place_at(f, k + tables[0]))
            self._act(evaluation, closure.alone, closure.reply)
            evaluation.write([closure.column])
            with f.loop(*entries, tested=False) as k:
                row, place = (place_at(f, k + table) for table in tables[1:])
                vectors.store(vectors.load(where(closure.column), row), square, place)
        for number in range(2):
            vectors.store(vectors.constant(float(number)), square, len(felt.places) + number)
        regular = f.variable(Bit(f, "true", 1))
        self.saddle.factor(square, self.tabled.placed(self.closure.responses.places), regular)
        self.good.append(regular.get())

    def _act(self, evaluation: Evaluation, forces: Sequence[Total], balance: Balance) -> None:
        """What moves by these forces, as far as constraints contain it."""
        respond(evaluation, forces, balance, self.sweeps, self.lasting.fixed, self.closure.by_coordinates)


def respond(
    evaluation: Evaluation,
    forces: Sequence[Total],
    balance: Balance,
    sweeps: Sweeps | None,
    fixed: Any,
    coordinates: bool,
) -> None:
    """The accelerations of nodes by ``forces``, and those of ``coordinates``."""
    evaluation.write([one for one in forces if one not in fixed])
    swept(evaluation, balance, sweeps, fixed)
    if coordinates:
        evaluation.write([one for one in balance.moved if one not in fixed])
