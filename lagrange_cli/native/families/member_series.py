"""The series of members that proofs look at: of combinations of q and v, and of singular sums.

They follow from those of q and v, order by order, for eight members at a time, as in ``@jet``: what this has
of members may be gone when a step is proven, since they take turns in memory.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence

from lagrange_cli.expression.node import Node
from lagrange_cli.families.arrays import Array, Domain, Slots, Source, Term
from lagrange_cli.native.families.evaluation import Evaluation, Writer
from lagrange_cli.native.families.loops import Loop
from lagrange_cli.native.families.series import LoopSeries
from lagrange_cli.native.families.spans import smaller
from lagrange_cli.native.families.stage import MemberStage
from lagrange_cli.native.families.vectors import DoubleVectors, Operands
from lagrange_cli.native.interface import LANES
from lagrange_cli.native.llvm.vector import Index, Integer, Pointer, Real
from lagrange_cli.native.recurrences.disk_arithmetic import ROUNDING
from lagrange_cli.native.stepping.state_series import Combination
from lagrange_cli.records import dataclass

OfOrder = Callable[["Index | None"], Evaluation]
"""What finds the coefficients of one order of q and v, or their low parts."""
Each = Callable[[Integer, Integer], None]
"""What is done with a member, which is in one of eight lanes."""
Known = Mapping[Node, Operands]
"""Numbers of eight members."""


class InUnits(DoubleVectors):
    """Doubles, where time has a ``%unit`` in series."""

    def integrated(self, value: Operands, k: Index, ahead: int) -> Operands:
        return self.over(self.kind.mul(value, self._unit.name), k, ahead)

    def rate(self, k: Index, ahead: int) -> Operands:
        return self.kind.div(super().rate(k, ahead), self._unit.name)

    @property
    def _unit(self) -> Real:
        return self.splat(Real(self.f, "%unit", 1), LANES)


@dataclass(frozen=True, eq=False)
class SumSeries:
    """What has series of its own in a ``loop`` over members: what is ``combined`` of q, v and totals, whose
    series are of this ``order``; ``sums``; and other ``nodes``. In memory, the series of eight members are in
    front of those that they follow from."""

    loop: Loop
    combined: Mapping[Node, Combination]
    sums: Sequence[Node]
    nodes: Sequence[Node]
    series: LoopSeries
    order: int

    @property
    def width(self) -> int:
        """The doubles of an order."""
        return LANES * (len(self.combined) + len(self.nodes))

    @property
    def first(self) -> int:
        """Where what they follow from begins."""
        return self.width * (self.order + 1)

    @property
    def room(self) -> int:
        """The doubles of all."""
        return self.first + self.series.size

    def combination(self, node: Node) -> int:
        """Where the coefficients of a combination are among those of an order."""
        return LANES * [*self.combined].index(node)

    def other(self, node: Node) -> int:
        """The same of a sum, or another node."""
        return LANES * (len(self.combined) + self.nodes.index(node))


def sum_series(
    combined: Mapping[Node, Combination],
    sums: Sequence[Node],
    others: Sequence[Node],
    domain: Domain,
    slots: Slots,
    moving: int,
    time: Node,
    order: int,
) -> SumSeries:
    """That of a domain's members; some symbols are ``moving``."""
    linear = [
        slots.graph.sum([(factor * symbol, 1.0) for symbol, factor in zip(one.symbols, one.factors)])
        for one in combined.values()
    ]
    nowhere, nodes = Array(Source.TOTAL, 1), [*dict.fromkeys((*sums, *others))]
    every, own = (
        Loop(domain, [(Term(domain, one, domain.together), nowhere) for one in listed], slots)
        for listed in ([*linear, *nodes], nodes)
    )
    return SumSeries(every, combined, sums, nodes, LoopSeries(own, slots, moving, time, order), order)


class SumWriter(Writer):
    """Takes the members of a domain in turn, eight by eight, once their series are at ``place``: ``each``
    writes what is done with one."""

    def __init__(self, of_order: OfOrder, found: SumSeries, place: Pointer, each: Each) -> None:
        super().__init__(of_order(0), found.loop)
        self.of_order, self.found, self.place, self.each = of_order, found, place, each

    def row(self, bases: Sequence[Integer], length: Integer, r: Integer) -> None:
        f, order, series = self.f, self.found.order, self.found.series
        start = self.listed_at(self.rows.starts, r)
        begun, end = max(series.unrolled, 1), order - 1  # accelerations have so many orders
        with f.loop(0, length, LANES, tested=False) as j:
            for k in range(begun):
                self.expand(k, bases, j)
            with f.loop(begun, end) as counter:
                self.expand(counter, bases, j)
            for k in range(end, order + 1):
                self.combine(k, self.slots_of(k, bases, j))
            with f.loop(j, smaller(f, j + LANES, length), tested=False) as i:
                self.each(start + i, i - j)

    def slots_of(self, k: Index | None, bases: Sequence[Integer], j: Integer) -> Known:
        """Coefficients ``k`` of eight members' slots, from the ``j``-th one of a row on; their low parts, if
        it is None."""
        evaluation = self.of_order(k)
        writer = Writer(evaluation, self.loop)
        writer.first = self.first
        return {**evaluation.known, **writer.fixed(bases), **writer.changing(bases, j)}

    def expand(self, k: Index, bases: Sequence[Integer], j: Integer) -> None:
        """Coefficients ``k`` of all."""
        known = self.slots_of(k, bases, j)
        if k == 0:
            self.begin(known, self.slots_of(None, bases, j))
        else:
            self.combine(k, known)
        if self.found.nodes:
            block = self.f.place(self.place, self.found.first, "double")
            stage = MemberStage(self.of_order(k), self.found.series, k, block, known, None)
            for node, value in zip(self.found.nodes, stage.values()):
                self.put(self.found.other(node), k, self.vectors.number(value))

    def combine(self, k: Index, known: Known) -> None:
        """At least the sizes of coefficients ``k`` of combinations."""
        f = self.f
        for node in self.found.combined:
            terms, total = self.terms_of(node, known), f.zero(LANES)
            for weight, one in terms:
                total = f.fused(weight, one, total)
            self.put(self.found.combination(node), k, f.magnitude(total) + self.rounding(terms))

    def begin(self, known: Known, low: Known) -> None:
        """In place of coefficients 0, the errors of these."""
        f = self.f
        for node in self.found.combined:
            error = self.rounding(self.terms_of(node, known))
            for weight, one in self.terms_of(node, low):
                error = f.fused(f.magnitude(weight), f.magnitude(one), error)
            self.put(self.found.combination(node), 0, error)

    def rounding(self, terms: Sequence[tuple[Real, Real]]) -> Real:
        """The rounding errors of a sum of products."""
        f, spread = self.f, self.f.zero(LANES)
        for weight, one in terms:
            spread = f.fused(f.magnitude(weight), f.magnitude(one), spread)
        return spread * (len(terms) * ROUNDING)

    def terms_of(self, node: Node, known: Known) -> list[tuple[Real, Real]]:
        """The weights of a combination, and what they are multiplied by."""
        one = self.found.combined[node]
        weights = self.evaluation.values(one.factors, known)
        values = (known[symbol] for symbol in one.symbols)
        return [(self.vectors.number(a), self.vectors.number(b)) for a, b in zip(weights, values)]

    def put(self, at: int, k: Index, value: Real) -> None:
        """Keep coefficients ``k``."""
        self.vectors.store_row(value, self.place, k * self.found.width + at)
