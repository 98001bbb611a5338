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

from lagrange_cli.native.llvm.flow import Variable
from lagrange_cli.native.llvm.vector import Bit, Integer, Real
from lagrange_cli.native.stepping.parts import ALLOWED, ENDED, KNOWN, NAN, RATES, StepPart, StepParts, choice
from lagrange_cli.native.stepping.rounding_errors import learn_rounding, measure_later, measure_rounding
from lagrange_cli.native.stepping.step_size import ENDLESS
from lagrange_cli.native.stepping.sums import HighLow, difference, moved_on

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
CROSSED, UNRELATED = 8.0, 2.0**-8
"""Where so many places of one step were crossed in the shortest parts, and the next part is not accepted
either though it is shorter than this part of what the series ask for, integrands are off by rounding
(``learn_rounding``)."""
FADED = 2.0**-20
"""The part of an integral that an integrand would add in the whole step, where it is next to nothing."""
SHORTER = 0.7
"""A part that is not proven is tried again so many times as long."""
NEARBY = 2.0**-30
"""Parts of a step that begin within this of each other are at the same place."""
EDGE = 16.0
"""A power law is followed over so many times the length of the shortest part with a series."""
ROOM = 128.0
"""Steps are so many times as long, so that the law is looked at within them."""
STRETCHES = 16.0
"""If an integrand is not finite beyond such a part, it is evaluated so many times as far away."""
MOST = 2**18
"""Parts of one step. These may take minutes, so that each checks whether to go on (``halted``)."""
PATIENT, EVEN = 48, 1 / 16
"""Where a part of a step is not accepted, rounding errors of the integrands are measured, and again after so
many parts (``rounding_errors``). Beside constraints, where they are larger, parts are of this length after so
many, and need not be accepted: what may hide is proven, and not divided so."""


