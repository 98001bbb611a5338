"""What impacts leave of the motion's speed, and whether that is the end of infinitely many of them."""

from __future__ import annotations

from lagrange_cli.native.guards import LEFT, UNSEEN, GuardRows
from lagrange_cli.native.llvm.function import Function
from lagrange_cli.native.llvm.vector import Integer, Pointer
from lagrange_cli.native.state import Clock, StateLayout
from lagrange_cli.native.stepping.at_once import NEARLY, NOTHING, ROUNDING, AtOnce, Speeds, hits
from lagrange_cli.native.stepping.coming_to_rest import Bounce
from lagrange_cli.records import dataclass

SOON, SOONER = 2.0**-29, 2.0**-25
"""If all further impacts take no longer than this part of a step, as far as the force before the impact
tells, the caller decides whether the motion rests: the second where impacts act on one another, whose limit
others change."""
SLOW = 512.0
"""Impacts that leave no speed may be the last of infinitely many if they have so little, beside none."""
DOUBTFUL = 8.0
"""The height of a flight is known from values of the argument up to this factor, where rounding may hide
it."""


@dataclass(frozen=True)
class Bounces:
    """Writes the code for it. From a coefficient of an argument to the next one it is ``term`` doubles; where
    series are ``interpolated``, the caller decides on flights that these may not show. Whether the motion
    ``rests`` is seen to in compiled code, if that can."""

    rows: GuardRows
    layout: StateLayout
    term: int
    interpolated: bool
    at_once: AtOnce
    rests: bool

    def of(self, f: Function, j: Integer, results: Pointer, known: Speeds | None) -> Bounce:
        """Leave an impact to the caller that rounding or a jump may have made, or after which the motion may
        rest, unless that is seen to here. What it leaves; speeds are compared with those that are
        ``known``."""
        rows, layout, state = self.rows, self.layout, f.pointer("%state")
        event, still, last = j - rows.first_event, f.variable(f.never(1)), f.variable(f.never(1))
        numbers = [f.variable(f.constant(0.0)) for _ in range(5)]
        bounce = f.load_integer("@bounces", j)
        with f.when(~bounce.equals(NOTHING)):
            side, mark = f.load(state, j + rows.mode(layout)), f.load(state, j + rows.fresh(layout))
            above, rate, bend = (f.load("%row", m * self.term) * float(m) for m in (1, 2, 3))
            size = f.load(results, event * 2 + (len(rows.changed) + 1)) * ROUNDING
            left = f.load(results, bounce + (len(rows.changed) + 2 * rows.events)) * side
            t, low = (f.load(state, layout.at(one)) for one in (Clock.TIME, Clock.TIME_LOW))
            place = event * 2 + rows.times(layout).start
            before = f.load(state, place), f.load(state, place + 1)
            since, flight = (t - before[0]) + (low - before[1]), -left / (bend * side)
            remaining = flight / (f.constant(1.0) - flight / since)
            returns = (flight > 0.0) & (flight < since)
            own = event * 2 + len(rows.changed)
            moved = size * f.load(state, layout.at(Clock.STEP))
            near = f.larger(f.load(results, own) * ROUNDING, moved)
            wrong, least = (above * side < -near) | ~(rate * side < -size), size
            if known is not None:
                least = f.larger(size, known.least)
                still.set(self.at_once.stands(f.magnitude(left), known))
                if self.rests:
                    noise = f.larger(size, known.largest * ROUNDING)
                    wrong = wrong | (still.get() & ~(f.magnitude(rate) > noise * SLOW))
                    last.set(returns & (remaining * NEARLY <= known.soon) & (left > noise) & hits(f, j))
                wrong = wrong | ((mark > 0.0) & ~(rate * side < -least))
                wrong = wrong | ~((left > least) | still.get() | last.get())
            else:
                wrong = wrong | (mark > 0.0) | ~(left > least)
            with f.when(wrong):
                f.give(f.count(LEFT))
            part, length = SOONER if rows.reached else SOON, f.load(state, layout.at(Clock.STEP))
            soon = remaining <= length * part
            if known is not None:
                f.store(self.at_once.length(f, results), results, self.at_once.behind + len(rows.bounces))
                soon = remaining <= known.soon
                if self.rests:
                    soon = soon & ~hits(f, j)
            with f.when(returns & soon & ~still.get()):
                f.give(f.count(LEFT))
            if self.interpolated:
                height = left * 0.25 * f.smaller(since * (left / f.magnitude(rate)), f.magnitude(flight))
                with f.when(height <= f.load(results, own) * (UNSEEN * DOUBTFUL)):
                    f.give(f.count(LEFT))
            for one, value in zip(numbers, (side, above, rate, left, remaining)):
                one.set(value)
        side, above, rate, left, remaining = (one.get() for one in numbers)
        return Bounce(side, above, rate, left, remaining, still.get(), last.get())

    def note_time(self, f: Function, j: Integer) -> None:
        """Note the time of an impact."""
        rows, state = self.rows, f.pointer("%state")
        with f.when(~f.load_integer("@bounces", j).equals(NOTHING)):
            place = (j - rows.first_event) * 2 + rows.times(self.layout).start
            for ahead, part in enumerate((Clock.TIME, Clock.TIME_LOW)):
                f.store(f.load(state, self.layout.at(part)), state, place + ahead)
