"""Steps of systems of families: coefficients of all rows are side by side."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from functools import partial
from typing import TypeAlias

from lagrange_cli.native.families.series_places import BESIDE, BRIEF, JET, MOTION
from lagrange_cli.native.families.spans import Span, divided, smaller
from lagrange_cli.native.guards import GuardRows
from lagrange_cli.native.interface import LANES
from lagrange_cli.native.llvm.function import Function
from lagrange_cli.native.llvm.vector import Bit, Index, Integer, Pointer, Real
from lagrange_cli.native.numbers.error_free import two_sum
from lagrange_cli.native.state import Clock, StateLayout, whole_vectors
from lagrange_cli.native.stepping.acceptance import Allowance
from lagrange_cli.native.stepping.doubles import DoubleSteps
from lagrange_cli.native.stepping.lengths import Row
from lagrange_cli.native.stepping.polynomial import CAREFUL, careful_sum, rate
from lagrange_cli.native.stepping.steps import STRAIGHT, Now
from lagrange_cli.native.stepping.sums import CHAINS, RATE_CHAINS

WEIGHTS = PLACE, SPEED, RATE = range(3)
"""What velocities' coefficients m give at the end of a step: h^(m + 1)/(m + 1) to coordinates, h^m to
velocities, m h^(m - 1) to accelerations."""
FEW = 3
"""Samples in a step that are taken one after the other."""
AT_ONCE = 4
"""Orders of a sum in each round of its loop."""
FEWEST = 1024
"""From so many arguments of guards on it pays to leave out what they have in a state."""
AHEAD, SHORTEST, LONGER = 4.0, 2.0**-30, 8.0
"""Guards are looked for in so many times the length of the last step, or in this part of the step, and then
in so many times that."""
NEXT = 4 * LANES
"""So many rows further on coefficients are fetched: those of an order are far from those of the next one, and
processors do not foresee that (100,000 beads: 8 percent of the time)."""
Take: TypeAlias = "Callable[[Integer, int, Real], None]"


class FamilySteps(DoubleSteps):
    """With series of all rows."""

    def straighten(self, f: Function) -> None:
        first, last = STRAIGHT * self.lengths.term, (self.lengths.order + 1) * self.lengths.term
        with f.loop(first, last, LANES, tested=False) as i:
            f.store_row(f.zero(LANES), "%work", i)

    @contextmanager
    def orders(self, f: Function, least: int = 1) -> Iterator[Integer]:
        """Orders from the highest one down to the ``least``."""
        with f.loop(0, self.lengths.order + 1 - least, tested=False) as passed:
            yield f.count(self.lengths.order) - passed

    def take_sums(self, f: Function, dt: Real, rows: int, take: Take) -> None:
        """``take(i, last, sum)`` of what series add within ``dt``, for so many rows together: those from
        ``i`` to before ``last``; or for 1 row, if several times are side by side."""
        degrees = self.lengths.degrees
        with f.loop(0, degrees, rows, tested=False) as i:
            both = (partial(one, f, i, rows=rows) for one in (self.place, self.speed))
            place, speed = self.sums_of(f, dt, *both)
            take(i, degrees, place)
            take(i + degrees, 2 * degrees, speed)
        first, count = self.lasting
        if count:
            with f.loop(first - degrees, first - degrees + count, rows, tested=False) as i:
                (change,) = self.sums_of(f, dt, partial(self.speed, f, i, rows=rows))
                take(i + degrees, self.lengths.rows, change)

    @property
    def lasting(self) -> tuple[int, int]:
        """The first of the integrals whose values are wanted, and how many there are: those of arguments of
        guards, before them, are not."""
        first = self.state.integrals.start + (self.given.guards.arguments if self.given.guards else 0)
        return first, self.lengths.rows - first

    def place(self, f: Function, i: Integer, m: Index, rows: int = 0) -> Real:
        """Coefficient ``m`` of coordinates, from the ``i``-th one on."""
        return f.load_row("%work", i + m * self.lengths.term, rows or self.lengths.lanes)

    def speed(self, f: Function, i: Integer, m: Index, rows: int = 0) -> Real:
        """The same of their velocities."""
        first = self.lengths.first + self.lengths.degrees
        series = f.place("%work", m * self.lengths.term + first, "double")
        return f.load_row(series, i, rows or self.lengths.lanes)

    def sums_of(self, f: Function, dt: Real, *series: Callable[[Integer], Real]) -> list[Real]:
        """sum_m c[m] dt^m, m from 1 on, for each of some series, which have c."""
        totals = [f.variable(f.zero(dt.lanes)) for _ in series]

        def add(m: Integer) -> None:
            for total, one in zip(totals, series):
                total.set(f.fused(total.get(), dt, f.splat(one(m), dt.lanes)))

        order = self.lengths.order
        for m in range(order, order - order % AT_ONCE, -1):
            add(f.count(m))
        with f.loop(0, order - order % AT_ONCE, AT_ONCE, tested=False) as passed:
            for m in range(AT_ONCE):
                add(f.count(order - order % AT_ONCE - m) - passed)
        return [one.get() * dt for one in totals]

    def sample(self, f: Function, now: Now, index: Integer, h: Real) -> Integer:
        """Eight together, or a few one after the other, but many rows."""
        at, stride, low = f.variable(index), Integer(f, "%stride"), self.state.part(1).start
        with f.forever() as rounds:
            times = (f.load_row("%times", at.get(), LANES) - f.splat(now.t, LANES)) - f.splat(now.low, LANES)
            hits = (times <= f.splat(h, LANES)).count()
            with f.when(hits.equals(0)):
                rounds.leave()

            def together(i: Integer, last: int, change: Real) -> None:
                state, rest = (f.splat(f.load("%state", i + part), LANES) for part in (0, low))
                f.store_row(state + (change + rest), "%out", i * stride + at.get())

            with f.when(hits > FEW):
                self.take_sums(f, times, 1, together)
            with f.otherwise(), f.loop(0, hits, tested=False) as one:
                lanes, place = self.lengths.lanes, at.get() + one

                def alone(i: Integer, last: int, change: Real) -> None:
                    rest = f.load_row("%state", i + low, lanes)
                    value = f.load_row("%state", i, lanes) + (change + rest)
                    count = smaller(f, f.count(lanes), f.count(last) - i)
                    with f.loop(0, count, tested=False) as lane:
                        f.store(f.lane(value, lane), "%out", (i + lane) * stride + place)

                self.take_sums(f, f.splat(f.lane(times, one), lanes), lanes, alone)
            at.set(at.get() + hits)
            rounds.repeat(hits.equals(LANES))
        return at.get()


class VelocitySteps(FamilySteps):
    """With series of the velocities, from which those of the coordinates follow."""

    def expand(self, f: Function, now: Now, brief: Callable[[], Bit] | None = None) -> tuple[Now, Bit]:
        given = f.pointer("%constants"), now.t + now.low, *self.places(f)
        if self.given.near is not None:
            self.measure(f, now)
            return now, f.call(Bit, MOTION, *given)
        if brief is None or self.state.quadratures:
            return super().expand(f, now)
        self.measure(f, now)
        regular = f.variable(f.never(1))
        with f.when(brief()):
            regular.set(f.call(Bit, BRIEF, *given))
        with f.otherwise():
            regular.set(f.call(Bit, JET, *given))
        return now, regular.get()

    def watch(self, f: Function, now: Now, h: Real) -> None:
        if self.given.near is not None:
            f.call(Bit, BESIDE, f.pointer("%constants"), now.t + now.low, *self.places(f), h)

    def forget(self, f: Function) -> None:
        near = self.given.near
        if near is None or not near.listed:
            super().forget(f)
            return
        term, velocities = self.lengths.term, self.lengths.first + 2 * self.lengths.degrees
        with f.loop(0, self.lengths.order + 1, tested=False) as m:
            f.call(None, "clear", f.place("%work", m * term, "double"), f.count(whole_vectors(velocities, 1)))
        behind = (self.lengths.order + 1) * term
        f.call(None, "clear", f.place("%work", behind, "double"), f.count(near.kept - behind))

    def first_guard(self, f: Function, now: Now, h: Real) -> tuple[Real, Integer, Real]:
        """The first one is looked for in the next few times the length of the last step, then in a longer
        time: so few guards are near."""
        near = self.given.near
        if near is None or not near.listed:
            self.watch(f, now, h)
            return super().first_guard(f, now, h)
        usual = f.larger(f.load("%state", self.state.at(Clock.LENGTH)) * AHEAD, h * SHORTEST)
        span = f.variable(f.smaller(h, usual))
        first, guard, reach = f.variable(h), f.variable(f.count(0)), f.variable(h)
        with f.forever() as rounds:
            self.watch(f, now, span.get())
            root, which, known = super().first_guard(f, now, span.get())
            first.set(root)
            guard.set(which)
            reach.set(known)
            with f.when((root <= span.get()) | ~(known >= span.get()) | ~(span.get() < h)):
                rounds.leave()
            span.set(f.smaller(h, span.get() * LONGER))
        return first.get(), guard.get(), reach.get()

    def place(self, f: Function, i: Integer, m: Index, rows: int = 0) -> Real:
        speed = self.speed(f, i, m - 1, rows)
        inverse, rest = (f.splat(f.load(table, m), speed.lanes) for table in ("@reciprocals", "@rests"))
        return divided(f, speed, inverse, rest)

    def move(self, f: Function, now: Now, h: Real, final: Bit, allowed: Allowance) -> Real:
        self.pass_time(f, now, h)
        if self.noise:
            self.noise.count(f)
        self.weigh(f, h)
        farthest = self.move_all(f, h, allowed)
        if self.lasting[1]:
            self.move_integrals(f, f.splat(h, self.lengths.lanes), allowed)
        return farthest

    def move_all(self, f: Function, h: Real, allowed: Allowance) -> Real:
        """All coordinates and velocities at the end of a step; the place farthest from 0."""
        span = f.count(0), f.count(self.lengths.degrees)
        return self.move_some(f, h, allowed, span, self.expected(f)[:2])

    def move_some(
        self, f: Function, h: Real, allowed: Allowance, span: Span, expected: tuple[Pointer, Pointer]
    ) -> Real:
        """The same for some coordinates and their velocities."""
        low, degrees, (rates, allowances) = self.state.width, self.lengths.degrees, expected
        lanes, weights = self.lengths.lanes, self.weights(f)
        nothing = f.splat(self.bounds.nothing(f, h), lanes) if self.proof else None
        h, zero = f.splat(h, lanes), f.zero(lanes)
        farthest = f.variable(zero)
        with f.loop(*span, lanes, tested=False) as i:
            place, speed = Row(self.lengths, f, i), Row(self.lengths, f, i + degrees)
            inside = place.among(0, degrees)
            speeds = [self.speed(f, i, m) for m in range(CAREFUL + 2)]
            totals = [f.variable(zero) for _ in WEIGHTS]
            """Sums of terms, from the last ones to the larger ones."""

            def add(which: int, m: Index, one: Real) -> None:
                weight = f.splat(f.load(weights, m * len(WEIGHTS) + which), lanes)
                totals[which].set(f.fused(one, weight, totals[which].get()))

            with self.orders(f, CAREFUL + 1) as k:
                one = self.speed(f, i, k)
                f.prefetch("%work", i + (k * self.lengths.term + (self.lengths.first + degrees + NEXT)))
                for which in WEIGHTS:
                    add(which, k, one)
            add(PLACE, CAREFUL, speeds[CAREFUL])
            for m in range(CAREFUL, 0, -1):
                add(RATE, m, speeds[m])

            def changed(row: Row, c: Sequence[Real], extra: Real, further: Real) -> Real:
                """The rows after the step; where they are nearer to 0, there or before."""
                change, rest = careful_sum(f, c, h)
                old, lost = row.at("%state"), row.at("%state", low)
                new, error = two_sum(old, change + ((lost + extra) + (rest + further)))
                row.put(f.select(inside, new, old), "%state")
                row.put(f.select(inside, error, lost), "%state", low)
                return f.smaller(f.magnitude(new), f.magnitude(old))

            # the low part of a velocity moves its coordinate
            follows = [self.place(f, i, m) for m in range(1, CAREFUL + 1)]
            lesser = changed(place, follows, speed.at("%state", low) * h, totals[PLACE].get())
            farthest.set(f.larger(farthest.get(), f.select(inside, lesser, zero)))
            lesser = changed(speed, speeds[1 : CAREFUL + 1], zero, totals[SPEED].get())
            found = totals[RATE].get()
            size = f.magnitude(found) + f.magnitude(speeds[1])
            speed.put(found, rates)
            most = allowed.of(f, self.lengths, size, speed.floored(lesser))
            most = most if nothing is None else most + nothing
            speed.put(most + speed.at("%state", self.noise.place) if self.noise else most, allowances)
        return f.reduce("fmax", farthest.get())

    def move_integrals(self, f: Function, h: Real, allowed: Allowance) -> None:
        """The same for integrals."""
        lengths, low, (rates, allowances, _) = self.lengths, self.state.width, self.expected(f)
        first, count = self.lasting
        with lengths.each(f, lengths.vector(first)) as row:
            inside, c = row.among(first, count), row.series().terms(1, lengths.order)
            change, rest = careful_sum(f, c, h, CHAINS)
            old, lost = row.at("%state"), row.at("%state", low)
            new, error = two_sum(old, change + (lost + rest))
            row.put(f.select(inside, new, old), "%state")
            row.put(f.select(inside, error, lost), "%state", low)
            if self.quadratures:
                found, lesser = rate(f, c[:-1], h, RATE_CHAINS), f.smaller(f.magnitude(new), f.magnitude(old))
                most = allowed.of(f, lengths, f.magnitude(found) + f.magnitude(c[0]), row.floored(lesser))
                row.put(f.select(inside, found, row.at(rates)), rates)
                row.put(f.select(inside, most, row.at(allowances)), allowances)

    def weights(self, f: Function) -> Pointer:
        """Where ``weigh`` has its numbers."""
        return f.place("%work", self.given.work - weights_size(self.lengths.order))

    def weigh(self, f: Function, h: Real) -> None:
        """What coefficients of velocities are multiplied by in a step of ``h``, for each of ``WEIGHTS``."""
        found, power = self.weights(f), f.variable(h)
        before = f.variable(f.constant(1.0))
        with f.loop(1, self.lengths.order + 1, tested=False) as m:
            place, number = m * len(WEIGHTS), m.to_real()
            f.store(power.get() / number, found, place + (PLACE - len(WEIGHTS)))
            f.store(power.get(), found, place + SPEED)
            f.store(number * before.get(), found, place + RATE)
            before.set(power.get())
            power.set(power.get() * h)


def idle_places(rows: GuardRows | None, state: StateLayout) -> list[slice[int, int, None]]:
    """Places of a state that ``VelocitySteps`` never change, if they are many: integrals of arguments, whose
    values nobody needs, and times of events, unless members bounce."""
    if rows is None or rows.arguments < FEWEST:
        return []
    first = state.integrals.start
    places = (start + first for start in (0, state.width, state.errors))
    found = [slice(one, one + rows.arguments) for one in places]
    return found if rows.bounces else [*found, rows.times(state)]


def weights_size(order: int) -> int:
    """Doubles that ``VelocitySteps`` need at the end of ``%work``; the last one is free."""
    return whole_vectors(len(WEIGHTS) * (order + 1) + 1)
