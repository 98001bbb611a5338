"""Steps in double-double (see ``advance``): lengths are doubles, time and state are not.

The state keeps a third part of every number behind the clock, so that adding up steps loses nothing. Time in
the series has a unit close to the step size, a power of two, so that coefficients neither overflow nor
underflow.
"""

from __future__ import annotations

from collections.abc import Callable

from lagrange_cli.native.interface import Stop
from lagrange_cli.native.llvm.function import Function
from lagrange_cli.native.llvm.vector import Bit, Integer, Pointer, Real
from lagrange_cli.native.numbers.error_free import fast_sum, two_sum
from lagrange_cli.native.recurrences.layout_rows import RowLayout
from lagrange_cli.native.state import LANES, Clock, whole_vectors
from lagrange_cli.native.stepping.acceptance import DOUBLE_DOUBLE, Allowance
from lagrange_cli.native.stepping.advance import advance
from lagrange_cli.native.stepping.divided import DividedSteps
from lagrange_cli.native.stepping.division import Division
from lagrange_cli.native.stepping.given import Given
from lagrange_cli.native.stepping.lengths import Lengths, Row
from lagrange_cli.native.stepping.proof import proven
from lagrange_cli.native.stepping.step_size import ENDLESS, chosen_step
from lagrange_cli.native.stepping.steps import STRAIGHT, Now
from lagrange_cli.native.stepping.sums import DoubleDoubleSums, HighLow, difference, pair
from lagrange_cli.records import replace

GONE = 2.0**-900
"""Values that have decayed to less do not limit the steps: low parts of such numbers have few digits, or
none."""
LONGEST = 1e30
"""The longest step: that of a motion without forces."""
WIDE = 2.0**12
"""If a step is this many times longer than the unit of its series, coefficients were lost and are computed
again."""
NARROWER, NARROWEST = 2.0**-32, 2.0**-300
"""The factor for the unit if coefficients overflow, and its lower limit."""
EXPONENT = 0x7FF0000000000000


class DoubleDoubleDivision(Division):
    """Integrals by parts, whose series have a unit of time close to their length."""

    edge, provable = 0.0, 2.0**-42

    def asked(self, left: Real, place: HighLow) -> Real:
        f, unit = self.f, self.parts.units.part
        length, fresh = f.variable(left), f.variable(Bit(f, "true"))

        def again(other: Real) -> None:
            self.parts.rescale(other)
            fresh.set(Bit(f, "false"))
            self.parts.expand(place)

        with f.forever() as rounds:
            used = unit.get()
            scaled = super().asked(left * (1.0 / used), place)
            with f.when(~(scaled > 0.0) & (used > NARROWEST)):
                again(used * NARROWER)
                rounds.go_on()
            length.set(f.smaller(scaled * used, left))
            with f.when((scaled > WIDE) & (length.get() < ENDLESS) & fresh.get()):
                again((length.get().bits() & EXPONENT).number())
                rounds.go_on()
            rounds.leave()
        return length.get()


ROUNDED = 2.0**-51
"""The time that is left, a double, may be so much less than that until the last sample."""


def stepper(lengths: Lengths, low: int, given: Given) -> list[str]:
    """IR of ``@advance``, ``@accelerate`` and their helpers: low parts of coefficients are ``low``
    coefficients behind."""
    steps = DoubleDoubleSteps(lengths, low, given)
    return [advance(steps), steps.accelerate().text()]


def lengths_of(rows: RowLayout, given: Given) -> Lengths:
    """Where series are that have a row each."""
    floor = given.work - whole_vectors(rows.width) if given.state.degrees > 1 else 0
    return Lengths(
        given.state.degrees, len(rows.state), rows.width, rows.order, 1, 1,
        row=2 * rows.beyond, term=1, first=LANES, floor=floor,
    )  # fmt: skip


