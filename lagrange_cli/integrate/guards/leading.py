"""Where modes of guards lead to: whether the motion that they give goes to their sides, or is held at 0."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from lagrange_cli.integrate.guards.at_zero import AtZero
from lagrange_cli.integrate.guards.modes import ROUNDING

if TYPE_CHECKING:
    from lagrange_cli.integrate.arrays import Array

FEW = 8
"""So many guards are looked at one by one."""
LET_GO = 2.0**-26
"""What is let go at its limit begins with an acceleration of 0, up to this part of what the force changes."""


class Leading(AtZero):
    """Multipliers, and the derivatives of arguments."""

    _let_go: int | None = None
    """The guard that is let go, as its multiplier has reached its bound."""

    def _multiplier(self, j: int) -> float:
        return float(self._multipliers([j])[0])

    def _multipliers(self, guards: Sequence[int]) -> Array:
        """The multipliers of guards, infinite where limits are 0."""
        listed = [self._rows.guards[j] for j in guards]
        limits = np.array([one.limit for one in listed], dtype=np.int64)
        others = np.array([one.multiplier for one in listed], dtype=np.int64)
        rows = np.where(limits, limits, others) - self._layout.v.start
        values = self._here.coefficients[:, 0]
        found: Array = values[rows].copy()
        limited = np.flatnonzero(limits)
        above, below = values[rows[limited]], values[rows[limited] + 1]
        whole = above + below
        with np.errstate(divide="ignore", invalid="ignore"):
            found[limited] = np.where(whole != 0.0, (above - below) / whole, np.inf)
        return found

    def _holding(self, guards: Sequence[int]) -> Array:
        """The sizes of multipliers, infinite where the motion passes u = 0 with a velocity."""
        sizes = np.abs(self._multipliers(guards))
        return np.where((self._passing(guards) == 0.0) & np.isfinite(sizes), sizes, np.inf)

    def _passing(self, guards: Sequence[int]) -> Array:
        """The rates with which arguments pass 0; those of velocities that others hold are rounding."""
        if not guards:
            return np.zeros(0)
        rates = self._coefficients_of(self._rows.first, self._rows.first + self.count)[guards, 1]
        still = np.array([self._rows.guards[j].explicit for j in guards])
        still |= np.abs(rates) <= ROUNDING * self.scale()[1]
        return np.where(still, 0.0, rates)

    def _misled(self, guards: Sequence[int]) -> list[int]:
        """The guards to whose sides the motion does not lead, nor along u = 0."""
        found = list[int]()
        for some in few_or_all(guards):
            self.modes[some] = -self.modes[some]
            self._series()
            others = [self._coefficients(self._rows.first + j) for j in some]
            self.modes[some] = -self.modes[some]
            self._series()
            usual = self.scale()
            for j, other in zip(some, others):
                u = self._coefficients(self._rows.first + j)
                change = np.abs(u - other)
                scale = ROUNDING * np.fmax(usual[: len(u)], change)
                if j == self._let_go and not self._rows.guards[j].placed:
                    scale[1] = max(scale[1], LET_GO * change[1])
                clear = np.flatnonzero(~(np.abs(u[1:]) <= scale[1:]))
                leads = u[1 + clear[0]] * self.modes[j] > 0.0 if len(clear) else np.all(np.isfinite(u))
                if not leads:
                    found.append(j)
        return found


def few_or_all(guards: Sequence[int]) -> list[list[int]]:
    """A few guards one by one, many of them together: a series costs as much as there are of them."""
    if len(guards) <= FEW:
        return [[j] for j in guards]
    return [[*guards]]
