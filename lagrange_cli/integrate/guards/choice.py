"""Which of several velocities that friction holds at 0 stay 0, and in which directions the others begin.

Let x_i be the rates of these velocities, and f_i(x) = f_i + (A x)_i the forces that they take. Friction
allows

    |f_i| <= D_i where x_i = 0,    f_i = D_i x_i/|x_i| where it is not.

These are the conditions for the least value of -(f + A x/2) x + sum_i D_i |x_i|: of Gauss's constraint with
friction beside it (J. J. Moreau, in Nonsmooth Mechanics and Applications, 1988, sec. 9). As -A is symmetric
and positive definite, but for a factor of each row, there is one solution. It is a zero of x_i - p_i(x_i +
t_i f_i(x)), where p_i shortens a vector by t_i D_i, or to 0 (a proximal map). Newton's method finds it in a
few iterations, also for hundreds of velocities (L. Qi and J. Sun, Math. Programming 58, 1993). It need not:
changes of one f_i after the other always lead nearer (P. Tseng, J. Optim. Theory Appl. 109, 2001).

Limits D_i may depend on x, as those of friction by a force of constraint do. Then there may be no solution,
or several, and these iterations need not end."""

from __future__ import annotations

from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from lagrange_cli.integrate.guards.slopes import inverse_of
from lagrange_cli.records import dataclass

if TYPE_CHECKING:
    from collections.abc import Sequence

    from lagrange_cli.integrate.arrays import Array

DOUBLINGS, ITERATIONS = 12, 24
"""How often Newton's method begins, with 1, 2, 4, ... rounds of all f_i in between; and its iterations."""
EXACT = 2.0**-40
"""How little is left of an equation that is solved, beside its terms."""
CLEAR = 1.0 + 2.0**-26
"""A force that is less than so many times its limit holds: of what it depends on no more digits are known."""


@dataclass(frozen=True)
class Choice:
    """Velocities with these numbers of ``parts``. All parts (n,) and ``limits`` (velocities,) change with the
    rates by ``slopes`` (n, n) and ``falls`` (velocities, n)."""

    parts: Sequence[int]
    slopes: Array
    falls: Array

    @cached_property
    def _places(self) -> list[slice[int, int, None]]:
        return places_of(self.parts)

    @cached_property
    def _yields(self) -> Array:
        """By how much rates change with forces."""
        return -inverse_of(self.slopes)

    @cached_property
    def _times(self) -> list[float]:
        """How much each x_i changes with its own f_i."""
        return [float(np.linalg.norm(self._yields[one, one], 2)) or 1.0 for one in self._places]

    def rates(self, forces: Array, limits: Array) -> Array | None:
        """The rates (n,), which are 0 where friction holds on; None if none were found. ``forces`` (n,) and
        ``limits`` (velocities,) are those of rates that are all 0."""
        x, taken = np.zeros(len(forces)), forces.copy()
        for doubling in range(DOUBLINGS):
            found = self._by_newton(x, forces, limits)
            if found is not None:
                return found
            for _ in range(2**doubling):
                for place, time, limit, fall in zip(self._places, self._times, limits, self.falls):
                    force, most = taken[place] + x[place] / time, limit + fall @ x
                    force -= shortened(force, most)
                    x += self._yields[:, place] @ (taken[place] - force)
                    taken[place] = force
            if not np.all(np.isfinite(x)):
                return None
        return None

    def _by_newton(self, x: Array, forces: Array, limits: Array) -> Array | None:
        """The same from near ``x``."""
        for _ in range(ITERATIONS):
            off, matrix, solved = x.copy(), np.eye(len(x)), True
            every, limited = forces + self.slopes @ x, limits + self.falls @ x
            for i, (place, time) in enumerate(zip(self._places, self._times)):
                z, least = x[place] + time * every[place], time * limited[i]
                size = float(np.linalg.norm(z))
                if size > CLEAR * least:
                    along = z / size
                    off[place] -= z - least * along
                    keeps = np.eye(len(z)) * (1.0 - least / size) + np.outer(along, along) * (least / size)
                    moved = time * self.slopes[place]
                    moved[:, place] += np.eye(len(z))
                    matrix[place] -= keeps @ moved - np.outer(along, time * self.falls[i])
                solved &= float(np.linalg.norm(off[place])) <= EXACT * max(size, least)
            if solved:
                return np.where(off == x, 0.0, x)
            try:
                x = x - np.linalg.solve(matrix, off)
            except np.linalg.LinAlgError:
                return None
            if not np.all(np.isfinite(x)):
                return None
        return None


def places_of(parts: Sequence[int]) -> list[slice[int, int, None]]:
    """Where each velocity is among all parts."""
    ends = np.cumsum(parts).tolist()
    return [slice(end - count, end) for end, count in zip(ends, parts)]


def shortened(vector: Array, by: float) -> Array:
    """A vector of the same direction that is so much shorter; 0 if it is not as long."""
    size = float(np.linalg.norm(vector))
    found: Array = vector * (1.0 - by / size) if size > by else np.zeros(len(vector))
    return found
