"""Steps of order 8 by an explicit Runge-Kutta method (``DOP853``).

E. Hairer, S. P. Norsett and G. Wanner, Solving Ordinary Differential Equations I, 2nd ed., 1993, sec. II.10.
Coordinates, velocities and integrals have the same weights and one error: the root mean square over all of
them, each relative to 1 + its size, as scipy's solver has it for equal tolerances.

The polynomial within a step takes three more stages. They are computed only if a sample lies in the step, or
if it ends early; otherwise the polynomial is the cubic one through both ends.
"""

from __future__ import annotations

import math
from collections.abc import Callable

from lagrange_cli.native.llvm.function import Function, exp2_roughly, log2_roughly
from lagrange_cli.native.llvm.vector import Bit, Integer, Real
from lagrange_cli.native.rates.dop853_stages import FIFTH, INSIDE, NODES, STAGE, STAGES, THIRD, Weights
from lagrange_cli.native.rates.places import HEAD, LENGTH, Places, wide_of
from lagrange_cli.native.rates.steps import RateSteps
from lagrange_cli.native.rates.trials import LARGEST, SMALLEST, Trial
from lagrange_cli.native.state import Clock
from lagrange_cli.native.stepping.given import Given
from lagrange_cli.native.stepping.steps import Now

DEGREE = 7
"""Of the polynomial."""
ALL = STAGES + 4
SAFETY = 0.9


def powers() -> list[list[int]]:
    """Row n: the coefficients, from s on, of what the n-th difference is multiplied by: s, s (1 - s), s^2
    (1 - s), s^2 (1 - s)^2 and so on."""
    rows, last = [], [1]
    for n in range(DEGREE):
        last = [0, *last] if n % 2 == 0 else [a - b for a, b in zip([*last, 0], [0, *last])]
        rows.append(last[1:] + [0] * (DEGREE + 1 - len(last)))
    return rows


