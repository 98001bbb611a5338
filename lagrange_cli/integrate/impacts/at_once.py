"""What happens at one time: how much of it, and the largest speeds, beside which others are rounding."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from lagrange_cli.integrate.arrays import Array
from lagrange_cli.integrate.guards.modes import ROUNDING

NO_TIME, AGAIN = 2.0**-50, 1000
"""So many actions for each event, within this fraction of the time, count as infinitely many."""


class AtOnce:
    """Of a motion with so many events, which begins at ``start``; its numbers have so many parts."""

    def __init__(self, count: int, start: float, parts: int) -> None:
        self._least = ROUNDING**parts
        self._start, self._latest = start, -np.inf
        self.same = 0
        """How many actions there have been at this time."""
        self._time, self._rates = -np.inf, np.zeros(count)
        self._ends = np.full(count, -np.inf)

    def recurs(self, now: float, none: float) -> bool:
        """Whether infinitely many actions happen at one time, one of them now; up to ``none`` is no time."""
        at_once = now - self._latest <= none or self._since(self._latest, now)
        self.same = self.same + 1 if at_once else 0
        self._latest = now
        return self.same >= AGAIN * max(1, len(self._rates))

    def _since(self, before: float, now: float) -> bool:
        """Whether no time has passed."""
        return now - before <= NO_TIME * max(abs(now), now - self._start)

    def noise(self, now: float, rates: Array, gained: Array) -> Array:
        """How large rounding errors of the rates of events' arguments are, whose terms are as large as
        ``rates`` now, and ``gained`` in a step: what is left of larger ones is not known better than these
        were."""
        if not self._since(self._time, now):
            self._rates = np.zeros(len(self._rates))
        self._time, self._rates = now, np.fmax(self._rates, np.fmax(rates, gained))
        return np.fmax(ROUNDING * rates, self._least * self._rates)

    def first(self, event: int, now: float) -> bool:
        """Whether an event ends at this time for the first time."""
        before, self._ends[event] = self._ends[event], now
        return not self._since(before, now)

    def state(self) -> tuple[float, ...]:
        """The numbers that a continued run needs."""
        return (float(self.same), self._latest, self._time, *self._rates.tolist(), *self._ends.tolist())

    def restore(self, state: Sequence[float]) -> Sequence[float]:
        """Go on with these numbers; those that follow."""
        same, self._latest, self._time = state[:3]
        self.same, count = int(same), len(self._rates)
        self._rates, self._ends = (np.array(state[3 + k * count :][:count]) for k in range(2))
        return state[3 + 2 * count :]