class Division:
    """Writes the loop over the ``parts`` of a step.

    ``prove`` tells whether integrands have nothing to hide within some length of a place of the step.
    """

    edge = 2.0**-30
    """A power law is not followed over less than this part of a step: coefficients of its series would
    overflow."""

    provable = 0.0
    """Parts up to this part of the time are too short for proofs, in which time is a double."""

    def __init__(
        self, parts: StepParts, prove: Callable[[HighLow, Real], Bit] | None, halted: Callable[[], Bit],
        *, tires: bool = False,
    ) -> None:  # fmt: skip
        self.f, self.parts, self.prove, self.halted = parts.f, parts, prove, halted
        self.tires = tires and prove is None

    def asked(self, left: Real, place: HighLow) -> Real:
        """The length that the integrals' series ask for at a place, at most what is left of the step."""
        self.parts.quadratures.measure(self.f, self.parts.at.arrays, self.parts.at.there, left)
        return self.f.call(Real, "integral_length", self.parts.at.arrays, self.parts.at.there, left)

    def proven(self, length: Real, least: Real, free: Bit, place: HighLow) -> Real:
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
        self, t: Real, step: HighLow, samples: Callable[[StepPart], Integer], index: Variable[Integer]
    ) -> tuple[Bit, Bit]:
        """The loop over the parts of a ``step`` at about ``t``; ``samples`` are written up to an ``index``
        that is kept if the part is good. Whether the end of the step was reached, and whether rounding, once
        it was measured, explains why parts were not accepted before."""
        f, parts, bounds = self.f, self.parts, self.parts.bounds
        zero, one = f.constant(0.0), f.constant(1.0)
        reached, beyond, gap, usual, last, repeats, crossed = (f.variable(zero) for _ in range(7))
        stretch, push, count = f.variable(one), f.variable(one), f.variable(f.count(0))
        refused, since = f.variable(f.never(1)), f.variable(f.count(PATIENT))
        unexplained = f.variable(f.never(1))
        parts.begin()
        parts.go((zero, zero))
        with f.forever() as rounds:
            tau = reached.get(), beyond.get()
            left = difference(step, tau)
            with f.when(refused.get() & (since.get() >= PATIENT)):
                measure_rounding(parts, tau)
                ended = moved_on(tau, f.smaller(gap.get(), left[0]))  # what is at rest here may move there
                parts.go(ended)
                measure_rounding(parts, ended)
                measure_later(parts, step)
                parts.go(tau)
                since.set(f.count(0))
                gap.set(zero)
            near = gap.get() > 0.0
            asked = self.asked(left[0], tau)
            usual.set(f.larger(asked, usual.get() * LAG))
            resolved = ((f.magnitude(t) + tau[0]) * bounds.ulp + step[0] * bounds.grain) * stretch.get()
            crowded, noisy = resolved * CROWDED, repeats.get() >= REPEATS
            provable = asked > (f.magnitude(t) + tau[0]) * self.provable
            own = self.proven(asked, crowded, ~near & provable, tau)
            begins, edge = tau[0].equals(0.0), f.larger(crowded * EDGE, step[0] * self.edge)
            edge = f.smaller(edge, step[0] / ROOM)  # a step as short as this may begin just beyond u = 0
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
            h, end = choice(f, ends, left, (wanted, zero)), choice(f, ends, step, moved_on(tau, wanted))
            part = StepPart(tau, end, h, short, steep, ends)
            parts.add(part, usual.get(), f.magnitude(t))
            sampled = samples(part)
            parts.go(part.end)
            room = f.select(begins, left[0] - h[0], tau[0])
            with f.when(short & steep & (begins | ends) & (room > h[0] * FARTHER**3)):
                follow_powers(parts, part, f.magnitude(t))
            blinded = stretch.get() >= STRETCHES
            unseen = self.lose(part, f.magnitude(t), blinded, noisy & ~tired, unproven)
            good = (parts.accepted() | short | noisy | tired) & ~unseen
            less = f.larger(push.get() * 0.5, one)
            push.set(f.select(short, f.select(steep, push.get() * 2.0, push.get()), less))
            stretch.set(f.select(unseen, stretch.get() * 2.0, one))
            parts.accept(good)
            refused.set(~good)
            crossed.set(f.select(at_gap & good, crossed.get() + 1.0, crossed.get()))
            with f.when(~good & (crossed.get() >= CROSSED) & (h[0] <= asked * UNRELATED)):
                learn_rounding(parts)
                crossed.set(zero)
            unexplained.set(unexplained.get() | (~good & (since.get() < PATIENT)))
            index.set(f.select(good, sampled, index.get()))
            for variable, after, old in zip((reached, beyond), part.end, tau):
                variable.set(f.select(good, after, old))
            again, stuck = (tau[0] - last.get()) <= step[0] * NEARBY, short & ~steep
            repeats.set(f.select(stuck, f.select(again, repeats.get() + 1.0, zero), repeats.get()))
            last.set(f.select(stuck, tau[0], last.get()))
            rest = f.select(near & ~short, f.larger(gap.get() - h[0], zero), zero)
            gap.set(f.select(good, rest, f.select(unseen, h[0] * 2.0, h[0])))
            with f.when(~good):
                parts.go((reached.get(), beyond.get()))
            count.set(count.get() + 1)
            since.set(since.get() + 1)
            missing = difference(step, (reached.get(), beyond.get()))[0] > 0.0
            rounds.repeat(missing & (count.get() < MOST) & ~self.halted())
        return difference(step, (reached.get(), beyond.get()))[0] <= 0.0, ~unexplained.get()

    def lose(self, part: StepPart, t: Real, blind: Bit, noisy: Bit, unproven: Bit) -> Bit:
        """Integrals become nan here if the integrand is too steep to be passed over, if it is not finite
        beyond and not evaluated further away (``blind``), if it is far from its predicted value at the
        shortest part (``noisy``), or if it is ``unproven`` there, and no power law either. Returns whether to
        evaluate it further away."""
        f, parts = self.f, self.parts
        own, ended = parts.own, parts.array(ENDED)
        conditions = part.short, part.steep, blind, noisy, unproven, part.last
        short, steep, last, lax, unknown, ends = (f.splat(one, own.lanes) for one in conditions)
        h, none = own.wide(f, part.h[0]), f.splat(Real(f, NAN, 1), own.lanes)
        unseen = f.variable(f.never(own.lanes))
        with own.velocities(f) as row:
            found, allowed = parts.rate(row)[0], row.at(parts.array(ALLOWED))
            both, old = f.magnitude(found) + allowed, row.at(parts.at.arrays)
            little, finite = both * h <= f.magnitude(old) * parts.bounds.almost, both < ENDLESS
            apart = f.magnitude(found - row.at(parts.array(RATES)))
            wrong = lax & ~short & apart.compared("ugt", allowed * NOISY)
            strange = short & ~row.at(parts.array(KNOWN)).equals(1.0)
            even = apart <= allowed * BENT  # as beside a root, however small the integral is by chance
            even = even | parts.slight(row, apart, allowed, h, t)
            # where a contact ends, rounding may have let u be below 0 in u^1.5, which was next to nothing
            before = f.magnitude(row.at(parts.array(RATES))) * own.wide(f, part.end[0])
            beyond = ~finite & ~(ends & (before <= f.magnitude(old) * FADED))
            steeply = (beyond & last) | (finite & steep & ~little & ~even)
            lost = row.moving(wrong | (strange & ((unknown & (finite | beyond)) | steeply)))
            row.put(f.select(lost, none, row.at(ended)), ended)
            unseen.set(unseen.get() | row.moving(strange & beyond & ~last & old.equals(old)))
        return own.of_motions(f, unseen.get())


