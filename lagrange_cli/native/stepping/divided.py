"""``@divide``: the integrals of a step of the motion that is divided into parts (``division``)."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

from lagrange_cli.native.llvm.function import Function
from lagrange_cli.native.llvm.vector import Bit, Integer, Real
from lagrange_cli.native.state import whole_vectors
from lagrange_cli.native.stepping.motion import Steps
from lagrange_cli.native.stepping.parts import StepArrays, StepPart, StepParts, Units
from lagrange_cli.native.stepping.quadratures import Quadratures
from lagrange_cli.native.stepping.sums import HighLow, difference


class DividedSteps(Steps):
    """Steps that can be divided."""

    def divide(self, quadratures: Quadratures) -> Function:
        """``@divide``: the integrals of the step (%h, %hl) from ``%trial`` on, with the series in ``%work``,
        by parts; also those of the samples from ``first`` to before ``last``. Asked to, it leaves at once."""
        heads = "ptr %constants, ptr %trial, ptr %work, ptr %state, ptr %times, ptr %out, ptr %info"
        more = "double %t, double %low, double %h, double %hl, double %unit"
        counts = "i64 %first, i64 %last, i64 %stride, i64 %beyond"
        f = Function(f"define internal void @divide({heads}, {more}, {counts}) #0")
        t, low, h, hl, unit = f.reals("t", "low", "h", "hl", "unit")
        index, trial = f.variable(Integer(f, "%first")), f.pointer("%trial")
        first = whole_vectors(self.state.memory + 3 * self.state.width)
        series, arrays = (f.place(trial, one) for one in (first, first + self.given.work))
        units = Units(unit, f.variable(unit))

        def expand(place: HighLow) -> None:
            self.compute(f, self.sums.sum(f, (t, low), place), units.part.get(), arrays, series)

        def prove(place: HighLow, length: Real) -> Bit:
            return self.has_proven(f, (t + low) + place[0], arrays, series, length, units.part.get())

        guards = self.guards if self.guards and self.guards.holding else None

        @contextmanager
        def let_go(side: float) -> Iterator[None]:
            assert guards
            guards.let_go(f, trial, f.constant(side))
            yield
            guards.hold(f, trial, guards.modes(f, f.pointer("%state")))

        at = StepArrays(trial, f.pointer("%work"), arrays, series)
        free = let_go if guards else None
        parts = StepParts(f, quadratures, self.sums, at, self.state.width, units, expand, free)
        made = self.division(
            parts, prove if self.integrands else None, lambda: self.halted(f), tires=self.constrained
        )

        def samples(part: StepPart) -> Integer:
            zero = f.constant(0.0)
            return parts.samples(
                index, Integer(f, "%last"), part, lambda instant: difference((instant, zero), (t, low))
            )

        whole, explained = made.divide(t, (h, hl), samples, index)
        with f.when(~whole):
            parts.lose_samples(index, Integer(f, "%last"))
        parts.give(f.pointer("%state"), self.state.third, whole, explained)
        f.give()
        return f
