"""Friction along a vector u (see ``mechanics.guards.vectors``): where u becomes 0, the motion is held, or
slides on in the direction in which it is pushed; where what holds it reaches its limit, it begins to slide.

At u = 0 the direction u/|u| has no series, though it has a limit. The motion is taken a little way from there
by collocation: rates at Gauss's nodes are those of the polynomial through them."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from lagrange_cli.integrate.methods.gauss import gauss
from lagrange_cli.integrate.methods.leading import Leading
from lagrange_cli.native.guards import HELD, SMALLEST
from lagrange_cli.native.state import BEGINNING, Clock

if TYPE_CHECKING:
    from lagrange_cli.integrate.arrays import Array
    from lagrange_cli.native.compilation.machine import Machine

SOON = 2.0**-30
"""A velocity that becomes 0 within this fraction of the time is set to 0."""
STAGES, ROUNDS, SHORTER, LEAST = 8, 12, 2.0**-2, 2.0**-40
"""Gauss's nodes; iterations of Newton's method, at most; how much shorter the next way is, and the shortest,
as part of the time."""
CONVERGED, RESOLVED = 2.0**-48, 2.0**-48
"""Changes of accelerations in the last iteration, and the last coefficient of their polynomials, beside that
of friction."""
NUDGE = 2.0**-24
"""By which part of |u| velocities are changed to find how forces depend on them."""


class Sliding(Leading):
    """The modes of lengths of vectors."""

    def __init__(self, machine: Machine, constants: Array, memory: Array, work: Array) -> None:
        super().__init__(machine, constants, memory, work)
        self.ahead = np.inf
        """The time of the next sample, which no way goes beyond."""

    def vectors(self) -> list[int]:
        """The guards of lengths."""
        return [j for j, guard in enumerate(self._rows.guards) if guard.parts]

    def stops(self) -> bool:
        """Hold the motion where a length is about to be 0, or slide on; whether there is one."""
        self._series()
        soon = max(abs(self.memory[self._layout.time]), SMALLEST) * SOON
        for j in self.vectors():
            u, rate = self._coefficients(self._rows.first + j)[:2]
            if not self._rows.guards[j].multiplier:
                rate = -abs(rate)  # it may just have passed 0, up to rounding
            if self.modes[j] != 0.0 and rate < 0.0 < u <= -rate * soon:
                return self.slide_or_hold(j)
        return False

    def slide_or_hold(self, j: int) -> bool:
        """Choose the mode of a length that has become 0, or whose force has reached its limit; whether the
        motion goes on."""
        before = self.memory.copy()
        for number in BEGINNING:
            self.memory[self._layout.at(number)] = 0.0
        reached, holds = self.modes[j] == 0.0, bool(self._rows.guards[j].multiplier)
        self.modes[j] = 0.0
        if holds or not reached:
            self._stop(j)
        self._series()
        if not reached and (self._multiplier(j) <= HELD if holds else self._waits(j)):
            self.prepare()
            return True
        found = (holds or not self._waits(j)) and self._slide(j)
        if not found:
            self.memory[:] = before
        if reached and not holds:  # the vector is not 0 any more
            self.modes[j], found = 1.0, True
        self.prepare()
        return found

    def _waits(self, j: int) -> bool:
        """Whether a motion that nothing holds goes on for a while as if the vector were 0: nothing changes
        it, or time is resolved so well that this makes no difference."""
        return self.machine.program.parts > 1 or not np.any(self._push(j))

    def _push(self, j: int) -> Array:
        """The direction in which a vector begins to change: of the force that holds it, or of its rate."""
        guard = self._rows.guards[j]
        first, m = (guard.multiplier, 0) if guard.multiplier else (guard.beside, 1)
        found: Array = self._coefficients_of(first, first + guard.parts)[:, m].copy()
        return found

    def _parts(self, j: int) -> Array:
        """The parts of a vector."""
        guard = self._rows.guards[j]
        self._series()
        found: Array = self._coefficients_of(guard.beside, guard.beside + guard.parts)[:, 0].copy()
        return found

    def _slopes_of_parts(self, j: int) -> Array:
        """Their derivatives by velocities (parts, velocities); they are linear in these."""
        memory, rows = self.memory.copy(), self._layout.v
        here, found = self._parts(j), []
        for k in range(rows.start, rows.start + self.machine.program.degrees):
            self.memory[k] += 1.0
            found.append(self._parts(j) - here)
            self.memory[:] = memory
        slopes: Array = np.array(found).T
        return slopes

    def _stop(self, j: int) -> None:
        """Take a vector away that is 0 up to rounding."""
        if not np.any(self._parts(j)):
            return
        inverse, own = np.linalg.pinv(self._slopes_of_parts(j)), self.machine.program.degrees
        for _ in range(2):
            self._add(slice(self._layout.v.start, self._layout.v.start + own), -inverse @ self._parts(j))

    def _slide(self, j: int) -> bool:
        """Begin to slide from u = 0, a little way."""
        layout, origin = self._layout, self.memory.copy()
        self._series()
        together = [j]
        if self._rows.guards[j].multiplier:
            direction = np.linalg.pinv(self._slopes_of_parts(j)) @ self._push(j)
        else:
            direction = self._rates_of_rows()[: self.machine.program.degrees].copy()
            others = (k for k in self.vectors() if not self._rows.guards[k].multiplier)
            together += [k for k in others if self.modes[k] == 0.0 and np.any(self._push(k))]
        now, length = float(origin[layout.time]), float(origin[layout.at(Clock.LENGTH)])
        if not (length and self._rows.guards[j].multiplier):  # the last step may have been short
            length = self.span
        length = min(length, self.span) * SHORTER
        if self.ahead > now:
            length = min(length, self.ahead - now)
        while np.all(np.isfinite(direction)) and np.any(direction):
            if length < LEAST * max(abs(now), self.span):
                break
            self.memory[:] = origin
            self.modes[together] = 1.0
            if self._collocated(j, length, direction / np.linalg.norm(direction)):
                return True
            length *= SHORTER
        self.memory[:] = origin
        return False

    def _collocated(self, j: int, length: float, direction: Array) -> bool:
        """Move on by a time, from u = 0 in about this direction of velocities; whether the polynomials
        converge."""
        layout, origin, own = self._layout, self.memory.copy(), self.machine.program.degrees
        nodes, weights = (np.array(one) for one in zip(*gauss(STAGES)))
        powers = nodes[:, None] ** np.arange(STAGES)
        inverse = np.linalg.inv(powers)
        once = (nodes[:, None] ** np.arange(1, STAGES + 1) / np.arange(1, STAGES + 1)) @ inverse
        twice, at_end = once @ once, weights @ once
        v = slice(layout.v.start, layout.v.start + own)

        def rates(t: float, places: Array, speeds: Array) -> Array:
            self.memory[:] = origin
            self._move(t, np.zeros(layout.rates.stop - layout.rates.start))
            self._add(slice(layout.q.start, layout.q.start + own), places)
            self._add(v, speeds)
            self._series()
            return self._rates_of_rows()

        times, none = nodes * length, np.zeros(own)
        holds = bool(self._rows.guards[j].multiplier)
        tiny = SOON * (float(np.max(np.abs(origin[layout.v]))) * holds or length)
        guesses = [float(rates(t, none, tiny * direction)[:own] @ direction) for t in times]
        found: Array = np.outer(guesses, direction)
        apart = [rates(0.0, none, side * tiny * direction)[:own] for side in (1.0, -1.0)]
        usual = float(np.max(np.abs(apart[0] - apart[1] if holds else apart)))
        for _ in range(ROUNDS):
            speeds, places = length * (once @ found), length**2 * (twice @ found)
            if not np.all(np.isfinite(found)):
                return False
            here = [rates(*one) for one in zip(times, places, speeds)]
            accelerations = np.array([one[:own] for one in here])
            matrix = np.eye(STAGES * own)
            for i, t in enumerate(times):
                size = NUDGE * float(np.max(np.abs(speeds[i])))
                for k in range(own):
                    nudge = np.zeros(own)
                    nudge[k] = size
                    slope = (rates(t, places[i], speeds[i] + nudge)[:own] - accelerations[i]) / size
                    for m in range(own):
                        matrix[i * own + m, k::own] -= length * once[i] * slope[m]
            if not (np.all(np.isfinite(matrix)) and np.all(np.isfinite(accelerations))):
                return False
            change = np.linalg.solve(matrix, (accelerations - found).ravel()).reshape(found.shape)
            found = found + change
            if np.max(np.abs(change)) <= CONVERGED * usual:
                break
        else:
            return False
        highest = np.abs(inverse @ found)[-1] / 4.0 ** (STAGES - 1)
        if np.max(highest) > RESOLVED * usual:
            return False
        speeds, places = length * (once @ found), length**2 * (twice @ found)
        here = [rates(*one) for one in zip(times, places, speeds)]
        self.memory[:] = origin
        self._move(length, np.zeros(layout.rates.stop - layout.rates.start))
        self._add(slice(layout.q.start, layout.q.start + own), length**2 * (at_end @ found))
        total = length * (weights @ np.array(here))
        total[:own] = length * (weights @ found)
        self._add(layout.rates, total)
        arguments = self.coefficients_between(self._rows.first, self._rows.first + self._rows.count)[:, 0]
        return bool(np.all(arguments * self.modes[: len(arguments)] >= 0.0))
