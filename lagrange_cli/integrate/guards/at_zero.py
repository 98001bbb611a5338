"""Arguments of contact forces that rest at 0, or that rounding does not tell from 0: their terms are left out
until the force that acts beyond is felt, or the argument is told."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from lagrange_cli.integrate.guards.crossing import Crossing
from lagrange_cli.integrate.guards.longer_ways import FELT
from lagrange_cli.integrate.guards.modes import ROUNDING
from lagrange_cli.integrate.guards.trial_states import TOLD
from lagrange_cli.native.guards import AT_REST, SMALL, Role
from lagrange_cli.native.state import Clock
from lagrange_cli.native.stepping.noise import LASTS

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from lagrange_cli.integrate.arrays import Array

LARGER = 2.0**4
"""How much larger it must be before it is told from 0."""
FEW = 2.0**12
"""An argument up to so many rounding errors is known to few digits."""
MANY = 2.0**40
"""Steps do not predict a force better than to this part of it."""
ROUNDED_OFF = 2.0**-52, 2.0**-104
"""The unit of rounding of coordinates."""
TRIALS = 8
"""How often their rounding errors are drawn."""
GROWTHS = 64
"""How often changes of coordinates are doubled until arguments change by their rounding errors."""
VARIED = 2.0**-32, 2.0**-60
"""Relative changes of parameters whose squares are below rounding."""
BLUR = 4.0
"""The largest effect of rounding is so many times as large as that of those drawn, at most."""


class AtZero(Crossing):
    """The modes of such guards, which are 0."""

    left: tuple[Array, int] | None = None
    """The memory before a guard was left last that had rested at 0, and which one."""
    _blurred: tuple[float, ...] = ()

    def let_rest(self, guards: Sequence[int]) -> None:
        """Set the modes of guards to 0 whose arguments stay 0. If they do so up to rounding, forces act as
        soon as these are told from 0: until then rounding would decide on them. If they are exactly 0, this
        is of use where forces jump, which have a value at 0, and beside forces that have no series there:
        these act as soon as they are felt. Those that a force may hold have been tried before."""
        modes, exact = self.modes.copy(), list[int]()
        still = [j for j in guards if modes[j] and not self._rows.guards[j].multiplier]
        if not still:
            return
        while still:
            self.modes[still] = 0.0  # a force from a depth that is rounding would seem to end the contact
            self._series()
            found = self._coefficients_of_arguments()[still]
            stay, values = self._stay(found[:, 1:]), np.abs(found[:, 0])
            self.modes[still] = modes[still]
            if np.any(values[stay]):
                stay = stay & (values <= self._noise()[still])
            if np.all(stay):
                exact = [j for j, value in zip(still, values) if value == 0.0]
                break
            still = [j for j, one in zip(still, stay) if one]
        if exact and self._is_smooth(exact):
            still = [j for j in still if j not in exact]
        if not still:
            return
        self.modes[still] = 0.0
        if self._infinite():
            self.modes[still] = modes[still]
        else:
            self.marks[still] = -LARGER * self._noise()[still]

    def _is_smooth(self, guards: list[int]) -> bool:
        """Whether accelerations are finite and the same with the opposite modes of some guards."""
        own, modes = self._layout.degrees, self.modes.copy()
        before = self._series()[:own].copy()
        self.modes[guards] = -modes[guards]
        smooth = not self._infinite() and np.array_equal(self._series()[:own], before)
        self.modes[guards] = modes[guards]
        return smooth

    def begin_at_rest(self, values: Array) -> None:
        """Let arguments rest that have other ``values`` than 0 by rounding alone where the motion begins, and
        stay as they are."""
        q, own = self.memory[self._layout.part(0)][self._layout.q], self.modes[: self.count]
        largest = np.max(np.abs(np.append(values, q)))
        small = (values != 0.0) & (np.abs(values) <= SMALL * largest)
        if not any(small):
            return
        noise = np.fmax(self._noise(), self._roughness_of_parameters())
        free = np.array([guard.role is Role.SWITCH for guard in self._rows.guards[: self.count]])
        zero = np.flatnonzero(free & (np.abs(values) <= noise))
        modes = own[zero].copy()
        own[zero] = 0.0
        self._series()
        rates = self._coefficients_of_arguments()[zero, 1:]
        still = small[zero] & self._stay(rates)
        own[zero[~still]] = modes[~still]
        self.marks[zero[still]] = -LARGER * noise[zero[still]]

    def _stay(self, rates: Array) -> NDArray[np.bool_]:
        """Which arguments do not change but for rounding: their coefficients (guards, orders) from the first
        rate on are small beside those of coordinates."""
        speed = np.max(np.abs(self.memory[self._layout.part(0)][self._layout.v]))
        usual = np.append(speed, self.scale()[1 : rates.shape[1]])
        found: NDArray[np.bool_] = np.all(np.abs(rates) <= ROUNDING * usual, axis=1)
        return found

    def has_left(self, j: int) -> bool:
        """Whether the argument of a guard, which rested at 0, has become as large as its series tells.

        If rounding hides that, and the force that acts beyond is not felt yet, the motion goes on as it is
        until the argument is larger.
        """
        least = max(AT_REST, -float(self.marks[j]))
        size = abs(float(self._arguments()[j]))
        if abs(size - least) <= TOLD * least or self._feels(j):
            return True
        if self._noise()[j] <= TOLD * size > 0.0:
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

    def touching(self, few: float = FEW) -> list[int]:
        """The guards whose arguments are at most so many rounding errors, while forces contain their
        roots."""
        rooted = [j for j in range(self.count) if self._rows.guards[j].rooted and self.modes[j] != 0.0]
        if not rooted:
            return []
        near = np.abs(self._arguments()) <= few * self._noise()
        return [j for j in rooted if near[j]]

    def goes_in(self) -> bool:
        """Take the motion on where no step leads on because an argument has just left 0, by no more than
        rounding: from that nobody knows how near the branch point of a force is."""
        self._series()
        rates = self._coefficients_of_arguments()[:, 1]
        begun = [j for j in self.touching(1.0) if rates[j] * self.modes[j] > 0.0]
        mode = self.modes[begun]
        found = bool(begun) and self._crossed_by(begun, 0.0, -mode, mode)
        self.prepare()
        return found

    def blur(self) -> bool:
        """Let accelerations differ from those predicted by what rounding changes them, for some steps, where
        a force contains a root of an argument that is known to few digits; whether that is new."""
        own, layout, now = self._layout.degrees, self._layout, self.now
        rooted = self.touching(MANY)
        if now == self._blurred or own < 2 or self.machine.program.parts > 1 or not rooted:
            return False
        self._blurred = now
        memory, noise, found = self.memory.copy(), self._noise(), np.zeros(own)
        unit = ROUNDED_OFF[0] * np.max(np.abs(memory[layout.part(0)][layout.motion]))
        before, arguments = self._series()[:own], self._values(rooted)
        for _ in range(GROWTHS):
            source, changed = np.random.default_rng(0), np.zeros(len(rooted))
            for _ in range(TRIALS):
                self._add(layout.q, unit * source.uniform(-1.0, 1.0, own))
                with np.errstate(invalid="ignore"):
                    found = np.fmax(found, np.abs(self._series()[:own] - before))
                changed = np.fmax(changed, np.abs(self._values(rooted) - arguments))
                self.memory[:] = memory
            if np.all(changed >= noise[rooted]):
                break
            unit *= 2.0
        first = layout.errors + layout.v.start
        self.memory[first : first + own] = BLUR * found
        self.memory[layout.errors] = LASTS
        self.begin_steps()
        self.prepare()
        return bool(np.any(found))

    def leave_out(self) -> bool:
        """Let arguments rest that are not told from 0 by much, where no step leads on otherwise, and the
        forces beyond have not been felt since they were 0; whether there are any."""
        noise, own = self._noise(), self.modes[: self.count]
        self._series()
        first = self._coefficients_of_arguments()[:, :2]
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
        if found:
            self.begin_steps()
        self.prepare()
        self._crossed = ()
        return bool(found)

    def _noise(self) -> Array:
        """How much of arguments may be rounding."""
        return np.fmax(self._rounding(), self._roughness())

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
        computed from, which may be larger than coordinates are. These change by more and more until that is
        seen."""
        layout, memory, parts = self._layout, self.memory.copy(), self.machine.program.parts
        q, v = (np.max(np.abs(memory[layout.part(0)][one])) for one in (layout.q, layout.v))
        unit = ROUNDED_OFF[parts - 1] * FEW * max(q, v * memory[layout.at(Clock.LENGTH)])
        before, source, found = self._arguments(), np.random.default_rng(0), np.zeros(self.count)
        for _ in range(TRIALS):
            change, second = unit * source.uniform(-1.0, 1.0, layout.degrees), before
            # not on both sides: beside an exact number these are rounded by opposite errors
            for part, weight in ((0.5, -2.0), (1.0, 1.0)):
                self._add(layout.q, part * change)
                second = second + weight * self._arguments()
                self.memory[:] = memory
            found = np.where(found > 0.0, found, np.abs(second))
            if np.all(found > 0.0):
                break
            unit *= LARGER
        return found

    def _roughness_of_parameters(self) -> Array:
        """How much arguments differ from linear functions of parameters nearby: by rounding of what they are
        computed from, as the places of bodies in a long row."""
        memory, first, source = self.memory.copy(), self._layout.settings.start, np.random.default_rng(0)
        before, found = self._arguments(), np.zeros(self.count)
        rows = slice(first, first + self._rows.parameters)
        for _ in range(TRIALS):
            change = VARIED[self.machine.program.parts - 1] * source.uniform(-1.0, 1.0, self._rows.parameters)
            second = before
            for part, weight in ((0.5, -2.0), (1.0, 1.0)):
                self.memory[rows] *= 1.0 + part * change
                second = second + weight * self._arguments()
                self.memory[:] = memory
            found = np.fmax(found, np.abs(second))
        self.prepare()
        return found
