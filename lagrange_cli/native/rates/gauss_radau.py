"""Steps of order 15 by Gauss-Radau quadrature (``ias15``).

E. Everhart, in: Dynamics of Comets: Their Origin and Evolution, 1985; H. Rein and D. S. Spiegel, MNRAS 446,
2015. Rates within a step are a polynomial of degree 7, which passes through those at the step's beginning and
at seven nodes. It is found by iteration: from the polynomial follow the states at the nodes, from these the
rates, from these the polynomial. The polynomial of the step before is where it begins.

The polynomials in time are of degree 9 for q and 8 for v and integrals. Behind the lengths, the polynomials
of the rates are carried, in units of the step.
"""

from __future__ import annotations

import math
from functools import partial
from math import comb

from lagrange_cli.native.llvm.function import Function
from lagrange_cli.native.llvm.vector import Bit, Integer, Real
from lagrange_cli.native.rates.gauss_radau_lengths import GaussRadauLengths
from lagrange_cli.native.rates.gauss_radau_nodes import STRIDE, TERMS, inverse, products, tables
from lagrange_cli.native.rates.gauss_radau_sizes import ORDER
from lagrange_cli.native.rates.places import HEAD, HEADER, LEAST
from lagrange_cli.native.rates.trials import Trial
from lagrange_cli.native.stepping.polynomial import powers

CONVERGED = 1e-12
"""The iteration ends where it changes this term by so little: another one would change it by some hundredth
of that, and the state by less than its rounding. (Rates that are rounded change it by as much.)"""
ROUNDS, FEWEST = 12, 2
"""Iterations at most; and how many there are before it counts that they do not come closer any more."""
BESIDE = 2.0**-10
"""Beside constraints a velocity is measured by this part of the largest one at least: the accelerations of
what rests are rounding errors of its forces of constraint. So it is where joints have several coordinates."""
AHEAD = 8.0
"""A step that is longer than the one before by more than this factor begins without its polynomials."""
NODE = "double %t, double %low, double %h, i64 %n"
"""A node of a step: where this begins, how long it is, and the number of the node."""


