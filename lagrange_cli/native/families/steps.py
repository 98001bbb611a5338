"""Steps of systems of families: coefficients of all rows are side by side."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence

from lagrange_cli.native.families.spans import divided
from lagrange_cli.native.interface import LANES
from lagrange_cli.native.llvm.function import Function
from lagrange_cli.native.llvm.vector import Bit, Integer, Real
from lagrange_cli.native.numbers.error_free import operators_two_sum as two_sum
from lagrange_cli.native.recurrences.stage import reciprocal_rest
from lagrange_cli.native.stepping.acceptance import Allowance
from lagrange_cli.native.stepping.doubles import DoubleSteps
from lagrange_cli.native.stepping.lengths import Row
from lagrange_cli.native.stepping.polynomial import careful_sum, rate
from lagrange_cli.native.stepping.steps import STRAIGHT, Now
from lagrange_cli.native.stepping.sums import CHAINS, RATE_CHAINS


class FamilySteps(DoubleSteps):
    """With series of all rows."""

    def straighten(self, f: Function) -> None:
        first, last = STRAIGHT * self.lengths.term, (self.lengths.order + 1) * self.lengths.term
        with f.loop(first, last, LANES, tested=False) as i:
            f.store_row(f.zero(LANES), "%work", i)


class VelocitySteps(FamilySteps):
    """With series of the velocities, from which those of the coordinates follow."""

    def speeds(self, f: Function, i: Integer, lanes: int) -> list[Real]:
        """All coefficients of so many velocities, from the ``i``-th one on."""
        first = self.lengths.first + self.lengths.degrees
        return [
            f.load_row("%work", i + (first + m * self.lengths.term), lanes)
            for m in range(self.lengths.order + 1)
        ]

    def take_series(self, f: Function, take: Callable[[Integer, Iterable[Real]], None]) -> None:
        degrees = self.lengths.degrees
        with f.loop(0, 2 * degrees, tested=False) as i:
            is_place = i < degrees
            speeds = self.speeds(f, f.select(is_place, i, i - degrees), 1)
            both = zip(followers(f, speeds), speeds[1:])
            take(i, (f.select(is_place, place, speed) for place, speed in both))

    def move(self, f: Function, now: Now, h: Real, final: Bit, allowed: Allowance) -> Real:
        self.pass_time(f, now, h)
        low, degrees, (rates, allowances, _) = self.state.width, self.lengths.degrees, self.expected(f)
        lanes = self.lengths.lanes
        h, zero = f.splat(h, lanes), f.zero(lanes)
        farthest = f.variable(zero)
        with f.loop(0, degrees, lanes, tested=False) as i:
            place, speed = Row(self.lengths, f, i), Row(self.lengths, f, i + degrees)
            inside = place.among(0, degrees)

            def changed(row: Row, c: Sequence[Real], extra: Real) -> Real:
                """The rows after the step; where they are nearer to 0, there or before."""
                change, rest = careful_sum(f, c, h, CHAINS)
                old, lost = row.at("%state"), row.at("%state", low)
                new, error = two_sum(old, change + ((lost + extra) + rest))
                row.put(f.select(inside, new, old), "%state")
                row.put(f.select(inside, error, lost), "%state", low)
                return f.smaller(f.magnitude(new), f.magnitude(old))

            series = self.speeds(f, i, lanes)
            # the low part of a velocity moves its coordinate
            lesser = changed(place, followers(f, series), speed.at("%state", low) * h)
            farthest.set(f.larger(farthest.get(), f.select(inside, lesser, zero)))
            lesser = changed(speed, series[1:], zero)
            found = rate(f, series[1:-1], h, RATE_CHAINS)
            size = f.magnitude(found) + f.magnitude(series[1])
            speed.put(found, rates)
            speed.put(allowed.of(f, self.lengths, size, speed.floored(lesser)), allowances)
        return f.reduce("fmax", farthest.get())


def followers(f: Function, speeds: Sequence[Real]) -> list[Real]:
    """The coefficients of coordinates from the first on, from those of their velocities."""
    found = [speeds[0]]
    for m, one in enumerate(speeds[1:-1], 2):
        inverse, rest = (f.splat(f.constant(x), one.lanes) for x in (1.0 / m, reciprocal_rest(m)))
        found.append(divided(f, one, inverse, rest))
    return found
