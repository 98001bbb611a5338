"""The first root of a guard's argument within a step, of which none is missed.

In Bernstein's form on an interval a polynomial lies within the convex hull of its coefficients, and has no
more roots there than these have changes of sign (G. Farin, Curves and Surfaces for CAGD, 5th ed., sec. 6.3;
R. T. Farouki, The Bernstein polynomial basis, CAGD 29, 2012). So pieces of the step without a change of sign
hold no root, those with one hold exactly one, and others are halved."""

from __future__ import annotations

import math
from collections.abc import Callable

from lagrange_cli.native.llvm.flow import Variable
from lagrange_cli.native.llvm.function import Function, exp2_roughly, log2_roughly
from lagrange_cli.native.llvm.text import table
from lagrange_cli.native.llvm.vector import Bit, Index, Integer, Pointer, Real
from lagrange_cli.records import dataclass

NOTHING = 2.0**-50
"""A coefficient that is this small beside the others is rounding, where the argument begins at 0."""
NOISE = 2.0**-40
"""The same of coefficients that are computed from values of the argument."""
FINEST = 2.0**-48
"""Pieces of a step are not made smaller than this part of it."""
CONVERGED, SHORTER, SHORTENINGS = 2.0**-50, 0.9, 32
"""A series has converged where its last terms are this part of the sum of all; else less of the step is
examined, so much less, so often."""
HUGE = 2.0**1000
"""No power of a step is larger: what it is multiplied with may be 0."""
ITERATIONS, CLOSE = 200, 2.0**-52
"""Improvements of a root at most; it is found when one changes it by no more than this part of it."""
GLANCE, ROUNDED = 8, 2.0**-44
"""The degree up to which a polynomial is looked at first, and how much of it may be rounding."""
NEARLY = 2.0**-10
"""A root is corrected by no more than this part of it."""
NONE, BACK = float("inf"), -1.0
"""The values in place of a root: there is none; the motion would go back to where it came from."""


def points_of(degree: int) -> list[float]:
    """The points of a step, as parts of it, where values of arguments are known: Chebyshev's, from 0 to 1."""
    return [0.5 - 0.5 * math.cos(math.pi * n / degree) for n in range(degree)] + [1.0]


