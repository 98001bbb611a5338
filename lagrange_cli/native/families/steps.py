"""Steps of systems of families: coefficients of all rows are side by side."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager

from lagrange_cli.native.families.jets import BRIEF, JET
from lagrange_cli.native.families.spans import divided, smaller
from lagrange_cli.native.interface import LANES
from lagrange_cli.native.llvm.function import Function
from lagrange_cli.native.llvm.vector import Bit, Integer, Pointer, Real
from lagrange_cli.native.numbers.error_free import operators_two_sum as two_sum
from lagrange_cli.native.stepping.acceptance import Allowance
from lagrange_cli.native.stepping.doubles import DoubleSteps
from lagrange_cli.native.stepping.lengths import Row
from lagrange_cli.native.stepping.polynomial import CAREFUL, careful_sum
from lagrange_cli.native.stepping.steps import STRAIGHT, Now

WEIGHTS = PLACE, SPEED, RATE = range(3)
"""What velocities' coefficients m give at the end of a step: h^(m + 1)/(m + 1) to coordinates, h^m to
velocities, m h^(m - 1) to accelerations."""


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

    def take_sums(self, f: Function, dt: Real, take: Callable[[Integer, Integer, Real], None]) -> None:
        """``take(i, last, sum)`` for vectors of rows: those from ``i`` to before ``last``, and what their
        series add within ``dt``."""
        lengths = self.lengths
        with lengths.each(f, 0, lengths.rows) as row:
            total = f.variable(f.zero(lengths.lanes))
            with self.orders(f) as m:
                total.set(f.fused(total.get(), dt, row.series()[m]))
            take(row.i, f.count(lengths.rows), total.get() * dt)

    def sample(self, f: Function, now: Now, index: Integer, h: Real) -> Integer:
        """One after the other: most steps have few of them, but many rows."""
        at, lanes = f.variable(index), self.lengths.lanes
        with f.forever() as rounds:
            after = (f.load("%times", at.get()) - now.t) - now.low
            with f.when(~(after <= h)):
                rounds.leave()
            dt = f.splat(after, lanes)

            def take(i: Integer, last: Integer, change: Real) -> None:
                rest = f.load_row("%state", i + self.state.part(1).start, lanes)
                value = f.load_row("%state", i, lanes) + (change + rest)
                with f.loop(0, smaller(f, f.count(lanes), last - i), tested=False) as lane:
                    f.store(f.lane(value, lane), "%out", (i + lane) * Integer(f, "%stride") + at.get())

            self.take_sums(f, dt, take)
            at.set(at.get() + 1)
        return at.get()


class VelocitySteps(FamilySteps):
    """With series of the velocities, from which those of the coordinates follow."""

    def expand(self, f: Function, now: Now, brief: Callable[[], Bit] | None = None) -> tuple[Now, Bit]:
        if brief is None:
            return super().expand(f, now)
        self.measure(f, now)
        given, regular = (f.pointer("%constants"), now.t + now.low, *self.places(f)), f.variable(f.never(1))
        with f.when(brief()):
            regular.set(f.call(Bit, BRIEF, *given))
        with f.otherwise():
            regular.set(f.call(Bit, JET, *given))
        return now, regular.get()

    def speed(self, f: Function, i: Integer, m: Integer | int) -> Real:
        """Coefficient ``m`` of velocities, from the ``i``-th one on."""
        first = self.lengths.first + self.lengths.degrees
        return f.load_row(f.place("%work", m * self.lengths.term + first, "double"), i, self.lengths.lanes)

    def follower(self, f: Function, i: Integer, m: Integer | int) -> Real:
        """Coefficient ``m`` of their coordinates."""
        tables = (f.splat(f.load(table, m), self.lengths.lanes) for table in ("@reciprocals", "@rests"))
        return divided(f, self.speed(f, i, m - 1), *tables)

    def take_sums(self, f: Function, dt: Real, take: Callable[[Integer, Integer, Real], None]) -> None:
        degrees = f.count(self.lengths.degrees)
        with f.loop(0, degrees, self.lengths.lanes, tested=False) as i:
            place, speed = (f.variable(f.zero(self.lengths.lanes)) for _ in range(2))
            with self.orders(f) as m:
                for total, one in ((place, self.follower(f, i, m)), (speed, self.speed(f, i, m))):
                    total.set(f.fused(total.get(), dt, one))
            take(i, degrees, place.get() * dt)
            take(i + degrees, degrees + degrees, speed.get() * dt)

    def move(self, f: Function, now: Now, h: Real, final: Bit, allowed: Allowance) -> Real:
        self.pass_time(f, now, h)
        if self.noise:
            self.noise.count(f)
        low, degrees, (rates, allowances, _) = self.state.width, self.lengths.degrees, self.expected(f)
        lanes, weights = self.lengths.lanes, self.weights(f, h)
        h, zero = f.splat(h, lanes), f.zero(lanes)
        farthest = f.variable(zero)
        with f.loop(0, degrees, lanes, tested=False) as i:
            place, speed = Row(self.lengths, f, i), Row(self.lengths, f, i + degrees)
            inside = place.among(0, degrees)
            speeds = [self.speed(f, i, m) for m in range(CAREFUL + 2)]
            totals = [f.variable(zero) for _ in WEIGHTS]
            """Sums of terms, from the last ones to the larger ones."""

            def add(which: int, m: Integer | int, one: Real) -> None:
                weight = f.splat(f.load(weights, m * len(WEIGHTS) + which), lanes)
                totals[which].set(f.fused(one, weight, totals[which].get()))

            with self.orders(f, CAREFUL + 1) as k:
                one = self.speed(f, i, k)
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
            follows = [self.follower(f, i, m) for m in range(1, CAREFUL + 1)]
            lesser = changed(place, follows, speed.at("%state", low) * h, totals[PLACE].get())
            farthest.set(f.larger(farthest.get(), f.select(inside, lesser, zero)))
            lesser = changed(speed, speeds[1 : CAREFUL + 1], zero, totals[SPEED].get())
            found = totals[RATE].get()
            size = f.magnitude(found) + f.magnitude(speeds[1])
            speed.put(found, rates)
            most = allowed.of(f, self.lengths, size, speed.floored(lesser))
            speed.put(most + speed.at("%state", self.noise.place) if self.noise else most, allowances)
        return f.reduce("fmax", farthest.get())

    def weights(self, f: Function, h: Real) -> Pointer:
        """What coefficients of velocities are multiplied by in a step of ``h``, for each of ``WEIGHTS``."""
        found, power = f.place("%work", self.given.work - weights_size(self.lengths.order)), f.variable(h)
        before = f.variable(f.constant(1.0))
        with f.loop(1, self.lengths.order + 1, tested=False) as m:
            place, number = m * len(WEIGHTS), m.to_real()
            f.store(power.get() / number, found, place + (PLACE - len(WEIGHTS)))
            f.store(power.get(), found, place + SPEED)
            f.store(number * before.get(), found, place + RATE)
            before.set(power.get())
            power.set(power.get() * h)
        return found


def weights_size(order: int) -> int:
    """Doubles that ``VelocitySteps`` need at the end of ``%work``."""
    return LANES * -(-len(WEIGHTS) * (order + 1) // LANES)
