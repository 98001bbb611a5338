"""What the velocities of Gauss-Radau steps are measured by, and where the steps keep their terms."""

from __future__ import annotations

import math

from lagrange_cli.native.llvm.function import Function
from lagrange_cli.native.llvm.vector import Bit, Integer, Real
from lagrange_cli.native.rates.gauss_radau_nodes import TERMS
from lagrange_cli.native.rates.places import HEADER, LATER, NEXT, Places, span_of
from lagrange_cli.native.rates.steps import RateSteps
from lagrange_cli.native.rates.trials import SMALLEST
from lagrange_cli.native.state import StateLayout
from lagrange_cli.native.stepping.given import Given
from lagrange_cli.native.stepping.lengths import Row
from lagrange_cli.native.stepping.related import FAINT, HARDLY_SEEN, write_fastest

ORDER = TERMS + 2
"""The degree of q's polynomials."""
UNMOVED = 2.0**-52
"""No velocity is measured by less than the one that changes its coordinate by this part within a step."""


class GaussRadauSizes(RateSteps):
    """The terms of these steps: b are those of the polynomials of rates, g their divided differences."""

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

    def _term(self, f: Function, first: int, k: int, i: Integer) -> Real:
        return f.load_row("%work", i + (first + k * self.span), self.lengths.lanes)

    def _put(self, f: Function, value: Real, first: int, k: int, i: Integer) -> None:
        f.store_row(value, "%work", i + (first + k * self.span))

    def begin(self, f: Function, first: Bit, h: Real) -> Real:
        """Where nothing moves and no force acts, find out how large accelerations are a little later."""
        if not self.lengths.floor:
            return h
        place = self._places.chosen + LATER
        f.store(f.constant(0.0), "%work", place)
        with f.when(self._largest(f, f.splat(f.constant(1.0), self.lengths.lanes)).equals(0.0)):
            asked = f.load("%state", self.state.carried_at + NEXT)
            later = f.select(first, self._first_length(f), asked)
            with f.loop(0, self.state.rows, self.lengths.lanes, tested=False) as i:
                zero = f.zero(self.lengths.lanes)
                self.put_state(f, i, zero, f.load_row("%state", i + self.state.width, self.lengths.lanes))
            rates, _ = self.node(f, self.now(f) + later)
            largest = f.variable(f.zero(self.lengths.lanes))
            with self._each(f, self.lengths.degrees) as i:
                rate = f.magnitude(f.load_row(rates, i, self.lengths.lanes))
                counts = self._among(f, i, self.lengths.degrees) & (rate < math.inf)
                largest.set(f.larger(f.select(counts, rate, f.zero(self.lengths.lanes)), largest.get()))
            f.store(f.reduce("fmax", largest.get()), "%work", place)
            self.spend(f, f.constant(1.0))
        return h

    def _write_scale(self, f: Function, i: Integer, length: Real, least: Real, change: Real) -> None:
        """Write down the ``length`` of the step over the size of velocities: theirs, the ``least`` one, their
        change by accelerations or by the ``change`` of these, or what moves a coordinate."""
        lanes, degrees, zero = self.lengths.lanes, self.lengths.degrees, f.zero(self.lengths.lanes)
        v = f.magnitude(f.load_row("%state", i + degrees, lanes))
        a = f.larger(f.magnitude(self._term(f, self._places.begin, 0, i)), f.magnitude(change))
        if self.lengths.floor:
            v = f.larger(v, f.load_row("%work", i + (self.lengths.floor + degrees), lanes))
        size = f.larger(f.larger(v, a * length), least) if self.mutual else f.larger(v, a * length)
        place = f.magnitude(f.load_row("%state", i, lanes))
        still = f.select(self._among(f, i, degrees), place / length * UNMOVED, zero)
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
