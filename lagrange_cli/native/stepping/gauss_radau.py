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

from lagrange_cli.native.llvm.function import Function, exp2_roughly, log2_roughly
from lagrange_cli.native.llvm.vector import Bit, Integer, Real
from lagrange_cli.native.state import StateLayout
from lagrange_cli.native.stepping.gauss_radau_nodes import NODES, TERMS, inverse, products
from lagrange_cli.native.stepping.given import Given
from lagrange_cli.native.stepping.lengths import Row
from lagrange_cli.native.stepping.polynomial import powers
from lagrange_cli.native.stepping.rate_places import HEADER, LATER, NEXT, Places, span_of
from lagrange_cli.native.stepping.rate_steps import LARGEST, SMALLEST, RateSteps, Trial
from lagrange_cli.native.stepping.related import FAINT, HARDLY_SEEN, write_fastest

ORDER = TERMS + 2
"""The degree of q's polynomials."""
LAST_TERM = 1e-9
"""What the last term of the rates may add to a velocity, relative to it, at full double precision: the error
at the end of a step is of twice the order (Rein and Spiegel, sec. 2.3)."""
CONVERGED = 1e-12
"""The iteration ends where it changes this term by so little: another one would change it by some hundredth
of that, and the state by less than its rounding. (Rates that are rounded change it by as much.)"""
ROUNDS, FEWEST = 12, 2
"""Iterations at most; and how many there are before it counts that they do not come closer any more."""
SENSITIVITY = {TERMS - 3: 51100.0, TERMS - 2: 38800.0, TERMS - 1: 11600.0}
"""What rounding errors of rates change a term by at most, as multiples of them."""
ROUNDED, SMOOTH, BETWEEN = 5.0, 200.0, 1 / 3
"""How many times as large as the last term the third last one is by rounding errors of rates, and in a step
of the right length at full double precision. Rates are rounded where it is less than the first times this
power of the ratio between these."""
NO_LONGER = 1.25
"""If a step whose rates are rounded should be longer by no more than this, these errors are measured."""
ACROSS = 2.0**-12
"""The part of the last term that steps across a place where rates jump change velocities by, at most."""
LEAST = 0.8
"""A step is taken again that should have been shorter by this factor."""
BESIDE = 2.0**-10
"""Beside constraints a velocity is measured by this part of the largest one at least: the accelerations of
what rests are rounding errors of its forces of constraint. So it is where joints have several coordinates."""
NEARER = 0.5
"""The part by which the square of a distance with a pole may become less in a step: its force is seen
at nodes before it matters between them."""
UNMOVED = 2.0**-52
"""No velocity is measured by less than the one that changes its coordinate by this part within a step."""
AHEAD = 8.0
"""A step that is longer than the one before by more than this factor begins without its polynomials."""


