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
from math import comb

from lagrange_cli.native.llvm.function import Function
from lagrange_cli.native.llvm.vector import Bit, Integer, Real
from lagrange_cli.native.rates.gauss_radau_lengths import LEAST, GaussRadauLengths
from lagrange_cli.native.rates.gauss_radau_nodes import NODES, TERMS, inverse, products
from lagrange_cli.native.rates.gauss_radau_sizes import ORDER
from lagrange_cli.native.rates.places import HEADER, TRIED
from lagrange_cli.native.rates.steps import Trial
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


class GaussRadauSteps(GaussRadauLengths):
    """Steps of ``ias15``."""

    def attempt(self, f: Function, t: Real, low: Real, h: Real, ratio: Real, doubtful: Bit) -> Trial:
        if self.given.static:
            f.store(h, "%work", self._places.chosen + TRIED)
        self._predict(f, h, ratio)
        regular = self._iterate(f, t, low, h)
        factor, finite = self.judged(f, doubtful & regular, lambda: self._factor(f))
        if self.given.approach:
            factor = f.smaller(factor, self._approached(f, t + low, h))
        return Trial(factor, factor < LEAST, regular & finite)

    def _predict(self, f: Function, h: Real, ratio: Real) -> None:
        """b from the step before, g from b, and the scales."""
        layout, lanes = self.state, self.lengths.lanes
        ratio = f.select(ratio < AHEAD, ratio, f.constant(0.0))
        wide, rows = [f.splat(one, lanes) for one in powers(ratio, TERMS)], inverse(products())
        length, zero = f.splat(h, lanes), f.zero(lanes)
        least = f.splat(self._largest(f, length) * BESIDE, lanes) if self.mutual else zero
        self._measure_related(f, length)
        with self._each(f, self._count) as i:
            before = layout.carried_at + HEADER
            b = [f.load_row("%state", i + (before + k * self.span), lanes) * wide[k] for k in range(TERMS)]
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
        regular = f.variable(Bit(f, "true"))
        with f.forever() as iterations:
            for n in range(TERMS):
                error, good = self._node(f, n, t, low, h)
                regular.set(regular.get() & good)
            rounds.set(rounds.get() + 1)
            stalls = (rounds.get() > FEWEST) & (error >= before.get())
            near = error <= max(CONVERGED, 0.001 * self.given.tolerance)
            done = near | stalls | (rounds.get() >= ROUNDS) | ~regular.get()
            with f.when(done):
                iterations.leave()
            before.set(error)
        self.spend(f, rounds.get().to_real() * float(TERMS))
        return regular.get()

    def _node(self, f: Function, n: int, t: Real, low: Real, h: Real) -> tuple[Real, Bit]:
        """The state at a node, its rates, and the polynomial through them; by how much its last term has
        changed, and whether the rates are regular."""
        layout, at, lanes = self.state, self._places, self.lengths.lanes
        degrees, width, s = layout.degrees, layout.width, NODES[n]
        hs = h * s
        wide = f.splat(hs, lanes)

        def total(i: Integer, divisors: list[int]) -> Real:
            """a(0) and b, each times a power of s, over a divisor."""
            begin = self._term(f, at.begin, 0, i)
            sums = [begin * (1.0 / divisors[0]), None]
            for k in range(TERMS):
                factor = s ** (k + 1) / divisors[k + 1]
                b = self._term(f, self.terms, k, i)
                other = sums[(k + 1) % 2]
                sums[(k + 1) % 2] = b * factor if other is None else f.fused(b, factor, other)
            assert sums[0] is not None and sums[1] is not None
            return sums[0] + sums[1]

        with self._each(f, degrees) as i:
            twice = total(i, [(k + 1) * (k + 2) for k in range(TERMS + 1)])
            v, v_low = (f.load_row("%state", i + (degrees + part * width), lanes) for part in (0, 1))
            change = f.fused(wide, f.fused(wide, twice, v_low), wide * v)
            self.put_state(f, i, change, f.load_row("%state", i + width, lanes))
        with self._each(f, self._count) as i:
            change = wide * total(i, [k + 1 for k in range(TERMS + 1)])
            rest = f.load_row("%state", i + (degrees + width), lanes)
            self.put_state(f, i + degrees, change, rest)
        rates, good = self.node(f, t + (low + hs))
        parts, largest = products()[n], f.variable(f.zero(lanes))
        with self._each(f, self._count) as i:
            x = (f.load_row(rates, i, lanes) - self._term(f, at.begin, 0, i)) * (1.0 / s)
            for j in range(n):
                x = (x - self._term(f, self.differences, j, i)) * (1.0 / (s - NODES[j]))
            change = x - self._term(f, self.differences, n, i)
            self._put(f, x, self.differences, n, i)
            for k in range(n + 1):
                b = self._term(f, self.terms, k, i)
                self._put(f, f.fused(change, float(parts[k]), b), self.terms, k, i)
            if n == TERMS - 1:
                error = f.magnitude(change) * f.load_row("%work", i + self.scale, lanes)
                largest.set(f.larger(error, largest.get()))
        return f.reduce("fmax", largest.get()), good

    def finish(self, f: Function, h: Real) -> None:
        """The coefficients of the polynomials, in time, where ``advance`` reads them."""
        at, lanes, scales = self._places, self.lengths.lanes, powers(h, TERMS)

        def coefficient(k: int, i: Integer, divisor: int) -> Real:
            return self._term(f, self.terms, k, i) / f.splat(scales[k] * float(divisor), lanes)

        def place(m: int, i: Integer) -> Real:
            return coefficient(m - 3, i, m * (m - 1)) if m > 2 else self._term(f, at.begin, 0, i) * 0.5

        def rate(m: int, i: Integer) -> Real:
            if m == ORDER:
                return f.zero(lanes)
            return coefficient(m - 2, i, m) if m > 1 else self._term(f, at.begin, 0, i)

        self.write_terms(f, place, rate)

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
