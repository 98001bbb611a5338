"""Forces with a kink at u = 0, such as the drag -b v |v|, on what is at rest in equilibrium up to rounding.

There the accelerations are differences of forces that cancel: nothing but rounding errors, and so is u, which
they make. Its sign changes again and again, and decides nothing: a force whose value and slope are
continuous at u = 0 is far less than the rounding errors of the others. Such a switch stays as it is until u
has become so large that it may be felt. In n steps, it changes velocities by n times its part of one rounding
error; the rounding errors themselves, which are independent, by the square root of n times one of them."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING

import numpy as np

from lagrange_cli.integrate.guards.at_zero import FEW, ROUNDED_OFF, AtZero
from lagrange_cli.native.guards import Role

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from lagrange_cli.integrate.arrays import Array

UNFELT = 2.0**-12
"""A force that is not felt is no more than this part of the rounding errors: in fewer than 2^24 steps, that
is less than what these add up to."""
TRIALS, CLEARLY = 4, 2.0**8
"""How often rounding errors of coordinates are drawn; and how much larger than by the first draw they hardly
are."""
MIXING, BITS = (2654435769, 2246822519, 3266489917), 2**32
"""Odd numbers of many bits, and the range of products of these that count."""
BEYOND, FARTHEST, FARTHER = 2.0**4, 2.0**12, 4.0
"""How much larger than rounding errors make it at once u may become, at least and at most, until the force is
looked at again, and by what factor bounds are apart. In 2^24 steps it becomes so large; what else the force
depends on, such as the time, may have changed."""


class Unfelt(AtZero):
    """The modes of such switches, which are 0."""

    def let_drift(self, guards: Sequence[int]) -> None:
        """Set the modes of guards to 0 whose arguments are 0 and are moved by rounding errors alone, until
        they are larger than these make them, if no acceleration tells which mode they have."""
        free = [j for j in guards if self.modes[j] and self._rows.guards[j].role is Role.SWITCH]
        if not free:
            return
        modes = self.modes[free].copy()
        self.modes[free] = 0.0  # roots have series then
        found = self._errors(free, range(1))
        if not np.any(self._rounded(free, CLEARLY * found[1])[0]):  # as where a force sets them in motion
            self.modes[free] = modes
            return
        more = self._errors(free, range(1, TRIALS))
        errors, of_arguments = (np.fmax(*both) for both in zip(found, more))
        rounded, times = self._rounded(free, of_arguments)
        self.modes[free] = modes
        groups = [np.flatnonzero(rounded).tolist()]
        while groups:
            some = groups.pop()
            if some and not self._drift([free[i] for i in some], errors, max(times[some])) and len(some) > 1:
                half = len(some) // 2
                groups += [some[half:], some[:half]]

    def _rounded(self, guards: list[int], errors: Array) -> tuple[NDArray[np.bool_], Array]:
        """Which arguments are moved by such ``errors`` of their derivatives alone, and in what time these
        turn round."""
        self._series()
        times = turning_times(errors)
        powers = times[:, None] ** np.arange(1, errors.shape[1] + 1)
        with np.errstate(invalid="ignore"):
            changes = np.abs(self._coefficients_of_arguments()[guards, 1:]) * powers
            rounded = np.sum(changes, axis=1) <= FEW * np.sum(errors * powers, axis=1)
        return rounded & np.isfinite(times), times

    def _drift(self, guards: list[int], errors: Array, time: float) -> bool:
        """Set the modes of guards to 0, if no acceleration changes by what is felt beside its rounding error,
        as far as these ``errors`` move the arguments in about this ``time``; whether none does."""
        modes, bounds, beyond = self.modes[guards].copy(), np.zeros(len(guards)), BEYOND
        self.modes[guards] = 0.0
        memory, values = self.memory.copy(), np.abs(self._arguments()[guards])
        rates = self._rates_of_rows().copy()
        own = rates[: len(errors)]
        own[:] = np.where(np.abs(own) < errors, np.copysign(errors, scattered(len(errors), TRIALS)), own)
        while beyond <= FARTHEST:
            found = np.zeros(len(guards))
            for direction in (1.0, -1.0):
                self._move(time * beyond, rates * direction)
                found = np.fmax(found, self._unfelt(guards, UNFELT * errors))
                self.memory[:] = memory
            if not np.all(np.isfinite(found)):
                break
            bounds, beyond = found, beyond * FARTHER
        if not np.all(bounds > 2.0 * values):
            self.modes[guards] = modes
            return False
        self.marks[guards] = -bounds
        return True

    def _unfelt(self, guards: list[int], least: Array) -> Array:
        """How large the arguments of guards are in a state, where their modes are 0; infinite if those of
        their sides change an acceleration by more than the ``least`` that is felt."""
        without, values = self._series()[: self._layout.degrees].copy(), self._arguments()[guards]
        self.modes[guards] = np.where(values < 0.0, -1.0, 1.0)
        with np.errstate(invalid="ignore"):
            changes = np.abs(self._series()[: self._layout.degrees] - without)
        return np.abs(values) if np.all(changes <= least) else np.full(len(guards), np.inf)

    def _errors(self, guards: list[int], trials: Iterable[int]) -> tuple[Array, Array]:
        """How much accelerations, and the derivatives of the arguments of guards (guards, orders), change at
        most where coordinates and velocities change by their rounding errors."""
        layout, memory = self._layout, self.memory.copy()
        sizes = np.abs(memory[layout.part(0)][layout.motion])
        unit = 2.0 * ROUNDED_OFF[self.machine.program.parts - 1] * sizes
        before = self._derivatives(guards)
        found = [np.zeros_like(one) for one in before]
        for trial in trials:
            self._add(layout.motion, unit * scattered(len(unit), trial))
            with np.errstate(invalid="ignore"):
                changes = [np.abs(new - old) for new, old in zip(self._derivatives(guards), before)]
                found = [np.fmax(*both) for both in zip(found, changes)]
            self.memory[:] = memory
        accelerations, arguments = found
        return accelerations, arguments

    def _derivatives(self, guards: list[int]) -> tuple[Array, Array]:
        """The accelerations, and the coefficients of the arguments of guards from the first rate on."""
        accelerations = self._series()[: self._layout.degrees].copy()
        return accelerations, self._coefficients_of_arguments()[guards, 1:]


def scattered(count: int, trial: int) -> Array:
    """Numbers from -1 to 1 without a pattern, the same on all machines. (To import numpy's generators takes
    longer than all else.)"""
    mixed = np.arange(1, count + 1, dtype=np.uint64) * np.uint64(MIXING[0]) + np.uint64(trial * MIXING[1])
    for _ in range(2):
        mixed = (mixed * (mixed ^ np.uint64(MIXING[2]))) & np.uint64(BITS - 1)
    found: Array = mixed * (2.0 / BITS) - 1.0
    return found


def turning_times(errors: Array) -> Array:
    """In what time a motion that rounding errors make turns round, from the ``errors`` of the derivatives of
    arguments (arguments, orders): infinite where it does not."""
    orders = np.arange(1, errors.shape[1])
    with np.errstate(divide="ignore", over="ignore", invalid="ignore"):
        times = (errors[:, :1] / errors[:, 1:]) ** (1.0 / orders)
    times[~(times > 0.0)] = np.inf
    found: Array = np.min(times, axis=1)
    return found
