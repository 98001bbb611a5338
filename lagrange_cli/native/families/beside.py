"""Series beside those of a motion: of the arguments of events and switches, and of what is integrated."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from lagrange_cli.families.arrays import Array, Total
from lagrange_cli.native.families.evaluation import Evaluation, LowParts
from lagrange_cli.native.families.jets import Jet, SeriesJet
from lagrange_cli.native.families.loops import needed
from lagrange_cli.native.families.spans import Span, in_vectors
from lagrange_cli.native.interface import LANES
from lagrange_cli.native.llvm.vector import Bit, Index, Integer
from lagrange_cli.native.motions import RATES
from lagrange_cli.native.state import Clock
from lagrange_cli.records import replace


class BesideJet(SeriesJet):
    """The series of integrals of ``integrands``, such as the arguments of events: behind the velocities of a
    ``motion`` in its arrays, and after its series, which do not depend on them."""

    tiled = False

    def __init__(self, integrands: Total, motion: SeriesJet, name: str) -> None:
        self.integrands, self.motion, self.local = integrands, motion, motion.local
        super().__init__(motion.setting, name)

    def of_state(self) -> dict[Array, tuple[int, int]]:
        self.work = self.motion.work
        given = self.system.q, self.system.v, *self.motion.carried
        return {one: self.motion.planes[one] for one in given}

    def evaluation(self, k: Index) -> Evaluation:
        """Flights between impacts become so short that low parts count: until the next impact an argument may
        be smaller than rounding errors of coordinates."""
        found, f = super().evaluation(k), self.f
        accumulate = self.system.impacts is not None and self.order > RATES
        if not (accumulate and self.vectors.parts == 1 and isinstance(k, int) and k == 0):
            return found
        own = self.system.q, self.system.v
        lower = {one: f.place("%state", self.width + i * self.degrees, "double") for i, one in enumerate(own)}
        late = f.load("%state", self.setting.layout.at(Clock.TIME_LOW))
        return replace(found, low=LowParts(lower, f.splat(late, LANES).name, found.where))

    def prepared(self) -> Sequence[Total]:
        known = *self.lasting.fixed, *self.motion.carried
        totals = needed([self.integrands], self.slots, known)
        self.arrange(totals)
        return totals

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
        values = evaluation.where(self.integrands)
        rows = vectors.place(self.at(self.system.v, k + 1), self.degrees)

        def write(i: Integer, lanes: int) -> None:
            vectors.store_row(vectors.divided(vectors.load_row(values, i, lanes), divisor), rows, i)

        in_vectors(self.f, self.integrands.count, self.chosen(write))

    def chosen(self, write: Callable[[Integer, int], None]) -> Callable[[Integer, int], None]:
        """What writes those of some integrands that are needed."""
        return write

    def regular(self) -> Bit:
        return Bit(self.f, "true", 1)
