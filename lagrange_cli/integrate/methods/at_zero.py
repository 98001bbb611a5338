"""Arguments of contact forces that rest at 0, or that rounding does not tell from 0: their terms are left out
until the force that acts beyond is felt, or the argument is told."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from lagrange_cli.integrate.methods.crossing import FELT, TOLD, Crossing
from lagrange_cli.native.guards import AT_REST
from lagrange_cli.native.state import Clock

if TYPE_CHECKING:
    from lagrange_cli.integrate.arrays import Array
    from lagrange_cli.native.compilation.machine import Machine

ROUNDING = 2.0**-44
"""A derivative that is so small beside the terms of the others is a rounding error."""
LARGER = 2.0**4
"""How much larger it must be before it is told from 0."""
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

    def _feels(self, j: int) -> bool:
        """Whether one of the forces beyond a guard that rests at 0 changes velocities in a step."""
        own, layout = self._layout.degrees, self._layout
        accelerations, before = [], float(self.modes[j])
        for mode in (1.0, -1.0, 0.0):
            self.modes[j] = mode
            accelerations.append(self._series()[:own])
        self.modes[j] = before
        changes = np.abs(np.array(accelerations) - accelerations[-1])
        speed = np.max(np.abs(self.memory[layout.part(0)][layout.v]))
        felt = np.nan_to_num(changes) * self.memory[layout.at(Clock.LENGTH)]
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
        if self._crossed == begun and now in (begun, ended) and not self._feels(j):
            self.memory[:] = origin
            self.marks[j] = -LARGER * abs(float(self._arguments()[j]))
            self.left = None
            self.prepare()
            return True
        self.memory[:] = reached
        self.prepare()
        return False

    def leave_out(self) -> bool:
        """Let arguments rest that rounding does not tell from 0, if they stay there without the forces
        beyond, and these are not felt; whether there are any."""
        least, values, own = LARGER * self._rounding(), np.abs(self._arguments()), self.modes[: self.count]
        free = [int(j) for j in np.flatnonzero(own) if not self._rows.guards[j].multiplier]
        still = [j for j in free if values[j] <= least[j] and not self._feels(j)]
        before = own.copy()
        own[still] = 0.0
        self._series()
        small = ROUNDING * self.scale()[1:-1]
        rates = {j: np.abs(self._coefficients(self._rows.first + j)[1:]) for j in still}
        still = [j for j in still if np.all(rates[j] <= small)]
        own[:] = before
        own[still] = 0.0
        self.marks[still] = -np.fmax(least, LARGER * values)[still]
        self.prepare()
        self._crossed = ()
        return bool(still)

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
