"""Series beside those of a motion: of the arguments of events and switches, and of what is integrated."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from lagrange_cli.families.arrays import Array, Chain, Source, Term, Total, total_of
from lagrange_cli.native.families.evaluation import Evaluation, room
from lagrange_cli.native.families.jets import Jet, SeriesJet
from lagrange_cli.native.families.loops import needed
from lagrange_cli.native.families.spans import Span, in_vectors
from lagrange_cli.native.llvm.vector import Bit, Index, Integer
from lagrange_cli.native.motions import RATES
from lagrange_cli.records import replace


class BesideJet(SeriesJet):
    """The series of integrals of ``integrands``, such as the arguments of events: behind the velocities of a
    ``motion`` in its arrays, and after its series, which do not depend on them."""

    tiled = False
    lost: Total | None = None
    """What the low parts of coordinates and velocities add to integrands."""

    def __init__(self, integrands: Total, motion: SeriesJet, name: str) -> None:
        self.integrands, self.motion, self.local = integrands, motion, motion.local
        super().__init__(motion.setting, name)

    def of_state(self) -> dict[Array, tuple[int, int]]:
        self.work = self.motion.work
        given = self.system.q, self.system.v, *self.motion.carried
        return {one: self.motion.planes[one] for one in given}

    def prepared(self) -> Sequence[Total]:
        known = *self.lasting.fixed, *self.motion.carried
        totals = needed([self.integrands], self.slots, known)
        self.arrange(totals)
        if self.system.contact is not None and self.vectors.parts == 1 and self.order > RATES:
            self.lost = self._lost()
            self.loops = [
                one if isinstance(one, Chain) else (replace(one[0], exact=True), one[1]) for one in self.loops
            ]
        return totals

    def _lost(self) -> Total | None:
        """The low parts times the slopes of integrands. Flights between impacts become so short that these
        count: until the next impact an argument may be smaller than rounding errors of coordinates."""
        slots, low, terms = self.slots, dict[Array, Array](), list[Term]()
        for shift, one in enumerate((self.system.q, self.system.v)):
            low[one] = Array(Source.TOTAL, self.degrees)
            self.places[low[one]] = self.f.place("%state", self.width + shift * self.degrees, "double")
        for term in self.integrands.terms:
            for symbol, slot in slots.inside(term.node):
                if slot.array in low:
                    slope = slots.graph.diff(term.node, symbol)
                    part = slope * slots.symbol(term.domain, low[slot.array], slot.table)
                    terms.append(Term(term.domain, part, term.targets))
        if not terms:
            return None
        lost = total_of(self.integrands.count, terms, slots.graph)
        self.planes[lost] = self.take(room(lost.count)), 0
        return lost

    def write(self) -> Jet:
        f, count = self.f, self.integrands.count
        self.totals = self.prepared()
        self.bounded()
        operations = self.emitter.operations + self.stages()
        last = self.vectors.place(self.at(self.system.v, self.order), self.degrees)
        with f.loop(0, count, tested=False) as i:
            self.vectors.store(self.vectors.zero(1), last, i)
        f.give(self.regular())
        return Jet(f.text(), self.work, operations)

    def accelerate(
        self, evaluation: Evaluation, k: Index, phase: int | None, span: Span | None = None
    ) -> None:
        vectors, divisor = self.vectors, self.vectors.divisor(k, 1)
        values, lost = evaluation.where(self.integrands), self.lost if k == 0 else None
        if lost is not None:
            evaluation.write([lost])
        rows = vectors.place(self.at(self.system.v, k + 1), self.degrees)

        def write(i: Integer, lanes: int) -> None:
            value = vectors.load_row(values, i, lanes)
            if lost is not None:
                value = value + vectors.load_row(evaluation.where(lost), i, lanes)
            vectors.store_row(vectors.divided(value, divisor), rows, i)

        in_vectors(self.f, (self.f.count(0), self.f.count(self.integrands.count)), self.chosen(write))

    def chosen(self, write: Callable[[Integer, int], None]) -> Callable[[Integer, int], None]:
        """What writes those of some integrands that are needed."""
        return write

    def regular(self) -> Bit:
        return Bit(self.f, "true", 1)