@dataclass(frozen=True)
class Roots:
    """``@first_root(row, h, start, side, fresh, scratch)``: the time in a step of ``h`` when ``start`` +
    ``side`` u stops being positive; ``NONE`` or ``BACK``.

    The ``row`` is the series of the quadrature of u: its coefficients, up to ``order``, are ``term`` doubles
    apart. If it is ``fresh``, the sum is 0 where the step begins: then this root does not count, and the next
    coefficient tells the side to which the motion goes. There are ``room`` doubles of ``scratch``."""

    order: int
    term: int
    interpolated: bool = False
    """Whether polynomials are no series: they do not converge, and are rounded more."""

    @property
    def degree(self) -> int:
        """The degree of the argument's polynomial."""
        return self.order - 2

    def text(self) -> str:
        """Its IR."""
        inverse = [1.0 / math.comb(self.degree, m) for m in range(self.degree + 1)]
        own = self._value(), self._bernstein(), self._known(), self._first_root()
        return table("inverse_binomials", inverse, "double") + "".join(f.text() for f in own)

    def _each(self, f: Function, body: Callable[[Integer], None], first: Index = 0) -> None:
        with f.loop(first, self.degree + 1, tested=not isinstance(first, int)) as m:
            body(m)

    def _value(self) -> Function:
        """``@value_at(p, s)``: the polynomial ``p`` at ``s``."""
        f = Function("define internal double @value_at(ptr noalias %p, double %s) #0")
        total = f.load("%p", self.degree)
        for m in reversed(range(self.degree)):
            total = f.fused(total, Real(f, "%s"), f.load("%p", m))
        f.give(total)
        return f

    def _known(self) -> Function:
        """``@known(row, h)``: the part of a step of ``h`` in which the series of an argument, whose
        quadrature the ``row`` is, has converged. It may do so more slowly than the motion's. And the sum of
        the sizes of its terms there, infinite if that is not known."""
        f = Function("define internal { double, double } @known(ptr noalias %row, double %h) #0")
        if self.interpolated:
            f.give(Real(f, "%h"), f.constant(math.inf))
            return f
        length, size = f.variable(Real(f, "%h")), f.variable(f.constant(math.inf))
        with f.section() as shorter, f.loop(0, SHORTENINGS, tested=False):
            power, total = f.variable(f.constant(1.0)), f.variable(f.constant(0.0))
            last, before, shown = (f.variable(f.constant(0.0)) for _ in range(3))

            def add(m: Integer) -> None:
                one = f.magnitude(f.load("%row", (m + 1) * self.term) * (m + 1).to_real() * power.get())
                before.set(last.get())
                last.set(one)
                counts = (one > 0.0) & (m >= (self.degree + 1) // 2)
                shown.set(f.select(counts, one, shown.get()))
                total.set(total.get() + one)
                power.set(f.smaller(power.get() * length.get(), f.constant(HUGE)))

            self._each(f, add)
            # The last terms may be 0 since only some orders are there, as in a function of t^4.
            least, tail = total.get() * CONVERGED, f.larger(last.get(), before.get())
            tail = f.select(tail > 0.0, tail, shown.get())
            with f.when(~(tail > least)):
                size.set(total.get())
                shorter.leave()
            factor = exp2_roughly(log2_roughly(least / tail) * (1.0 / (self.degree - 1)))
            length.set(length.get() * f.smaller(factor, f.constant(SHORTER)))
        f.give(length.get(), size.get())
        return f

    def apart(self, f: Function, row: Pointer, h: Real, side: Real) -> Bit:
        """Of which arguments, whose rows from ``row`` on are side by side, ``@known`` would give all of a
        step of ``h``, and ``@first_root`` no root at a glance."""
        lanes = side.lanes
        power, zero = f.variable(f.constant(1.0)), f.zero(lanes)
        total, last, before, shown = (f.variable(zero) for _ in range(4))

        def add(m: Integer) -> None:
            factor, now = (f.splat(one, lanes) for one in ((m + 1).to_real(), power.get()))
            one = f.magnitude(f.load_row(row, (m + 1) * self.term, lanes) * factor * now)
            total.set(total.get() + one)
            power.set(f.smaller(power.get() * h, f.constant(HUGE)))
            if not self.interpolated:
                before.set(last.get())
                last.set(one)
                later = f.splat(m >= (self.degree + 1) // 2, lanes)
                shown.set(f.select((one > 0.0) & later, one, shown.get()))

        self._each(f, add)
        begins = f.load_row(row, self.term, lanes) * side
        apart = begins + begins > total.get()
        if self.interpolated:
            return apart
        tail = f.larger(last.get(), before.get())
        tail = f.select(tail > 0.0, tail, shown.get())
        return apart & ~(tail > total.get() * CONVERGED)

    def _bernstein(self) -> Function:
        """``@bernstein(p, b, a, w)``: the coefficients ``b`` of ``p`` on [a, a + w]: how often they change
        their sign, and the smallest one."""
        given = "ptr noalias %p, ptr noalias %b, double %a, double %w"
        f = Function(f"define internal {{ i64, double }} @bernstein({given}) #0")
        a, w, n = Real(f, "%a"), Real(f, "%w"), self.degree
        self._each(f, lambda m: f.store(f.load("%p", m), "%b", m))
        with f.when(~a.equals(0.0)):
            shifted(f, "%b", 0, n, a)
        power = f.variable(f.constant(1.0))

        def scale(m: Integer) -> None:
            f.store(f.load("%b", m) * power.get() * f.load("@inverse_binomials", m), "%b", m)
            power.set(power.get() * w)

        self._each(f, scale)
        added_up(f, "%b", 0, n)
        least, changes = f.variable(f.load("%b")), f.variable(f.count(0))
        before = f.variable(f.load("%b") < 0.0)

        def look(m: Integer) -> None:
            one = f.load("%b", m)
            negative = one < 0.0
            changes.set(changes.get() + negative.compared("ne", before.get()).to_integer())
            before.set(negative)
            least.set(f.smaller(one, least.get()))

        self._each(f, look)
        f.give(changes.get(), least.get())
        return f

    def _first_root(self) -> Function:
        given = "ptr noalias %row, double %h, double %start, double %side, i1 %fresh, ptr noalias %scratch"
        f = Function(f"define internal double @first_root({given}) #0")
        h, fresh, none = Real(f, "%h"), Bit(f, "%fresh"), f.constant(NONE)
        d, size = f.pointer("%scratch"), self.degree + 1
        p, b = f.place(d, size), f.place(d, 2 * size)
        total = self._scaled(f, d, h, Real(f, "%start"), Real(f, "%side"))
        first = f.variable(f.count(0))
        with f.when(fresh):
            self._counting(f, d, total, first, none)
            if self.interpolated:
                self._begin_at_first_point(f, d, first, none)
        begins = f.load(d, first.get())
        with f.when(begins < 0.0):
            f.give(f.select(fresh, f.constant(BACK), f.constant(0.0)))
        with f.when(begins + begins > total):
            f.give(none)
        self._each(f, lambda m: f.store(f.constant(0.0), p, m))
        self._each(f, lambda m: f.store(f.load(d, m), p, m - first.get()), first.get())
        with f.when(total < math.inf), f.when(self._stays_positive(f, p, total)):
            f.give(none)
        self._search(f, p, b, d, h)
        return f

    def _scaled(self, f: Function, d: Pointer, h: Real, start: Real, side: Real) -> Real:
        """Put the coefficients of ``start`` + ``side`` u, with the step as unit of time, to ``d``; the sum of
        their sizes."""
        power, total = f.variable(f.constant(1.0)), f.variable(f.constant(0.0))
        begin = f.variable(start)

        def scale(m: Integer) -> None:
            signed = power.get() * side
            one = begin.get() + f.load("%row", (m + 1) * self.term) * (m + 1).to_real() * signed
            begin.set(f.constant(0.0))
            f.store(one, d, m)
            total.set(total.get() + f.magnitude(one))
            power.set(f.smaller(power.get() * h, f.constant(HUGE)))

        self._each(f, scale)
        return total.get()

    def _counting(self, f: Function, d: Pointer, total: Real, first: Variable[Integer], none: Real) -> None:
        """Set ``first`` to the next coefficient that is not rounding; give ``none`` if all are."""
        with f.forever() as rounds:
            first.set(first.get() + 1)
            with f.when(first.get() > self.degree):
                f.give(none)
            nothing = NOISE if self.interpolated else NOTHING
            with f.when(f.magnitude(f.load(d, first.get())) > total * nothing):
                rounds.leave()

    def _begin_at_first_point(self, f: Function, d: Pointer, first: Variable[Integer], none: Real) -> None:
        """Go on to the first coefficient that is not negative, if the first value behind 0 is positive: what
        begins to rise with rounding errors in its rate, as where a force is let go, does not lead back."""
        point = f.constant(points_of(self.degree)[1])
        with f.when(f.call(Real, "value_at", d, point) > 0.0), f.forever() as rounds:
            with f.when(~(f.load(d, first.get()) < 0.0)):
                rounds.leave()
            first.set(first.get() + 1)
            with f.when(first.get() > self.degree):
                f.give(none)

    def side(self) -> Function:
        """``@side_of(row, h, fresh, scratch)``: the sign of u from here on, which is 0 now if it is
        ``fresh``."""
        f = Function("define internal double @side_of(ptr %row, double %h, i1 %fresh, ptr %scratch) #0")
        d, zero, one = f.pointer("%scratch"), f.constant(0.0), f.constant(1.0)
        total = self._scaled(f, d, Real(f, "%h"), zero, one)
        first = f.variable(f.count(0))
        with f.when(Bit(f, "%fresh") | f.load(d).equals(0.0)):
            self._counting(f, d, total, first, one)
        f.give(f.select(f.load(d, first.get()) < 0.0, -one, one))
        return f

    def _stays_positive(self, f: Function, p: Pointer, total: Real) -> Bit:
        """Whether ``p``, the sizes of whose coefficients are ``total``, is seen to be positive in [0, 1] by
        its first coefficients: in Bernstein's form these, up to ``GLANCE``, are more than all others. That
        takes a fiftieth of the time of the whole form."""
        most = min(GLANCE, self.degree)
        form = f.zero(GLANCE)
        for m in range(most + 1):
            column = [math.comb(j, m) / math.comb(most, m) for j in range(most + 1)]
            last = [column[-1]] * (GLANCE - most)
            form = f.fused(f.splat(f.load(p, m), GLANCE), f.vector([*column[1:], *last]), form)
        rest = f.variable(total * ROUNDED)
        if self.degree > most:
            self._each(f, lambda m: rest.set(rest.get() + f.magnitude(f.load(p, m))), most + 1)
        return f.smaller(f.reduce("fmin", form), f.load(p)) > rest.get()

    def _search(self, f: Function, p: Pointer, b: Pointer, whole: Pointer, h: Real) -> None:
        """Give the first root of ``p`` in [0, 1], times ``h``; corrected by what ``whole``, a power of s
        times ``p`` but for rounding, is there: from crossing to crossing such errors would add up."""
        one = f.constant(1.0)
        a, w = f.variable(f.constant(0.0)), f.variable(one)
        with f.forever() as pieces:
            changes, least = f.parts((Integer, Real), "bernstein", p, b, a.get(), w.get())
            end = a.get() + w.get()

            def pass_by() -> None:
                with f.when(end >= 1.0):
                    f.give(f.constant(NONE))
                a.set(end)
                w.set(f.smaller(w.get() + w.get(), one - end))
                pieces.go_on()

            with f.when(~(least < 0.0)):
                pass_by()
            ends_below = f.call(Real, "value_at", p, end) < 0.0
            with f.when((changes.equals(1) & ends_below) | ((w.get() <= FINEST) & ends_below)):
                root = self._refined(f, p, a.get(), end)
                value, slope = self._both(f, whole, root)
                near = f.magnitude(value) <= f.magnitude(slope) * root * NEARLY
                f.give(f.larger(f.select(near, root - value / slope, root), f.constant(0.0)) * h)
            with f.when(w.get() <= FINEST):  # it touches 0, as far as doubles can tell
                pass_by()
            w.set(w.get() * 0.5)
            pieces.go_on()

    def _refined(self, f: Function, p: Pointer, start: Real, end: Real) -> Real:
        """The one root in an interval at whose end ``p`` is negative: by Newton's method, or by halving where
        that leads out of it."""
        low, high, x = f.variable(start), f.variable(end), f.variable((start + end) * 0.5)
        with f.section() as found, f.loop(0, ITERATIONS, tested=False):
            at = x.get()
            value, slope = self._both(f, p, at)
            below = value < 0.0
            high.set(f.select(below, at, high.get()))
            low.set(f.select(below, low.get(), at))
            newton = at - value / slope
            inside = (newton > low.get()) & (newton < high.get())
            following = f.select(inside, newton, (low.get() + high.get()) * 0.5)
            x.set(following)
            with f.when(~(f.magnitude(following - at) > following * CLOSE)):
                found.leave()
        return f.larger(x.get(), f.constant(0.0))

    def _both(self, f: Function, p: Pointer, s: Real) -> tuple[Real, Real]:
        """``p`` and its derivative at ``s``."""
        total = f.variable(f.load(p, self.degree))
        slope = f.variable(f.constant(0.0))
        with f.loop(1, self.degree + 1, tested=False) as m:
            slope.set(f.fused(slope.get(), s, total.get()))
            total.set(f.fused(total.get(), s, f.load(p, f.count(self.degree) - m)))
        return total.get(), slope.get()


def shifted(f: Function, base: Pointer | str, first: int, n: int, a: Real) -> None:
    """Put p(a + x) in place of p(x), of degree n, whose coefficients are at ``base[first]`` and behind it."""
    with f.loop(0, n, tested=False) as k, f.loop(0, f.count(n) - k, tested=False) as j:
        i = f.count(n - 1 + first) - j
        f.store(f.fused(f.load(base, i + 1), a, f.load(base, i)), base, i)


def added_up(f: Function, base: Pointer | str, first: int, n: int) -> None:
    """The same in Bernstein's form, from its coefficients divided by binomial ones."""
    with f.loop(0, n, tested=False) as k, f.loop(0, f.count(n) - k, tested=False) as j:
        i = f.count(n + first) - j
        f.store(f.load(base, i) + f.load(base, i - 1), base, i)
