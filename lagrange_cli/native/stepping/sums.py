"""Sums of series within a step, in each kind of numbers: what states and integrals are at its end and within.

A time or a number is a double and its low part (``HighLow``). Times are since the beginning of the series,
whose coefficients may have a unit of time of their own.
"""

from __future__ import annotations

from typing import Protocol, TypeAlias

from lagrange_cli.native.llvm.function import Function
from lagrange_cli.native.llvm.vector import Integer, Pointer, Real
from lagrange_cli.native.numbers.error_free import fast_sum, two_sum
from lagrange_cli.native.stepping.lengths import Row
from lagrange_cli.native.stepping.polynomial import careful_sum, polynomial, rate

HighLow: TypeAlias = "tuple[Real, Real]"

CHAINS, RATE_CHAINS = 4, 2
"""Partial sums of a polynomial that are added in parallel."""


class Sums(Protocol):
    """The sums of one kind of numbers; low parts of coefficients are ``beyond`` of these behind, if they have
    any."""

    beyond: int

    def state(self, f: Function, row: Row, base: Pointer, low: int, h: Real) -> HighLow:
        """What a row of a state is, from which it is moved on by ``h``; low parts are ``low`` rows behind."""

    def change(self, f: Function, row: Row, work: Pointer, h: HighLow, unit: Real) -> HighLow:
        """What a series adds within ``h``."""

    def slope(self, f: Function, row: Row, work: Pointer, h: HighLow, unit: Real) -> HighLow:
        """Its derivative there."""

    def product(self, f: Function, a: HighLow, b: HighLow) -> HighLow: ...
    def sum(self, f: Function, a: HighLow, b: HighLow) -> HighLow: ...


class DoubleSums:
    """Compensated sums of doubles."""

    beyond = 0

    def state(self, f: Function, row: Row, base: Pointer, low: int, h: Real) -> HighLow:
        """The low part of a velocity moves its coordinate."""
        degrees = row.lengths.degrees
        extra = row.only(row.among(0, degrees), row.at(base, low + degrees) * h)
        return row.at(base), row.at(base, low) + extra

    def change(self, f: Function, row: Row, work: Pointer, h: HighLow, unit: Real) -> HighLow:
        lengths = row.lengths
        c = row.series(work).terms(1, lengths.order)
        return careful_sum(f, c, lengths.wide(f, h[0]), CHAINS if lengths.together > 1 else 1)

    def slope(self, f: Function, row: Row, work: Pointer, h: HighLow, unit: Real) -> HighLow:
        lengths = row.lengths
        c = row.series(work).terms(1, lengths.top)
        chains = RATE_CHAINS if lengths.together > 1 else 1
        return rate(f, c, lengths.wide(f, h[0]), chains), f.zero(lengths.lanes)

    def product(self, f: Function, a: HighLow, b: HighLow) -> HighLow:
        return a[0] * b[0], f.zero(a[0].lanes)

    def sum(self, f: Function, a: HighLow, b: HighLow) -> HighLow:
        return two_sum(a[0], b[0] + (a[1] + b[1]))


class DoubleDoubleSums:
    """Sums of double-double numbers, by ``@polynomial`` and ``@slope``. From a coefficient to the next it is
    ``term`` doubles; low parts are ``beyond`` coefficients behind."""

    def __init__(self, beyond: int, term: int = 1) -> None:
        self.beyond, self.term = beyond, term

    def functions(self, order: int) -> list[Function]:
        """These functions, for series of q to that order."""
        half = order // 2
        slope = self._sum("slope", order, max(1, half - 4), True)
        return [self._sum("polynomial", order, half + 4, False), slope]

    def _sum(self, name: str, order: int, half: int, derivative: bool) -> Function:
        """``@polynomial(row, h)``: sum_{m=1}^{order} c[m] h^m, or ``@slope(row, h)``: sum_{m=1}^{order-1} m
        c[m] h^(m-1). For terms beyond ``half`` a double is enough."""
        f = Function(f"define internal {{ double, double }} @{name}(ptr %row, double %h, double %hl) #0")
        h, last = (Real(f, "%h"), Real(f, "%hl")), order - 1 if derivative else order
        upper = [
            f.load("%row", m * self.term) * float(m) if derivative else f.load("%row", m * self.term)
            for m in range(half + 1, last + 1)
        ]
        total = [
            f.variable(x) for x in (polynomial(f, upper, h[0]) if upper else f.constant(0.0), f.constant(0.0))
        ]

        def times_h() -> HighLow:
            return pair(f, "mul", *(one.get() for one in total), *h)

        m = f.variable(f.count(half))
        with f.forever() as rounds:
            term = [self._coefficient(f, m.get() + low if low else m.get()) for low in (0, self.beyond)]
            if derivative:
                term = [*pair(f, "scale", *term, m.get().to_real())]
            for one, value in zip(total, pair(f, "add", *times_h(), *term)):
                one.set(value)
            m.set(m.get() - 1)
            rounds.repeat(m.get() > 0)
        f.give(*([one.get() for one in total] if derivative else times_h()))
        return f

    def _coefficient(self, f: Function, m: Integer) -> Real:
        return f.load("%row", m if self.term == 1 else m * self.term)

    def state(self, f: Function, row: Row, base: Pointer, low: int, h: Real) -> HighLow:
        return row.at(base), row.at(base, low)

    def change(self, f: Function, row: Row, work: Pointer, h: HighLow, unit: Real) -> HighLow:
        inverse = 1.0 / unit
        return self.called(f, "polynomial", row, work, (h[0] * inverse, h[1] * inverse))

    def slope(self, f: Function, row: Row, work: Pointer, h: HighLow, unit: Real) -> HighLow:
        inverse = 1.0 / unit
        high, low = self.called(f, "slope", row, work, (h[0] * inverse, h[1] * inverse))
        return high * inverse, low * inverse

    def called(self, f: Function, name: str, row: Row, work: Pointer, h: HighLow) -> HighLow:
        """A sum at ``h`` in units of the series."""
        high, low = f.parts((Real, Real), name, row.series(work).place, *h)
        return high, low

    def product(self, f: Function, a: HighLow, b: HighLow) -> HighLow:
        return pair(f, "mul", *a, *b)

    def sum(self, f: Function, a: HighLow, b: HighLow) -> HighLow:
        return pair(f, "add", *a, *b)


def pair(f: Function, name: str, *arguments: Real) -> HighLow:
    """A sum or product of numbers by the functions of ``numbers.double_double``."""
    high, low = f.parts((Real, Real), f"pair_{name}", *arguments)
    return high, low


def difference(a: HighLow, b: HighLow) -> HighLow:
    """a - b"""
    high, low = two_sum(a[0], -b[0])
    return fast_sum(high, low + (a[1] - b[1]))


def moved_on(a: HighLow, b: Real) -> HighLow:
    """a + b"""
    high, low = two_sum(a[0], b)
    return fast_sum(high, low + a[1])
