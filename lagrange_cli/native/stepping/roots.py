"""The first root of a guard's argument within a step, of which none is missed.

In Bernstein's form on an interval a polynomial lies within the convex hull of its coefficients, and has no
more roots there than these have changes of sign (G. Farin, Curves and Surfaces for CAGD, 5th ed., sec. 6.3;
R. T. Farouki, The Bernstein polynomial basis, CAGD 29, 2012). So pieces of the step without a change of sign
hold no root, those with one hold exactly one, and others are halved."""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import reduce
from operator import add

from lagrange_cli.native.llvm.flow import Variable
from lagrange_cli.native.llvm.function import Function, exp2_roughly, log2_roughly
from lagrange_cli.native.llvm.text import table
from lagrange_cli.native.llvm.vector import Bit, Index, Integer, Pointer, Real
from lagrange_cli.native.state import LANES, vectors_of
from lagrange_cli.native.stepping.polynomial import added, bernstein, powers_of
from lagrange_cli.records import dataclass

NOTHING = 2.0**-50
"""A coefficient that is this small beside the others is rounding, where the argument begins at 0."""
NOISE = 2.0**-40
"""The same of coefficients that are computed from values of the argument."""
FINEST, COARSE, MOST = 2.0**-48, 2.0**-10, 4096
"""Pieces of a step are not made smaller than this part of it; and after so many, no smaller than the second
one: where that many hold no root, the argument is nothing but rounding errors."""
CONVERGED, SHORTER, SHORTENINGS = 2.0**-50, 0.9, 32
"""A series has converged where its last terms are this part of the sum of all; else less of the step is
examined, so much less, so often."""
HUGE = 2.0**1000
"""No power of a step is larger: what it is multiplied with may be 0."""
ITERATIONS, CLOSE = 200, 2.0**-28
"""Improvements of a root at most; when one changes it by no more than this part of it, the next is the last
one, as each doubles the number of its digits."""
ROUNDED = 2.0**-44
"""How much of a polynomial's first coefficients may be rounding."""
NEARLY, STEADY = 2.0**-10, 16.0
"""A root is corrected by no more than this part of it, and where its slope changes by no more than so many
times itself."""
NONE, BACK = float("inf"), -1.0
"""The values in place of a root: there is none; the motion would go back to where it came from."""


def points_of(degree: int) -> list[float]:
    """The points of a step, as parts of it, where values of arguments are known: Chebyshev's, from 0 to 1."""
    return [0.5 - 0.5 * math.cos(math.pi * n / degree) for n in range(degree)] + [1.0]


