"""``@follow`` for sections: of each motion its crossings of a surface g(q, q_dot, t) = 0, or its states after
multiples of a period, are samples.

g is the last quadrature's rate, so that its series is known in each step. A step is no longer than that
series converges. All roots within it are found as those of guards are (see ``roots``), in all lanes at
once: in Bernstein's form a piece of the step without a change of sign holds none, one with one change exactly
one, and others are halved. The steps themselves are not divided: a crossing is a sample at the root.

A coefficient that is small beside the sum of all is rounding, and has the sign of the one before it. So a
motion that starts on the surface does not cross it there, and no crossing is counted twice, or lost, where
two steps meet.

A sample has the time behind the rows of the state. Behind ``HALT``, the queue holds the direction (a double:
+1 rising, -1 falling, 0 either), and the number of steps without a crossing after which a motion ends. Behind
a member's parameters, its row has its period.
"""

from __future__ import annotations

import math
from functools import reduce
from operator import add, and_

from lagrange_cli.native.ensembles.pack import Pack
from lagrange_cli.native.ensembles.periods import Returns
from lagrange_cli.native.llvm.function import Function, exp2_roughly, log2_roughly
from lagrange_cli.native.llvm.vector import Bit, Integer, Real
from lagrange_cli.native.members import DIRECTION, PATIENCE, SECTION
from lagrange_cli.native.state import LANES
from lagrange_cli.native.stepping.polynomial import added_up, polynomial, shifted
from lagrange_cli.native.stepping.roots import CONVERGED, FINEST, HUGE, NOTHING, SHORTENINGS, SHORTER
from lagrange_cli.native.stepping.step_size import ENDLESS
from lagrange_cli.records import replace

CLOSE, QUADRATIC = 2.0**-53, 2.0**-40
"""A root is found when it changes by no more than the one; or, by Newton's method, by the other, the number
of its digits doubling. Both are parts of the step."""
FLAT = 2.0**-12
"""A zero at which the rate of g is this part of its terms may be a multiple one."""
CLUSTERS, NEWTON = (3, 5, 7), 4
"""How many zeros may be one but for rounding, where the sign of g changes, and steps of Newton's method that
find their centre."""
NEARBY, ALIKE, BLURRED = 2.0**-6, 2.0**10, 2.0**-36
"""How far from that they are at most, as part of the step; up to what ratio coefficients are of one size; and
the most that rounding of g is, as part of its terms."""
ITERATIONS = 100
"""Improvements of a root at most."""
LONGEST = 1024.0
"""If nothing limits a step, it takes this multiple of the time before it."""
OVER = 2.0**60
"""A motion whose time is beyond this ends: no root has a digit left."""
LOW = 3
"""The degree of the polynomial that is examined first."""
CHAINS = 4
"""Partial sums of a polynomial that are added in parallel."""