class GaussRadauSteps(RateSteps):
    """Steps of ``ias15``."""

    order, beside, compares, approaches = ORDER, True, True, True
    most, shorter = 2.0, 0.0625

    @staticmethod
    def room(given: Given) -> Places:
        return Places(given.state, ORDER, (2 * TERMS + 1) * span_of(given.state))

    @staticmethod
    def carried(layout: StateLayout) -> int:
        return HEADER + TERMS * span_of(layout)

    @property
    def span(self) -> int:
        """Doubles of a number for each rate."""
        return span_of(self.state)

    @property
    def terms(self) -> int:
        """Where b[0], b[1], .. are."""
        return self._places.own

    @property
    def differences(self) -> int:
        """And g[0], g[1], .."""
        return self.terms + TERMS * self.span

    @property
    def scale(self) -> int:
        """The step over the size of each velocity."""
        return self.differences + TERMS * self.span

    def begin(self, f: Function, first: Bit) -> None:
        """Where nothing moves and no force acts, find out how large accelerations are a little later."""
        if not self.lengths.floor:
            return
        place = self._places.chosen + LATER
        f.store(f.constant(0.0), "%work", place)
        with f.when(self._largest(f, f.splat(f.constant(1.0), self.lengths.lanes)).equals(0.0)):
            asked = f.load("%state", self.state.carried_at + NEXT)
            h = f.select(first, self._first_length(f), asked)
            with f.loop(0, self.state.rows, self.lengths.lanes, tested=False) as i:
                zero = f.zero(self.lengths.lanes)
                self.put_state(f, i, zero, f.load_row("%state", i + self.state.width, self.lengths.lanes))
            rates, _ = self.node(f, self.now(f) + h)
            largest = f.variable(f.zero(self.lengths.lanes))
            with self._each(f, self.lengths.degrees) as i:
                rate = f.magnitude(f.load_row(rates, i, self.lengths.lanes))
                counts = self._among(f, i, self.lengths.degrees) & (rate < math.inf)
                largest.set(f.larger(f.select(counts, rate, f.zero(self.lengths.lanes)), largest.get()))
            f.store(f.reduce("fmax", largest.get()), "%work", place)
            self.spend(f, f.constant(1.0))

    def attempt(self, f: Function, t: Real, low: Real, h: Real, ratio: Real, doubtful: Bit) -> Trial:
        self._predict(f, h, ratio)
        regular = self._iterate(f, t, low, h)
        factor, finite = self.judged(f, doubtful & regular, lambda: self._factor(f))
        if self.given.approach:
            factor = f.smaller(factor, self._approached(f, t + low, h))
        return Trial(factor, factor < LEAST, regular & finite)

    def _term(self, f: Function, first: int, k: int, i: Integer) -> Real:
        return f.load_row("%work", i + (first + k * self.span), self.lengths.lanes)

    def _put(self, f: Function, value: Real, first: int, k: int, i: Integer) -> None:
        f.store_row(value, "%work", i + (first + k * self.span))

    def _predict(self, f: Function, h: Real, ratio: Real) -> None:
        """b from the step before, g from b, and the scales."""
        layout, at, lanes = self.state, self._places, self.lengths.lanes
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
            v = f.magnitude(f.load_row("%state", i + layout.degrees, lanes))
            a = f.larger(f.magnitude(self._term(f, at.begin, 0, i)), f.magnitude(b[0]))
            if self.lengths.floor:
                v = f.larger(v, f.load_row("%work", i + (self.lengths.floor + layout.degrees), lanes))
            size = f.larger(f.larger(v, a * length), least) if self.mutual else f.larger(v, a * length)
            place = f.magnitude(f.load_row("%state", i, lanes))
            still = f.select(self._among(f, i, self.lengths.degrees), place / length * UNMOVED, zero)
            size = f.larger(size, still)
            there = self._among(f, i, self._count) & (size > SMALLEST)
            one = length / f.select(there, size, f.splat(f.constant(1.0), lanes))
            f.store_row(f.select(there, one, zero), "%work", i + self.scale)

    def _measure_related(self, f: Function, length: Real) -> None:
        """Write down what velocities are measured by at least, beside the largest one, and integrals, beside
        that of their family: as it is, or will be after the ``length`` of the step. In a chain at rest that
        is pushed, the motion far away grows as a power of t that polynomials do not have."""
        rates = self._places.begin - self.lengths.degrees
        later = f.splat(f.load("%work", self._places.chosen + LATER), self.lengths.lanes)

        def size(row: Row) -> Real:
            rate = f.larger(f.magnitude(row.at("%work", rates)), later)
            return f.larger(f.magnitude(row.at("%state")), rate * length)

        lengths, least = self.lengths, bool(self.given.floors)
        if lengths.floor:
            every = [(0, lengths.degrees)]
            write_fastest(f, lengths, every, lengths.floor, f.constant(FAINT), size, least=least)
            write_fastest(f, lengths, self.alike, lengths.floor, f.constant(HARDLY_SEEN), size)

    def _largest(self, f: Function, length: Real) -> Real:
        """The largest velocity, or acceleration times the ``length`` of the step."""
        lanes, degrees = self.lengths.lanes, self.lengths.degrees
        largest = f.variable(f.zero(lanes))
        with self._each(f, degrees) as i:
            v = f.magnitude(f.load_row("%state", i + degrees, lanes))
            size = f.larger(v, f.magnitude(self._term(f, self._places.begin, 0, i)) * length)
            largest.set(f.larger(f.select(self._among(f, i, degrees), size, f.zero(lanes)), largest.get()))
        return f.reduce("fmax", largest.get())

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

    def _factor(self, f: Function) -> tuple[Real, Bit, Bit]:
        """By what the step should be longer, by its last two terms; whether all rates are finite; and whether
        rounding may have shortened it."""
        lanes, last = self.lengths.lanes, TERMS - 1
        zero, one = f.zero(lanes), f.splat(f.constant(1.0), lanes)
        unseen = f.splat(f.constant(self._last_term / SENSITIVITY[last]), lanes)
        plain, known, level = ({k: f.variable(zero) for k in range(last - 2, last + 1)} for _ in range(3))
        total = f.variable(zero)
        with self._each(f, self._count) as i:
            # a velocity that begins at 0, without an acceleration, is measured by what it becomes
            grown = one / f.magnitude(self._term(f, self.terms, 0, i))
            scale = f.smaller(f.load_row("%work", i + self.scale, lanes), grown)
            errors = self.rounding.of(f, i)
            rough = f.smaller(scale, unseen / errors)
            for k in plain:
                b = f.magnitude(self._term(f, self.terms, k, i))
                rest = f.larger(f.fused(errors, -SENSITIVITY[k], b), zero)
                for largest, size in (
                    (plain[k], b * scale),
                    (known[k], rest * scale),
                    (level[k], rest * rough),
                ):
                    largest.set(f.larger(size, largest.get()))
            moving = self._among(f, i, self.lengths.degrees)
            total.set(total.get() + f.select(moving, b, zero))
        finite = f.reduce("fadd", total.get(), f.constant(0.0)) < math.inf
        flat = f.reduce("fmax", plain[last - 2].get()) < f.reduce("fmax", plain[last].get()) * self._flat
        goal, exponents = math.log2(self._last_term), list[Real]()
        for k in (last - 1, last):
            most = f.reduce("fmax", f.select(flat, level[k].get(), known[k].get()))
            size = log2_roughly(f.smaller(most, f.constant(LARGEST)))
            exponents.append((size * -1.0) * (1.0 / (k + 1)) + goal / TERMS)
        factor = exp2_roughly(f.smaller(*exponents))
        return factor, finite, (factor < LEAST) | ((factor < NO_LONGER) & flat)

    def _approached(self, f: Function, t: Real, h: Real) -> Real:
        """By what the step should be longer, by how near it may bring the motion to a pole."""
        at, lanes, degrees = self._places, self.lengths.lanes, self.lengths.degrees
        square = f.splat(h * h, lanes)
        with self._each(f, degrees) as i:
            bound = f.magnitude(self._term(f, at.begin, 0, i)) * 0.5
            for k in range(TERMS):
                b = f.magnitude(self._term(f, self.terms, k, i))
                bound = f.fused(b, 1.0 / ((k + 2) * (k + 3)), bound)
            f.store_row(bound * square, "%work", i + at.spare)
        bounds = f.place("%work", at.spare, "double")
        part = f.call(Real, "approach", f.pointer("%constants"), t, f.pointer("%state"), bounds, h)
        return f.constant(NEARER) / f.larger(part, f.constant(SMALLEST))

    @property
    def _last_term(self) -> float:
        looser: float = max(1.0, self.given.tolerance * 2.0**52) ** (TERMS / (2 * TERMS + 1))
        return LAST_TERM * looser

    @property
    def _flat(self) -> float:
        """Rates are rounded where the third last term is less than the last one times this."""
        smooth: float = SMOOTH * (LAST_TERM / self._last_term) ** (2 / TERMS)
        factor: float = (smooth / ROUNDED) ** BETWEEN
        return ROUNDED * factor

    @property
    def close(self) -> float:
        return ACROSS * self._last_term

    def finish(self, f: Function, h: Real) -> None:
        """The coefficients of the polynomials, in time, where ``advance`` reads them."""
        at, lanes, width = self._places, self.lengths.lanes, self.lengths.width
        degrees = self.lengths.degrees
        scales = powers(h, TERMS)

        def put(value: Real, m: int, i: Integer) -> None:
            f.store_row(value, "%work", i + m * width)

        def coefficient(k: int, i: Integer, divisor: int) -> Real:
            return self._term(f, self.terms, k, i) / f.splat(scales[k] * float(divisor), lanes)

        # what is written behind the last coordinate is overwritten by the velocities, and behind the last
        # row by the next coefficient
        for m in range(1, ORDER + 1):
            with self._each(f, degrees) as i:
                if m == 1:
                    put(f.load_row("%state", i + degrees, lanes), m, i)
                elif m == 2:
                    put(self._term(f, at.begin, 0, i) * 0.5, m, i)
                else:
                    put(coefficient(m - 3, i, m * (m - 1)), m, i)
            with self._each(f, self._count) as i:
                if m == 1:
                    put(self._term(f, at.begin, 0, i), m, i + degrees)
                elif m == ORDER:
                    put(f.zero(lanes), m, i + degrees)
                else:
                    put(coefficient(m - 2, i, m), m, i + degrees)

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
