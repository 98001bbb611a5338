"""Events whose arguments are 0 for as long as friction holds a motion.

Such an event has no side then: mode 0. It happens once, when its argument becomes 0 and the motion stops, but
not while the motion is held, or when it is released. Then its side is the one that the motion leads to.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from lagrange_cli.integrate.guards.modes import ROUNDING
from lagrange_cli.native.state import Clock
from lagrange_cli.records import dataclass

if TYPE_CHECKING:
    from lagrange_cli.integrate.arrays import Array
    from lagrange_cli.integrate.impacts.resting import Resting
    from lagrange_cli.integrate.impacts.sides import Sides

AHEAD = 2.0**-10
"""The part of the last step after which the sign of an argument tells where the motion leads."""


@dataclass(frozen=True)
class Moving:
    """The switches that hold the motion, the coefficients of all events' arguments (events, coefficients),
    and which of these were constantly 0."""

    held: frozenset[int]
    rows: Array
    still: tuple[bool, ...]


class Standstill:
    """The events of a motion beside those of resting contact."""

    def __init__(self, sides: Sides, resting: Resting) -> None:
        self._sides = sides
        self._events = [e for e in range(len(sides.program.events)) if e not in resting.guards]
        self._until = dict[int, float]()
        """By events that have been released: up to when the motion may turn or stop again as if it had not
        moved. A force that is not known to all digits lets go a little early."""
        self.possible = len(sides.program.guards) > 0
        """Whether anything might hold the motion."""

    def now(self) -> Moving:
        """How the motion is now."""
        sides, rows = self._sides, self._sides.all_coefficients()
        settling = sides.settling
        _, sizes = sides.act_now()
        still = tuple(
            abs(values[0]) <= ROUNDING * size and not any(sides.counting(values, rate))
            for values, (size, rate) in zip(rows, sizes)
        )
        held = np.flatnonzero(settling.modes[: settling.count] == 0.0)
        return Moving(frozenset(map(int, held)), rows, still)

    def hold(self) -> None:
        """Where the motion begins, or begins anew, arguments that are held at 0 have no side."""
        now = self.now()
        for e in self._events if now.held else ():
            if now.still[e]:
                self._sides.settling.modes[e + self._sides.first] = 0.0

    def stopped(self, before: Moving) -> dict[int, float]:
        """The events that happen because the motion has just been stopped, with the sides that they come
        from. Those that the motion leaves get a side."""
        now, sides, found = self.now(), self._sides, dict[int, float]()
        for e in self._events:
            side = sides.side(e)
            if not now.still[e]:
                if side == 0.0:
                    self._release(e, now.rows[e])
            elif now.held - before.held and side != 0.0:
                if not self.leaving(e, sides.now) and not before.still[e] and not sides.at_zero(e):
                    found[e] = side
                sides.settling.modes[e + sides.first] = 0.0
        return found

    @property
    def released(self) -> bool:
        """Whether the motion has been released yet."""
        return bool(self._until)

    def leaving(self, event: int, t: float) -> bool:
        """Whether the motion is just leaving the zero of an event's argument at which it was held."""
        return t <= self._until.get(event, -np.inf)

    def _release(self, event: int, values: Array) -> None:
        """Choose the side that the motion leads to from 0: forces that have just held each other may leave a
        rate that is nothing but rounding."""
        settling, layout, j = self._sides.settling, self._sides.layout, event + self._sides.first
        ahead = AHEAD * float(self._sides.memory[layout.at(Clock.LENGTH)])
        leads = float(np.polynomial.polynomial.polyval(ahead, values))
        settling.modes[j] = 1.0 if (leads if np.isfinite(leads) else values[0]) > 0.0 else -1.0
        settling.mark([j])
        self._until[event] = self._sides.now + ahead
