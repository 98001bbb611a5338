"""Quadratures (action, ledgers) within a step of the motion, divided where their series ask for less.

The motion decides on its steps without them. Within a step it is known, by the step's polynomials. Where an
integrand changes faster than these, or where the next series does not confirm what was expected of it, the
step is divided: the series are expanded anew at places of the step, and the integrals of each part are added.
A part ends where the rule for steps says (``step_size``), and every part is confirmed by the series at its
end (``acceptance``). A jump or a kink of an integrand is approached by halving, and passed; across a pole an
integral is not a number. The motion itself stays the same to the last bit.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import TypeVar

from lagrange_cli.native.llvm.function import Function, Variable
from lagrange_cli.native.llvm.vector import Bit, Integer, Pointer, Real, constant
from lagrange_cli.native.numbers.error_free import operators_fast_sum as fast_sum
from lagrange_cli.native.numbers.error_free import operators_two_sum as two_sum
from lagrange_cli.native.state import GuardRows, StateLayout
from lagrange_cli.native.stepping.acceptance import Bounds, allowance
from lagrange_cli.native.stepping.lengths import Lengths, Row
from lagrange_cli.native.stepping.polynomial import careful_sum, polynomial, rate
from lagrange_cli.native.stepping.step_size import ENDLESS, LARGEST_GUESS, StepSize
from lagrange_cli.records import dataclass, replace

ENOUGH = 4.0
"""A step is divided if the last terms of a series exceed so many times the tolerance."""
ROUNDS = 16
"""How often a step is computed at most until sizes are measured over about its length."""
LAG = 0.7
"""The factor by which the usual length of parts may shrink from one to the next."""
REPEATS, NOISY = 12.0, 2.0**16
"""If so many parts in a row are not confirmed however short they are, rounding is the cause, and so much more
is allowed; what is not confirmed then is lost."""
CROWDED = 2.0**6
"""Parts so many times as long as the resolution of time are too short for a series."""
CLOSE = 2.0**-16
"""Parts of a step so short, close to a kink, need not be as short as the series ask for: rounding errors make
these short there, and what is expected at the end of a part is sound if it is confirmed."""
SHORTER = 0.7
"""A part that is not proven is tried again so many times as long."""
NEARBY = 2.0**-30
"""Parts of a step that begin within this of each other are at the same place."""
STRETCHES = 16.0
"""If an integrand is not finite beyond such a part, it is looked at so many times as far away."""
MOST = 2**18
"""Parts of one step."""
NAN = "0x7FF8000000000000"
T = TypeVar("T")
Time = tuple[Real, Real]
"""A time with its low part."""


def followed(state: StateLayout, guards: GuardRows | None) -> tuple[int, int]:
    """The first row of quadratures that have a say, and how many there are: not those of guards' arguments,
    which come first."""
    before = guards.arguments if guards else 0
    return state.integrals.start + before, state.quadratures - before


@dataclass(frozen=True)
class Places:
    """The state at the beginning of a step and the series there; the arrays that the parts of the step take,
    and the series of a part.

    The arrays (``interface.ARRAYS``) are the state within the step and that at the end of a part, with low
    parts; the rates expected there, how far off they may be, and their low parts.
    """

    begin: Pointer
    work: Pointer
    parts: Pointer
    there: Pointer


@dataclass(frozen=True)
class Part:
    """A part of a step: from ``start`` to ``end``, ``h`` long.

    It may be so ``short`` that the integrand is taken to be constant, and so because the integrand is
    ``steep`` there; it may be the ``last`` one.
    """

    start: Time
    end: Time
    h: Time
    short: Bit
    steep: Bit
    last: Bit


def sampling(
    f: Function,
    index: Variable[Integer],
    last: Integer,
    since: Callable[[Real], T],
    within: Callable[[T, Part], Bit],
    write: Callable[[Part, T, Integer], None],
) -> Callable[[Part], Callable[[Bit], None]]:
    """What samples a part: it writes those from ``index`` to before ``last`` that are ``within`` it, at the
    times ``since`` the beginning of the step, and returns what keeps them if the part is good."""

    def sample(part: Part) -> Callable[[Bit], None]:
        reached = f.variable(index.get())
        with f.section() as done, f.forever() as rounds:
            with f.when(reached.get() >= last):
                done.leave()
            dt = since(f.load("%times", reached.get()))
            with f.when(~(within(dt, part) | part.last)):
                done.leave()
            write(part, dt, reached.get())
            reached.set(reached.get() + 1)
            rounds.go_on()
        return lambda good: index.set(f.select(good, reached.get(), index.get()))

    return sample


class Quadratures:
    """Writes what the quadratures of a motion take: ``count`` rows of ``lengths`` from ``first`` on.

    In the state low parts are ``low`` rows behind.
    """

    def __init__(
        self, lengths: Lengths, first: int, count: int, low: int, tolerance: float, bounds: Bounds,
        *, fades: bool = True, rest: float = 0.0,
    ) -> None:  # fmt: skip
        self.lengths, self.bounds, self.low, self.tolerance = lengths, bounds, low, tolerance
        self.own = replace(lengths, followed=(first, count), apart=True)
        self.sizes = StepSize(self.own, tolerance, rest, fades=fades, prefix="integral_")
        self._chains = 4 if lengths.together > 1 else 1

    @property
    def alone(self) -> bool:
        """Whether series may be cut where higher coefficients are not finite."""
        return self.lengths.motions == 1

    def functions(self) -> list[Function]:
        """What its instructions call."""
        shortened = [self.sizes.shortened_step()] if self.alone else []
        return [*self.sizes.functions(), *shortened, self.length(), self.rough(), self.confirmed()]

    def function(self, head: str) -> Function:
        """One that takes or gives numbers of each motion."""
        motions = self.lengths.motions
        for name, type in (("REAL", "double"), ("BIT", "i1")):
            head = head.replace(name, type if motions == 1 else f"<{motions} x {type}>")
        return Function(head, motions)

    def flag(self, f: Function, value: str) -> Bit:
        """A condition for every row of a vector."""
        return Bit(f, constant("i1", self.lengths.lanes, value), self.lengths.lanes)

    def of_motions(self, f: Function, rows: Bit) -> Bit:
        """Of each motion whether something holds for any row of a vector."""
        return rows if self.lengths.together == 1 else f.any(rows)

    def length(self) -> Function:
        """``@integral_length(state, work, over)``: the step that the integrals' series ask for, at most
        ``over``; 0 where too few coefficients are finite."""
        f = self.function("define internal REAL @integral_length(ptr %state, ptr %work, REAL %over) #0")
        over, one = f.smaller(Real(f, "%over"), f.constant(LARGEST_GUESS)), f.constant(1.0)
        places = f.pointer("%state"), f.pointer("%work")
        h, met = f.variable(over), f.variable(one)
        with f.section() as settled, f.loop(0, ROUNDS, tested=False):
            before = h.get()
            found, total = f.parts("integral_step_size", [one, one], *places, before)
            h.set(f.smaller(found, over))
            met.set(total)
            with f.when(~f.any((h.get() < before * 0.5) | (h.get() > before * 2.0))):
                settled.leave()
        finite = met.get() < ENDLESS
        if self.alone:
            with f.when(~finite):
                fewer = f.call(Real, "integral_shortened_step", *places, h.get())
                h.set(f.smaller(fewer, over))
            f.give(h.get())
        else:
            f.give(f.select(finite, h.get(), f.constant(0.0)))
        return f

    def rough(self) -> Function:
        """``@rough(state, work, h)``: whether the last terms of an integral's series over ``h`` matter, or
        are not finite."""
        f = self.function("define internal BIT @rough(ptr %state, ptr %work, REAL %h) #0")
        lengths, top, h = self.own, self.own.top, Real(f, "%h")
        wide, least = lengths.wide(f, h), lengths.wide(f, f.constant(ENOUGH * self.tolerance))
        powers, rest = {1: h}, top - 1
        while 2 * max(powers) <= rest:
            powers[2 * max(powers)] = powers[max(powers)] * powers[max(powers)]
        halves, total = [f.constant(1.0), f.constant(1.0)], 0
        for exponent in sorted(powers, reverse=True):  # two factors: their product may overflow
            if total + exponent <= rest:
                halves[total > 0] = halves[total > 0] * powers[exponent]
                total += exponent
        first, second = (lengths.wide(f, one) for one in halves)
        bad, zero = f.variable(self.flag(f, "false")), f.zero(lengths.lanes)
        with lengths.velocities(f) as row:
            c = row.series()
            last = f.magnitude(c[top]) * wide + f.magnitude(c[top - 1])
            last = f.select(last.equals(zero), zero, (last * first) * second)
            size = self.sizes.sizes(row, c, wide)
            bad.set(bad.get() | (self.sizes.heard(row) & ~(last <= size * least)))
        f.give(self.of_motions(f, bad.get()))
        return f

    def confirmed(self) -> Function:
        """``@integrals_confirmed(work, rates, allowed, integrals, nothing)``: whether the integrands are
        those expected, but for integrals that are no numbers. They may be off by ``nothing`` more."""
        given = ", ".join(f"ptr %{name}" for name in ("work", "rates", "allowed", "integrals"))
        f = self.function(f"define internal BIT @integrals_confirmed({given}, REAL %nothing) #0")
        nothing = self.own.wide(f, Real(f, "%nothing"))
        bad = f.variable(self.flag(f, "false"))
        with self.own.velocities(f) as row:
            apart = f.magnitude(row.at("%rates") - row.series()[1])
            off = apart.compared("ugt", row.at("%allowed") + nothing)
            new = row.at("%integrals")
            bad.set(bad.get() | row.moving(off & new.equals(new)))
        f.give(~self.of_motions(f, bad.get()))
        return f

    def array(self, f: Function, at: Places, number: int) -> Pointer:
        """One of the arrays."""
        place = number * self.lengths.width * self.lengths.value
        return f.place(at.parts, place, "double") if place else at.parts

    def keep(self, f: Function, row: Row, where: Bit, new: tuple[Real, Real], to: Pointer) -> None:
        """Change numbers of a row and their low parts where that holds."""
        for shift, value in zip((0, self.low), new):
            row.put(f.select(where, value, row.at(to, shift)), to, shift)

    def begin(self, f: Function, at: Places) -> None:
        """All parts begin with the integrals that the step begins with."""
        with self.lengths.each(f) as row:
            for shift in (0, self.low):
                row.put(row.at(at.begin, shift), at.parts, shift)

    def go(self, f: Function, at: Places, place: Time) -> None:
        """The motion at a place of the step; the integrals stay as they are."""
        lengths, h = self.lengths, self.lengths.wide(f, place[0])
        with lengths.each(f) as row:
            c, is_place = row.series(at.work).terms(1, lengths.order), row.among(0, lengths.degrees)
            change, rest = careful_sum(f, c, h, self._chains)
            old, lost = row.at(at.begin), row.at(at.begin, self.low)
            extra = row.only(is_place, row.at(at.begin, self.low + lengths.degrees) * h)
            moves = self.spread(f, ~row.among(*self.own.leading))
            self.keep(f, row, moves, two_sum(old, change + ((lost + extra) + rest)), at.parts)

    def spread(self, f: Function, which: Bit) -> Bit:
        """A condition of rows, for every lane."""
        return f.splat(which, self.lengths.lanes) if which.lanes != self.lengths.lanes else which

    def add(self, f: Function, at: Places, part: Part, usual: Real, t: Real) -> None:
        """The integrals at the end of a part, and what is expected of the integrands there."""
        own, ended = self.own, self.array(f, at, 2)
        h, short = own.wide(f, part.h[0]), self.spread(f, part.short)
        zero = f.zero(own.lanes)
        allowed = allowance(f, self.bounds, t, usual, part.h[0])
        with own.velocities(f) as row:
            c = row.series(at.there).terms(1, own.top)
            change, rest = careful_sum(f, c, h, self._chains)
            slope = self.known(f, c[0])
            change, rest = f.select(short, slope * h, change), f.select(short, zero, rest)
            old, lost = row.at(at.parts), row.at(at.parts, self.low)
            new, error = two_sum(old, change + (lost + rest))
            row.put(new, ended)
            row.put(error, ended, self.low)
            speed, lesser = rate(f, c, h, self._chains), f.smaller(f.magnitude(new), f.magnitude(old))
            most = allowed.of(f, own, f.magnitude(speed) + f.magnitude(c[0]), lesser)
            most = most + own.wide(f, self.nothing(f, part.h[0]))
            row.put(speed, self.array(f, at, 4))
            row.put(f.select(short, f.magnitude(slope), most), self.array(f, at, 5))

    def nothing(self, f: Function, h: Real) -> Real:
        """How far off an integrand may be in any case: where it is proven, what it is next to nothing of
        before a pulse does not matter."""
        if not self.sizes.rest:
            return f.constant(0.0)
        return f.constant(self.bounds.nothing_much) / (h * f.larger(h, f.constant(1.0)))

    def known(self, f: Function, rate: Real) -> Real:
        """A rate, or 0 where it is not finite: what lies beyond tells whether it may be."""
        return f.select(f.magnitude(rate) < ENDLESS, rate, f.zero(rate.lanes))

    def lose(self, f: Function, at: Places, part: Part, blind: Bit, noisy: Bit, unproven: Bit) -> Bit:
        """Integrals of what is too steep to be passed over are no numbers from here on, nor are those of what
        is not finite beyond, if that is not looked for further away (``blind``), or far from what was
        expected although nothing else is left (``noisy``), or ``unproven``. Whether it is to be looked
        for."""
        own, ended = self.own, self.array(f, at, 2)
        h, conditions = own.wide(f, part.h[0]), self.wide(f, part.short, part.steep, blind, noisy, unproven)
        short, steep, last, lax, unknown = conditions
        none = f.splat(Real(f, NAN, 1), own.lanes)
        unseen = f.variable(self.flag(f, "false"))
        with own.velocities(f) as row:
            found, allowed = self.rate(f, row, at), row.at(self.array(f, at, 5))
            both, old = f.magnitude(found) + allowed, row.at(at.parts)
            little, finite = both * h <= f.magnitude(old) * self.bounds.almost, both < ENDLESS
            apart = f.magnitude(found - row.at(self.array(f, at, 4)))
            wrong = lax & ~short & apart.compared("ugt", allowed * NOISY)
            lost = row.moving(wrong | (short & (unknown | (~finite & last) | (finite & steep & ~little))))
            row.put(f.select(lost, none, row.at(ended)), ended)
            unseen.set(unseen.get() | row.moving(short & ~finite & ~last & old.equals(old)))
        return self.of_motions(f, unseen.get())

    def wide(self, f: Function, *conditions: Bit) -> list[Bit]:
        """Conditions for every row of a vector."""
        return [self.spread(f, one) for one in conditions]

    def rate(self, f: Function, row: Row, at: Places) -> Real:
        """What integrands are at the beginning of a part."""
        return row.series(at.there)[1]

    def accept(self, f: Function, at: Places, good: Bit) -> None:
        """Go on with the integrals at the end of a part."""
        ended, wide = self.array(f, at, 2), self.spread(f, good)
        with self.own.velocities(f) as row:
            self.keep(f, row, wide, (row.at(ended), row.at(ended, self.low)), at.parts)

    def give(self, f: Function, at: Places, state: Pointer, live: Bit, whole: Bit) -> None:
        """The integrals of all parts as those of the state; no numbers where the parts are not the whole
        step."""
        wide, known = self.spread(f, live), self.spread(f, whole)
        none = f.splat(Real(f, NAN, 1), self.own.lanes)
        with self.own.velocities(f) as row:
            high, low = (f.select(known, row.at(at.parts, shift), none) for shift in (0, self.low))
            self.keep(f, row, row.moving(wide), (high, low), state)

    def value(self, f: Function, row: Row, at: Places, part: Part, dt: Real) -> Real:
        """Integrals at ``dt`` within a part."""
        c = row.series(at.there).terms(1, row.lengths.top)
        within = row.lengths.wide(f, dt - part.start[0])
        short = (
            f.splat(part.short, row.lengths.lanes) if row.lengths.lanes != part.short.lanes else part.short
        )
        change = f.select(short, self.known(f, c[0]) * within, polynomial(f, c, within) * within)
        return row.at(at.parts) + (change + row.at(at.parts, self.low))

    def sample(self, f: Function, at: Places, part: Part, dt: Real, index: Integer) -> None:
        """One sample of a motion alone: rows of ``%out`` are ``%stride`` apart."""
        one, (first, count) = replace(self.own, lanes=1, together=1), self.own.followed
        with f.loop(first, first + count, tested=False) as i:
            value = self.value(f, Row(one, f, i), at, part, dt)
            f.store(value, "%out", i * Integer(f, "%stride") + index)

    def proven(self, f: Function, length: Real, least: Real, free: Bit, prove: Callable[[Real], Bit]) -> Real:
        """A length, or as much of it as is proven, but for what is hardly more than nothing. Close to a
        kink (not ``free``) parts are confirmed only."""
        found = f.variable(length)
        with f.when(free), f.section() as sound, f.forever() as rounds:
            with f.when(prove(found.get())):
                sound.leave()
            found.set(found.get() * SHORTER)
            rounds.repeat(found.get() > least)
        return found.get()

    def choice(self, f: Function, where: Bit, yes: Time, no: Time) -> Time:
        """One time or the other."""
        return f.select(where, yes[0], no[0]), f.select(where, yes[1], no[1])

    def asked(self, f: Function, at: Places, left: Real) -> Real:
        """The length that the integrals' series ask for, at most what is left of the step."""
        return f.call(Real, "integral_length", at.parts, at.there, left)

    def confirm(self, f: Function, at: Places) -> Bit:
        """Whether the series at the end of a part confirm what was expected."""
        arrays = (self.array(f, at, number) for number in (4, 5, 2))
        return f.call(Bit, "integrals_confirmed", at.there, *arrays, f.constant(0.0))

    def divide(
        self,
        f: Function,
        at: Places,
        t: Real,
        step: Time,
        live: Bit,
        expand: Callable[[Time], None],
        sample: Callable[[Part], Callable[[Bit], None]],
        prove: Callable[[Time, Real], Bit] | None = None,
    ) -> Bit:
        """Write the loop over the parts of a ``step`` at about ``t``, of motions that are ``live``.

        ``expand`` is to compute the series at a place of the step, where the state is already; ``sample`` to
        give the integrals of samples within a part, and what is to be done if that is confirmed; ``prove``
        whether integrands have nothing to hide within some length of a place. It returns whether the end of
        the step was reached.
        """
        zero, one = f.constant(0.0), f.constant(1.0)
        reached, beyond, gap, usual, last, repeats = (f.variable(zero) for _ in range(6))
        stretch, push = f.variable(one), f.variable(one)
        count, bounds = f.variable(f.count(0)), self.bounds
        self.begin(f, at)

        def go(place: Time) -> None:
            self.go(f, at, place)
            expand(place)

        go((zero, zero))
        with f.forever() as rounds:
            tau = reached.get(), beyond.get()
            near, left = gap.get() > 0.0, difference(step, tau)
            active = live & (left[0] > 0.0)
            own = self.asked(f, at, left[0])
            usual.set(f.larger(own, usual.get() * LAG))
            resolved = ((f.magnitude(t) + tau[0]) * bounds.ulp + step[0] * bounds.grain) * stretch.get()
            crowded, noisy = resolved * CROWDED, repeats.get() >= REPEATS
            unproven = f.variable(Bit(f, constant("i1", f.lanes, "false"), f.lanes))
            if prove is not None:
                own = self.proven(f, own, crowded, ~near, partial(prove, tau))
                unproven.set(~near & (own <= crowded) & (own < left[0]))
            steep = (own <= crowded) & (own < left[0])
            at_gap = near & (gap.get() <= resolved) & ~noisy
            half = gap.get() * 0.5
            halved = f.larger(f.smaller(own, half), f.smaller(half, step[0] * CLOSE))
            wanted = f.select(near & ~noisy, halved, own)
            wanted = f.select(steep & ~near, crowded * push.get(), wanted)
            wanted = f.select(at_gap, f.larger(gap.get(), resolved), wanted)
            short = (at_gap | (steep & ~near)) & active
            ends = wanted >= left[0]
            h = self.choice(f, active, self.choice(f, ends, left, (wanted, zero)), (zero, zero))
            end = self.choice(f, active, self.choice(f, ends, step, total(tau, wanted)), tau)
            part = Part(tau, end, h, short, steep, ends)
            self.add(f, at, part, usual.get(), f.magnitude(t))
            kept = sample(part)
            go(part.end)
            unseen = self.lose(f, at, part, stretch.get() >= STRETCHES, noisy, unproven.get())
            good = (self.confirm(f, at) | short | noisy) & ~unseen
            less = f.larger(push.get() * 0.5, one)
            push.set(f.select(short, f.select(steep, push.get() * 2.0, push.get()), less))
            stretch.set(f.select(unseen, stretch.get() * 2.0, one))
            self.accept(f, at, good & active)
            kept(good & active)
            for variable, after, old in zip((reached, beyond), part.end, tau):
                variable.set(f.select(good, after, old))
            again, stuck = (tau[0] - last.get()) <= step[0] * NEARBY, short & ~steep
            repeats.set(f.select(stuck, f.select(again, repeats.get() + 1.0, zero), repeats.get()))
            last.set(f.select(stuck, tau[0], last.get()))
            rest = f.select(near & ~short, f.larger(gap.get() - h[0], zero), zero)
            gap.set(f.select(good, rest, f.select(unseen, h[0] * 2.0, h[0])))
            with f.when(f.any(active & ~good)):
                go((reached.get(), beyond.get()))
            count.set(count.get() + 1)
            missing = difference(step, (reached.get(), beyond.get()))[0] > 0.0
            rounds.repeat(f.any(live & missing) & (count.get() < MOST))
        return difference(step, (reached.get(), beyond.get()))[0] <= 0.0


def difference(a: Time, b: Time) -> Time:
    """a - b"""
    high, low = two_sum(a[0], -b[0])
    return fast_sum(high, low + (a[1] - b[1]))


def total(a: Time, b: Real) -> Time:
    """a + b"""
    high, low = two_sum(a[0], b)
    return fast_sum(high, low + a[1])
