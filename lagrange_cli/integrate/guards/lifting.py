"""What begins at 0 is taken a little to its side where rounding would lead it back."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from lagrange_cli.integrate.guards.at_zero import ROUNDED_OFF
from lagrange_cli.integrate.guards.bound import Bound
from lagrange_cli.integrate.guards.pivoting import dip

OFTEN = 4
"""If a guard is due so many times more at one time, and no other, rounding leads it back."""
LED = 2.0**20
"""What others may hold is led on by so many rounding errors at most."""


class Lifting(Bound):
    """Arguments that have just left 0."""

    _again = 0
    """How often the same guard was due at one time, and no other."""

    def _lead_on(self, guards: Sequence[int]) -> None:
        """Take arguments a little to their sides that begin at 0 with rounding errors of the other sign, so
        that these do not lead back: where a force is let go at its limit, the first derivative is such an
        error. Of places, take the rates. Steps on rates, which carry something on, look at values of
        arguments instead: for them it is done if these lead back again and again."""
        carried = bool(self.machine.program.carried)
        if not guards or (carried and self._again < OFTEN):
            return
        self._series()
        arguments = self._coefficients_of_arguments()[guards]
        speeds = np.abs(self.memory[self._layout.part(0)][self._layout.v])
        least = 2.0 * ROUNDED_OFF[self.machine.program.parts - 1] * float(speeds.max())
        placed = [j for j in guards if self._rows.guards[j].placed]
        held = zip(placed, self._holding(placed).tolist())
        resting = {j for j, size in held if np.isfinite(size)}
        for j, u in zip(guards, arguments * self.modes[guards][:, None]):
            own = u[1:] * np.arange(1, len(u)) if j in placed else u
            farthest = dip(own[1:])
            if j in placed:
                if j in resting and own[0] < max(least, farthest):
                    self._take_to(j, self.modes[j] * max(least, farthest))
            elif farthest > 0.0 or carried:
                side, enough = float(self.modes[j]), max(least, farthest)
                leads = self._rows.bound and side * self._arguments()[j] >= enough
                if not leads and (not self._rows.bound or enough <= LED * least):
                    self._take_to(j, side * enough)
                self.marks[j] = 0.0