class Crossings(Returns):
    """Samples where g is 0. ``side`` is the sign of g before, 0 at the beginning; ``since`` the number of
    steps since the last crossing."""

    kind = SECTION

    def __init__(self, pack: Pack, order: int, tolerance: float, parameters: int) -> None:
        surface = 2 * pack.degrees + pack.quadratures - 1
        super().__init__(replace(pack, quadratures=pack.quadratures - 1), order, tolerance, parameters)
        self.series = self.places["work"] + surface * pack.span
        self.degree = order - 2
        self.piece = self.places["own"] + self.degree + 1

    def sampling(self) -> list[Function]:
        return [self.reach(), self.roots(), self.search(), self.root()]

    def terms(self, f: Function) -> list[Real]:
        """The coefficients of g in this step, as a function of the part of it."""
        return [f.load("%state", self.places["own"] + m) for m in range(self.degree + 1)]

    def bounded(self, f: Function, h: Real, left: Real, live: Bit) -> Real:
        longest = (f.magnitude(self.get(f, "time")) + 1.0) * LONGEST
        h = f.select(h < ENDLESS, h, longest)
        return f.call(Real, "reach", f.pointer("%state"), f.smaller(h, left), live)

    def reach(self) -> Function:
        """``@reach``: the part of a step of ``h`` in which the series of g has converged, which it may do
        more slowly than the motion's; its terms there are in ``own``."""
        f = Function("define internal REAL @reach(ptr %state, REAL %h, BIT %live) #0", LANES)
        length, n = f.variable(Real(f, "%h")), self.degree
        with f.section() as found, f.loop(0, SHORTENINGS, tested=False):
            power, sizes = f.constant(1.0), list[Real]()
            for m in range(n + 1):
                term = f.load("%state", self.series + m + 1) * float(m + 1) * power
                power = f.smaller(power * length.get(), f.constant(HUGE))
                f.store(term, "%state", self.places["own"] + m)
                sizes.append(f.magnitude(term))
            tail, least = f.larger(sizes[-1], sizes[-2]), reduce(add, sizes) * CONVERGED
            long = (tail > least) & Bit(f, "%live")
            with f.when(~f.any(long)):
                found.leave()
            factor = exp2_roughly(log2_roughly(least / tail) * (1.0 / (n - 1)))
            length.set(f.select(long, length.get() * f.smaller(factor, f.constant(SHORTER)), length.get()))
        f.give(length.get())
        return f

    def sample(self, f: Function, step: Real, moving: Bit, count: Integer) -> Integer:
        direction = Real(f, f.define(f"load double, ptr {f.place('%queue', DIRECTION, 'double').name}"), 1)
        since = self.get(f, "since").bits() + 1
        self.put(f, "since", since.number())
        places = f.pointer("%state"), f.pointer("%work")
        given = step, moving, f.splat(direction, LANES), count, Integer(f, "%slots", 1)
        f.call(None, "roots", *places, *given, f.pointer("%samples"))
        patience = f.splat(f.load_integer("%queue", PATIENCE), LANES)
        lost = self.get(f, "since").bits() >= patience
        lost = lost | (f.magnitude(self.get(f, "time")) > OVER)
        return ((lost | self.complete_lanes(f, count)) & moving).mask()

    def roots(self) -> Function:
        """``@roots``: sample the crossings within the step of the lanes that are ``moving``.

        Nearly all lanes are found at a glance to have none, or one: by the first terms and a bound of the
        others, or where g is monotonic.
        """
        heads = "ptr %state, ptr %work, REAL %h, BIT %moving, REAL %direction"
        counts = "i64 %count, i64 %slots, ptr %samples"
        f = Function(f"define internal void @roots({heads}, {counts}) #0", LANES)
        terms, zero, count = self.terms(f), f.zero(LANES), Integer(f, "%count", 1)
        total = later = slopes = zero
        for m, term in reversed([*enumerate(terms)][1:]):
            size = f.magnitude(term)
            total = total + size
            later = total if m == LOW + 1 else later
            slopes = f.fused(size, f.constant(float(m)), slopes) if m > 1 else slopes
        end = polynomial(f, terms, f.constant(1.0), CHAINS)
        side = self.get(f, "side")
        noise = (total + f.magnitude(terms[0])) * NOTHING
        low = [one * side for one in raised(terms[: LOW + 1])]
        away = reduce(f.smaller, low) > later + noise
        monotonic = (f.magnitude(terms[1]) > slopes) & (f.magnitude(end) > noise) & (f.magnitude(side) > 0.0)
        single = monotonic & (end * side < 0.0)
        searching = Bit(f, "%moving") & ~self.complete_lanes(f, count)
        last = f.select(single, -side, side)
        self.put(f, "side", f.select(searching, last, side))
        self.take_root(f, single & searching, zero, f.constant(1.0), terms[0], end, last)
        rest = searching & ~(away | monotonic)
        with f.when(f.any(rest)):
            given = Real(f, "%h"), rest, Real(f, "%direction"), noise, count, Integer(f, "%slots", 1)
            f.call(None, "search", f.pointer("%state"), f.pointer("%work"), *given, f.pointer("%samples"))
        f.give()
        return f

    def take_root(
        self, f: Function, crossed: Bit, a: Real, end: Real, first: Real, to: Real, last: Real
    ) -> None:
        """Sample the lanes that have ``crossed`` in the right direction, between ``a`` and ``end``."""
        hit = crossed & (Real(f, "%direction") * last >= 0.0)
        with f.when(f.any(hit)):
            found = f.call(Real, "root", f.pointer("%state"), a, end, first, to, last, hit)
            self.take(f, found * Real(f, "%h"), hit.mask(), Integer(f, "%count", 1))
            self.put(f, "since", f.select(hit, f.zero(LANES), self.get(f, "since")))

    def search(self) -> Function:
        """``@search``: the same by pieces of the step, whatever g is like."""
        heads = "ptr %state, ptr %work, REAL %h, BIT %rest, REAL %direction, REAL %noise"
        counts = "i64 %count, i64 %slots, ptr %samples"
        f = Function(f"define internal void @search({heads}, {counts}) #0", LANES)
        zero, one, count = f.zero(LANES), f.constant(1.0), Integer(f, "%count", 1)
        a, w, side = f.variable(zero), f.variable(one), f.variable(self.get(f, "side"))
        searching = f.variable(Bit(f, "%rest"))
        with f.forever() as pieces:
            self.form(f, a.get(), w.get())
            changes, last = self.signs(f, side.get(), Real(f, "%noise"))
            fine, end = w.get() <= FINEST, a.get() + w.get()
            empty, single = changes.equals(0.0), changes.equals(1.0)
            crossed = single | (fine & (last * side.get() < 0.0))
            first, to = (f.load("%state", self.piece + m) for m in (0, self.degree))
            self.take_root(f, crossed & searching.get(), a.get(), end, first, to, last)
            passed = empty | single | fine
            side.set(f.select(searching.get() & passed, last, side.get()))
            searching.set(searching.get() & ~(passed & (end >= 1.0)) & ~self.complete_lanes(f, count))
            with f.when(~f.any(searching.get())):
                pieces.leave()
            a.set(f.select(passed, end, a.get()))
            wider = f.smaller(w.get() + w.get(), f.constant(1.0) - end)
            w.set(f.select(passed, wider, w.get() * 0.5))
        self.put(f, "side", side.get())
        f.give()
        return f

    def form(self, f: Function, a: Real, w: Real) -> None:
        """The coefficients on [a, a + w] in Bernstein's form."""
        n, piece, own = self.degree, self.piece, self.places["own"]
        with f.loop(0, n + 1, tested=False) as m:
            f.store(f.load("%state", m + own), "%state", m + piece)
        shifted(f, "%state", piece, n, a)
        power = f.constant(1.0)
        for place in range(n + 1):
            term = f.load("%state", piece + place) * power * (1.0 / math.comb(n, place))
            f.store(term, "%state", piece + place)
            power = power * w
        added_up(f, "%state", piece, n)

    def signs(self, f: Function, side: Real, noise: Real) -> tuple[Real, Real]:
        """How often coefficients change their sign, ``side`` before them, and the last one."""
        plus, minus, negative = f.constant(1.0), f.constant(-1.0), -noise
        changes, before = f.variable(f.zero(LANES)), f.variable(side)
        with f.loop(self.piece, self.piece + self.degree + 1, tested=False) as m:
            one = f.load("%state", m)
            now = f.select(one > noise, plus, f.select(one < negative, minus, before.get()))
            changed = now * before.get() < 0.0
            changes.set(changes.get() + f.select(changed, plus, f.zero(LANES)))
            before.set(now)
        return changes.get(), before.get()

    def root(self) -> Function:
        """``@root``: the root of g between ``a`` and ``end``, whose sign is ``last`` behind it, in the lanes
        that are ``hit``; ``from`` and ``to`` are its values there."""
        heads = "ptr %state, REAL %a, REAL %end, REAL %from, REAL %to, REAL %last, BIT %hit"
        f = Function(f"define internal REAL @root({heads}) #0", LANES)
        start, end, first, to, last = f.reals("a", "end", "from", "to", "last")
        terms = self.terms(f)
        middle = (start + end) * 0.5
        secant = start + (end - start) * (first / (first - to))
        x = f.variable(f.select((secant > start) & (secant < end), secant, middle))
        low, high, pending = f.variable(start), f.variable(end), f.variable(Bit(f, "%hit"))
        with f.section() as found, f.loop(0, ITERATIONS, tested=False):
            at = x.get()
            value, slope = polynomial(f, terms, at, CHAINS), rate_of(f, terms, at)
            beyond = value * last > 0.0
            high.set(f.select(beyond, at, high.get()))
            low.set(f.select(beyond, low.get(), at))
            newton = at - value / slope
            inside = (newton >= low.get()) & (newton <= high.get())
            following = f.select(inside, newton, (low.get() + high.get()) * 0.5)
            change = f.magnitude(following - at)
            x.set(f.select(pending.get(), following, at))  # whatever others still need
            pending.set(pending.get() & (change > CLOSE) & ~(inside & (change <= QUADRATIC)))
            with f.when(~f.any(pending.get())):
                found.leave()
        total = reduce(add, map(f.magnitude, terms))
        flat = f.magnitude(rate_of(f, terms, x.get())) <= total * FLAT
        flat = flat & Bit(f, "%hit")
        with f.when(f.any(flat)):
            x.set(f.select(flat, self.centre(f, terms, x.get(), total), x.get()))
        f.give(x.get())
        return f

    def centre(self, f: Function, terms: list[Real], x: Real, total: Real) -> Real:
        """The centre of the zeros that lie so close around ``x`` that rounding may be all that tells them
        from one; ``x`` where it is one. The coefficients of g have the sum ``total``.

        Rounding moves the zeros of (t - T)^k by the k-th root of itself, but not their centre: it is the zero
        of derivative k - 1, which is simple. Seen from there all coefficients below are rounding, of about
        one size, if there is one zero; if there are several at distances d, they are as d, d^2, .., d^k.
        """
        found = f.variable(x)
        for k in CLUSTERS:
            at, c = f.variable(x), list[Real]()
            for again in range(NEWTON + 1):
                for m, term in enumerate(terms):
                    f.store(term, "%state", self.piece + m)
                shifted(f, "%state", self.piece, self.degree, at.get())
                c = [f.load("%state", self.piece + m) for m in range(k + 1)]
                if again < NEWTON:
                    at.set(at.get() - c[k - 1] / (c[k] * float(k)))
            value = f.magnitude(c[0])
            noise = f.larger(value, total * NOTHING) * ALIKE
            close = (f.magnitude(at.get() - x) <= NEARBY) & (value <= total * BLURRED)
            close = reduce(and_, (f.magnitude(one) <= noise for one in c[1 : k - 1]), close)
            found.set(f.select(close, at.get(), found.get()))
        return found.get()


def raised(c: list[Real]) -> list[Real]:
    """The coefficients of a polynomial in Bernstein's form on [0, 1]."""
    n = len(c) - 1
    b = [one * (1.0 / math.comb(n, m)) for m, one in enumerate(c)]
    for k in range(n):
        for i in reversed(range(k + 1, n + 1)):
            b[i] = b[i] + b[i - 1]
    return b


def rate_of(f: Function, terms: list[Real], x: Real) -> Real:
    """The derivative of the polynomial."""
    scaled = [one * float(m) for m, one in enumerate(terms)][1:]
    return polynomial(f, scaled, x, CHAINS)
