"""Arguments of contact forces that rest at 0, or that rounding does not tell from 0: their terms are left out
until the force that acts beyond is felt, or the argument is told."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from lagrange_cli.integrate.methods.crossing import FELT, Crossing
from lagrange_cli.integrate.methods.trial_states import TOLD
from lagrange_cli.native.guards import AT_REST
from lagrange_cli.native.state import Clock

if TYPE_CHECKING:
    from lagrange_cli.integrate.arrays import Array
    from lagrange_cli.native.compilation.machine import Machine

LARGER = 2.0**4
"""How much larger it must be before it is told from 0."""
FEW = 2.0**12
"""An argument up to so many rounding errors is known to few digits."""
ROUNDED_OFF = 2.0**-52, 2.0**-104
"""The unit of rounding of coordinates."""
TRIALS = 8
"""How often their rounding errors are drawn."""


class AtZero(Crossing):
    """The modes of such guards, which are 0."""

    def __init__(self, machine: Machine, constants: Array, memory: Array, work: Array) -> None:
        super().__init__(machine, constants, memory, work)
        self.left: tuple[Array, int] | None = None
        """The memory before a guard was left last that had rested at 0, and which one."""

    def let_rest(self, guards: Sequence[int]) -> None:
        """Set the modes of guards to 0 whose arguments stay 0, beside forces that have no series there: these
        act as soon as they are felt."""
        self._series()
        still = [j for j in guards if self.modes[j] and not np.any(self._coefficients(self._rows.first + j))]
        modes = self.modes[still].copy()
        self.modes[still] = -modes
        if not still or not self._infinite():
            self.modes[still] = modes
            return
        self.modes[still] = 0.0
        if self._infinite():
            self.modes[still] = modes
        else:
            self.marks[still] = -LARGER * self._rounding()[still]

    def has_left(self, j: int) -> bool:
        """Whether the argument of a guard, which rested at 0, has become as large as its series tells.

        If rounding hides that, and the force that acts beyond is not felt yet, the motion goes on as it is
        until the argument is larger.
        """
        least = max(AT_REST, -float(self.marks[j]))
        size = abs(float(self._arguments()[j]))
        if abs(size - least) <= TOLD * least or self._feels(j):
            return True
        self.marks[j] = -LARGER * max(least, size)
        return False

    def _feels(self, j: int, length: float | None = None) -> bool:
        """Whether one of the forces beyond a guard that rests at 0 changes velocities in so long a time; or
        else, in a step."""
        length = float(self.memory[self._layout.at(Clock.LENGTH)]) if length is None else length
        own, layout = self._layout.degrees, self._layout
        accelerations, before = [], float(self.modes[j])
        for mode in (1.0, -1.0, 0.0):
            self.modes[j] = mode
            accelerations.append(self._series()[:own])
        self.modes[j] = before
        speed = np.max(np.abs(self.memory[layout.part(0)][layout.v]))
        with np.errstate(over="ignore", invalid="ignore"):  # forces that grow beyond all bounds
            changes = np.abs(np.array(accelerations) - accelerations[-1])
            felt = np.nan_to_num(changes) * length
        return bool(np.any(felt > FELT[self.machine.program.parts - 1] * speed))

    def rests_on(self) -> bool:
        """Let an argument that has just left 0 rest until it is larger, where no step leads on from there,
        and the force that acts beyond is not felt yet."""
        if self.left is None:
            return False
        now, reached, (origin, j) = self.now, self.memory.copy(), self.left
        self.memory[:] = origin
        begun = self.now
        ended = self._way.reached if self._way is not None and self._crossed == begun else begun
        length = float(self.memory[self._layout.at(Clock.LENGTH)]) * LARGER  # forces grow meanwhile
        if self._crossed == begun and now in (begun, ended) and not self._feels(j, length):
            self.memory[:] = origin
            self.marks[j] = -LARGER * abs(float(self._arguments()[j]))
            self.left = None
            self.prepare()
            return True
        self.memory[:] = reached
        self.prepare()
        return False

    def leave_out(self) -> bool:
        """Let arguments rest that are not told from 0 by much, where no step leads on otherwise, and the
        forces beyond have not been felt since they were 0; whether there are any."""
        noise, own = np.fmax(self._rounding(), self._roughness()), self.modes[: self.count]
        self._series()
        first = self._coefficients_of(self._rows.first, self._rows.first + self.count)[:, :2]
        values, rates = np.abs(first.T)
        length = float(self.memory[self._layout.at(Clock.LENGTH)])
        found = list[int]()
        for j in map(int, np.flatnonzero(own)):
            since = float(values[j] / rates[j]) if rates[j] > 0.0 else length
            if (
                self._rows.guards[j].multiplier
                or values[j] > FEW * noise[j]
                or self._feels(j, since * LARGER**2)
            ):
                continue
            found.append(j)
        own[found] = 0.0
        self.marks[found] = -LARGER * np.fmax(values, noise)[found]
        self.prepare()
        self._crossed = ()
        return bool(found)

    def _rounding(self) -> Array:
        """How much arguments change where all coordinates change by a rounding error of the largest one."""
        q, memory = self.memory[self._layout.part(0)][self._layout.q], self.memory.copy()
        unit = ROUNDED_OFF[self.machine.program.parts - 1] * np.max(np.abs(q))
        before, source, found = self._arguments(), np.random.default_rng(0), np.zeros(self.count)
        for _ in range(TRIALS):
            self._add(self._layout.q, unit * source.uniform(-1.0, 1.0, len(q)))
            found = np.fmax(found, np.abs(self._arguments() - before))
            self.memory[:] = memory
        return found

    def _roughness(self) -> Array:
        """How much arguments differ from linear functions of coordinates nearby: by rounding of what they are
        computed from, which may be larger than coordinates are."""
        q, memory = self.memory[self._layout.part(0)][self._layout.q], self.memory.copy()
        unit = ROUNDED_OFF[self.machine.program.parts - 1] * FEW * np.max(np.abs(q))
        before, source, found = self._arguments(), np.random.default_rng(0), np.zeros(self.count)
        for _ in range(TRIALS):
            change, second = unit * source.uniform(-1.0, 1.0, len(q)), -2.0 * before
            for one in (change, -change):
                self._add(self._layout.q, one)
                second = second + self._arguments()
                self.memory[:] = memory
            found = np.fmax(found, np.abs(second))
        return found
