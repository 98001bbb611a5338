"""States a little way along a motion, and what is known of arguments and accelerations there."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from lagrange_cli.integrate.guards.modes import Modes
from lagrange_cli.native.state import Clock

if TYPE_CHECKING:
    from lagrange_cli.integrate.arrays import Array

TOLD = 2.0**-3
"""An argument whose rounding error is a larger part of it is not known well enough."""


class TrialStates(Modes):
    """Moves the state in the memory to be tried, and looks at its series."""

    def regular(self, guards: Sequence[int]) -> Array:
        """Modes of guards whose arguments are 0 with which accelerations and their series are finite; the
        present ones as far as that is possible."""
        infinite = self._infinite()
        for j in guards:
            if not infinite:
                break
            if self.modes[j] != 0.0:
                self.modes[j] = -self.modes[j]
                others = self._infinite()
                if others < infinite:
                    infinite = others
                else:
                    self.modes[j] = -self.modes[j]
        found: Array = self.modes[guards].copy()
        return found

    def _infinite(self) -> int:
        """The number of coefficients of velocities that are not finite."""
        self._series()
        velocities = self._coefficients_of(self._layout.v.start, self._layout.v.stop)
        return int(np.count_nonzero(~np.isfinite(velocities)))

    def _accelerations(self, start: Array, rates: Array, t: float, mode: Array, j: Sequence[int]) -> Array:
        """The accelerations after the time t."""
        self.memory[:] = start
        self._move(t, rates)
        self.modes[j] = mode
        self._series()
        return self._rates_of_rows()[: self._layout.degrees]

    def _values(self, guards: Sequence[int]) -> Array:
        """The arguments of guards."""
        return np.array([self._coefficients(self._rows.first + j)[0] for j in guards])

    def told(self, guards: Sequence[int], values: Array) -> bool:
        """Whether the arguments of guards are not 0, and doubles tell: without the low parts of coordinates,
        they have about these ``values``, too."""
        if self.machine.program.parts > 1:
            return bool(np.all(values != 0.0))
        reached = self.memory.copy()
        self.memory[self._layout.part(1)][self._layout.q] = 0.0
        self._series()
        values = np.where(values == 0.0, np.nan, values)
        told = np.all(np.abs(self._values(guards) - values) <= TOLD * np.abs(values))
        self.memory[:] = reached
        self._series()
        return bool(told)

    def _slopes(self, guards: Sequence[int]) -> Array:
        """How fast the arguments of guards change."""
        return np.array([self._coefficients(self._rows.first + j)[1] for j in guards])

    def _rates_of_rows(self) -> Array:
        """The rates of all rows but q, from the series."""
        found: Array = self._coefficients_of(self._layout.rates.start, self._layout.rates.stop)[:, 0]
        return found

    def _move(self, t: float, rates: Array) -> None:
        """Move by the time ``t`` with constant rates."""
        layout = self._layout
        high, low = (self.memory[layout.part(part)].copy() for part in (0, 1))
        self._add(layout.q, high[layout.v] * t)
        self._add(layout.q, low[layout.v] * t + rates[: layout.degrees] * (t * t / 2))
        self._add(layout.rates, rates * t)
        self._add(slice(layout.time, layout.time + 1), t, Clock.TIME_LOW - Clock.TIME)

    def _add(self, rows: slice[int, int, None], change: Array | float, apart: int | None = None) -> None:
        """Add to numbers whose low parts are so far ``apart``, without an error of rounding (D. Knuth)."""
        shift = self._layout.width if apart is None else apart
        high, low = (self.memory[rows.start + k : rows.stop + k] for k in (0, shift))
        total = high + change
        rest = total - high
        low += (high - (total - rest)) + (change - rest)
        high[:] = total

    def _speed(self) -> float:
        """The speed that the motion gains from rest over a distance as large as its coordinates."""
        high, layout = self.memory[self._layout.part(0)], self._layout
        accelerations = np.abs(self._coefficients_of(layout.v.start, layout.v.stop)[:, 0])
        known = accelerations[np.isfinite(accelerations)]
        return float(np.sqrt(np.max(known, initial=0.0)) * np.sqrt(np.max(np.abs(high[layout.q]))))