class Dop853Steps(RateSteps):
    """Steps of ``DOP853``."""

    order = DEGREE + 1  # velocities are polynomials of this degree, too: q's have one more, which is 0
    most, shorter, patience = 10.0, 0.2, 1

    @staticmethod
    def room(given: Given) -> Places:
        return Places(given.state, DEGREE + 1, ALL * wide_of(given.state))

    def helpers(self) -> list[Function]:
        return [*([self._further()] if self.watching else []), self._inside(), self._ends()]

    def slope(self, f: Function, k: int, i: Integer) -> Real:
        """The rates of some rows at a stage."""
        return f.load_row("%work", i + (self._places.own + k * wide_of(self.state)), self.lengths.lanes)

    def total(self, f: Function, weights: Weights, i: Integer) -> Real:
        """A sum of rates, in two chains."""
        sums: list[Real | None] = [None, None]
        for n, (k, weight) in enumerate(weights.items()):
            slope, before = self.slope(f, k, i), sums[n % 2]
            sums[n % 2] = slope * weight if before is None else f.fused(slope, weight, before)
        first, second = sums
        assert first is not None
        return first if second is None else first + second

    def attempt(self, f: Function, t: Real, low: Real, h: Real, ratio: Real, doubtful: Bit) -> Trial:
        degrees, at, lanes = self.state.degrees, self._places, self.lengths.lanes
        f.copy_rows(("%state", degrees), ("%work", at.own), degrees, lanes)
        f.copy_rows(("%work", at.begin), ("%work", at.own + degrees), self._count, lanes)
        regular = f.variable(Bit(f, "true"))
        for k in range(1, STAGES + 1):
            regular.set(regular.get() & self.stage(f, k, t, low, h))
        self.spend(f, f.constant(float(STAGES)))
        factor, finite = self.judged(f, doubtful & regular.get(), lambda: self._factor(f, h))
        return Trial(factor, factor < SAFETY, regular.get() & finite)

    def stage(self, f: Function, k: int, t: Real, low: Real, h: Real) -> Bit:
        """The state at a stage and its rates, and whether these are regular."""
        layout, at, lanes = self.state, self._places, self.lengths.lanes
        wide = f.splat(h, lanes)
        with f.loop(0, layout.width, lanes, tested=False) as i:
            rest = f.load_row("%state", i + layout.width, lanes)
            self.put_state(f, i, wide * self.total(f, STAGE[k], i), rest)
        rates, good = self.node(f, t + (low + h * NODES[k]))
        place = at.own + k * wide_of(layout)
        # what is written behind the last coordinate is overwritten by the rates of the velocities
        f.copy_rows(("%work", at.state + layout.degrees), ("%work", place), layout.degrees, lanes)
        f.copy_rows((rates, 0), ("%work", place + layout.degrees), self._count, lanes)
        return good

    def _factor(self, f: Function, h: Real) -> tuple[Real, Bit, Bit]:
        layout, at, lanes = self.state, self._places, self.lengths.lanes
        zero = f.zero(lanes)
        fifth, third = f.variable(zero), f.variable(zero)
        with f.loop(0, layout.width, lanes, tested=False) as i:
            size = f.larger(*(f.magnitude(f.load_row(*one, lanes)) for one in (
                ("%state", i), ("%work", i + at.state)
            )))  # fmt: skip
            share = f.splat(f.constant(1.0 / self.given.tolerance), lanes) / (size + 1.0)
            inside = self._among(f, i, layout.rows)
            rounding = f.load_row("%state", i + self.rounding.place, lanes)
            for one, weights in ((fifth, FIFTH), (third, THIRD)):
                known = f.magnitude(self.total(f, weights, i))
                known = f.fused(rounding, -sum(map(abs, weights.values())), known)
                known = f.larger(zero, known)  # which is not a number where a rate is none
                error = f.select(inside, known * share, zero)
                one.set(f.fused(error, error, one.get()))
        five, three = (f.reduce("fadd", one.get(), f.constant(0.0)) for one in (fifth, third))
        both = f.fused(three, 0.01, five)
        some = both > SMALLEST
        # the error is h five / sqrt(n both)
        square = h * h * five * five / (f.select(some, both, f.constant(1.0)) * float(layout.rows))
        square = f.larger(f.smaller(square, f.constant(LARGEST)), f.constant(SMALLEST))
        factor = exp2_roughly(log2_roughly(square) * (-1.0 / 16)) * SAFETY
        factor = f.select(some, factor, f.constant(LARGEST))
        return factor, both < float("inf"), factor < SAFETY

    def finish(self, f: Function, h: Real) -> None:
        if self.watching:  # what guards look at is on the way
            self.called(f, "inside")
        else:
            f.call(None, "ends", f.pointer("%work"), h)

    def _ends(self) -> Function:
        """``@ends(work, h)``: the cubic polynomial of a step."""
        f = Function("define internal void @ends(ptr noalias %work, double %h) #0")
        self.write(f, Real(f, "%h"), dense=False)
        f.give()
        return f

    def write(self, f: Function, h: Real, *, dense: bool) -> None:
        """The coefficients of the polynomial, the cubic one or the ``dense`` one."""
        width, lanes, rows = self.state.width, self.lengths.lanes, powers()
        wide = f.splat(h, lanes)
        scales = [f.splat(f.constant(1.0) / h, lanes)]
        for _ in range(1, DEGREE):
            scales.append(scales[-1] * scales[0])
        with f.loop(0, width, lanes, tested=False) as i:
            change = wide * self.total(f, STAGE[STAGES], i)
            begin, end = (wide * self.slope(f, k, i) for k in (0, STAGES))
            differences = [change, begin - change, (change - end) + (change - begin)]
            if dense:
                differences += [wide * self.total(f, weights, i) for weights in INSIDE]
            for m in range(DEGREE):
                terms = [(rows[n][m], one) for n, one in enumerate(differences) if rows[n][m]]
                value = f.zero(lanes)
                for weight, one in reversed(terms):
                    value = f.fused(one, float(weight), value)
                f.store_row(value * scales[m], "%work", i + (m + 1) * width)
            f.store_row(f.zero(lanes), "%work", i + (DEGREE + 1) * width)

    # samples

    def vet(self, f: Function, now: Now, h: Real, left: Real, free: Bit) -> Real:
        self._left = left
        return super().vet(f, now, h, left, free)

    def sample(self, f: Function, now: Now, index: Integer, h: Real) -> Integer:
        if self.watching:
            return super().sample(f, now, index, h)
        chosen = f.load("%work", self._places.chosen + LENGTH)
        dt = (f.load("%times", index) - now.t) - now.low
        sampled, cut = dt <= h, (h < chosen) | (self._left < chosen)
        with f.when(sampled | cut):
            self.called(f, "inside")
        beyond = super().sample(f, now, index, h)
        with f.when(sampled & ~cut):  # samples change nothing, not even the rounding of a sum
            f.call(None, "ends", f.pointer("%work"), chosen)
        return beyond

    def further(self, f: Function) -> Callable[[Real], Bit] | None:
        if not self.watching:
            return None
        return lambda h: f.call(Bit, "further", *f.pointers("constants", "state", "work"), h)

    def _further(self) -> Function:
        """``@further(constants, state, work, h)``: the stages within a step, and whether their rates are
        finite. (A force that begins at 0 may be no number at one of them.)"""
        f = Function(f"define internal i1 @further{HEAD}, double %h) #0")
        self.stages_within(f, Real(f, "%h"))
        total = f.variable(f.zero(self.lengths.lanes))
        with self._each(f, self.state.rows) as i:
            sizes = [f.magnitude(self.slope(f, k, i)) for k in range(STAGES + 1, ALL)]
            inside = self._among(f, i, self.state.rows)
            total.set(total.get() + f.select(inside, sum(sizes[1:], sizes[0]), f.zero(self.lengths.lanes)))
        f.give(f.reduce("fadd", total.get(), f.constant(0.0)) < math.inf)
        return f

    def stages_within(self, f: Function, h: Real) -> None:
        """The states within a step, and their rates."""
        t, low = (f.load("%state", self.state.at(one)) for one in (Clock.TIME, Clock.TIME_LOW))
        for k in range(STAGES + 1, ALL):
            self.stage(f, k, t, low, h)
        self.spend(f, f.constant(float(ALL - STAGES - 1)))

    def _inside(self) -> Function:
        """``@inside(constants, state, work)``: the polynomial within the step that has been chosen."""
        f = Function(f"define internal void @inside{HEAD}) #0")
        h = f.load("%work", self._places.chosen + LENGTH)
        if not self.watching:
            self.stages_within(f, h)
        self.write(f, h, dense=True)
        f.give()
        return f