class DoubleDoubleSteps(DividedSteps):
    """The parts of steps in double-double."""

    refined, parts, small = True, 2, 2.0**-94
    division = DoubleDoubleDivision

    def __init__(self, lengths: Lengths, low: int, given: Given) -> None:
        self._low, self._width = low, lengths.width
        self._sums = DoubleDoubleSums(low, lengths.term)
        super().__init__(given, lengths, DOUBLE_DOUBLE, self._sums, GONE)

    def own(self) -> list[Function]:
        sums = self._sums.functions(self.lengths.order)
        integrals = [self.expect("expect_integrals", self.quadratures.own)] if self.quadratures else []
        expected = self.expect("expect", self.lengths), *integrals
        return [*sums, self.sample_at(), self.update(), *expected]

    def compute(self, f: Function, time: HighLow, unit: Real, state: Pointer, series: Pointer) -> Bit:
        return f.call(Bit, "jet", f.pointer("%constants"), *time, unit, state, series)

    # functions

    def at_end(self, f: Function, name: str, row: Row) -> HighLow:
        """What a series adds over (%h, %hl), or its slope there."""
        return self._sums.called(f, name, row, f.pointer("%work"), (Real(f, "%h"), Real(f, "%hl")))

    def sample_at(self) -> Function:
        """``@sample``: the state at (%h, %hl), rows ``stride`` apart, low parts ``beyond`` behind."""
        heads = "ptr %state, ptr %work, double %h, double %hl, ptr %out, i64 %stride, i64 %beyond"
        f = Function(f"define internal void @sample({heads}) #0")
        with self.lengths.each(f) as row:
            old = row.at("%state"), row.at("%state", self._width)
            high, low = pair(f, "add", *old, *self.at_end(f, "polynomial", row))
            place = row.i * Integer(f, "%stride")
            f.store(high, "%out", place)
            f.store(low, "%out", place + Integer(f, "%beyond"))
        f.give()
        return f

    def update(self) -> Function:
        """``@update``: the state at the end of the step (%h, %hl), in three parts."""
        f = Function("define internal void @update(ptr %state, ptr %work, double %h, double %hl) #0")
        with self.lengths.each(f) as row:
            change = self.at_end(f, "polynomial", row)
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

    def expect(self, name: str, lengths: Lengths) -> Function:
        """``@expect``: write down what the series lets expect of the accelerations at the end of a step,
        where %trial is the state at its beginning; the place farthest from 0. ``@expect_integrals``: the same
        of integrands."""
        numbers = ", ".join(f"double %{name}" for name in ("h", "hl", "inverse", "change", "speed"))
        f = Function(f"define internal double @{name}(ptr %state, ptr %work, ptr %trial, {numbers}) #0")
        inverse, zero = Real(f, "%inverse"), f.constant(0.0)
        allowed, expected = Allowance(Real(f, "%change"), Real(f, "%speed"), zero), self.expected(f)
        farthest = f.variable(zero)
        with lengths.velocities(f) as row:
            lesser, place = (
                f.smaller(*(f.magnitude(row.at(end, shift)) for end in ("%state", "%trial")))
                for shift in (0, -lengths.degrees)
            )
            farthest.set(f.larger(farthest.get(), place))
            rate, low = (x * inverse for x in self.at_end(f, "slope", row))
            both = f.magnitude(rate) + f.magnitude(row.series()[1] * inverse)
            most = allowed.of(f, lengths, both, lesser)
            if self.noise and not lengths.followed[1]:
                most = most + row.at("%state", self.noise.place)
            for value, pointer in zip((rate, most, low), expected):
                row.put(value, pointer)
        f.give(farthest.get())
        return f

    def accelerate(self) -> Function:
        """``@accelerate(constants, t, state, work, rates)``: the accelerations as doubles; whether the mass
        matrix is regular. The low part of t is that of the state."""
        f = Function(
            "define i64 @accelerate(ptr %constants, double %t, ptr %state, ptr %work, ptr %rates) #0"
        )
        low = f.load("%state", self.state.at(Clock.TIME_LOW))
        regular = self.computed(f, (Real(f, "%t"), low), f.constant(1.0))
        with self.lengths.velocities(f) as row:
            row.put(row.series()[1], "%rates", -self.lengths.degrees)
        f.give(regular.to_integer())
        return f

    # steps

    def forget(self, f: Function) -> None:
        pass

    def straighten(self, f: Function) -> None:
        zero = f.constant(0.0)
        with self.lengths.each(f) as row:
            series = row.series()
            with f.loop(STRAIGHT, self.lengths.order + 1, tested=False) as m:
                series.put(zero, m)
                series.put(zero, m + self._low)

    def expand(self, f: Function, now: Now, brief: Callable[[], Bit] | None = None) -> tuple[Now, Bit]:
        one = f.constant(1.0)
        unit = f.select(now.previous.equals(0.0), one, (now.previous.bits() & EXPONENT).number())
        now = replace(now, unit=unit)
        self.measure(f, now)
        return now, self.computed(f, (now.t, now.low), unit)

    def choose(self, f: Function, now: Now, fail: Callable[[Stop], None]) -> tuple[Now, Real, Bit]:
        unit, h, fresh = f.variable(now.unit), f.variable(now.previous), f.variable(Bit(f, "true"))

        def again(other: Real) -> None:
            unit.set(other)
            fresh.set(Bit(f, "false"))
            self.computed(f, (now.t, now.low), other)

        with f.forever() as rounds:
            used = unit.get()
            scaled, met = chosen_step(f, now.previous * (1.0 / used), self.places(f))
            with f.when(~(met < ENDLESS)):
                with f.when(~(used > NARROWEST)):
                    fail(Stop.NOT_FINITE)
                again(used * NARROWER)
                rounds.go_on()
            longest = f.constant(LONGEST)
            if self.guards:  # their series need not be as slow as the motion's
                left = (Real(f, "%stop") - now.t) - now.low
                longest = f.smaller(longest, left * (1.0 / used))
                with f.when(~(self.guards.largest(f) < ENDLESS) & (used > NARROWEST)):
                    again(used * NARROWER)
                    rounds.go_on()
            scaled = f.smaller(scaled, longest)
            length = scaled * used
            with f.when((scaled > WIDE) & (length < LONGEST) & fresh.get()):
                again((length.bits() & EXPONENT).number())
                rounds.go_on()
            h.set(f.smaller(length, LONGEST))
            rounds.leave()
        return replace(now, unit=unit.get()), h.get(), Bit(f, "true")

    def vet(self, f: Function, now: Now, h: Real, left: Real, free: Bit) -> Real:
        if not self.proofs:
            return h
        beyond = f.constant(float(self.lengths.order - 1))
        return proven(f, self.proofs, now, h, left, free, self.places(f), beyond)

    def first_guard(self, f: Function, now: Now, h: Real) -> tuple[Real, Integer, Real]:
        assert self.guards
        root, which, known = self.guards.first(f, self.scaled(f, now.unit, h)[0], now.unit)
        return root * now.unit, which, known * now.unit

    def sample(self, f: Function, now: Now, index: Integer, h: Real) -> Integer:
        at, stride, end = f.variable(index), Integer(f, "%stride"), h * (1.0 + ROUNDED)
        with f.forever() as rounds:
            dt = difference((f.load("%times", at.get()), f.constant(0.0)), (now.t, now.low))
            with f.when(~(dt[0] <= end)):
                rounds.leave()
            place = f.place("%out", at.get()), stride, stride * self.lengths.rows
            f.call(None, "sample", *self.places(f), *self.scaled(f, now.unit, *dt), *place)
            at.set(at.get() + 1)
        return at.get()

    def move(self, f: Function, now: Now, h: Real, final: Bit, allowed: Allowance) -> Real:
        rest, low = difference((Real(f, "%stop"), f.constant(0.0)), (now.t, now.low))
        h, low = f.select(final, rest, h), f.select(final, low, 0.0)
        step, (state, work) = self.scaled(f, now.unit, h, low), self.places(f)
        if self.noise:
            self.noise.count(f)
        f.call(None, "update", state, work, *step)
        for value, number in zip(pair(f, "add", now.t, now.low, h, low), (Clock.TIME, Clock.TIME_LOW)):
            f.store(value, state, self.state.at(number))
        given = *step, 1.0 / now.unit, allowed.change, allowed.speed
        if self.quadratures:
            f.call(Real, "expect_integrals", state, work, f.pointer("%trial"), *given)
        return f.call(Real, "expect", state, work, f.pointer("%trial"), *given)