class GaussRadauSteps(GaussRadauLengths):
    """Steps of ``ias15``."""

    def functions(self) -> list[str]:
        return [*tables(), *super().functions()]

    def attempt(self, f: Function, t: Real, low: Real, h: Real, ratio: Real, doubtful: Bit) -> Trial:
        self._predict(f, h, ratio)
        regular = self._iterate(f, t, low, h)
        factor, finite = self.judged(f, doubtful & regular, lambda: self._factor(f))
        if self.given.approach:
            factor = f.smaller(factor, self._approached(f, t + low, h))
        return Trial(factor, factor < LEAST, regular & finite)

    def _predict(self, f: Function, h: Real, ratio: Real) -> None:
        """b from the step before, g from b, and the scales. Where b is not finite, as after a trial that came
        to where a force has no value, it is 0."""
        layout, lanes = self.state, self.lengths.lanes
        ratio = f.select(ratio < AHEAD, ratio, f.constant(0.0))
        wide, rows = [f.splat(one, lanes) for one in powers(ratio, TERMS)], inverse(products())
        length, zero = f.splat(h, lanes), f.zero(lanes)
        least = f.splat(self._largest(f, length) * BESIDE, lanes) if self.mutual else zero
        self._measure_related(f, length)
        with self._each(f, self._count) as i:
            before = layout.carried_at + HEADER
            b = [f.load_row("%state", i + (before + k * self.span), lanes) * wide[k] for k in range(TERMS)]
            b = [f.select(f.magnitude(one) < math.inf, one, zero) for one in b]
            for k, one in enumerate(b):
                self._put(f, one, self.terms, k, i)
            for n in range(TERMS):
                total = b[n]
                for k in range(n + 1, TERMS):
                    total = f.fused(b[k], float(rows[n][k]), total)
                self._put(f, total, self.differences, n, i)
            self._write_scale(f, i, length, least, b[0])

    def _iterate(self, f: Function, t: Real, low: Real, h: Real) -> Bit:
        """Compute rates at the nodes until they do not change any more; whether all of them were regular."""
        before, rounds = f.variable(f.constant(math.inf)), f.variable(f.count(0))
        regular, error = f.variable(Bit(f, "true")), f.variable(f.constant(0.0))
        with f.forever() as iterations:
            with f.loop(0, TERMS, tested=False) as n:
                places = f.pointers("constants", "state", "work")
                changed, good = f.parts((Real, Bit), "corrected", *places, t, low, h, n)
                error.set(changed)
                regular.set(regular.get() & good)
            rounds.set(rounds.get() + 1)
            stalls = (rounds.get() > FEWEST) & (error.get() >= before.get())
            near = error.get() <= max(CONVERGED, 0.001 * self.given.tolerance)
            done = near | stalls | (rounds.get() >= ROUNDS) | ~regular.get()
            with f.when(done):
                iterations.leave()
            before.set(error.get())
        self.spend(f, rounds.get().to_real() * float(TERMS))
        return regular.get()

    def helpers(self) -> list[Function]:
        return [self._corrected()]

    def _corrected(self) -> Function:
        """``@corrected(constants, state, work, t, low, h, n)``: the state at a node, its rates, and the
        polynomial through them; by how much its last term has changed, relative to velocities, if the node is
        the last one, and whether the rates are regular."""
        f = Function(f"define internal {{ double, i1 }} @corrected{HEAD}, {NODE}) #0")
        t, low, h = f.reals("t", "low", "h")
        n = Integer(f, "%n")
        layout, at, lanes = self.state, self._places, self.lengths.lanes
        degrees, width, row = layout.degrees, layout.width, n * STRIDE
        hs = h * f.load("@nodes", n)
        wide = f.splat(hs, lanes)

        def total(i: Integer, first: float, factors: str) -> Real:
            """a(0) and b, each times its factor."""
            sums = [self._term(f, at.begin, 0, i) * first, None]
            for k in range(TERMS):
                factor = f.splat(f.load(factors, row + k), lanes)
                b = self._term(f, self.terms, k, i)
                other = sums[(k + 1) % 2]
                sums[(k + 1) % 2] = b * factor if other is None else f.fused(b, factor, other)
            assert sums[0] is not None and sums[1] is not None
            return sums[0] + sums[1]

        with self._each(f, degrees) as i:
            twice = total(i, 0.5, "@twice_integrated")
            v, v_low = (f.load_row("%state", i + (degrees + part * width), lanes) for part in (0, 1))
            change = f.fused(wide, f.fused(wide, twice, v_low), wide * v)
            self.put_state(f, i, change, f.load_row("%state", i + width, lanes))
        with self._each(f, self._count) as i:
            change = wide * total(i, 1.0, "@integrated")
            rest = f.load_row("%state", i + (degrees + width), lanes)
            self.put_state(f, i + degrees, change, rest)
        rates, good = self.node(f, t + (low + hs))
        largest = f.variable(f.zero(lanes))
        with self._each(f, self._count) as i:
            first = f.splat(f.load("@apart", row), lanes)
            x = f.variable((f.load_row(rates, i, lanes) - self._term(f, at.begin, 0, i)) * first)
            with f.loop(0, n) as j:
                apart = f.splat(f.load("@apart", row + j + 1), lanes)
                x.set((x.get() - f.load_row("%work", i + self.differences + j * self.span, lanes)) * apart)
            place = i + self.differences + n * self.span
            change = x.get() - f.load_row("%work", place, lanes)
            f.store_row(x.get(), "%work", place)
            with f.loop(0, n + 1, tested=False) as k:
                place = i + self.terms + k * self.span
                factor = f.splat(f.load("@products", row + k), lanes)
                f.store_row(f.fused(change, factor, f.load_row("%work", place, lanes)), "%work", place)
            error = f.magnitude(change) * f.load_row("%work", i + self.scale, lanes)
            largest.set(f.larger(error, largest.get()))
        f.give(f.reduce("fmax", largest.get()), good)
        return f

    def finish(self, f: Function, h: Real) -> None:
        """The coefficients of the polynomials, in time, where ``advance`` reads them."""
        lanes, degrees = self.lengths.lanes, self.lengths.degrees
        scale = f.variable(h)

        def first(part: float, i: Integer) -> Real:
            return self._term(f, self._places.begin, 0, i) * part

        self.write_velocities(f)
        self.write_term(f, 1, degrees, partial(first, 1.0))
        self.write_term(f, 2, 0, partial(first, 0.5))
        with f.loop(0, TERMS, tested=False) as k:

            def coefficient(divisor: Real, i: Integer) -> Real:
                return f.load_row("%work", i + self.terms + k * self.span, lanes) / f.splat(divisor, lanes)

            m = k + 2
            self.write_term(f, m, degrees, partial(coefficient, scale.get() * m.to_real()))
            both = (m * (m + 1)).to_real()
            self.write_term(f, m + 1, 0, partial(coefficient, scale.get() * both))
            scale.set(scale.get() * h)
        self.write_term(f, ORDER, degrees, lambda i: f.zero(lanes))

    def hand_over(self, f: Function, h: Real, length: Real) -> None:
        lanes, ratio = self.lengths.lanes, length / h
        scales = [f.splat(f.constant(1.0), lanes), *powers(f.splat(ratio, lanes), TERMS)]
        with self._each(f, self._count) as i:
            b = [self._term(f, self.terms, k, i) * scales[k + 1] for k in range(TERMS)]
            for k in range(TERMS):
                total = b[k]
                for j in range(k + 1, TERMS):
                    total = f.fused(b[j], float(comb(j + 1, k + 1)), total)
                place = i + (self.state.carried_at + HEADER + k * self.span)
                f.store_row(total, "%state", place)