@dataclass(frozen=True)
class Roots:
    """``@first_root(d, h, start, side, fresh, rises)``: the time in a step of ``h`` when ``start`` + ``side``
    u stops being positive; ``NONE`` or ``BACK``.

    ``d`` has the terms of u that ``@known`` puts there, and room behind them (``room`` doubles in all). The
    coefficients of the quadrature of u, up to ``order``, are ``term`` doubles apart. If it is ``fresh``, the
    sum is 0 where the step begins: then this root does not count, and the next coefficient tells the side to
    which the motion goes; or if it ``rises``, the first value behind 0, if that is positive."""

    order: int
    term: int
    interpolated: bool = False
    """Whether polynomials are no series: they do not converge, and are rounded more."""

    @property
    def degree(self) -> int:
        """The degree of the argument's polynomial."""
        return self.order - 2

    @property
    def vectors(self) -> int:
        """Vectors of its coefficients."""
        return vectors_of(self.degree + 1)

    @property
    def room(self) -> int:
        """Doubles that a search takes: coefficients, as many zeros, and those in Bernstein's form."""
        return 2 * LANES * self.vectors + self.degree + 1

    def text(self) -> str:
        """Its IR."""
        inverse = [1.0 / math.comb(self.degree, m) for m in range(self.degree + 1)]
        own = self._value(), bernstein(self.degree), self._known(), self._first_root()
        return table("inverse_binomials", inverse, "double") + "".join(f.text() for f in own)

    def _each(self, f: Function, body: Callable[[Integer], None], first: Index = 0) -> None:
        with f.loop(first, self.degree + 1, tested=not isinstance(first, int)) as m:
            body(m)

    def _loaded(self, f: Function, p: Pointer) -> list[Real]:
        """The coefficients at ``p``, in vectors."""
        return [f.load_row(p, LANES * k, LANES) for k in range(self.vectors)]

    def _value(self) -> Function:
        """``@value_at(p, s)``: the polynomial ``p`` at ``s``."""
        f = Function("define internal double @value_at(ptr noalias %p, double %s) #0")
        powers, whole = powers_of(f, Real(f, "%s"))
        *lower, total = self._loaded(f, f.pointer("%p"))
        for one in reversed(lower):
            total = f.fused(total, f.splat(whole, LANES), one)
        f.give(added(f, total * powers))
        return f

    def _known(self) -> Function:
        """``@known(row, h, d)``: the part of a step of ``h`` in which the series of an argument, whose
        quadrature the ``row`` is, has converged. It may do so more slowly than the motion's. And the sum of
        the sizes of its terms there, which are put to ``d``."""
        given = "ptr noalias %row, double %h, ptr noalias %d"
        f = Function(f"define internal {{ double, double }} @known({given}) #0")
        h, d = Real(f, "%h"), f.pointer("%d")
        if self.interpolated:
            f.give(h, added(f, reduce(add, self._put_terms(f, h, d))))
            return f
        length, total = f.variable(h), f.variable(f.constant(0.0))
        with f.section() as found, f.loop(0, SHORTENINGS + 1, tested=False) as i:
            sizes = self._put_terms(f, length.get(), d)
            total.set(added(f, reduce(add, sizes)))
            last, before = (f.lane(sizes[m // LANES], m % LANES) for m in (self.degree, self.degree - 1))
            tail = f.variable(f.larger(last, before))
            with f.when(~(tail.get() > 0.0)):  # only some orders may be there, as in a function of t^4
                half = (self.degree + 1) // 2
                self._each(f, lambda m: set_if_positive(tail, f.magnitude(f.load(d, m))), half)
            least = total.get() * CONVERGED
            with f.when(~(tail.get() > least) | i.equals(SHORTENINGS)):
                found.leave()
            factor = exp2_roughly(log2_roughly(least / tail.get()) * (1.0 / (self.degree - 1)))
            length.set(length.get() * f.smaller(factor, f.constant(SHORTER)))
        f.give(length.get(), total.get())
        return f

    def _put_terms(self, f: Function, h: Real, d: Pointer) -> list[Real]:
        """Put the terms of the argument over a step of ``h`` to ``d``; their sizes, in vectors."""
        powers, whole = powers_of(f, f.smaller(h, f.constant(HUGE)))
        factor, found = f.splat(f.smaller(whole, f.constant(HUGE)), LANES), list[Real]()
        for k in range(self.vectors):
            orders = [LANES * k + lane + 1 for lane in range(LANES)]
            given = [f.load("%row", m * self.term) if m < self.order else f.constant(0.0) for m in orders]
            terms = f.joined(given) * f.vector([float(m) for m in orders]) * powers
            powers = f.smaller(powers * factor, f.splat(f.constant(HUGE), LANES))
            f.store_row(terms, d, LANES * k)
            found.append(f.magnitude(terms))
        return found

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

    def _first_root(self) -> Function:
        given = "ptr noalias %d, double %h, double %start, double %side, i1 %fresh, i1 %rises"
        f = Function(f"define internal double @first_root({given}) #0")
        h, fresh, none = Real(f, "%h"), Bit(f, "%fresh"), f.constant(NONE)
        d = f.pointer("%d")
        total = self._turned(f, d, Real(f, "%start"), Real(f, "%side"))
        first = f.variable(f.count(0))
        with f.when(fresh):
            for k in range(self.vectors):
                f.store_row(f.zero(LANES), d, LANES * (self.vectors + k))
            self._counting(f, d, total, first, none)
            if self.interpolated:
                with f.when(Bit(f, "%rises")):
                    self._begin_at_first_point(f, d, first, none)
        begins = f.load(d, first.get())
        with f.when(begins < 0.0):
            f.give(f.select(fresh, f.constant(BACK), f.constant(0.0)))
        with f.when(begins + begins > total):
            f.give(none)
        p = f.place(d, first.get())
        with f.when(total < math.inf), f.when(self._stays_positive(f, p, total)):
            f.give(none)
        self._search(f, p, d, h)
        return f

    def _turned(self, f: Function, d: Pointer, start: Real, side: Real) -> Real:
        """Put ``start`` + ``side`` u in place of u; the sum of the sizes of its terms."""
        terms = [one * f.splat(side, LANES) for one in self._loaded(f, d)]
        terms[0] = terms[0] + f.joined([start, *[f.constant(0.0)] * (LANES - 1)])
        for k, one in enumerate(terms):
            f.store_row(one, d, LANES * k)
        return added(f, reduce(add, map(f.magnitude, terms)))

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
        """``@side_of(d, total, fresh)``: the sign of u from here on, which is 0 now if it is ``fresh``; its
        terms are at ``d``, the sum of their sizes is ``total``."""
        f = Function("define internal double @side_of(ptr %d, double %total, i1 %fresh) #0")
        d, one = f.pointer("%d"), f.constant(1.0)
        first = f.variable(f.count(0))
        with f.when(Bit(f, "%fresh") | f.load(d).equals(0.0)):
            self._counting(f, d, Real(f, "%total"), first, one)
        f.give(f.select(f.load(d, first.get()) < 0.0, -one, one))
        return f

    def _stays_positive(self, f: Function, p: Pointer, total: Real) -> Bit:
        """Whether ``p``, the sizes of whose coefficients are ``total``, is seen to be positive in [0, 1] by
        its first coefficients: in Bernstein's form these, up to ``LANES``, are more than all others. That
        takes a fiftieth of the time of the whole form."""
        most = min(LANES, self.degree)
        form = f.zero(LANES)
        for m in range(most + 1):
            column = [math.comb(j, m) / math.comb(most, m) for j in range(most + 1)]
            last = [column[-1]] * (LANES - most)
            form = f.fused(f.splat(f.load(p, m), LANES), f.vector([*column[1:], *last]), form)
        rest = total * ROUNDED
        if self.degree > most:
            _, behind, *others = map(f.magnitude, self._loaded(f, p))
            behind = behind * f.vector([0.0, *[1.0] * (LANES - 1)])
            rest = rest + added(f, reduce(add, others, behind))
        return f.smaller(f.reduce("fmin", form), f.load(p)) > rest

    def _search(self, f: Function, p: Pointer, whole: Pointer, h: Real) -> None:
        """Give the first root of ``p`` in [0, 1], times ``h``; corrected by what ``whole``, a power of s
        times ``p`` but for rounding, is there: from crossing to crossing such errors would add up."""
        one, b = f.constant(1.0), f.place(whole, 2 * LANES * self.vectors)
        a, w, tried = f.variable(f.constant(0.0)), f.variable(one), f.variable(f.count(0))
        with f.forever() as pieces:
            finest = f.select(tried.get() < MOST, f.constant(FINEST), f.constant(COARSE))
            tried.set(tried.get() + 1)
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
            there = f.call(Real, "value_at", p, end)
            with f.when((there < 0.0) & (changes.equals(1) | (w.get() <= finest))):
                begins = f.load(b)
                along = begins / (begins - there)
                guess = a.get() + w.get() * f.select((along > 0.0) & (along < 1.0), along, f.constant(0.5))
                root = self._refined(f, p, (a.get(), guess, end))
                f.give(f.larger(self._corrected(f, whole, root), f.constant(0.0)) * h)
            with f.when(w.get() <= finest):  # it touches 0, as far as doubles can tell
                pass_by()
            w.set(w.get() * 0.5)
            pieces.go_on()

    def _refined(self, f: Function, p: Pointer, given: tuple[Real, Real, Real]) -> Real:
        """The one root in an interval at whose end ``p`` is negative, from a guess within it: by Newton's
        method, or by halving where that leads out of it. A further step of it follows (``_search``)."""
        low, x, high = map(f.variable, given)
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

    def _corrected(self, f: Function, p: Pointer, root: Real) -> Real:
        """A root after one more of Newton's steps, if that is short and does not lead far beyond the places
        where the slope is about as small: where a root is multiple, slopes may be rounding errors."""
        value, (_, slope) = self._by_horner(f, p, root), self._both(f, p, root)
        corrected, size = root - value / slope, f.magnitude(slope)
        _, there = self._both(f, p, corrected)
        sound = (f.magnitude(value) <= size * root * NEARLY) & (f.magnitude(there - slope) <= size * STEADY)
        return f.select(sound, corrected, root)

    def _by_horner(self, f: Function, p: Pointer, s: Real) -> Real:
        """``p`` at ``s``, the last sum with one rounding: roots of linear functions are exact."""
        total = f.variable(f.load(p, self.degree))
        with f.loop(1, self.degree + 1, tested=False) as m:
            total.set(f.fused(total.get(), s, f.load(p, f.count(self.degree) - m)))
        return total.get()

    def _both(self, f: Function, p: Pointer, s: Real) -> tuple[Real, Real]:
        """``p`` and its derivative at ``s``: sum_j s^j q_j(s^8), where q_j has every eighth coefficient."""
        powers, whole = powers_of(f, s)
        *lower, total = self._loaded(f, p)
        slope, factor = f.zero(LANES), f.splat(whole, LANES)
        for one in reversed(lower):
            slope = f.fused(slope, factor, total)
            total = f.fused(total, factor, one)
        before = f.shuffle(powers, [0, *range(LANES - 1)]) * f.vector([float(m) for m in range(LANES)])
        inner = added(f, slope * powers) * f.lane(powers, LANES - 1) * float(LANES)
        return added(f, total * powers), added(f, total * before) + inner


def set_if_positive(variable: Variable[Real], value: Real) -> None:
    """Set a variable where the value is positive."""
    variable.set(value.body.select(value > 0.0, value, variable.get()))
