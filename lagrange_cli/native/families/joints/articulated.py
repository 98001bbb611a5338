"""``@jet`` of chains and trees: the series of all joints, order by order (see ``balance``)."""

from __future__ import annotations

from collections.abc import Collection, Sequence

from lagrange_cli.families.arrays import Array, Total
from lagrange_cli.native.families.corrected import CorrectedJet, Local
from lagrange_cli.native.families.diagonal import regular
from lagrange_cli.native.families.evaluation import Evaluation, added, room
from lagrange_cli.native.families.joints.balance import Balance
from lagrange_cli.native.families.joints.contacts import JointContacts
from lagrange_cli.native.families.joints.pressing import Pressing
from lagrange_cli.native.families.joints.sweeps import Sweeps
from lagrange_cli.native.families.loops import needed
from lagrange_cli.native.families.series_places import JetSetting
from lagrange_cli.native.families.spans import Span
from lagrange_cli.native.interface import LANES
from lagrange_cli.native.llvm.vector import Bit, Index


class ArticulatedJet(CorrectedJet):
    """The jet of a system of joints."""

    def __init__(
        self, balance: Balance, setting: JetSetting, name: str, touch: JointContacts | None = None
    ) -> None:
        super().__init__(setting, name)
        self.balance, self.touch = balance, touch
        self.good: list[Bit] = []

    @property
    def held(self) -> frozenset[int]:
        """The components of nodes whose series are needed in any case."""
        return frozenset()

    def of_joints(self) -> tuple[Sequence[Total], Sequence[Array], Sequence[Local]]:
        """The forces, further arrays, and what is computed by series."""
        balance = self.balance
        other = [] if balance.other is None else [balance.other]
        return (balance.forces, *balance.loads, *other), balance.arrays, balance.series

    def prepared(self) -> Sequence[Total]:
        balance, fixed, arranged = self.balance, self.lasting.fixed, self.lasting.changed
        nodes = [arranged.get(one, one) for one in balance.found.nodes]
        rates = [one and arranged.get(one, one) for one in balance.found.rates]
        self.sums = [*zip(balance.final_sums, balance.sums, balance.speeds)]
        """Accelerations of sums of coordinates, these, and their velocities."""
        given = {one: None for one in (*nodes, *rates) if one is not None}
        given |= {one: None for _, *both in self.sums for one in both}
        forces, arrays, series = self.of_joints()
        roots = [one for one in forces if one not in fixed]
        totals = needed(roots, self.slots, [*fixed, *given])
        inside = {slot.array for one in totals for t in one.terms for _, slot in self.slots.inside(t.node)}
        held = self.held if self.touch is None else self.held | self.touch.reaching.components
        self.followed = [
            (c, nodes[c], rates[c])
            for c in balance.places
            if {nodes[c], rates[c]} & (inside - {None}) or c in held
        ]
        """Nodes whose places or velocities forces depend on, or constraints."""
        for _, *both in (*self.followed, *self.sums):
            for one in both:
                if one is not None:
                    step = room(one.count)
                    self.planes[one] = self.take((self.order + 1) * step), step
        starts = [one for _, *both in (*self.sums, *self.followed) for one in both if one]
        self.starts = needed(starts, self.slots, fixed)
        for one in self.starts:
            if one not in self.planes:
                self.planes[one] = self.take(room(one.count)), 0
        self.arrange(totals)
        for array in arrays:
            if array not in fixed and array not in self.planes:
                self.planes[array] = self.take(room(array.count)), 0
        if balance.left is not None:
            step = room(balance.left.count)
            self.planes[self.carried[-1]] = self.take((self.order + 1) * step), step
        touch = self.touch
        if touch is not None:
            for array in touch.arrays:
                self.planes[array] = self.take(room(array.count + 1)), 0
            self.pressing = Pressing(self, touch)
            self.place_kept()
        self.arrange_members(series)
        tree = balance.found.nodes[0].tree if balance.found.nodes else None
        self.sweeps = Sweeps(self.vectors, self.tables, tree, lambda one: self.at(one, 0)) if tree else None
        if touch is not None:
            self.pressing.sweeps = self.sweeps
        return totals

    @property
    def carried(self) -> Sequence[Array]:
        locks = self.system.modes and self.system.modes.locks
        return [*super().carried, *([locks.left] if locks else [])]

    @property
    def ahead(self) -> Collection[Array]:
        return [self.system.q, *(place for _, place, _ in (*self.followed, *self.sums) if place is not None)]

    def begin(self) -> None:
        if self.starts:
            self.evaluation(0).write(self.starts)
            for _, place, rate in (*self.followed, *self.sums):
                if place is not None and rate is not None:
                    self.follow(0, self.at(rate, 0), self.at(place, 1), place.count)
        super().begin()

    def accelerate(
        self, evaluation: Evaluation, k: Index, phase: int | None, span: Span | None = None
    ) -> None:
        balance, first = self.balance, isinstance(k, int) and k == 0
        given = self.given(first=first)
        evaluation.clear(added(self.moving(given), [series.loop for series, _ in self.members]))
        self.evaluate(k, phase)
        if first:
            evaluation.write(self.moving(balance.first))
            self.good = [
                regular(self.f, self.at(kind.determinant, 0), kind.domain.count, positive=True)
                for kind in balance.kinds
                if kind.determinant is not None
            ]
            if self.sweeps is not None:
                self.good.append(self.sweeps.eliminate(balance))
        self.follow_forces(evaluation, first=first)
        evaluation.write(self.moving(balance.after))
        self.bind(evaluation)
        if balance.left is not None:
            self.copy(evaluation.where(balance.left), self.at(self.carried[-1], k), balance.left.count)
        if self.touch is not None:
            self.good += self.pressing.press(evaluation, first=first)
            if self.followed and self.sweeps is not None:
                self.pressing.move_nodes(evaluation)
            self.keep(self.touch.multipliers, k)
        self.evaluate(k, correcting=True)
        self.advance(evaluation, k, balance.final)

    def given(self, *, first: bool) -> list[Array]:
        """What series give."""
        touch = self.touch
        found = [*self.balance.local, *(self.balance.slopes if first else ())]
        if touch is not None:
            found += [*touch.in_order, *(touch.in_first if first else ())]
        return found

    def follow_forces(self, evaluation: Evaluation, *, first: bool) -> None:
        """The accelerations of nodes."""
        swept(evaluation, self.balance, self.sweeps, self.lasting.fixed)

    def bind(self, evaluation: Evaluation) -> None:
        """Change accelerations that follow from others."""

    def advance(self, evaluation: Evaluation, k: Index, rates: Array) -> None:
        """The newest coefficients of coordinates, and of nodes that forces depend on."""
        super().advance(evaluation, k, rates)
        f, vectors = self.f, self.vectors
        one, two = vectors.divisor(k, 1), vectors.divisor(k, 2)
        moved: list[tuple[Array, int, Array | None, Array | None]] = []
        moved += [(self.balance.accelerations[c], 1, place, rate) for c, place, rate in self.followed]
        moved += [(total, 0, place, rate) for total, place, rate in self.sums]
        for accelerations, first, place, rate_of in moved:
            source = evaluation.where(accelerations)
            with f.loop(0, accelerations.count, LANES, tested=False) as i:
                rate = vectors.divided(vectors.load_row(source, i + first, LANES), one)
                if rate_of is not None:
                    vectors.store_row(rate, self.at(rate_of, k + 1), i)
                if place is not None:
                    vectors.store_row(vectors.divided(rate, two), self.at(place, k + 2), i)

    def regular(self) -> Bit:
        found = self.good[0]
        for one in self.good[1:]:
            found = found & one
        return found


def swept(evaluation: Evaluation, balance: Balance, sweeps: Sweeps | None, fixed: Collection[Array]) -> None:
    """Forces to the roots, and accelerations of nodes to the tips."""

    def moving(totals: Sequence[Total]) -> list[Total]:
        return [one for one in totals if one not in fixed]

    evaluation.write(moving(balance.before))
    if sweeps is not None:
        sweeps.to_roots(balance)
    evaluation.write(moving(balance.between))
    if sweeps is not None:
        sweeps.to_tips(balance)
