"""Integrals of a step of the motion: whether its series are good for them, and where they are not, by parts
(``division``)."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

from lagrange_cli.native.guards import HALTED
from lagrange_cli.native.llvm.function import Function
from lagrange_cli.native.llvm.vector import Bit, Integer, Pointer, Real
from lagrange_cli.native.state import whole_vectors
from lagrange_cli.native.stepping.motion import Steps
from lagrange_cli.native.stepping.parts import StepArrays, StepPart, StepParts, Units
from lagrange_cli.native.stepping.quadratures import Quadratures
from lagrange_cli.native.stepping.rounding_errors import round_integrands
from lagrange_cli.native.stepping.steps import Now
from lagrange_cli.native.stepping.sums import HighLow, difference


class DividedSteps(Steps):
    """Steps that can be divided for the sake of integrals."""

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

        def errors(place: HighLow, rates: Pointer, to: Pointer) -> None:
            round_integrands(f, self.sums.sum(f, (t, low), place), arrays, rates, to)

        guards = self.guards if self.guards and self.guards.holding else None

        @contextmanager
        def let_go(side: float) -> Iterator[None]:
            assert guards
            guards.let_go(f, trial, f.constant(side))
            yield
            guards.hold(f, trial, guards.modes(f, f.pointer("%state")))

        at = StepArrays(trial, f.pointer("%work"), arrays, series)
        free = let_go if guards else None
        round_at = errors if self.given.cancelling else None
        parts = StepParts(f, quadratures, self.sums, at, self.state.width, units, expand, free, round_at)
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

    # what ``advance`` asks for

    def rough(self, f: Function, now: Now, h: Real, sound: Bit) -> Bit:
        """Whether the integrals' series do not hold all through the step of ``h`` just taken; where the
        motion's are not ``sound`` they were cut with these, but may have overflowed before."""
        places = f.pointer("%trial"), f.pointer("%work")
        rough = f.call(Bit, "rough", *places, *self.scaled(f, now.unit, h), *([h] if self.parts > 1 else []))
        if self.integrands is None:
            return rough | ~sound
        return rough | ~(sound & self.has_proven(f, now.t + now.low, *places, h, now.unit))

    def has_proven(self, f: Function, t: Real, state: Pointer, series: Pointer, h: Real, unit: Real) -> Bit:
        """Whether the integrands have nothing to hide within ``h``."""
        beyond = f.constant(float(self.lengths.order - 1))
        given = f.pointer("%constants"), t, state, series, h, unit, beyond
        return f.call(Real, "integrands_proven", *given) >= 1.0

    def surprising(self, f: Function, now: Now, h: Real) -> Bit:
        """Whether the integrands are not those expected after a step of ``h``."""
        assert self.quadratures
        rates, allowed, low = self.expected(f)
        nothing, zero = self.quadratures.nothing(f, h), f.constant(0.0)
        self.quadratures.allow(f, allowed)
        given = rates, allowed, nothing, f.constant(1.0), Bit(f, "false"), zero
        more = (low, 1.0 / now.unit) if self.parts > 1 else ()
        return ~f.call(Bit, "integrals_accepted", f.pointer("%work"), *given, *more, f.pointer("%state"))

    def resume(self, f: Function, before: Now) -> None:
        """Compute the series of the step before once more."""
        places = f.pointer("%trial"), f.pointer("%work")
        self.compute(f, (before.t, before.low), before.unit, *places)

    def part(self, f: Function, before: Now, h: Real, samples: tuple[Integer, Integer]) -> None:
        """Compute the integrals of the step before by parts (``quadratures``), also at its samples: from the
        one to before the other; or some of it, if it is ``halted``."""
        places = f.pointers("constants", "trial", "work", "state", "times", "out", "info")
        step, stride = difference(self.time(f), (before.t, before.low)), Integer(f, "%stride")
        more = *samples, stride, stride * self.lengths.rows
        f.call(None, "divide", *places, before.t, before.low, *step, before.unit, *more)

    def halted(self, f: Function) -> Bit:
        """Whether ``part`` is to leave its step."""
        return ~f.observe("%info", HALTED, "monotonic").equals(0)
