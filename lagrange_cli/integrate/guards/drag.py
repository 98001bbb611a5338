"""Drag along a vector u, such as -c |u| u, where u is 0: nothing holds the motion, but |u| has no series.

The motion goes on there as if |u| were 0, until that is larger: what drag would change meanwhile is less than
rounding."""

from __future__ import annotations

from lagrange_cli.integrate.guards.onset import Onset
from lagrange_cli.integrate.guards.resting import SOON
from lagrange_cli.native.guards import SMALLEST

APART, LARGER = 2.0**-40, 2.0**4
"""Drag acts from so long after u = 0 on, as part of the time, so that steps lead on; how much larger the
square of u is before that is asked again."""


class Drag(Onset):
    """Motions that pass u = 0."""

    def dragged(self) -> list[int]:
        """The guards of lengths of vectors that nothing holds."""
        return [j for j in self._rows.vectors if not self._rows.guards[j].multiplier]

    def turns(self) -> bool:
        """Leave drag out along a vector that is about to be 0, or has just been; whether there is one."""
        self._series()
        soon = max(abs(self.memory[self._layout.time]), SMALLEST) * SOON
        for j in self.dragged():
            u, rate = self._coefficients(self._rows.first + j)[:2]
            if self.modes[j] != 0.0 and u <= abs(rate) * soon:
                return self.pass_zero(j)
        return False

    def pass_zero(self, j: int) -> bool:
        """Leave drag along a vector out until times since it was 0 are told apart: the motion goes on."""
        waited, self.modes[j] = self.modes[j] == 0.0, 0.0
        self._series()
        square, rate = self._coefficients(self._rows.first + j)[:2]
        if waited and 2.0 * square >= APART * rate * self.memory[self._layout.time]:
            self.modes[j] = 1.0
        else:
            self.marks[j] = -LARGER * square
        self.begin_steps()
        self.prepare()
        return True
