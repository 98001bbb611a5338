"""Integrals over a step of the motion that is divided into parts.

The series are expanded anew at places of the step, and the integrals of each part are added. A part ends
where the rule for steps says (``step_size``), and every part is accepted by the series at its end
(``acceptance``). A jump or a kink of an integrand is approached by halving, and passed; across a pole an
integral is not a number. The motion itself stays the same to the last bit.

Where a step begins or ends at u = 0 with a power u^p in an integrand, the parts there are as short as time
resolves. What is left is the integral of a power law: r f(r)/(1 + p) within r of u = 0, where f(r) and f(4 r)
tell p.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from contextlib import nullcontext

from lagrange_cli.native.llvm.flow import Variable
from lagrange_cli.native.llvm.function import Function
from lagrange_cli.native.llvm.vector import Bit, Integer, Pointer, Real
from lagrange_cli.native.stepping.acceptance import allowance
from lagrange_cli.native.stepping.lengths import Row
from lagrange_cli.native.stepping.quadratures import Quadratures
from lagrange_cli.native.stepping.step_size import ENDLESS
from lagrange_cli.native.stepping.sums import Pair, Sums, difference, moved_on
from lagrange_cli.records import dataclass, replace

LAG = 0.7
"""The factor by which the usual length of parts may shrink from one to the next."""
REPEATS, NOISY = 12.0, 2.0**16
"""If so many parts in a row are not accepted however short they are, rounding is the cause, and so much more
is allowed; what is not accepted then is lost."""
CROWDED = 2.0**6
"""Parts so many times as long as the resolution of time are too short for a series."""
SINGULAR = 2.0**6
"""Where the series themselves ask for parts no longer than so many times this, an integrand has a
singularity: what is not proven there is no hidden feature."""
CLOSE = 2.0**-16
"""Parts of a step so short, close to a kink, need not be as short as the series ask for: rounding errors make
these short there, and what is expected at the end of a part is sound if it is accepted."""
SHORTER = 0.7
"""A part that is not proven is tried again so many times as long."""
NEARBY = 2.0**-30
"""Parts of a step that begin within this of each other are at the same place."""
FARTHER, WEAKEST, BENT, TERMS = 4.0, 0.264, 2.0**-10, 20
"""How many times as far away a power law is looked at; this to its exponent, below which the integral is
hardly finite; how far off the last place may be; terms of a logarithm."""
EVENLY = 2.0**-30
"""A quantity that changes by at most this fraction of itself counts as constant."""
EDGE = 16.0
"""A power law is followed over so many times the length of the shortest part with a series."""
STRETCHES = 16.0
"""If an integrand is not finite beyond such a part, it is evaluated so many times as far away."""
MOST = 2**18
"""Parts of one step. These may take minutes, so that each checks whether to go on (``halted``)."""
PATIENT, EVEN = 48, 1 / 16
"""Beside constraints, integrands may cancel to rounding errors, on which no part agrees. After so many parts
of a step, all are of this length and need not be accepted: what may hide is proven, and not divided so."""
NAN = "0x7FF8000000000000"
ENDED, RATES, ALLOWED, LOW_RATES = 2, 4, 5, 6
KNOWN = LOW_RATES
"""The arrays of ``Places`` behind the state within the step, by number; low parts of states take one more. Of
short parts the integrals that are known are marked."""


@dataclass(frozen=True)
class Places:
    """The state at the beginning of a step and the series there; the arrays that the parts of the step take,
    and the series of a part.

    The arrays (``interface.ARRAYS``) are the state within the step and that at the end of a part, with low
    parts; the rates expected there, how far off they may be, and their low parts.
    """

    begin: Pointer
    work: Pointer
    arrays: Pointer
    there: Pointer


@dataclass(frozen=True)
class Part:
    """A part of a step: from ``start`` to ``end``, ``h`` long.

    It may be so ``short`` that the integrand is taken to be constant, and so because the integrand is
    ``steep`` there; it may be the ``last`` one.
    """

    start: Pair
    end: Pair
    h: Pair
    short: Bit
    steep: Bit
    last: Bit


@dataclass
class Units:
    """Units of time: of the series of the step, and of those of its parts."""

    step: Real
    part: Variable[Real]


class Division:
    """Writes into ``f`` the loop over the parts of a step. In the state low parts are ``low`` rows behind.

    ``expand`` is to compute the series at a place of the step, in ``units.part``, where the state is already;
    ``prove`` tells whether integrands have nothing to hide within some length of such a place.
    """

    edge = 2.0**-30
    """Nor is one followed over less than this part of a step: coefficients of its series would overflow."""

    provable = 0.0
    """Parts up to this part of the time are too short for proofs, in which time is a double."""

    def __init__(
        self, f: Function, quadratures: Quadratures, sums: Sums, at: Places, low: int, units: Units,
        expand: Callable[[Pair], None], prove: Callable[[Pair, Real], Bit] | None,
        halted: Callable[[], Bit], *, tires: bool = False,
    ) -> None:  # fmt: skip
        self.halted = halted
        self.tires = tires and prove is None
        self.f, self.at, self.low, self.sums, self.units = f, at, low, sums, units
        self.lengths, self.own, self.bounds = quadratures.lengths, quadratures.own, quadratures.bounds
        self.quadratures, self.expand, self.prove = quadratures, expand, prove

    # states and arrays

    def array(self, number: int) -> Pointer:
        """One of the arrays."""
        return self.f.place(self.at.arrays, number * self.lengths.width) if number else self.at.arrays

    def put(self, row: Row, value: Pair, to: Pointer, where: Bit | None = None) -> None:
        """Store a number and its low part, or where that holds only."""
        for shift, one in zip((0, self.low), value):
            row.put(one if where is None else self.f.select(where, one, row.at(to, shift)), to, shift)

    def begin(self) -> None:
        """All parts begin with the integrals that the step begins with."""
        with self.lengths.each(self.f) as row:
            self.put(row, (row.at(self.at.begin), row.at(self.at.begin, self.low)), self.at.arrays)

    def go(self, place: Pair) -> None:
        """The motion at a place of the step, and the series there; the integrals stay as they are."""
        f, at, sums = self.f, self.at, self.sums
        with self.lengths.each(f) as row:
            moves = ~row.among(*self.own.leading)
            with f.when(moves) if self.lengths.together == 1 else nullcontext():
                old = sums.state(f, row, at.begin, self.low, self.lengths.wide(f, place[0]))
                change = sums.change(f, row, at.work, place, self.units.step)
                self.put(row, sums.sum(f, old, change), at.arrays, moves)
        self.expand(place)

    # integrals

    def rate(self, row: Row) -> Pair:
        """The integrand at the beginning of a part."""
        series, inverse = row.series(self.at.there), self.f.constant(1.0) / self.units.part.get()
        if not self.sums.beyond:
            return series[1], self.f.zero(row.lengths.lanes)
        return series[1] * inverse, series[1 + self.sums.beyond] * inverse

    def integral(self, row: Row, part: Part, h: Pair) -> Pair:
        """An integral within ``h`` of the beginning of a part. A rate that is not finite counts as 0: what
        lies beyond tells whether it may be."""
        f, sums, lengths = self.f, self.sums, row.lengths
        summed = sums.change(f, row, self.at.there, h, self.units.part.get())
        linear = sums.product(f, (self.known(row), self.known(row, 1)), (lengths.wide(f, h[0]), h[1]))
        change = self.choice(part.short, linear, summed)
        return sums.sum(f, (row.at(self.at.arrays), row.at(self.at.arrays, self.low)), change)

    def known(self, row: Row, part: int = 0) -> Real:
        """A rate, or 0."""
        rate = self.rate(row)[part]
        return self.f.select(self.f.magnitude(rate) < ENDLESS, rate, self.f.zero(rate.lanes))

    def add(self, part: Part, usual: Real, t: Real) -> None:
        """The integrals at the end of a part, and what is expected of the integrands there."""
        f, own, h = self.f, self.own, part.h[0]
        allowed = allowance(f, self.bounds, t, usual, h)
        with own.velocities(f) as row:
            new, old = self.integral(row, part, part.h), row.at(self.at.arrays)
            speed, low = self.sums.slope(f, row, self.at.there, part.h, self.units.part.get())
            lesser = f.smaller(f.magnitude(new[0]), f.magnitude(old))
            most = allowed.of(f, own, f.magnitude(speed) + f.magnitude(self.rate(row)[0]), lesser)
            most = most + own.wide(f, self.quadratures.nothing(f, h))
            most = f.select(part.short, f.magnitude(self.known(row)), most)
            self.put(row, new, self.array(ENDED))
            for number, value in ((RATES, speed), (ALLOWED, most), (LOW_RATES, low)):
                row.put(value, self.array(number))
        with f.when(part.short), own.velocities(f) as row:  # nothing is expected of these
            row.put(self.rate(row)[0], self.array(RATES))
            row.put(f.zero(own.lanes), self.array(KNOWN))

    def follow_powers(self, part: Part) -> None:
        """The integrals at the end of a short part where the step begins or ends, if integrands are a + b r^p
        at the distance r from there; these are ``KNOWN``. The series are those at the end of the part.

        With f1, f2 and f3 at r, 4 r and 16 r, q = (f3 - f2)/(f2 - f1) = 4^p, and f4 at 64 r tells whether
        that is so. The integral within r is r (f1 + (f2 - f1) p/((1 - q) (1 + p))), where log(q) = 2 z (1 +
        z^2/3 + ...) with z = (q - 1)/(q + 1).
        """
        f, own, h = self.f, self.own, part.h[0]
        zero, one = f.zero(own.lanes), f.splat(f.constant(1.0), own.lanes)
        begins = part.start[0].equals(0.0)
        with own.velocities(f) as row:
            row.put(f.select(begins, self.rate(row)[0], row.at(self.array(RATES))), self.array(RATES))
        for times, array in zip((FARTHER, FARTHER**2, FARTHER**3), (ALLOWED, KNOWN, None)):
            away = h * (times - 1.0)
            place = f.select(begins, part.end[0] + away, part.start[0] - away)
            self.go((place, f.constant(0.0)))
            if array is not None:
                with own.velocities(f) as row:
                    row.put(self.rate(row)[0], self.array(array))
        with own.velocities(f) as row:
            fourth = self.rate(row)[0]
            first, second, third = (row.at(self.array(one)) for one in (RATES, ALLOWED, KNOWN))
            change, size = second - first, f.magnitude(first)
            q = (third - second) / change
            z = (q - 1.0) / (q + 1.0)
            series = zero
            for k in reversed(range(TERMS)):
                series = series * z * z + 1.0 / (2 * k + 1)
            unit = 2.0 / math.log(FARTHER)
            power = z * series * unit
            even = f.magnitude(change) <= size * EVENLY
            bent = first - change * series * unit / ((q + 1.0) * (power + 1.0))
            integral = f.select(even, first, bent) * own.wide(f, h)
            follows = (
                f.magnitude((fourth - third) - (third - second) * q) <= f.magnitude(fourth - third) * BENT
            )
            known = (size < ENDLESS) & (even | (follows & (q > WEAKEST) & (q < ENDLESS)))
            known = row.moving(known)
            old = row.at(self.at.arrays), row.at(self.at.arrays, self.low)
            ended = row.at(self.array(ENDED)), row.at(self.array(ENDED), self.low)
            new = self.sums.sum(f, old, (integral, zero))
            self.put(row, self.choice(known, new, ended), self.array(ENDED))
            row.put(f.select(size < ENDLESS, size, zero), self.array(ALLOWED))
            row.put(f.select(known, one, zero), self.array(KNOWN))
        self.go(part.end)

    def lose(self, part: Part, blind: Bit, noisy: Bit, unproven: Bit) -> Bit:
        """Integrals become nan here if the integrand is too steep to be passed over, if it is not finite
        beyond and not evaluated further away (``blind``), if it is far from its predicted value at the
        shortest part (``noisy``), or if it is ``unproven``. Returns whether to evaluate it further away."""
        f, own, ended = self.f, self.own, self.array(ENDED)
        conditions = part.short, part.steep, blind, noisy, unproven
        short, steep, last, lax, unknown = (f.splat(one, own.lanes) for one in conditions)
        h, none = own.wide(f, part.h[0]), f.splat(Real(f, NAN, 1), own.lanes)
        unseen = f.variable(f.never(own.lanes))
        with own.velocities(f) as row:
            found, allowed = self.rate(row)[0], row.at(self.array(ALLOWED))
            both, old = f.magnitude(found) + allowed, row.at(self.at.arrays)
            little, finite = both * h <= f.magnitude(old) * self.bounds.almost, both < ENDLESS
            apart = f.magnitude(found - row.at(self.array(RATES)))
            wrong = lax & ~short & apart.compared("ugt", allowed * NOISY)
            strange = short & ~row.at(self.array(KNOWN)).equals(1.0)
            steeply = (~finite & last) | (finite & steep & ~little)
            lost = row.moving(wrong | (short & unknown) | (strange & steeply))
            row.put(f.select(lost, none, row.at(ended)), ended)
            unseen.set(unseen.get() | row.moving(strange & ~finite & ~last & old.equals(old)))
        return own.of_motions(f, unseen.get())

    def accepted(self) -> Bit:
        """Whether the series at the end of a part agree with what was expected."""
        f, zero = self.f, self.f.constant(0.0)
        given = self.array(RATES), self.array(ALLOWED), zero, f.constant(1.0), Bit(f, "false"), zero
        low = (self.array(LOW_RATES), f.constant(1.0) / self.units.part.get()) if self.sums.beyond else ()
        return f.call(Bit, "integrals_accepted", self.at.there, *given, *low, self.array(ENDED))

    def accept(self, good: Bit) -> None:
        """Go on with the integrals at the end of a part."""
        ended = self.array(ENDED)
        with self.f.when(good), self.own.velocities(self.f) as row:
            self.put(row, (row.at(ended), row.at(ended, self.low)), self.at.arrays)

    def give(self, state: Pointer, third: int, whole: Bit) -> None:
        """The integrals of all parts as those of the state; no numbers where the parts are not the whole
        step. Third parts, if there are any, become 0."""
        f, none = self.f, self.f.splat(Real(self.f, NAN, 1), self.own.lanes)
        with self.own.velocities(f) as row:
            value = row.at(self.at.arrays), row.at(self.at.arrays, self.low)
            every = row.moving(f.splat(Bit(f, "true", 1), self.own.lanes))
            self.put(row, self.choice(whole, value, (none, none)), state, every)
            if third:
                row.put(f.constant(0.0), state, third)

    def lose_samples(self, index: Variable[Integer], last: Integer) -> None:
        """Samples from ``index`` to before ``last`` are nan: the parts have not reached them."""
        f, (first, count) = self.f, self.own.followed
        none = Real(f, NAN, 1)
        with f.section() as done, f.forever() as rounds:
            with f.when(index.get() >= last):
                done.leave()
            with f.loop(first, first + count, tested=False) as i:
                place = i * Integer(f, "%stride") + index.get()
                f.store(none, "%out", place)
                if self.sums.beyond:
                    f.store(none, "%out", place + Integer(f, "%beyond"))
            index.set(index.get() + 1)
            rounds.go_on()

    def sample(self, part: Part, dt: Pair, index: Integer) -> None:
        """One sample: rows of ``%out`` are ``%stride`` apart, low parts ``%beyond`` behind."""
        f, (first, count) = self.f, self.own.followed
        one, h = replace(self.own, lanes=1, together=1), difference(dt, part.start)
        with f.loop(first, first + count, tested=False) as i:
            high, low = self.integral(Row(one, f, i), part, h)
            place = i * Integer(f, "%stride") + index
            f.store(high, "%out", place)
            if self.sums.beyond:
                f.store(low, "%out", place + Integer(f, "%beyond"))

    def samples(
        self, index: Variable[Integer], last: Integer, part: Part, since: Callable[[Real], Pair]
    ) -> Integer:
        """Write the samples of a part from ``index`` to before ``last``, at times ``since`` the beginning of
        the step: the first one beyond."""
        f, reached = self.f, self.f.variable(index.get())
        with f.section() as done, f.forever() as rounds:
            with f.when(reached.get() >= last):
                done.leave()
            dt = since(f.load("%times", reached.get()))
            with f.when(~((difference(dt, part.end)[0] <= 0.0) | part.last)):
                done.leave()
            self.sample(part, dt, reached.get())
            reached.set(reached.get() + 1)
            rounds.go_on()
        return reached.get()

    # parts

    def choice(self, where: Bit, yes: Pair, no: Pair) -> Pair:
        """One number or the other."""
        return self.f.select(where, yes[0], no[0]), self.f.select(where, yes[1], no[1])

    def asked(self, left: Real, place: Pair) -> Real:
        """The length that the integrals' series ask for at a place, at most what is left of the step."""
        return self.f.call(Real, "integral_length", self.at.arrays, self.at.there, left)

    def proven(self, length: Real, least: Real, free: Bit, place: Pair) -> Real:
        """A length, or as much of it as is proven, unless it is negligible. Close to a kink (not ``free``)
        parts are accepted only."""
        if self.prove is None:
            return length
        f, found = self.f, self.f.variable(length)
        with f.when(free), f.section() as sound, f.forever() as rounds:
            with f.when(self.prove(place, found.get())):
                sound.leave()
            found.set(found.get() * SHORTER)
            rounds.repeat(found.get() > least)
        return found.get()

    def divide(
        self, t: Real, step: Pair, samples: Callable[[Part], Integer], index: Variable[Integer]
    ) -> Bit:
        """The loop over the parts of a ``step`` at about ``t``; ``samples`` are written up to an ``index``
        that is kept if the part is good. Whether the end of the step was reached."""
        f, bounds = self.f, self.bounds
        zero, one = f.constant(0.0), f.constant(1.0)
        reached, beyond, gap, usual, last, repeats = (f.variable(zero) for _ in range(6))
        stretch, push, count = f.variable(one), f.variable(one), f.variable(f.count(0))
        self.begin()
        self.go((zero, zero))
        with f.forever() as rounds:
            tau = reached.get(), beyond.get()
            near, left = gap.get() > 0.0, difference(step, tau)
            asked = self.asked(left[0], tau)
            usual.set(f.larger(asked, usual.get() * LAG))
            resolved = ((f.magnitude(t) + tau[0]) * bounds.ulp + step[0] * bounds.grain) * stretch.get()
            crowded, noisy = resolved * CROWDED, repeats.get() >= REPEATS
            provable = asked > (f.magnitude(t) + tau[0]) * self.provable
            own = self.proven(asked, crowded, ~near & provable, tau)
            begins, edge = tau[0].equals(0.0), f.larger(crowded * EDGE, step[0] * self.edge)
            steep = (own < left[0]) & ((own <= crowded) | (left[0] <= edge))
            near = near & ~(steep & (left[0] <= edge))
            blind = (asked > crowded * SINGULAR) & provable if self.prove else f.never(1)
            unproven = ~near & (own <= crowded) & (own < left[0]) & blind
            at_gap = near & (gap.get() <= resolved) & ~noisy
            half = gap.get() * 0.5
            halved = f.larger(f.smaller(own, half), f.smaller(half, step[0] * CLOSE))
            wanted = f.select(near & ~noisy, halved, own)
            pushed = f.select(left[0] <= edge, left[0], crowded * push.get())
            wanted = f.select(steep & ~near, f.select(begins, edge, pushed), wanted)
            wanted = f.select(at_gap, f.larger(gap.get(), resolved), wanted)
            short, tired = at_gap | (steep & ~near), f.never(1)
            if self.tires:
                tired = count.get() >= PATIENT
                wanted, short = f.select(tired, step[0] * EVEN, wanted), short & ~tired
            ends = wanted >= left[0]
            h, end = self.choice(ends, left, (wanted, zero)), self.choice(ends, step, moved_on(tau, wanted))
            part = Part(tau, end, h, short, steep, ends)
            self.add(part, usual.get(), f.magnitude(t))
            sampled = samples(part)
            self.go(part.end)
            room = f.select(begins, left[0] - h[0], tau[0])
            with f.when(short & steep & (begins | ends) & (room > h[0] * FARTHER**3)):
                self.follow_powers(part)
            unseen = self.lose(part, stretch.get() >= STRETCHES, noisy & ~tired, unproven)
            good = (self.accepted() | short | noisy | tired) & ~unseen
            less = f.larger(push.get() * 0.5, one)
            push.set(f.select(short, f.select(steep, push.get() * 2.0, push.get()), less))
            stretch.set(f.select(unseen, stretch.get() * 2.0, one))
            self.accept(good)
            index.set(f.select(good, sampled, index.get()))
            for variable, after, old in zip((reached, beyond), part.end, tau):
                variable.set(f.select(good, after, old))
            again, stuck = (tau[0] - last.get()) <= step[0] * NEARBY, short & ~steep
            repeats.set(f.select(stuck, f.select(again, repeats.get() + 1.0, zero), repeats.get()))
            last.set(f.select(stuck, tau[0], last.get()))
            rest = f.select(near & ~short, f.larger(gap.get() - h[0], zero), zero)
            gap.set(f.select(good, rest, f.select(unseen, h[0] * 2.0, h[0])))
            with f.when(~good):
                self.go((reached.get(), beyond.get()))
            count.set(count.get() + 1)
            missing = difference(step, (reached.get(), beyond.get()))[0] > 0.0
            rounds.repeat(missing & (count.get() < MOST) & ~self.halted())
        return difference(step, (reached.get(), beyond.get()))[0] <= 0.0
