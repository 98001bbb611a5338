"""``@jet`` of systems whose M is diagonal and constant: accelerations are forces divided by masses."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from lagrange_cli.families.arrays import Array, Total
from lagrange_cli.native.families.evaluation import Evaluation
from lagrange_cli.native.families.jets import SeriesJet
from lagrange_cli.native.families.loops import needed
from lagrange_cli.native.families.spans import Span, in_vectors
from lagrange_cli.native.families.vectors import Numbers
from lagrange_cli.native.interface import LANES
from lagrange_cli.native.llvm.function import Function
from lagrange_cli.native.llvm.vector import Bit, Index, Integer, Pointer


class DiagonalJet(SeriesJet):
    """The jet of such a system: ``whole`` are the forces that accelerate it."""

    whole: Array

    @property
    def forces(self) -> Total:
        """Those whose series are found."""
        return self.lasting.arranged(self.system.forces, kept=False)

    @property
    def masses(self) -> Sequence[Array]:
        """What accelerations follow from by these: M and 1/M."""
        return self.lasting.masses, self.lasting.inverses

    def prepared(self) -> Sequence[Total]:
        self.whole = self.forces
        totals = needed([self.forces], self.slots, self.lasting.fixed)
        self.arrange(totals)
        return totals

    def accelerate(
        self, evaluation: Evaluation, k: Index, phase: int | None, span: Span | None = None
    ) -> None:
        f, vectors, divisor = self.f, self.vectors, self.vectors.divisor(k, 1)
        self.emitter.repeated = self.degrees // LANES + 1
        rate = self.rates_of(evaluation)
        velocities = self.at(self.system.v, k + 1)

        def write(i: Integer, lanes: int) -> None:
            vectors.store_row(vectors.divided(rate(i, lanes), divisor), velocities, i)

        in_vectors(f, span or self.degrees, write)
        self.bind(velocities)
        if not self.local:
            rates = self.at(self.system.v, k + 1)
            self.follow(k + 1, rates, self.at(self.system.q, k + 2), self.degrees)

    def rates_of(self, evaluation: Evaluation) -> Callable[[Integer, int], Numbers]:
        """What gives some of the accelerations, side by side."""
        vectors, given = self.vectors, [evaluation.where(one) for one in (self.whole, *self.masses)]
        return lambda i, lanes: vectors.quotient(*(vectors.load_row(one, i, lanes) for one in given))

    def bind(self, velocities: Pointer) -> None:
        """Change velocities that follow from others."""

    def regular(self) -> Bit:
        return regular_masses(self)


class RatesInRows(DiagonalJet):
    """The same without series, in rows as of the state."""

    local = False

    def follow(self, k: Index, source: Pointer, target: Pointer, count: int) -> None:
        if k == 0:
            super().follow(k, source, target, count)


def regular_masses(jet: SeriesJet) -> Bit:
    """Whether the masses of a system are positive; where it has a Lagrangian, whether they are not 0."""
    positive = jet.system.spec.lagrangian is None
    return regular(jet.f, jet.at(jet.lasting.masses, 0), jet.degrees, positive=positive)


def regular(f: Function, masses: Pointer, count: int, *, positive: bool) -> Bit:
    """Whether numbers are positive, or at least not 0."""
    wrong = {lanes: f.variable(f.never(lanes)) for lanes in (1, LANES)}

    def look(i: Integer, lanes: int) -> None:
        mass, found = f.load_row(masses, i, lanes), wrong[lanes]
        found.set(found.get() | ~((mass if positive else f.magnitude(mass)) > 0.0))

    in_vectors(f, count, look)
    return ~(f.any(wrong[LANES].get()) | wrong[1].get())
