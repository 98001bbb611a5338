"""Steps of order 5 by the implicit Radau IIA method of three stages (``Radau``).

E. Hairer and G. Wanner, Solving Ordinary Differential Equations II, 2nd ed., 1996, sec. IV.8: Newton's method
(``collocation``), a filtered error estimate, and K. Gustafsson's control of the length of steps. Errors are
measured as by ``DOP853``.

The velocities of a step are the polynomial of degree 3 through their increments, coordinates its integral.
"""

from __future__ import annotations

import math
from math import comb

from lagrange_cli.native.llvm.function import Function, exp2_roughly, log2_roughly
from lagrange_cli.native.llvm.vector import Bit, Integer, Real
from lagrange_cli.native.rates.collocation import DIVERGED, ROUNDS, UNSOUND, CollocationSteps
from lagrange_cli.native.rates.implicit import CHOSEN, CURRENT, ERROR, RENEW, THETA, TRIED
from lagrange_cli.native.rates.places import HEAD, HEADER, LEAST, Places
from lagrange_cli.native.rates.radau_constants import ERROR as ERROR_WEIGHTS
from lagrange_cli.native.rates.radau_constants import PLACE_ERROR, POLYNOMIAL, REAL, STAGES
from lagrange_cli.native.rates.trials import Trial
from lagrange_cli.native.state import Clock
from lagrange_cli.native.stepping.given import Given
from lagrange_cli.native.stepping.polynomial import powers, weighed

ORDER = STAGES + 2
"""The degree of polynomials, of which q's have one less: what guards look at has a cubic one."""
SAFETY, FAILED = 0.9, 0.5
"""By what factor lengths stay below those expected, and are less where Newton's method fails."""
KEPT = 1.2
"""A step that should be longer by less than this factor is as long as the one before: with its matrices."""
SLOW = 1e-3
"""If Newton's steps become shorter by no more than this factor, the next step takes new derivatives."""
SENSITIVITY = 1.0 + sum(map(abs, ERROR_WEIGHTS))
"""What rounding errors of rates change an error by at most, as multiples of what they do where it begins."""
SMALL_ERROR = 0.01
"""Smaller ones count as this one for the control of lengths."""


