"""Taylor series in which coordinates are two orders ahead, and the newest accelerations follow from all
members together: each order is computed without these, and then corrected."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from functools import cached_property
from typing import Any

from lagrange_cli.expression.node import Node, union
from lagrange_cli.families.arrays import Array, Domain, Slot, Slots, Source, Term, Total
from lagrange_cli.mechanics.substitution import substituted
from lagrange_cli.native.families.evaluation import Evaluation, room
from lagrange_cli.native.families.jets import SeriesJet
from lagrange_cli.native.families.loops import Loop
from lagrange_cli.native.families.series import LoopSeries
from lagrange_cli.native.families.stage import MemberStage, SeriesWriter
from lagrange_cli.native.families.vectors import Operands
from lagrange_cli.native.interface import LANES
from lagrange_cli.native.llvm.vector import Index, Integer
from lagrange_cli.records import dataclass
from lagrange_cli.series.lowering import lower_functions
from lagrange_cli.series.program import Op, SeriesProgram, needs

BEFORE_ACCELERATIONS = -2, -1
"""Stages that have the state alone: coordinates are two orders ahead."""


def early(k: Index) -> bool:
    """Whether stage k is one of these."""
    return isinstance(k, int) and k < 0


@dataclass(frozen=True, eq=False)
class Local:
    """What the series of the members of one kind give: terms, and the arrays that they are added to.
    ``coordinates`` are the symbols of q and ``unknowns`` those of forces; ``change`` has those of q_ddot,
    when it is known. The last ``slopes`` terms are slopes, which order 0 has. ``sums`` are the symbols of
    totals of coordinates, whose coefficients are known up to the order of the accelerations."""

    domain: Domain
    terms: Sequence[tuple[Term, Array]]
    slopes: int
    coordinates: Sequence[Node]
    unknowns: Sequence[Node]
    change: Sequence[Node]
    sums: Sequence[Node] = ()


def in_series(
    slots: Slots, node: Node, domain: Domain, places: Mapping[Array, Array]
) -> tuple[Node, Mapping[Node, Slot]]:
    """An expression of places and velocities as one of places and their rates, whose series are two orders
    ahead, and these places; ``places`` has them by their velocities."""
    rates, found = dict[Node, Node](), dict[Node, Slot]()
    for symbol, slot in slots.inside(node):
        if slot.array in places:
            place = slots.symbol(domain, places[slot.array], slot.table)
            rates[symbol], found[place] = slots.graph.ddt(place), slots.of[place]
        elif slot.array in places.values():
            found[symbol] = slot
    return substituted(slots.graph, [node], rates)[0], found


@dataclass(frozen=True, eq=False)
class CorrectedSeries(LoopSeries):
    """The series of members of one kind, whose coordinates are two orders ahead."""

    local: Local | None = None

    @property
    def terms(self) -> int:
        assert self.local is not None
        return len(self.local.terms) - self.local.slopes

    @cached_property
    def program(self) -> SeriesProgram:
        assert self.local is not None
        nodes = [term.node for term, _ in self.local.terms]
        return lower_functions(
            self.slots.graph, self.moving, self.local.coordinates, self.time, nodes, self.local.unknowns, 2,
            self.local.sums,
        )  # fmt: skip

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

    @cached_property
    def blank(self) -> frozenset[int]:
        """Series whose newest coefficients are 0 without the newest accelerations and multipliers."""
        found = set[int]()
        for index, one in enumerate(self.program.series):
            if one.corrected and one.op in (Op.COORDINATE, Op.MULTIPLIER):
                found.add(index)
            elif one.op is Op.DERIVATIVE or (one.op is Op.LINEAR and one.level > 0):
                known = [a for a, ahead in needs(one) if self.program.series[a].level != one.level + ahead]
                if not known and found.issuperset(one.arguments):
                    found.add(index)
        return frozenset(found)


def series_of(local: Local, slots: Slots, time: Node, order: int, alone: frozenset[Array]) -> CorrectedSeries:
    """The series that a kind of members has."""
    moving = union((time, *local.coordinates, *local.unknowns, *local.sums))
    # what corrections read is read in the same loop
    read = [*local.unknowns, *local.change]
    every, unused = local.domain.every, Array(Source.TOTAL, local.domain.count)
    terms = [*local.terms, *((Term(local.domain, one, every), unused) for one in read)]
    loop = Loop(local.domain, terms, slots, alone, onto=True)
    return CorrectedSeries(loop, slots, moving, time, order, local=local)


class CorrectedWriter(SeriesWriter):
    """The loop over members in stage k: first without the newest accelerations, then, if ``correcting``, what
    they add."""

    correcting = False

    @property
    def local(self) -> Local:
        """What the series give."""
        assert isinstance(self.series, CorrectedSeries) and self.series.local is not None
        return self.series.local

    @property
    def terms(self) -> Sequence[tuple[Term, Array]]:
        if self.correcting or early(self.k):
            return []
        first = isinstance(self.k, int) and self.k == 0
        return self.local.terms if first else self.local.terms[: self.series.terms]

    def values(self, known: dict[Node, Operands], j: Integer) -> list[Operands]:
        if not early(self.k) and not self.correcting:
            known = {**known, **dict.fromkeys(self.local.coordinates)}
        stage = CorrectedStage(self.evaluation, self.series, self.k, self.block_at(j), known, self.phase)
        if self.correcting:
            stage.correct()
        else:
            stage.advance()
        return stage.terms() if self.terms else []


class CorrectedStage(MemberStage):
    """Stage k of eight members."""

    series: CorrectedSeries

    def put(self, index: int, value: Operands, m: Index) -> None:
        if early(self.k) or index not in self.series.blank:
            super().put(index, value, m)

    def correct(self) -> None:
        """Add what the accelerations add to all series that are needed later."""
        series, local, program = self.series, self.series.local, self.series.program
        assert local is not None
        found = dict(zip(local.coordinates, (self.known[one] for one in local.change)))
        change: dict[int, Operands] = {}
        for index in series.corrected:
            one = program.series[index]
            if one.op is Op.COORDINATE:
                assert one.node is not None
                change[index] = self.integrated(self.integrated(found[one.node], 1), 2)
            elif one.op is Op.MULTIPLIER:
                assert one.node is not None
                change[index] = self.known[one.node]
            else:
                change[index] = self.correction(index, change, None)
            if index in series.stored:
                at = self.k + one.level
                before = None if index in series.blank else self.vector(index, at)
                super().put(index, self.emitter.add(before, change[index]), at)


class CorrectedJet(SeriesJet):
    """A jet with all coefficients of the state."""

    local = False
    many = 2**18
    """The code is longer."""
    members: list[tuple[CorrectedSeries, int]]
    """Their series, with places in ``%work``."""
    kept: Total | None = None
    """The multipliers, if what is followed beside the motion contains them."""

    @property
    def ahead(self) -> Collection[Array]:
        """What is two orders ahead."""
        return [self.system.q]

    def start(self) -> None:
        super().start()
        self.begin()

    def begin(self) -> None:
        """The stages before order 0, of the series of members."""
        for k in BEFORE_ACCELERATIONS:
            self.evaluate(k)

    @property
    def series(self) -> list[tuple[LoopSeries, int]]:
        return [*super().series, *self.members]

    def arrange_members(self, locals: Sequence[Local]) -> None:
        """Find the series of all kinds of members."""
        own = [array for local in locals for _, array in local.terms]
        alone = frozenset(one for one in own if own.count(one) == 1)
        self.members = []
        for local in locals:
            series = series_of(local, self.slots, self.system.time, self.order, alone)
            self.members.append((series, self.take(series.doubles)))

    @property
    def carried(self) -> Sequence[Array]:
        return () if self.kept is None else (self.kept,)

    def keep(self, multipliers: Array, k: Index) -> None:
        """Keep coefficients k of the multipliers, if that is asked for."""
        if self.kept is not None:
            self.copy(self.at(multipliers, 0), self.at(self.kept, k), multipliers.count)

    def place_kept(self) -> None:
        """Find a place for these."""
        if self.kept is not None:
            step = room(self.kept.count)
            self.planes[self.kept] = self.take((self.order + 1) * step), step

    def moving(self, totals: Sequence[Array]) -> list[Any]:
        """Those that are no constants of the motion."""
        return [one for one in totals if one not in self.lasting.fixed]

    def evaluate(self, k: Index, phase: int | None = None, *, correcting: bool = False) -> None:
        """The series of all members in stage k."""
        evaluation = Evaluation(
            self.vectors, self.slots, lambda array: self.at(array, k + 2 if early(k) and array in self.ahead
            else 0), self.tables, {self.system.time: self.time},
        )  # fmt: skip
        for series, place in self.members:
            writer = CorrectedWriter(evaluation, series, place, k, phase)
            writer.correcting = correcting
            writer.write()

    def advance(self, evaluation: Evaluation, k: Index, rates: Array) -> None:
        """The newest coefficients of coordinates, from those of their accelerations."""
        f, vectors = self.f, self.vectors
        one, two = vectors.divisor(k, 1), vectors.divisor(k, 2)
        found = evaluation.where(rates)
        following, beyond = (k + 1) * self.width, (k + 2) * self.width
        # from the last ones on: a whole vector of velocities goes beyond them, where the next coefficients of
        # the first coordinates are
        last = LANES * ((self.degrees - 1) // LANES)
        with f.loop(0, self.degrees, LANES, tested=False) as j:
            i = f.count(last) - j
            velocity = vectors.divided(vectors.load_row(found, i, LANES), one)
            vectors.store_row(velocity, "%work", i + self.degrees + following)
            vectors.store_row(vectors.divided(velocity, two), "%work", i + beyond)
