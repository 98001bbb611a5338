"""The modes of all friction that constraints bind together, chosen at once (see ``balance``).

What friction does to velocities that are 0 is seen where nothing is held: equations are regular then,
whatever constraints there are. Each force is reversed once. Of those that hold, as many have mode 0 as
determine the others. These ride: their velocities stay 0 with those, and their forces are the parts of their
limits that were found. Where what holds follows from other forces alone, they are at their limits instead.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from lagrange_cli.integrate.guards.balance import balanced, centred, determined, factors, independent, vertex
from lagrange_cli.integrate.guards.creeping import Creeping
from lagrange_cli.native.guards import HELD, RIDDEN, RIDES

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from lagrange_cli.integrate.arrays import Array

SOON = 2.0**-24, 2.0**-30, 2.0**-36, 0.0
"""How soon forces are looked at, as parts of the time or of the last step: where a limit has just been
reached, their rates decide."""
SLIPS = 2.0**-34
"""Rates beyond this part of what friction changes them by are some."""


class Bound(Creeping):
    """The choice of what friction holds and what slips."""

    def _balanced(self, guards: Sequence[int], stopped: NDArray[np.bool_]) -> list[int]:
        """Choose the modes of all friction on what is held or has ``stopped``, beside those of other
        ``guards``, which stay as they are. Returns the guards of these; none if no modes were found."""
        modes, own = self.modes.copy(), self.modes[: self.count]
        riders = own > RIDES
        group = np.flatnonzero(self._binds & ((own == 0.0) | riders | stopped))
        if len(group) < 2 or not self._binds[guards].any():
            return []
        self._stop_all(np.flatnonzero(stopped))
        rates, slopes = self._pushed(group)
        acts = np.diag(slopes[:, :, 0]) < 0.0  # of places, rates are what they are
        if not np.all(acts):
            self.modes[:] = modes
            group = group[acts]
            rates, slopes = self._pushed(group)
        now = max(abs(float(self.length())), abs(float(self.memory[self._layout.time]))) or self.span
        times = now * np.array(SOON)
        scales = factors(slopes[:, :, 0])
        kept, self._let_go = self._let_go, group.tolist()
        found = scales is not None and any(
            self._takes(
                group, modes, scales * (rates @ [1.0, t]), scales[:, None] * (slopes @ [1.0, t]), guards
            )
            for t in times.tolist()
        )
        self._let_go = kept
        if not found:
            self.modes[:] = modes
            own[riders] = np.where(own[riders] < RIDDEN, -1.0, 1.0)
            group = np.flatnonzero(riders)
        self._take_noise(group[own[group] <= RIDES])
        return group.tolist() if found else []

    def _stop_all(self, guards: NDArray[np.intp]) -> None:
        """Take away velocities that are rounding, where they are arguments of guards."""
        values, layout = self._arguments()[guards], self._layout
        still = np.isin(self.memory[layout.v], values[values != 0.0])
        for part in range(2):
            self.memory[layout.part(part)][layout.v][still] = 0.0

    def _take_noise(self, guards: NDArray[np.intp]) -> None:
        """Take away what rounding has left of velocities that others held until now, or that are 0."""
        self._stop_all(guards)
        for j in guards.tolist():
            if self._arguments()[j] != 0.0:
                self._take_to(j, 0.0)

    def _takes(
        self, group: NDArray[np.intp], modes: Array, pushes: Array, slopes: Array, guards: Sequence[int]
    ) -> bool:
        """Take the modes of a group that follow from its rates without friction (n,), and what friction adds
        to these (n, n); whether the motion is that of these modes."""
        matrix = -(slopes + slopes.T) / 2.0
        sizes = np.abs(matrix).max(axis=1, initial=0.0)
        if not (np.all(np.isfinite(matrix)) and np.all(np.isfinite(pushes))):
            return False
        s = balanced(matrix, pushes)
        if s is None:
            return False
        still = np.abs(pushes - matrix @ s) <= SLIPS * sizes
        self.modes[:] = modes
        if np.any(self._explicit[group]):
            s = vertex(matrix, s, still)
            self.modes[group] = np.where(np.abs(s) < 1.0, 0.0, s)
        else:
            s = centred(matrix, s, still)
            basis = independent(matrix, np.where(still, 1.0 - np.abs(s), 0.0))
            rides = still & ~basis & determined(matrix, basis)
            slips = np.where(np.where(still, s, pushes - matrix @ s) < 0.0, -1.0, 1.0)
            self.modes[group] = np.where(basis, 0.0, np.where(rides, RIDDEN + s, slips))
        self._series()
        held = [j for j in group.tolist() if self.modes[j] == 0.0]
        if not np.all(self._holding(held) <= HELD):
            return False
        return not self._misled([j for j in {*guards, *group.tolist()} if self.modes[j] != 0.0])

    def _pushed(self, group: NDArray[np.intp]) -> tuple[Array, Array]:
        """The first two coefficients of the rates of a group without its friction (n, 2), and of what each
        force of friction adds to them (n, n, 2)."""

        def look() -> Array:
            self._series()
            found: Array = self._coefficients_of_arguments()[group, 1:3] * np.arange(1, 3)
            return found

        self.modes[group] = 1.0
        base = look()
        slopes = np.zeros((len(group), len(group), 2))
        for k, j in enumerate(group):
            self.modes[j] = -1.0
            slopes[:, k] = (base - look()) / 2.0
            self.modes[j] = 1.0
        return base - slopes.sum(axis=1), slopes