FARTHER, WEAKEST, BENT, TERMS = 4.0, 0.264, 2.0**-10, 20
"""How many times as far away a power law is looked at; this to its exponent, below which the integral is
hardly finite; how far off the last place may be; terms of a logarithm."""
EVENLY, STEADY = 2.0**-30, 0.0625
"""A quantity that changes by at most this fraction of itself counts as constant, and by at most this one as
bounded."""


def follow_powers(parts: StepParts, part: StepPart, t: Real) -> None:
    """The integrals at the end of a short part where the step begins or ends, if integrands are a + b r^p
    at the distance r from there; these are ``KNOWN``. The series are those at the end of the part.

    With f1, f2 and f3 at r, 4 r and 16 r, q = (f3 - f2)/(f2 - f1) = 4^p, and f4 at 64 r tells whether
    that is so. The integral within r is r (f1 + (f2 - f1) p/((1 - q) (1 + p))), where log(q) = 2 z (1 +
    z^2/3 + ...) with z = (q - 1)/(q + 1). Where f1 to f4 differ by rounding, as the direction of a vector
    does that is almost 0, f1 is as good as the law.
    """
    f, own, h = parts.f, parts.own, part.h[0]
    zero, one = f.zero(own.lanes), f.splat(f.constant(1.0), own.lanes)
    begins = part.start[0].equals(0.0)
    with own.velocities(f) as row:
        row.put(f.select(begins, parts.rate(row)[0], row.at(parts.array(RATES))), parts.array(RATES))
    for times, array in zip((FARTHER, FARTHER**2, FARTHER**3), (ALLOWED, KNOWN, None)):
        away = h * (times - 1.0)
        place = f.select(begins, part.end[0] + away, part.start[0] - away)
        parts.go((place, f.constant(0.0)))
        if array is not None:
            with own.velocities(f) as row:
                row.put(parts.rate(row)[0], parts.array(array))
    with own.velocities(f) as row:
        fourth = parts.rate(row)[0]
        first, second, third = (row.at(parts.array(one)) for one in (RATES, ALLOWED, KNOWN))
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
        follows = f.magnitude((fourth - third) - (third - second) * q) <= f.magnitude(fourth - third) * BENT
        law = follows & (q > WEAKEST) & (q < ENDLESS)
        spread = f.magnitude(change)
        for other in (third, fourth):
            spread = f.larger(spread, f.magnitude(other - first))
        steady = (spread <= size * STEADY) | parts.slight(row, spread, size, own.wide(f, h), t)
        known = row.moving((size < ENDLESS) & (even | law | steady))
        integral = f.select(law & ~even, bent, first) * own.wide(f, h)
        old = row.at(parts.at.arrays), row.at(parts.at.arrays, parts.low)
        ended = row.at(parts.array(ENDED)), row.at(parts.array(ENDED), parts.low)
        new = parts.sums.sum(f, old, (integral, zero))
        parts.put(row, choice(f, known, new, ended), parts.array(ENDED))
        row.put(f.select(size < ENDLESS, size, zero), parts.array(ALLOWED))
        row.put(f.select(known, one, zero), parts.array(KNOWN))
    parts.go(part.end)
