"""Drag along a vector u, such as -c |u| u, where u is 0: nothing holds the motion, but |u| has no series.

Where u becomes 0, or the motion begins there, it is taken a little way beyond by collocation at Gauss's
nodes, as where sliding begins. If nothing moves it yet, or time is resolved so well that this makes no
difference, it goes on as if |u| were 0 until that is larger."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from lagrange_cli.integrate.methods.onset import EXACT, ROUNDS, SOON, STAGES, Onset, Way, inverse_of, rule
from lagrange_cli.native.guards import SMALLEST
from lagrange_cli.native.state import BEGINNING

if TYPE_CHECKING:
    from lagrange_cli.integrate.arrays import Array
    from lagrange_cli.native.compilation.machine import Machine

SHORTER, LEAST, NUDGE = 2.0**-2, 2.0**-40, 2.0**-24
"""How much shorter the next way is, and the shortest, as part of the time; by which part of |u| velocities
are changed to find how forces depend on them."""


class Drag(Onset):
    """Motions that pass u = 0."""

    def __init__(self, machine: Machine, constants: Array, memory: Array, work: Array) -> None:
        super().__init__(machine, constants, memory, work)
        self.end = np.inf
        """The time at which the motion ends, which no way goes beyond."""

    def dragged(self) -> list[int]:
        """The guards of lengths of vectors that nothing holds."""
        return [j for j, guard in enumerate(self._rows.guards) if guard.parts and not guard.multiplier]

    def turns(self) -> bool:
        """Pass where such a length is 0 up to rounding; whether there is one."""
        self._series()
        soon = max(abs(self.memory[self._layout.time]), SMALLEST) * SOON
        for j in self.dragged():
            u, rate = self._coefficients(self._rows.first + j)[:2]
            if self.modes[j] != 0.0 and 0.0 < u <= abs(rate) * soon:
                return self.pass_zero(j)
        return False

    def pass_zero(self, j: int) -> bool:
        """Go on where a length has become 0, or is not 0 any more; whether that was possible."""
        before, left = self.memory.copy(), self.modes[j] == 0.0
        for number in BEGINNING:
            self.memory[self._layout.at(number)] = 0.0
        self.modes[j] = 0.0
        if not left:
            inverse = inverse_of(self._slopes_of_parts(j))
            for _ in range(2):
                self._add(self._own, -inverse @ self._parts(j))
        self._series()
        waits = self.machine.program.parts > 1 or not np.any(self._change(j))
        found = not left if waits else self._taken_beyond()
        if not found:
            self.memory[:] = before
        if left and not found:
            self.modes[j], found = 1.0, True
        self.prepare()
        return found

    def _change(self, j: int) -> Array:
        """The rates of the parts of a vector."""
        guard = self._rows.guards[j]
        found: Array = self._coefficients_of(guard.beside, guard.beside + guard.parts)[:, 1].copy()
        return found

    def _taken_beyond(self) -> bool:
        """Move on a little, with all vectors that are 0 now and change; whether a way was found."""
        origin, now = self.memory.copy(), float(self.memory[self._layout.time])
        changing = [k for k in self.dragged() if self.modes[k] == 0.0 and np.any(self._change(k))]
        direction = self._rates_of_rows()[: self.machine.program.degrees].copy()
        direction /= np.linalg.norm(direction)
        length = min(self.span * SHORTER, self.end - now)
        while length >= LEAST * max(abs(now), self.span) and np.all(np.isfinite(direction)):
            self.memory[:] = origin
            self.modes[changing] = 1.0
            if self._passed(length, direction):
                return True
            length *= SHORTER
        self.memory[:] = origin
        return False

    def _passed(self, length: float, direction: Array) -> bool:
        """Move on by a time, with velocities that begin to change in this direction; whether polynomials of
        that length describe the motion."""
        origin, own, gauss_rule = self.memory.copy(), self.machine.program.degrees, rule()
        once, twice, times = gauss_rule.once, gauss_rule.twice, gauss_rule.nodes * length

        def rates(t: float, places: Array, speeds: Array) -> Array:
            self.memory[:] = origin
            return self._rates_at(t, places, speeds)

        none, tiny = np.zeros(own), SOON * length * direction
        found: Array = np.outer([rates(t, none, tiny)[:own] @ direction for t in times], direction)
        usual = EXACT * float(np.max(np.abs(found)))
        for _ in range(ROUNDS):
            if not np.all(np.isfinite(found)):
                return False
            speeds, places = length * (once @ found), length**2 * (twice @ found)
            accelerations = np.array([rates(*one)[:own] for one in zip(times, places, speeds)])
            matrix = np.eye(STAGES * own)
            for i, t in enumerate(times):
                size = NUDGE * float(np.max(np.abs(speeds[i])))
                for k in range(own):
                    nudged = rates(t, places[i], speeds[i] + size * np.eye(own)[k])[:own]
                    slope = (nudged - accelerations[i]) / size
                    for m in range(own):
                        matrix[i * own + m, k::own] -= length * once[i] * slope[m]
            if not (np.all(np.isfinite(matrix)) and np.all(np.isfinite(accelerations))):
                return False
            change = np.linalg.solve(matrix, (accelerations - found).ravel()).reshape(found.shape)
            found = found + change
            if np.max(np.abs(change)) <= usual:
                break
        else:
            return False
        if np.max(np.abs(gauss_rule.series[-1] @ found)) > usual:
            return False
        speeds, places = length * (once @ found), length**2 * (twice @ found)
        here = np.array([rates(*one) for one in zip(times, places, speeds)])
        self.onset = Way(origin, length, np.hstack([found, here[:, own:]]))
        self._follow(self.onset, length)
        self.marks[:] = np.fmin(self.marks, 0.0)
        return self._on_their_sides()
