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
        self._state, self._impulses = sides.state(sides.memory), Impulses(sides.settling)
        self._numbers = np.searchsorted([*sides.program.slowing], events)
        self._speeds = self._relative(np.zeros((n, 1)))[:, 0]
        self._slopes: dict[int, Array] = {}
        """How the usual speed along a coordinate changes relative velocities, by its number."""

    def _relative(self, changes: Array) -> Array:
        """The rates of the events' arguments (events, m) after changes (n, m) of the velocities."""
        sides, n = self._sides, len(self._v)
        states = np.repeat(self._state[:, None], changes.shape[1], axis=1)
        states[n : 2 * n] += changes
        found = sides.speeds(states)
        if found is not None:
            return found[self._numbers]
        memory, rates = sides.memory.copy(), list["Array"]()
        for velocities in states[n : 2 * n].T:
            sides.memory[self._v] = velocities
            sides.begin_anew()
            rates.append(sides.all_coefficients()[self._events, 1].copy())
            sides.memory[:] = memory
        return np.stack(rates, axis=1)

    def _coordinates(self, i: int) -> NDArray[np.intp]:
        """Those whose velocities the action of an event sets."""
        n = len(self._v)
        return np.array([place - n for _, place in self._sides.sets[int(self._events[i])]], dtype=np.intp)

    def _find_slopes(self, chosen: NDArray[np.intp]) -> None:
        """Find how relative velocities follow from those that the actions of the ``chosen`` events set."""
        needed = {k for i in chosen.tolist() for k in self._coordinates(i).tolist()}
        new = sorted(needed - self._slopes.keys())
        if new:
            changes = np.zeros((len(self._v), len(new)))
            changes[new, range(len(new))] = self._usual
            self._slopes.update(zip(new, (self._relative(changes) - self._speeds[:, None]).T))

    def _direction(self, i: int) -> Array | None:
        """The changes of velocities by a slow impact; None if it does not part what touches."""
        sides, event, n = self._sides, int(self._events[i]), len(self._v)
        which, towards = self._coordinates(i), np.zeros(n)
        towards[which] = [-self._where[i] * self._slopes[k][i] for k in which.tolist()]
        length = float(np.linalg.norm(towards))
        if not length > 0.0:
            return None
        state, change = self._state.copy(), np.zeros(n)
        own = state[n : 2 * n]
        own += SLOWLY * self._usual / length * towards
        numbers = [number for number, _ in sides.sets[event]]
        change[which] = sides.act_on(state)[0][0, numbers] - own[which]
        own[:] = self._state[n : 2 * n] + change
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
            self._find_slopes(chosen)
            some = [(i, one) for i in chosen.tolist() if (one := self._direction(i)) is not None]
            directions = np.reshape([one for _, one in some], (len(some), len(self._v)))
            after = self._relative(directions.T) if some else np.empty((len(reached), 0))
            for (i, direction), change in zip(some, (after - self._speeds[:, None]).T):
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
