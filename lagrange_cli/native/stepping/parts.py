"""The integrals over one part of a step of the motion: at its end, at the samples within it, and what is
expected of the integrands at its end."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import AbstractContextManager, nullcontext

from lagrange_cli.native.llvm.flow import Variable
from lagrange_cli.native.llvm.function import Function
from lagrange_cli.native.llvm.vector import Bit, Integer, Pointer, Real
from lagrange_cli.native.stepping.acceptance import allowance
from lagrange_cli.native.stepping.lengths import FollowingSeries, Row
from lagrange_cli.native.stepping.quadratures import FADING, ROUNDING, Quadratures
from lagrange_cli.native.stepping.step_size import ENDLESS
from lagrange_cli.native.stepping.sums import HighLow, Sums, difference
from lagrange_cli.records import dataclass

NAN = "0x7FF8000000000000"
ENDED, RATES, ALLOWED, LOW_RATES = 2, 4, 5, 6
KNOWN = LOW_RATES
"""The arrays of ``StepArrays`` behind the state within the step, by number; low parts of states take one
more. Of short parts the integrals that are known are marked."""
SLIGHT = 8.0
"""By so many rounding errors an integral may be off where an integrand jumps within what time resolves."""


@dataclass(frozen=True)
class StepArrays:
    """The state at the beginning of a step and the series there; the arrays that the parts of the step take,
    and the series of a part.

    The arrays (``interface.ARRAYS``) are the state within the step and that at the end of a part, with low
    parts; the rates expected there, how far off they may be, and their low parts; and rounding errors of the
    integrands, where they are known.
    """

    begin: Pointer
    work: Pointer
    arrays: Pointer
    there: Pointer


@dataclass(frozen=True)
class StepPart:
    """A part of a step: from ``start`` to ``end``, ``h`` long.

    It may be so ``short`` that the integrand is taken to be constant, and so because the integrand is
    ``steep`` there; it may be the ``last`` one.
    """

    start: HighLow
    end: HighLow
    h: HighLow
    short: Bit
    steep: Bit
    last: Bit


@dataclass
class Units:
    """Units of time: of the series of the step, and of those of its parts."""

    step: Real
    part: Variable[Real]


def choice(f: Function, where: Bit, yes: HighLow, no: HighLow) -> HighLow:
    """One number or the other."""
    return f.select(where, yes[0], no[0]), f.select(where, yes[1], no[1])


class StepParts:
    """Writes into ``f`` what is computed of a part. In the state low parts are ``low`` rows behind.

    ``expand`` is to compute the series at a place of the step, in ``units.part``, where the state is already;
    where the motion may be held, ``let_go`` has equations in which it is not, to one side or the other.
    ``round_at`` computes rounding errors of integrands there, from rates (``integrand_errors``).
    """

    def __init__(
        self, f: Function, quadratures: Quadratures, sums: Sums, at: StepArrays, low: int, units: Units,
        expand: Callable[[HighLow], None], let_go: Callable[[float], AbstractContextManager[None]] | None,
        round_at: Callable[[HighLow, Pointer, Pointer], None] | None,
    ) -> None:  # fmt: skip
        self.f, self.at, self.low, self.sums, self.units = f, at, low, sums, units
        self.lengths, self.own, self.bounds = quadratures.lengths, quadratures.own, quadratures.bounds
        self.quadratures, self.expand, self.let_go, self.round_at = quadratures, expand, let_go, round_at

    # states and arrays

    def array(self, number: int) -> Pointer:
        """One of the arrays."""
        return self.f.place(self.at.arrays, number * self.lengths.width) if number else self.at.arrays

    def put(self, row: Row, value: HighLow, to: Pointer, where: Bit | None = None) -> None:
        """Store a number and its low part, or where that holds only."""
        for shift, one in zip((0, self.low), value):
            row.put(one if where is None else self.f.select(where, one, row.at(to, shift)), to, shift)

    def begin(self) -> None:
        """All parts begin with the integrals that the step begins with."""
        with self.lengths.each(self.f) as row:
            self.put(row, (row.at(self.at.begin), row.at(self.at.begin, self.low)), self.at.arrays)
            known = self.quadratures.known
            error = row.at(self.at.begin, known) if known else self.f.zero(self.lengths.lanes)
            if self.sums.beyond:
                error = error * self.units.part.get()
            row.put(error, self.array(ROUNDING))

    def go(self, place: HighLow) -> None:
        """The motion at a place of the step, and the series there; the integrals stay as they are."""
        f, lengths, first = self.f, self.lengths, 0
        if lengths.followers:
            with f.loop(0, lengths.degrees, lengths.together, tested=False) as i:
                follower = FollowingSeries(lengths, f, i)
                self._carry(follower, place, follower.among(0, lengths.degrees))
            first = lengths.vector(lengths.degrees)
        with lengths.each(f, first) as row:
            moves = ~row.among(*self.own.leading)
            if lengths.followers:
                moves = moves & ~row.among(0, lengths.degrees)
            with f.when(moves) if lengths.together == 1 else nullcontext():
                self._carry(row, place, moves)
        self.expand(place)

    def _carry(self, row: Row, place: HighLow, moves: Bit) -> None:
        """Rows that move, at a place of the step."""
        f, at, sums = self.f, self.at, self.sums
        old = sums.state(f, row, at.begin, self.low, self.lengths.wide(f, place[0]))
        change = sums.change(f, row, at.work, place, self.units.step)
        self.put(row, sums.sum(f, old, change), at.arrays, moves)

    # integrals

    def rate(self, row: Row) -> HighLow:
        """The integrand at the beginning of a part."""
        series, beyond = row.series(self.at.there), self.sums.beyond
        low = series[1 + beyond] if beyond else self.f.zero(row.lengths.lanes)
        return self.in_time(series[1]), self.in_time(low)

    def rounding(self, row: Row) -> Real:
        """The integrand's rounding error, as far as it is known."""
        return self.in_time(row.at(self.array(ROUNDING)))

    def in_time(self, rate: Real) -> Real:
        """A rate, of a term of its series."""
        return rate * (1.0 / self.units.part.get()) if self.sums.beyond else rate

    def of_series(self, rate: Real) -> Real:
        """The term of its series, of a rate in time."""
        return rate * self.units.part.get() if self.sums.beyond else rate

    def rescale(self, unit: Real) -> None:
        """Another unit of time for the series from now on."""
        times = unit / self.units.part.get()
        with self.own.velocities(self.f) as row:
            array = self.array(ROUNDING)
            row.put(row.at(array) * self.own.wide(self.f, times), array)
        self.units.part.set(unit)

    def integral(self, row: Row, part: StepPart, h: HighLow) -> HighLow:
        """An integral within ``h`` of the beginning of a part. A rate that is not finite counts as 0: what
        lies beyond tells whether it may be."""
        f, sums, lengths = self.f, self.sums, row.lengths
        summed = sums.change(f, row, self.at.there, h, self.units.part.get())
        linear = sums.product(f, (self.known(row), self.known(row, 1)), (lengths.wide(f, h[0]), h[1]))
        change = choice(f, part.short, linear, summed)
        return sums.sum(f, (row.at(self.at.arrays), row.at(self.at.arrays, self.low)), change)

    def slight(self, row: Row, change: Real, size: Real, h: Real, t: Real) -> Bit:
        """Whether a ``change`` of an integrand of some ``size`` within ``h`` matters no more to the integral
        than rounding errors of the time and of the integral so far."""
        so_far = row.floored(self.f.magnitude(row.at(self.at.arrays)), self.at.there)
        return change * h <= (size * self.own.wide(self.f, t) + so_far) * (self.bounds.rounding * SLIGHT)

    def known(self, row: Row, part: int = 0) -> Real:
        """A rate, or 0."""
        rate = self.rate(row)[part]
        return self.f.select(self.f.magnitude(rate) < ENDLESS, rate, self.f.zero(rate.lanes))

    def add(self, part: StepPart, usual: Real, t: Real) -> None:
        """The integrals at the end of a part, and what is expected of the integrands there."""
        f, own, h = self.f, self.own, part.h[0]
        allowed = allowance(f, self.bounds, t, usual, h)
        with own.velocities(f) as row:
            new, old = self.integral(row, part, part.h), row.at(self.at.arrays)
            speed, low = self.sums.slope(f, row, self.at.there, part.h, self.units.part.get())
            lesser = row.floored(f.smaller(f.magnitude(new[0]), f.magnitude(old)), self.at.there)
            most = allowed.of(f, own, f.magnitude(speed) + f.magnitude(self.rate(row)[0]), lesser)
            most = (most + own.wide(f, self.quadratures.nothing(f, h))) + self.rounding(row)
            most = f.select(part.short, f.magnitude(self.known(row)), most)
            self.put(row, new, self.array(ENDED))
            for number, value in ((RATES, speed), (ALLOWED, most), (LOW_RATES, low)):
                row.put(value, self.array(number))
        with f.when(part.short), own.velocities(f) as row:  # nothing is expected of these
            row.put(self.rate(row)[0], self.array(RATES))
            row.put(f.zero(own.lanes), self.array(KNOWN))

    def accepted(self) -> Bit:
        """Whether the series at the end of a part agree with what was expected."""
        f, zero = self.f, self.f.constant(0.0)
        given = self.array(RATES), self.array(ALLOWED), zero, f.constant(1.0), Bit(f, "false"), zero
        low = (self.array(LOW_RATES), 1.0 / self.units.part.get()) if self.sums.beyond else ()
        return f.call(Bit, "integrals_accepted", self.at.there, *given, *low, self.array(ENDED))

    def accept(self, good: Bit) -> None:
        """Go on with the integrals at the end of a part."""
        ended = self.array(ENDED)
        with self.f.when(good), self.own.velocities(self.f) as row:
            self.put(row, (row.at(ended), row.at(ended, self.low)), self.at.arrays)

    def give(self, state: Pointer, third: int, whole: Bit, explained: Bit) -> None:
        """The integrals of all parts as those of the state; no numbers where the parts are not the whole
        step. ``third`` parts, where there are any, become 0. Rounding errors of integrands are those of this
        step if they have ``explained`` why it was divided."""
        f, none = self.f, self.f.splat(Real(self.f, NAN, 1), self.own.lanes)
        with self.own.velocities(f) as row:
            value = row.at(self.at.arrays), row.at(self.at.arrays, self.low)
            every = row.moving(f.splat(Bit(f, "true", 1), self.own.lanes))
            self.put(row, choice(f, whole, value, (none, none)), state, every)
            if self.sums.beyond:
                row.put(f.select(every, f.zero(self.own.lanes), row.at(state, third)), state, third)
            known = self.quadratures.known
            before = row.at(self.at.begin, known) * FADING
            error = f.select(explained, self.rounding(row), before)
            row.put(f.select(every, error, row.at(state, known)), state, known)

    def lose_samples(self, index: Variable[Integer], last: Integer) -> None:
        """Samples from ``index`` to before ``last`` are nan: the parts have not reached them."""
        f, (first, count) = self.f, self.own.followed
        none = Real(f, NAN, 1)
        with f.loop(index.get(), last) as k, f.loop(first, first + count, tested=False) as i:
            place = i * Integer(f, "%stride") + k
            f.store(none, "%out", place)
            if self.sums.beyond:
                f.store(none, "%out", place + Integer(f, "%beyond"))

    def sample(self, part: StepPart, dt: HighLow, index: Integer) -> None:
        """One sample: rows of ``%out`` are ``%stride`` apart, low parts ``%beyond`` behind."""
        f, (first, count) = self.f, self.own.followed
        one, h = self.own.one_by_one(), difference(dt, part.start)
        with f.loop(first, first + count, tested=False) as i:
            high, low = self.integral(Row(one, f, i), part, h)
            place = i * Integer(f, "%stride") + index
            f.store(high, "%out", place)
            if self.sums.beyond:
                f.store(low, "%out", place + Integer(f, "%beyond"))

    def samples(
        self, index: Variable[Integer], last: Integer, part: StepPart, since: Callable[[Real], HighLow]
    ) -> Integer:
        """Write the samples of a part from ``index`` to before ``last``, at times ``since`` the beginning of
        the step: the first one beyond."""
        f, reached = self.f, self.f.variable(index.get())
        with f.section() as done, f.loop(reached.get(), last) as k:
            dt = since(f.load("%times", k))
            with f.when(~((difference(dt, part.end)[0] <= 0.0) | part.last)):
                done.leave()
            self.sample(part, dt, k)
            reached.set(k + 1)
        return reached.get()
