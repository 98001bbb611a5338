"""Impulses of slow impacts in a state: how each of them changes the relative velocities of others."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from lagrange_cli.integrate.arrays import largest_of
from lagrange_cli.integrate.guards.modes import ROUNDING
from lagrange_cli.integrate.impacts.impulses import Impulses

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from lagrange_cli.integrate.arrays import Array
    from lagrange_cli.integrate.impacts.sides import Sides

SLOWLY = 2.0**-10
"""The part of the usual speeds with which impacts are tried, whose direction is sought."""
NOTHING = 2.0**-30
"""What is this small beside what was taken away is 0."""


class Pushes:
    """Impulses of contacts in a state: of these ``events``, from their ``sides``. They are tried with slow
    impacts, beside the ``usual`` speed of bodies."""

    def __init__(self, sides: Sides, events: NDArray[np.intp], where: Array, usual: float) -> None:
        self._sides, self._events, self._where, self._usual = sides, events, where, usual
        n = sides.program.degrees
        self._q, self._v = sides.outer[:n], sides.outer[n : 2 * n]
        self._now, self._impulses = sides.memory[self._v].copy(), Impulses(sides.settling)
        self._speeds = self._relative(np.zeros(n))

    def _relative(self, change: Array) -> Array:
        """The rates of the events' arguments after a change of the velocities."""
        sides, memory = self._sides, self._sides.memory.copy()
        if change.any():
            sides.memory[self._v] = self._now + change
            sides.begin_anew()
        found: Array = sides.all_coefficients()[self._events, 1].copy()
        sides.memory[:] = memory
        return found

    def _direction(self, i: int) -> Array | None:
        """The changes of velocities by a slow impact; None if it does not part what touches."""
        sides, event, n = self._sides, int(self._events[i]), len(self._v)
        places = np.array([(number, place - n) for number, place in sides.sets[event]])
        towards = np.zeros(n)
        for k in places[:, 1]:
            one = np.zeros(n)
            one[k] = self._usual
            towards[k] = self._where[i] * (self._speeds[i] - self._relative(one)[i])
        length = float(np.linalg.norm(towards))
        if not length > 0.0:
            return None
        state, change = sides.state(sides.memory), np.zeros(n)
        own, which = state[n : 2 * n], places[:, 1]
        own += SLOWLY * self._usual / length * towards
        change[which] = sides.act_on(state)[0][0, places[:, 0]] - own[which]
        own[:] = self._now + change
        change += self._impulses.impulse(state, event, sides.sets[event])
        return change if np.isfinite(change).all() else None

    def coupled(self, chosen: NDArray[np.intp]) -> tuple[NDArray[np.intp], Array, Array]:
        """The ``chosen`` contacts, and those that are coupled with them: their numbers, the changes of all
        velocities (n, k), and of all relative ones (contacts, k) by their impulses."""
        found, along, changes = list[int](), list["Array"](), list["Array"]()
        reached = np.zeros(len(self._events), dtype=bool)
        while len(chosen):
            reached[chosen] = True
            touched = np.zeros(len(reached), dtype=bool)
            for i in chosen.tolist():
                direction = self._direction(i)
                if direction is None:
                    continue
                change = self._relative(direction) - self._speeds
                if self._where[i] * change[i] > 0.0:
                    found.append(i)
                    along.append(direction / change[i])
                    changes.append(change / change[i])
                    touched |= np.abs(changes[-1]) > ROUNDING
            chosen = np.flatnonzero(touched & ~reached)
        count, n, k = len(reached), len(self._v), len(found)
        shaped = np.reshape(along, (k, n)).T, np.reshape(changes, (k, count)).T
        return np.array(found, dtype=np.intp), *shaped

    def move(self, changes: Array) -> None:
        """Change coordinates and velocities (n, 2)."""
        for rows, change in zip((self._q, self._v), changes.T):
            self._sides.move(rows, change, NOTHING * largest_of(change))
        self._sides.begin_anew()
