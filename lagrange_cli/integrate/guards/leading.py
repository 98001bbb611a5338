"""Where modes of guards lead to: whether the motion that they give goes to their sides, or is held at 0."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from lagrange_cli.integrate.guards.modes import ROUNDING
from lagrange_cli.integrate.guards.unfelt import Unfelt

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from lagrange_cli.integrate.arrays import Array
    from lagrange_cli.native.compilation.machine import Machine

FEW = 8
"""So many guards are looked at one by one."""
NOTHING = 2.0**-48, 2.0**-100
"""A velocity that is so small beside others, and beside its changes in a step, is a rounding error."""
LET_GO = 2.0**-26
"""What is let go at its limit begins with an acceleration of 0, up to this part of what the force changes."""


class Leading(Unfelt):
    """Multipliers, and the derivatives of arguments."""

    _let_go: Sequence[int] = ()
    """The guard that is let go, as its multiplier has reached its bound, and those that are bound to it."""

    def __init__(self, machine: Machine, constants: Array, memory: Array, work: Array) -> None:
        super().__init__(machine, constants, memory, work)
        listed, first = self._rows.guards[: self.count], self._layout.v.start
        self._forces = np.array([one.limit or one.multiplier for one in listed], np.intp) - first
        """The rows of multipliers, or of limits, which follow one another."""
        self._limited = np.array([bool(one.limit) for one in listed], np.bool_)
        self._explicit = np.array([one.explicit for one in listed], np.bool_)

    def _multiplier(self, j: int) -> float:
        return float(self._multipliers([j])[0])

    def _multipliers(self, guards: Sequence[int]) -> Array:
        """The multipliers of guards, infinite where limits are 0, but forces are not; no finite numbers where
        contact holds what friction would have to take along."""
        rows, limited = self._forces[guards], self._limited[guards]
        found: Array = self._here[rows, 0]
        if np.count_nonzero(limited):
            above, below = found[limited], self._here[rows[limited] + 1, 0]
            with np.errstate(divide="ignore", invalid="ignore"):
                force, limit = above - below, above + below
                found[limited] = np.where(limit != 0.0, force / limit, np.where(force != 0.0, np.inf, 0.0))
        return found

    def _holding(self, guards: Sequence[int]) -> Array:
        """The sizes of multipliers, infinite where the motion passes u = 0 with a velocity."""
        if not guards:
            return np.zeros(0)
        sizes = np.abs(self._multipliers(guards))
        return np.where((self._passing(guards) == 0.0) & np.isfinite(sizes), sizes, np.inf)

    def _passing(self, guards: Sequence[int]) -> Array:
        """The rates with which arguments pass 0; those of velocities that others hold are rounding."""
        rates = self._coefficients_of_arguments()[guards, 1]
        still = self._explicit[guards] | (np.abs(rates) <= ROUNDING * self._largest_acceleration())
        return np.where(still, 0.0, rates)

    def _largest_acceleration(self) -> float:
        """The scale of first derivatives."""
        found = self._coefficients_of(self._layout.v.start, self._layout.v.stop)[:, 0]
        return float(np.abs(found).max())

    @cached_property
    def _binds(self) -> NDArray[np.bool_]:
        """The guards of friction that constraints may bind together."""
        guards = self._rows.guards[: self.count]
        found = np.array(
            [bool(one.multiplier) and not one.parts and not one.placed for one in guards], np.bool_
        )
        return found & self._rows.constrained

    def _stopped(self) -> NDArray[np.bool_]:
        """Which arguments of friction are 0 but for rounding, also that of the present time."""
        if not self._binds.any():
            return self._binds
        u, rates = np.abs(self._arguments()), np.abs(self._coefficients_of_arguments()[:, 1])
        layout = self._layout
        speed = np.abs(self.memory[layout.v]).max() + self._largest_acceleration() * abs(self.length())
        sizes = speed + rates * abs(float(self.memory[layout.time]))
        found: NDArray[np.bool_] = self._binds & (u <= NOTHING[layout.parts - 1] * sizes)
        return found

    def _bound_at_rest(self) -> NDArray[np.bool_]:
        """Which guards of friction at its limit are at rest, bound to something that is held. Velocities that
        are rounding errors are taken away."""
        found, layout = self._arguments(), self._layout
        nothing = self._explicit & (found != 0.0) & self._stopped()
        if nothing.any():
            still = np.isin(self.memory[layout.v], found[nothing])
            for part in range(2):
                self.memory[layout.part(part)][layout.v][still] = 0.0
            found = self._arguments()
        rests: NDArray[np.bool_] = self._explicit & (self.modes[: self.count] != 0.0) & (found == 0.0)
        return rests

    def _misled(self, guards: Sequence[int]) -> list[int]:
        """The guards to whose sides the motion does not lead, nor along u = 0."""
        found = list[int]()
        for some in few_or_all(guards):
            self.modes[some] = -self.modes[some]
            self._series()
            others = self._coefficients_of_arguments()[some]
            self.modes[some] = -self.modes[some]
            self._series()
            arguments, usual = self._coefficients_of_arguments()[some], self.scale()
            for j, u, other in zip(some, arguments, others):
                change = np.abs(u - other)
                scale = ROUNDING * np.fmax(usual[: len(u)], change)
                if j in self._let_go and not self._rows.guards[j].placed:
                    scale[1] = max(scale[1], LET_GO * change[1])
                sizes = zip(u.tolist()[1:], scale.tolist()[1:])
                leads = next((one for one, size in sizes if not abs(one) <= size), None)
                if not (np.isfinite(u).all() if leads is None else leads * self.modes[j] > 0.0):
                    found.append(j)
        return found


def few_or_all(guards: Sequence[int]) -> list[list[int]]:
    """A few guards one by one, many of them together: a series costs as much as there are of them."""
    if len(guards) <= FEW:
        return [[j] for j in guards]
    return [[*guards]]
