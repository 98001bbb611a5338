"""``@jet`` of chains and trees: the series of all joints, order by order (see ``balance``)."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property
from typing import Any

from lagrange_cli.expression.node import Node
from lagrange_cli.families.arrays import Array, Slots, Term, Total
from lagrange_cli.native.families.balance import Balance
from lagrange_cli.native.families.evaluation import Evaluation, added, room
from lagrange_cli.native.families.jets import SeriesJet, regular
from lagrange_cli.native.families.kinds import Kind
from lagrange_cli.native.families.local import Local
from lagrange_cli.native.families.loops import Loop, needed
from lagrange_cli.native.families.series import LoopSeries
from lagrange_cli.native.families.spans import Span, divided
from lagrange_cli.native.families.stage import MemberStage, SeriesWriter
from lagrange_cli.native.families.sweeps import Sweeps
from lagrange_cli.native.interface import LANES
from lagrange_cli.native.llvm.text import Value
from lagrange_cli.native.llvm.vector import Bit, Integer
from lagrange_cli.records import dataclass
from lagrange_cli.series.lowering import lower_functions
from lagrange_cli.series.program import Op, SeriesProgram, needs

BEFORE_ACCELERATIONS = -2, -1
"""Stages that have the state alone: coordinates are two orders ahead."""


@dataclass(frozen=True, eq=False)
class JointSeries(LoopSeries):
    """The series of the joints of one kind."""

    local: Local | None = None

    @cached_property
    def program(self) -> SeriesProgram:
        assert self.local is not None
        nodes = [term.node for term, _ in self.local.terms]
        return lower_functions(
            self.slots.graph, self.moving, self.local.coordinates, self.time, nodes, self.local.unknowns
        )

    @cached_property
    def corrected(self) -> Sequence[int]:
        """Series that are needed again later and depend on the newest accelerations, and what these
        corrections take."""
        series, wanted = self.program.series, set[int]()
        for index in reversed(range(len(series))):
            one = series[index]
            if one.corrected and (index in self.stored or index in wanted):
                wanted.add(index)
                wanted |= {
                    a
                    for a, ahead in needs(one)
                    if series[a].corrected and series[a].level == one.level + ahead
                }
        return sorted(wanted)


def series_of(
    kind: Kind, local: Local, slots: Slots, time: Node, order: int, alone: frozenset[Array]
) -> JointSeries:
    """The series of a kind of joints."""
    moving = kind.moving
    for one in local.unknowns:
        moving |= one.symbols
    # what corrections read is read in the same loop
    read = [*local.unknowns, *local.change]
    terms = (
        [*local.terms, *((Term(local.domain, one, kind.every), kind.change[0]) for one in read)]
        if read
        else local.terms
    )
    loop = Loop(local.domain, terms, slots, alone)
    return JointSeries(loop, slots, moving, time, order, local=local)


class JointWriter(SeriesWriter):
    """The loop over joints in stage k: first without the newest accelerations, then, if ``correcting``, what
    they add."""

    correcting = False

    @property
    def early(self) -> bool:
        """Whether there are no accelerations yet."""
        return isinstance(self.k, int) and self.k < 0

    @property
    def local(self) -> Local:
        """What the series give."""
        assert isinstance(self.series, JointSeries) and self.series.local is not None
        return self.series.local

    @property
    def terms(self) -> Sequence[tuple[Term, Array]]:
        if self.correcting or self.early:
            return []
        first = isinstance(self.k, int) and self.k == 0
        return self.local.terms if first else self.local.terms[: len(self.local.terms) - self.local.slopes]

    def values(self, known: dict[Node, str | None], j: Integer) -> list[str | None]:
        if not self.early and not self.correcting:
            known = {**known, **dict.fromkeys(self.local.coordinates)}
        stage = JointStage(self.evaluation, self.series, self.k, self.block_at(j), known, self.phase)
        if self.correcting:
            stage.correct()
        else:
            stage.advance()
        return stage.terms()[: len(self.terms)] if self.terms else []


class JointStage(MemberStage):
    """Stage k of eight joints."""

    def correct(self) -> None:
        """Add what the accelerations add to all series that are needed later."""
        series = self.series
        assert isinstance(series, JointSeries) and series.local is not None
        emitter, local, program = self.emitter, series.local, series.program
        found = dict(zip(local.coordinates, (self.known[one] for one in local.change)))
        change: dict[int, Value] = {}
        for index in series.corrected:
            one = program.series[index]
            if one.op is Op.COORDINATE:
                assert one.node is not None
                change[index] = self.divided(self.divided(found[one.node], 1), 2)
            elif one.op is Op.MULTIPLIER:
                assert one.node is not None
                change[index] = self.known[one.node]
            else:
                change[index] = self.correction(index, change, None)
            if index in series.stored:
                at = self.k + one.level
                self.put(index, emitter.add(self.vector(index, at), change[index]), at)


class ArticulatedJet(SeriesJet):
    """The jet of a system of joints."""

    local = False
    many = 2**18
    """Their code is longer."""

    def __init__(self, balance: Balance, *given: Any) -> None:
        super().__init__(*given)
        self.balance = balance
        self.good: list[Bit] = []

    def of_state(self) -> dict[Array, tuple[int, int]]:
        """Coefficient m of the state's row i is at ``m * width + i``."""
        self.take(room(self.width * (self.order + 1) + self.degrees))
        return {self.system.q: (0, self.width), self.system.v: (self.degrees, self.width)}

    def start(self) -> None:
        super().start()
        self.copy(self.at(self.system.v, 0), self.at(self.system.q, 1), self.degrees)

    def prepared(self) -> Sequence[Total]:
        balance, fixed = self.balance, self.lasting.fixed
        nodes = [self.lasting.arranged(one) for one in balance.found.nodes]
        rates = [self.lasting.arranged(one) if one is not None else None for one in balance.found.rates]
        given = {one: None for one in (*nodes, *rates) if one is not None}
        roots = [one for one in (balance.forces, *balance.loads) if one not in fixed]
        totals = needed(roots, self.slots, [*fixed, *given])
        inside = {slot.array for one in totals for t in one.terms for _, slot in self.slots.inside(t.node)}
        self.followed = [
            (c, nodes[c], rates[c]) for c in balance.axes if {nodes[c], rates[c]} & (inside - {None})
        ]
        """Nodes whose places or velocities forces depend on."""
        for _, *both in self.followed:
            for one in both:
                if one is not None:
                    step = room(one.count)
                    self.planes[one] = self.take((self.order + 1) * step), step
        self.starts = needed([one for _, *both in self.followed for one in both if one], self.slots, fixed)
        for one in self.starts:
            if one not in self.planes:
                self.planes[one] = self.take(room(one.count)), 0
        self.arrange(totals)
        for array in balance.arrays:
            if array not in fixed and array not in self.planes:
                self.planes[array] = self.take(room(array.count)), 0
        own = [array for local in balance.series for _, array in local.terms]
        alone = frozenset(one for one in own if own.count(one) == 1)
        self.joints = []
        for kind, local in zip(balance.kinds, balance.series):
            series = series_of(kind, local, self.slots, self.system.time, self.order, alone)
            self.joints.append((series, self.take(series.doubles)))
        tree = balance.found.nodes[0].tree if balance.found.nodes else None
        self.sweeps = Sweeps(self.f, self.tables, tree, lambda one: self.at(one, 0)) if tree else None
        return totals

    def moving(self, totals: Sequence[Array]) -> list[Any]:
        """Those that are no constants of the motion."""
        return [one for one in totals if one not in self.lasting.fixed]

    @property
    def series(self) -> list[tuple[LoopSeries, int]]:
        return [*super().series, *self.joints]

    def begin(self) -> None:
        if self.starts:
            self.evaluation(0).write(self.starts)
            for _, place, rate in self.followed:
                if place is not None and rate is not None:
                    self.copy(self.at(rate, 0), self.at(place, 1), place.count)
        for k in BEFORE_ACCELERATIONS:
            self.evaluate(k)

    def evaluate(self, k: int | Integer, phase: int | None = None, *, correcting: bool = False) -> None:
        """The series of all joints in stage k."""
        early = isinstance(k, int) and k < 0
        evaluation = Evaluation(
            self.f, self.slots, lambda array: self.at(array, k + 2 if early and array is self.system.q else
            0), self.tables, {self.system.time: self.time}, self.emitter,
        )  # fmt: skip
        for series, place in self.joints:
            writer = JointWriter(evaluation, series, place, k, phase)
            writer.correcting = correcting
            writer.write()

    def accelerate(
        self, evaluation: Evaluation, k: int | Integer, phase: int | None, span: Span | None = None
    ) -> None:
        balance, first = self.balance, isinstance(k, int) and k == 0
        given = [*balance.local, *(balance.slopes if first else ())]
        evaluation.clear(added(self.moving(given), [series.loop for series, _ in self.joints]))
        self.evaluate(k, phase)
        if first:
            evaluation.write(self.moving(balance.first))
            self.good = [
                regular(self.f, self.at(kind.determinant, 0), kind.domain.count, positive=True)
                for kind in balance.kinds
                if kind.determinant is not None
            ]
            if self.sweeps is not None:
                self.good.append(
                    self.sweeps.eliminate(
                        balance.masses, balance.inertia, balance.node_slopes, balance.own, balance.corners,
                        balance.weights, balance.gains, balance.inverse, balance.passed,
                    )
                )  # fmt: skip
        evaluation.write(self.moving(balance.before))
        if self.sweeps is not None:
            bare = not any(one.terms for one in balance.pull)
            self.sweeps.to_roots(balance.pull, balance.push, balance.passed, bare=bare)
        evaluation.write(self.moving(balance.between))
        if self.sweeps is not None:
            self.sweeps.to_tips(balance.accelerations, balance.drift, balance.passed)
        evaluation.write(self.moving(balance.after))
        self.evaluate(k, correcting=True)
        self.advance(evaluation, k)

    def advance(self, evaluation: Evaluation, k: int | Integer) -> None:
        """The newest coefficients of coordinates, and of nodes that forces depend on."""
        f, one, two = self.f, self.reciprocal(k, 1), self.reciprocal(k, 2)
        found = evaluation.where(self.balance.rates)
        following, beyond = (k + 1) * self.width, (k + 2) * self.width
        # from the last ones on: a whole vector of velocities goes beyond them, where the next coefficients of
        # the first coordinates are
        last = LANES * ((self.degrees - 1) // LANES)
        with f.loop(0, self.degrees, LANES, tested=False) as j:
            i = f.count(last) - j
            velocity = divided(f, f.load_row(found, i, LANES), *one)
            f.store_row(velocity, "%work", i + self.degrees + following)
            f.store_row(divided(f, velocity, *two), "%work", i + beyond)
        for c, place, rate_of in self.followed:
            source = evaluation.where(self.balance.accelerations[c])
            with f.loop(0, self.balance.count, LANES, tested=False) as i:
                rate = divided(f, f.load_row(source, i + 1, LANES), *one)
                if rate_of is not None:
                    f.store_row(rate, self.at(rate_of, k + 1), i)
                if place is not None:
                    f.store_row(divided(f, rate, *two), self.at(place, k + 2), i)

    def regular(self) -> Bit:
        found = self.good[0]
        for one in self.good[1:]:
            found = found & one
        return found
