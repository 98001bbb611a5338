"""Steps in double-double (see ``advance``): lengths are doubles, time and state are not.

The state keeps a third part of every number behind the clock, so that adding up steps loses nothing. Time in
the series has a unit close to the step size, a power of two, so that coefficients neither overflow nor
underflow.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

from lagrange_cli.native.interface import records_at
from lagrange_cli.native.llvm.function import Function
from lagrange_cli.native.llvm.vector import Bit, Integer, Pointer, Real
from lagrange_cli.native.numbers.error_free import operators_fast_sum as fast_sum
from lagrange_cli.native.numbers.error_free import operators_two_sum as two_sum
from lagrange_cli.native.recurrences.layout_rows import Rows
from lagrange_cli.native.state import LANES, Clock, GuardRows, StateLayout
from lagrange_cli.native.stepping.acceptance import DOUBLE_DOUBLE, Allowance, accepted
from lagrange_cli.native.stepping.advance import STRAIGHT, Now, Steps, advance, clear_function
from lagrange_cli.native.stepping.double_double_quadratures import PairQuadratures, apply
from lagrange_cli.native.stepping.doubles import AT_REST
from lagrange_cli.native.stepping.guards import GuardCode
from lagrange_cli.native.stepping.lengths import Lengths, Row
from lagrange_cli.native.stepping.polynomial import polynomial
from lagrange_cli.native.stepping.proof import Proof, Proving, proven
from lagrange_cli.native.stepping.quadratures import Part, Places, Time, difference, followed, sampling
from lagrange_cli.native.stepping.step_size import ENDLESS, LEAP, StepSize, chosen_step
from lagrange_cli.records import replace

GONE = 2.0**-1060
"""What has decayed to less does not limit the steps: numbers as small as that are rounded to some digits."""
LONGEST = 1e30
"""The longest step: what a motion without forces gets."""
WIDE = 2.0**12
"""If a step is this many times longer than the unit of its series, coefficients were lost and are computed
again."""
NARROWER, NARROWEST = 2.0**-32, 2.0**-300
"""The factor for the unit if coefficients overflow, and its lower limit."""
ROUGHLY, ROUGH = 2.0**-40, 2.0**-80
"""What ``Bounds.almost`` and ``Bounds.rounding`` are for the trial of a long step's end before it is
taken."""
TRIALS = 31
EXPONENT = 0x7FF0000000000000
Pair = tuple[Real, Real]


SMALL = 2.0**-94
"""A defect up to this part of what moves is not told from rounding (see ``Proof``)."""


def stepper(
    rows: Rows,
    state: StateLayout,
    work: int,
    tolerance: float,
    proving: tuple[Proving | None, Proving | None] = (None, None),
    guards: GuardRows | None = None,
) -> list[str]:
    """IR of ``@advance``, ``@accelerate`` and their helpers, for ``work`` doubles of ``%work``."""
    steps = DoubleDoubleSteps(rows, state, work, tolerance, proving, guards)
    return [advance(steps), steps.accelerate().text()]


class DoubleDoubleSteps(Steps):
    """What steps in double-double are made of."""

    refined = True

    def __init__(
        self,
        rows: Rows,
        state: StateLayout,
        work: int,
        tolerance: float,
        proving: tuple[Proving | None, Proving | None],
        guards: GuardRows | None,
    ) -> None:
        self.state, degrees, count = state, state.degrees, len(rows.state)
        self.bounds = DOUBLE_DOUBLE.coarser(tolerance)
        self.lengths = Lengths(
            degrees, count, rows.width, rows.order, 1, 1, 1, row=2 * rows.beyond, term=1, first=LANES
        )
        self.quadratures: PairQuadratures | None = None
        first, extra = followed(state, guards)
        if extra:
            self.lengths = replace(self.lengths, apart=True)
            rest = AT_REST if proving[1] else 0.0
            given = self.lengths, first, extra, rows.width, tolerance, self.bounds
            self.quadratures = PairQuadratures(*given, rows.beyond, self.state.third, rest)
        self.sizes = StepSize(self.lengths, tolerance, GONE, fades=False)
        self.guards = GuardCode(guards, state, self.lengths, records_at(state, work, 2)) if guards else None
        self._low, self._width = rows.beyond, rows.width
        self._work = work
        self._proof: Proof | None = None
        self._integrands: Proof | None = None
        small = SMALL * max(1.0, tolerance / self.bounds.precision)
        nothing = self.bounds.nothing_much
        proof = partial(Proof, lengths=self.lengths, low=rows.width, nothing=nothing, small=small, parts=2)
        if proving[0]:
            self._proof = proof(*proving[0])
        if proving[1]:
            self._integrands = proof(*proving[1], integrals=(first, extra))

    def functions(self) -> list[str]:
        half = self.lengths.order // 2
        sums = self.sum("polynomial", half + 4, False), self.sum("slope", max(1, half - 4), True)
        own = *sums, self.sample_at(), self.update(), self.expect(), self.holds()
        made = [*self.sizes.functions(), accepted(self.lengths, self._low), *own]
        made += [self._proof.function()] if self._proof else []
        made += [self._integrands.function()] if self._integrands else []
        if self.quadratures:
            made += [*self.quadratures.functions(), self.expect_integrals(), self.divide()]
        guards = self.guards.functions() if self.guards else []
        return [clear_function(), *guards, *(f.text() for f in made)]

    # numbers

    def apply(self, f: Function, name: str, *arguments: Real) -> Pair:
        """A sum or product of numbers (see ``numbers.double_double``)."""
        return apply(f, name, *arguments)

    def since(self, instant: Real, now: Now) -> Pair:
        """The time from now to an instant."""
        high, low = two_sum(instant, -now.t)
        return fast_sum(high, low - now.low)

    def places(self, f: Function) -> tuple[Pointer, Pointer]:
        """The state, and the series."""
        return f.pointer("%state"), f.pointer("%work")

    def expected(self, f: Function) -> tuple[Pointer, Pointer, Pointer]:
        """Where the accelerations are that are expected, how far off they may be, and their low parts."""
        first = self.state.memory
        rates, allowed, low = (f.place("%trial", first + i * self._width) for i in range(3))
        return rates, allowed, low

    # functions

    def sum(self, name: str, half: int, derivative: bool) -> Function:
        """``@polynomial(row, h)``: sum_{m=1}^{order} c[m] h^m, or ``@slope(row, h)``: sum_{m=1}^{top} m c[m]
        h^(m-1). For terms beyond ``half`` a double is enough."""
        f = Function(f"define internal {{ double, double }} @{name}(ptr %row, double %h, double %hl) #0")
        h, last = (Real(f, "%h"), Real(f, "%hl")), self.lengths.top if derivative else self.lengths.order
        upper = [
            f.load("%row", m) * float(m) if derivative else f.load("%row", m)
            for m in range(half + 1, last + 1)
        ]
        total = [
            f.variable(x) for x in (polynomial(f, upper, h[0]) if upper else f.constant(0.0), f.constant(0.0))
        ]

        def times_h() -> Pair:
            return self.apply(f, "mul", *(one.get() for one in total), *h)

        m = f.variable(f.count(half))
        with f.forever() as rounds:
            term = f.load("%row", m.get()), f.load("%row", m.get() + self._low)
            if derivative:
                term = self.apply(f, "scale", *term, m.get().to_real())
            for one, value in zip(total, self.apply(f, "add", *times_h(), *term)):
                one.set(value)
            m.set(m.get() - 1)
            rounds.repeat(m.get() > 0)
        f.give(*([one.get() for one in total] if derivative else times_h()))
        return f

    def change(self, f: Function, row: Row, name: str = "polynomial") -> Pair:
        """What a series adds over (%h, %hl), or its slope there."""
        pair = [f.constant(0.0)] * 2
        high, low = f.parts(name, pair, row.series().place, Real(f, "%h"), Real(f, "%hl"))
        return high, low

    def sample_at(self) -> Function:
        """``@sample``: the state at (%h, %hl), rows ``stride`` apart, low parts ``beyond`` behind."""
        heads = "ptr %state, ptr %work, double %h, double %hl, ptr %out, i64 %stride, i64 %beyond"
        f = Function(f"define internal void @sample({heads}) #0")
        with self.lengths.each(f) as row:
            old = row.at("%state"), row.at("%state", self._width)
            high, low = self.apply(f, "add", *old, *self.change(f, row))
            place = row.i * Integer(f, "%stride")
            f.store(high, "%out", place)
            f.store(low, "%out", place + Integer(f, "%beyond"))
        f.give()
        return f

    def update(self) -> Function:
        """``@update``: the state at the end of the step (%h, %hl), in three parts."""
        f = Function("define internal void @update(ptr %state, ptr %work, double %h, double %hl) #0")
        with self.lengths.each(f) as row:
            change = self.change(f, row)
            high, error = two_sum(row.at("%state"), change[0])
            low, rest = two_sum(row.at("%state", self._width), change[1])
            low, more = two_sum(error, low)
            low, rest = two_sum(low, (rest + more) + row.at("%state", self.state.third))
            high, low = fast_sum(high, low)
            low, rest = two_sum(low, rest)
            row.put(high, "%state")
            row.put(low, "%state", self._width)
            row.put(rest, "%state", self.state.third)
        f.give()
        return f

    def expect(self) -> Function:
        """``@expect``: write down what the series lets expect of the accelerations at the end of a step,
        where %trial is the state at its beginning; the place farthest from 0."""
        numbers = ", ".join(f"double %{name}" for name in ("h", "hl", "inverse", "change", "speed"))
        f = Function(f"define internal double @expect(ptr %state, ptr %work, ptr %trial, {numbers}) #0")
        lengths, inverse, zero = self.lengths, Real(f, "%inverse"), f.constant(0.0)
        allowed, expected = Allowance(Real(f, "%change"), Real(f, "%speed"), zero), self.expected(f)
        farthest = f.variable(zero)
        with lengths.velocities(f) as row:
            lesser, place = (
                f.smaller(*(f.magnitude(row.at(end, shift)) for end in ("%state", "%trial")))
                for shift in (0, -lengths.degrees)
            )
            farthest.set(f.larger(farthest.get(), place))
            rate, low = (x * inverse for x in self.change(f, row, "slope"))
            both = f.magnitude(rate) + f.magnitude(row.series()[1] * inverse)
            for value, pointer in zip((rate, allowed.of(f, lengths, both, lesser), low), expected):
                row.put(value, pointer)
        f.give(farthest.get())
        return f

    def holds(self) -> Function:
        """``@holds``: whether the equations hold, roughly, at the end of the step %length."""
        lengths = self.lengths
        heads = "ptr %constants, ptr %state, ptr %work, double %length, double %h, double %hl, double %unit"
        f = Function(f"define internal i1 @holds({heads}, ptr %trial) #0")
        unit, length, h = Real(f, "%unit"), Real(f, "%length"), (Real(f, "%h"), Real(f, "%hl"))
        trial, there = f.pointer("%trial"), f.place("%trial", LANES * -(-2 * self._width // LANES))
        f.call(None, "sample", *self.places(f), *h, trial, f.count(1), f.count(self._width))
        t, low = (f.load("%state", self.state.at(one)) for one in (Clock.TIME, Clock.TIME_LOW))
        time = self.apply(f, "add", t, low, length, f.constant(0.0))
        good = f.variable(f.call(Bit, "jet", f.pointer("%constants"), *time, unit, trial, there))
        inverse = f.constant(1.0) / unit
        with lengths.velocities(f) as row:
            rate = self.change(f, row, "slope")[0] * inverse
            found, begin = row.series(there)[1] * inverse, row.series()[1] * inverse
            v, q = (f.magnitude(row.at(trial, shift)) for shift in (0, -lengths.degrees))
            size = v / length + f.magnitude(found) + f.magnitude(begin)
            allowed = f.fused(size, f.constant(ROUGHLY), q * ROUGH / length / length)
            good.set(good.get() & (f.magnitude(rate - found) <= allowed))
        f.give(good.get())
        return f

    def accelerate(self) -> Function:
        """``@accelerate(constants, t, state, work, rates)``: the accelerations as doubles; whether the mass
        matrix is regular."""
        f = Function(
            "define i64 @accelerate(ptr %constants, double %t, ptr %state, ptr %work, ptr %rates) #0"
        )
        regular = self.series(f, Real(f, "%t"), f.constant(0.0), f.constant(1.0))
        with self.lengths.velocities(f) as row:
            row.put(row.series()[1], "%rates", -self.lengths.degrees)
        f.give(regular.to_integer())
        return f

    # steps

    def series(self, f: Function, t: Real, low: Real, unit: Real) -> Bit:
        """Compute the series in that unit of time; whether the mass matrix is regular."""
        return f.call(Bit, "jet", f.pointer("%constants"), t, low, unit, *self.places(f))

    def forget(self, f: Function) -> None:
        pass

    def straighten(self, f: Function) -> None:
        zero = f.constant(0.0)
        with self.lengths.each(f) as row:
            series = row.series()
            with f.loop(STRAIGHT, self.lengths.order + 1, tested=False) as m:
                series.put(zero, m)
                series.put(zero, m + self._low)

    def expand(self, f: Function, now: Now) -> tuple[Now, Bit]:
        one = f.constant(1.0)
        unit = f.select(now.previous.equals(0.0), one, (now.previous.bits() & EXPONENT).number())
        return replace(now, unit=unit), self.series(f, now.t, now.low, unit)

    def choose(self, f: Function, now: Now, fail: Callable[[], None]) -> tuple[Now, Real, Bit]:
        unit, h, fresh = f.variable(now.unit), f.variable(now.previous), f.variable(Bit(f, "true"))

        def again(other: Real) -> None:
            unit.set(other)
            fresh.set(Bit(f, "false"))
            self.series(f, now.t, now.low, other)

        with f.forever() as rounds:
            used = unit.get()
            scaled, met = chosen_step(f, now.previous * (f.constant(1.0) / used), self.places(f))
            with f.when(~(met < ENDLESS)):
                with f.when(~(used > NARROWEST)):
                    fail()
                again(used * NARROWER)
                rounds.go_on()
            longest = f.constant(LONGEST)
            if self.guards:  # their series need not be as slow as the motion's
                left = (Real(f, "%stop") - now.t) - now.low
                longest = f.smaller(longest, left * (f.constant(1.0) / used))
                with f.when(~(self.guards.largest(f) < ENDLESS) & (used > NARROWEST)):
                    again(used * NARROWER)
                    rounds.go_on()
            scaled = f.smaller(scaled, longest)
            length = scaled * used
            with f.when((scaled > WIDE) & (length < LONGEST) & fresh.get()):
                again((length.bits() & EXPONENT).number())
                rounds.go_on()
            h.set(f.smaller(length, f.constant(LONGEST)))
            rounds.leave()
        return replace(now, unit=unit.get()), h.get(), Bit(f, "true")

    def vet(self, f: Function, now: Now, h: Real, left: Real, free: Bit) -> Real:
        length = f.variable(h)
        leaps, places = free & (h > now.previous * LEAP), (f.pointer("%constants"), *self.places(f))
        with f.when(leaps), f.section() as sound, f.loop(0, TRIALS, tested=False):
            needed = f.smaller(length.get(), left)
            scaled = self.scaled(f, now, needed, f.constant(0.0))
            with f.when(f.call(Bit, "holds", *places, needed, *scaled, now.unit, f.pointer("%trial"))):
                sound.leave()
            length.set(needed * 0.25)
        if self._proof is None:
            return length.get()
        beyond = f.constant(float(self.lengths.order - 1))
        return proven(f, now, length.get(), left, free, self.places(f), beyond)

    def first_guard(self, f: Function, now: Now, h: Real) -> tuple[Real, Integer, Real]:
        assert self.guards
        root, which, known = self.guards.first(f, self.scaled(f, now, h)[0], now.unit)
        return root * now.unit, which, known * now.unit

    def scaled(self, f: Function, now: Now, *times: Real) -> list[Real]:
        """Times in the unit of the series."""
        inverse = f.constant(1.0) / now.unit
        return [one * inverse for one in times]

    def sample(self, f: Function, now: Now, index: Integer, h: Real) -> Integer:
        at, stride = f.variable(index), Integer(f, "%stride")
        with f.forever() as rounds:
            dt = self.since(f.load("%times", at.get()), now)
            with f.when(~(dt[0] <= h)):
                rounds.leave()
            place = f.place("%out", at.get()), stride, stride * self.lengths.rows
            f.call(None, "sample", *self.places(f), *self.scaled(f, now, *dt), *place)
            at.set(at.get() + 1)
        return at.get()

    def move(self, f: Function, now: Now, h: Real, final: Bit, allowed: Allowance) -> Real:
        rest, low = self.since(Real(f, "%stop"), now)
        h, low = f.select(final, rest, h), f.select(final, low, f.constant(0.0))
        step, (state, work) = self.scaled(f, now, h, low), self.places(f)
        f.call(None, "update", state, work, *step)
        for value, number in zip(self.apply(f, "add", now.t, now.low, h, low), (Clock.TIME, Clock.TIME_LOW)):
            f.store(value, state, self.state.at(number))
        given = *step, f.constant(1.0) / now.unit, allowed.change, allowed.speed
        if self.quadratures:
            f.call(None, "expect_integrals", state, work, f.pointer("%trial"), *given)
        return f.call(Real, "expect", state, work, f.pointer("%trial"), *given)

    def agree(self, f: Function, now: Now, uneven: Real, slack: Real, unexplained: Bit, room: Real) -> Bit:
        rates, allowed, low = self.expected(f)
        given = uneven, slack, unexplained, room, low, f.constant(1.0) / now.unit
        return f.call(Bit, "accepted", f.pointer("%work"), rates, allowed, *given)

    # integrals

    def expect_integrals(self) -> Function:
        """``@expect_integrals``: what ``@expect`` does, for the integrals."""
        assert self.quadratures
        numbers = ", ".join(f"double %{name}" for name in ("h", "hl", "inverse", "change", "speed"))
        f = Function(
            f"define internal void @expect_integrals(ptr %state, ptr %work, ptr %trial, {numbers}) #0"
        )
        lengths, inverse, zero = self.quadratures.own, Real(f, "%inverse"), f.constant(0.0)
        allowed, expected = Allowance(Real(f, "%change"), Real(f, "%speed"), zero), self.expected(f)
        with lengths.velocities(f) as row:
            lesser = f.smaller(*(f.magnitude(row.at(end)) for end in ("%state", "%trial")))
            rate, low = (x * inverse for x in self.change(f, row, "slope"))
            both = f.magnitude(rate) + f.magnitude(row.series()[1] * inverse)
            for value, pointer in zip((rate, allowed.of(f, lengths, both, lesser), low), expected):
                row.put(value, pointer)
        f.give()
        return f

    def rough(self, f: Function, now: Now, h: Real) -> Bit:
        given = f.pointer("%trial"), f.pointer("%work")
        rough = f.call(Bit, "rough", *given, *self.scaled(f, now, h))
        if self._integrands is None:
            return rough
        places = f.pointer("%constants"), now.t + now.low, *given
        beyond = f.constant(float(self.lengths.order - 1))
        return rough | ~f.call(Bit, "integrands_proven", *places, h, now.unit, beyond)

    def surprising(self, f: Function, now: Now, h: Real) -> Bit:
        assert self.quadratures
        rates, allowed, low = self.expected(f)
        given = f.pointer("%work"), rates, allowed, low, f.pointer("%state"), f.constant(1.0) / now.unit
        return ~f.call(Bit, "integrals_confirmed", *given, self.quadratures.nothing(f, h))

    def resume(self, f: Function, before: Now) -> None:
        given = before.t, before.low, before.unit, f.pointer("%trial"), f.pointer("%work")
        f.call(Bit, "jet", f.pointer("%constants"), *given)

    def part(self, f: Function, before: Now, h: Real, samples: tuple[Integer, Integer]) -> None:
        places = (f.pointer(f"%{name}") for name in ("constants", "trial", "work", "state", "times", "out"))
        t, low = (f.load("%state", self.state.at(one)) for one in (Clock.TIME, Clock.TIME_LOW))
        step = self.apply(f, "add", t, low, -before.t, -before.low)
        stride = Integer(f, "%stride")
        more = before.unit, *samples, stride, stride * self.lengths.rows
        f.call(None, "divide", *places, before.t, before.low, *step, *more)

    def divide(self) -> Function:
        """``@divide``: the integrals of the step (%h, %hl) from ``%trial`` on, with the series in ``%work``,
        by parts; also those of the samples from ``first`` to before ``last``."""
        heads = ", ".join(f"ptr %{name}" for name in ("constants", "trial", "work", "state", "times", "out"))
        more = ", ".join(f"double %{name}" for name in ("t", "low", "h", "hl", "unit"))
        counts = ", ".join(f"i64 %{name}" for name in ("first", "last", "stride", "beyond"))
        f = Function(f"define internal void @divide({heads}, {more}, {counts}) #0")
        assert self.quadratures
        made, zero, yes = self.quadratures, f.constant(0.0), Bit(f, "true")
        t, low, h, hl, unit = (Real(f, f"%{name}") for name in ("t", "low", "h", "hl", "unit"))
        first = LANES * -(-(self.state.memory + 3 * self._width) // LANES)
        series, arrays = (f.place("%trial", one) for one in (first, first + self._work))
        at = Places(f.pointer("%trial"), f.pointer("%work"), arrays, series)
        index, begin = f.variable(Integer(f, "%first")), Now(t, low, zero, unit)
        place, rest = f.variable(zero), f.variable(zero)
        made.unit, made.whole = f.variable(unit), unit

        def compute() -> None:
            time = self.apply(f, "add", t, low, place.get(), rest.get())
            f.call(Bit, "jet", f.pointer("%constants"), *time, made.unit.get(), arrays, series)

        def expand(to: Time) -> None:
            place.set(to[0])
            rest.set(to[1])
            compute()

        def write(part: Part, dt: Time, reached: Integer) -> None:
            made.sample_at(f, at, part, dt, reached)

        def within(dt: Time, part: Part) -> Bit:
            return difference(dt, part.end)[0] <= 0.0

        last = Integer(f, "%last")
        sample = sampling(f, index, last, lambda instant: self.since(instant, begin), within, write)

        def prove(place: Time, length: Real) -> Bit:
            given = f.pointer("%constants"), (t + low) + place[0], arrays, series, length, made.unit.get()
            beyond = f.constant(float(self.lengths.order - 1))
            return f.call(Bit, "integrands_proven", *given, beyond)

        made.again, proof = compute, prove if self._integrands else None
        whole = made.divide(f, at, t, (h, hl), yes, expand, sample, proof)
        made.give(f, at, f.pointer("%state"), yes, whole)
        f.give()
        return f