class RadauSteps(CollocationSteps):
    """Steps of ``Radau``."""

    order = ORDER
    most, shorter, patience = 10.0, 0.2, 1

    @classmethod
    def room(cls, given: Given) -> Places:
        return Places(given.state, ORDER, sum(cls.own_areas(given).values()))

    def helpers(self) -> list[Function]:
        return [*super().helpers(), self._filter(), self._estimate()]

    # a step

    def attempt(self, f: Function, t: Real, low: Real, h: Real, ratio: Real, doubtful: Bit) -> Trial:
        places = f.pointers("constants", "state", "work")
        iterations = f.variable(f.constant(DIVERGED))
        with f.forever() as again:
            self.factored(f, h)
            iterations.set(f.call(Real, "collocate", *places, h, ratio))
            failed, current = iterations.get().equals(DIVERGED), self.noted(f, CURRENT, "cache") > 0.0
            with f.when(~failed | (current & self.rounding.known(f))):
                again.leave()
            with f.when(current):
                self.rounding.measure(f)
            with f.otherwise():
                self.renew(f)
        converged, square = iterations.get() > DIVERGED, f.variable(f.constant(1.0))
        with f.when(converged):
            square.set(f.call(Real, "estimate", *places, h))
            large = (square.get() > 1.0) & (square.get() < math.inf)
            with f.when(doubtful & large & ~self.rounding.known(f)):
                self.rounding.measure(f)
                square.set(f.call(Real, "estimate", *places, h))
        sound = (iterations.get() > UNSOUND) & (square.get() < math.inf)
        self.note(f, f.constant(1.0), TRIED, "cache")
        factor = self._factor(f, h, square.get(), iterations.get())
        again_too = ~converged | (square.get() > 1.0)
        factor = f.select(converged, factor, f.constant(FAILED))
        if self.given.approach:
            nearest = f.variable(f.constant(math.inf))
            with f.when(converged & ~again_too):
                nearest.set(self.approached(f, t + low, h))
            factor, again_too = f.smaller(factor, nearest.get()), again_too | (nearest.get() < LEAST)
        return Trial(factor, again_too, sound)

    def _factor(self, f: Function, h: Real, square: Real, iterations: Real) -> Real:
        """By what the step should be longer, with that square of its error after so many iterations; and what
        the next step is told."""
        zero, one = f.constant(0.0), f.constant(1.0)
        carried = self.state.carried_at + HEADER
        before, last = (f.load("%state", carried + number) for number in (ERROR, CHOSEN))
        square = f.larger(square, f.constant(1e-20))
        begins = f.load("%state", self.state.at(Clock.STEP)).equals(0.0)
        measured = (before > 0.0) & ~begins  # what was before other equations held says nothing
        safe = f.constant(SAFETY * (2 * ROUNDS + 1)) / (iterations + 2.0 * ROUNDS)
        usual = exp2_roughly(log2_roughly(square) * (-1.0 / 8))
        trend = exp2_roughly(
            (log2_roughly(f.select(measured, before, square)) - log2_roughly(square)) * 0.125
        )
        expected = f.select(measured, h / f.select(measured, last, one) * trend, one)
        factor = f.larger(safe * usual * f.smaller(expected, one), f.constant(self.shorter))
        accepted = square <= 1.0
        keeps = accepted & (factor >= 1.0) & (factor < KEPT)
        slow = (iterations > 2.0) & (self.noted(f, THETA, "cache") > SLOW)
        self.note(f, f.larger(square, f.constant(SMALL_ERROR**2)), ERROR)
        self.note(f, h, CHOSEN)
        self.note(f, f.select(slow, one, zero), RENEW)
        return f.select(keeps, one, factor)

    def _filter(self) -> Function:
        """``@filter(.., rates, h, moved)``: the error of coordinates and velocities, from the ``rates`` where
        the step begins, or those where this error, ``moved`` once, has been added; the sum of its squares."""
        f = Function(f"define internal double @filter{HEAD}, ptr %rates, double %h, double %moved) #0")
        h, lanes, n, band = Real(f, "%h"), self.lengths.lanes, self.size, self.band
        inverse, scale = f.splat(f.constant(1.0) / h, lanes), f.splat(h * (1.0 / REAL), lanes)
        moved, x = f.splat(Real(f, "%moved"), lanes), self.areas["x"]
        with f.loop(0, n, lanes, tested=False) as i:
            z, inside, zero = self.rows(f, "z", i), self._among(f, i, n), f.zero(lanes)
            place = f.fused(moved, self.row(f, "rows1", i), weighed(f, z, PLACE_ERROR))
            speed = f.fused(weighed(f, z, ERROR_WEIGHTS), inverse, f.load_row("%rates", i, lanes))
            self.put_row(f, f.select(inside, place * scale, zero), "rows0", i)
            self.put_row(f, f.select(inside, speed, zero), "rows2", i)
        with self.in_band(f) as (p, row):
            f.store(f.load("%work", row + self.areas["rows0"]), "%work", p + (x + band.length))
        own = self.coupling.masses is not None
        if own:
            with self.in_band(f) as (p, row):
                f.store(f.load("%work", row + self.areas["rows2"]), "%work", p + x)
            self.push(f, 1)
        with self.in_band(f) as (p, row):
            total = f.variable(f.load("%work", p + x if own else row + self.areas["rows2"]))
            first, last = band.within(f, p)
            with f.loop(first, last, tested=False) as j:
                slope = f.load("%work", band.at(p, j) + self.areas["by_q"])
                total.set(f.fused(slope, f.load("%work", j + (x + band.length)), total.get()))
            f.store(total.get(), "%work", p + x)
        self.solve(f, "real", 1, 0)
        with self.in_band(f) as (p, row):
            f.store(f.load("%work", p + x), "%work", row + self.areas["rows1"])
        squares = f.variable(f.zero(lanes))
        with f.loop(0, n, lanes, tested=False) as i:
            speed, inside = self.row(f, "rows1", i), self._among(f, i, n)
            place = f.fused(speed, scale, self.row(f, "rows0", i))
            self.put_row(f, place, "rows0", i)
            rounding = self.rounding.of(f, i) * scale * SENSITIVITY
            for shift, value, known in ((0, place, rounding * scale), (n, speed, rounding)):
                left = f.larger(f.magnitude(value) - known, f.zero(lanes))
                left = f.select(value.equals(value), left, f.splat(f.constant(math.inf), lanes))
                error = f.select(inside, left * self.row(f, "shares", i + shift), f.zero(lanes))
                squares.set(f.fused(error, error, squares.get()))
        f.give(f.reduce("fadd", squares.get(), f.constant(0.0)))
        return f

    def _estimate(self) -> Function:
        """``@estimate(.., h)``: the mean square of the error in units of what is allowed.

        The error is filtered by the derivatives. Where that is not enough, as in the first step, it is
        computed again from the rates at the state that it leads to, and so is that of integrals always.
        """
        f = Function(f"define internal double @estimate{HEAD}, double %h) #0")
        h, layout, lanes, at = Real(f, "%h"), self.state, self.lengths.lanes, self._places
        n, count = self.size, self._count
        places = f.pointers("constants", "state", "work")
        part = f.splat(f.constant(1.0 / self.given.tolerance), lanes)
        with f.loop(0, layout.width, lanes, tested=False) as i:
            size = f.larger(*(f.magnitude(f.load_row(*one, lanes)) for one in (
                ("%state", i), ("%work", i + at.state)
            )))  # fmt: skip
            self.put_row(f, part / (size + 1.0), "shares", i)

        def filtered(rates: int, moved: float) -> Real:
            begin = f.place("%work", rates, "double")
            return f.call(Real, "filter", *places, begin, h, f.constant(moved))

        total = f.variable(filtered(at.begin, 0.0))
        large = (total.get() > float(layout.rows)) & (self.noted(f, TRIED, "cache") > 0.0)
        with f.when(large if count == n else Bit(f, "true")):
            with f.loop(0, n, lanes, tested=False) as i:
                low = f.load_row("%state", i + layout.width, lanes)
                self.put_state(f, i, self.row(f, "rows0", i), low)
            with f.loop(0, n, lanes, tested=False) as i:
                low = f.load_row("%state", i + (layout.width + n), lanes)
                self.put_state(f, i + n, self.row(f, "rows1", i), low)
            self.put_integrals(f)
            rates, _ = self.node(f, self.now(f))
            f.copy_rows((rates, 0), ("%work", self.areas["f0"]), count, lanes)
            self.spend(f, f.constant(1.0))
            with f.when(large):
                again = filtered(self.areas["f0"], 1.0)  # a force may have no value there, as depth^1.5
                total.set(f.select(again < math.inf, again, total.get()))
            if count > n:
                total.set(total.get() + self._of_integrals(f, h))
        f.give(total.get() * (1.0 / layout.rows))
        return f

    def _of_integrals(self, f: Function, h: Real) -> Real:
        """The squares of the errors of integrals."""
        n, count, lanes = self.size, self._count, self.lengths.lanes
        inverse, scale = f.splat(f.constant(1.0) / h, lanes), f.splat(h * (1.0 / REAL), lanes)
        squares = f.variable(f.zero(lanes))
        with f.loop(n, count, lanes, tested=False) as i:
            rate = f.fused(weighed(f, self.rows(f, "z", i), ERROR_WEIGHTS), inverse, self.row(f, "f0", i))
            error = rate * scale * self.row(f, "shares", i + n)
            error = f.select(self._among(f, i, count), error, f.zero(lanes))
            squares.set(f.fused(error, error, squares.get()))
        return f.reduce("fadd", squares.get(), f.constant(0.0))

    # polynomials

    def finish(self, f: Function, h: Real) -> None:
        lanes = self.lengths.lanes
        scales = powers(f.splat(f.constant(1.0) / h, lanes), STAGES)

        def rate(m: int, i: Integer) -> Real:
            if m > STAGES:
                return f.zero(lanes)
            return weighed(f, self.rows(f, "z", i), POLYNOMIAL[m - 1]) * scales[m - 1]

        def place(m: int, i: Integer) -> Real:
            return rate(m - 1, i) if m > STAGES + 1 else rate(m - 1, i) * (1.0 / m)

        self.write_terms(f, place, rate)

    def hand_over(self, f: Function, h: Real, length: Real) -> None:
        super().hand_over(f, h, length)
        lanes, width, degrees = self.lengths.lanes, self.lengths.width, self.lengths.degrees
        scales = powers(f.splat(length, lanes), STAGES)
        with f.loop(0, degrees, lanes, tested=False) as i:
            terms = [
                f.load_row("%work", i + ((k + 1) * width + degrees), lanes) * scales[k] for k in range(STAGES)
            ]
            for k, place in enumerate(self.terms(self.state)):
                weights = tuple(float(comb(j + 1, k + 1)) for j in range(k, STAGES))
                f.store_row(weighed(f, terms[k:], weights), "%state", i + place)
