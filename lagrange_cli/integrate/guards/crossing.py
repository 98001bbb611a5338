"""The passage through u = 0 where a power such as |u|^1.5 or |u|^0.25 has no series.

The motion is taken a short way from one side to the other. There the acceleration is that at the beginning
plus a change, which is integrated by quadrature along the path without that change (a step of
E. Picard's iteration). The change of the change is neglected. With t = h s^6, a power of t such as
t^0.1 is smooth enough in s for Gauss's rule.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import count, product, takewhile
from math import frexp, ldexp
from typing import TYPE_CHECKING

import numpy as np

from lagrange_cli.integrate.guards.longer_ways import FELT, QUADRATURE, LongerWays, Path
from lagrange_cli.native.guards import SMALLEST, Role
from lagrange_cli.native.state import Clock
from lagrange_cli.records import dataclass

if TYPE_CHECKING:
    from lagrange_cli.integrate.arrays import Array

WAYS = [2.0**k for k in range(-40, -16, 4)], [2.0**k for k in range(-44, -84, -4)]
"""The ways across u = 0, as parts of the coordinates, in the order in which they are tried, in doubles and in
double-double. (There the longest come first, and they are parts of the time, too, if that is longer: proofs
of steps know of u no more than doubles of both tell.)"""
LONGER, FARTHEST = 2.0**4, 2.0**-8
"""How much longer the next way is where no step leads on from the end of one, and the part of the step before
that none exceeds."""
RESOLVED = 2.0**-44, 2.0**-96
"""The shortest way, as a part of the time: further steps are parts of it."""
AT_ONCE = 2.0**-48
"""Arguments are 0 at the same time if that is this part of it away."""
NEAR = 2.0**-16
"""If u = 0 is farther away, in the same terms, something else stops the motion."""
BRIEF = 2.0**-20
"""A short fraction of the whole time since t = 0."""
UNSURE = 2.0**-50, 2.0**-100
"""The part of the time, and of the time in which coordinates change by their size, in which rounding decides
where u = 0 is."""
FAR, GROWS, SEVERAL = 2.0**12, 4.0, 64.0
"""An acceleration grows without bound if, this much nearer to u = 0, it is so many times as large; a few
times a negligible error may be rounding."""
LATER = [2.0**k for k in range(0, -28, -4)]
"""Fractions of the time after which a force is looked for where none acts yet."""
TOGETHER = 4
"""So many arguments are taken across 0 at once, at most."""


@dataclass(frozen=True)
class Way:
    """A way across, to the time ``reached``: the memory before, what ``Crossing`` was given, and which
    ``part`` of the usual time it took."""

    reached: tuple[float, ...]
    origin: Array
    guards: Sequence[int]
    left: float
    begin: Array
    mode: Array
    part: float


class Crossing(LongerWays):
    """The way across a place where a force has no series."""

    _crossed: tuple[float, ...] = ()
    _way: Way | None = None
    span = 0.0
    """The duration of the motion: the scale of times where it begins at rest, at t = 0. (Nothing much shorter
    can: coefficients of series would overflow.)"""
    limited = False
    """Whether this scale was needed, so that steps depend on it."""

    def cross(self) -> bool:
        """Take the motion a little way across u = 0. Returns whether the error is negligible.

        It begins with the acceleration on the side from which the motion comes, or on that to which it goes
        if it begins at u = 0 where the force jumps.
        """
        now, self.path = self.now, None
        if now == self._crossed:
            return False
        before, self._crossed = self._crossed, now
        self._series()
        free = [j for j in range(self.count) if self.modes[j] != 0.0]
        own = self._coefficients_of_arguments()[:, :2]
        u = {j: own[j] for j in free}
        soon = max(abs(now[0]), SMALLEST) * AT_ONCE
        simple = [j for j in free if self._rows.guards[j].role is Role.SWITCH]
        ending = [j for j in simple if u[j][1] * self.modes[j] < 0.0 and abs(u[j][0]) <= abs(u[j][1]) * soon]
        if ending and self._ends(ending):
            self._crossed = before
            return True
        marked = [j for j in range(self.count) if self.marks[j] > 0.0]
        with np.errstate(over="ignore"):
            ahead = {j: -u[j][0] / u[j][1] for j in free if u[j][1] * self.modes[j] < 0.0}
        if marked:
            modes = self.modes[marked].copy()
            entered = self.regular(marked) != modes
            self.modes[marked] = modes
            guards = [j for j, one in zip(marked, entered) if one] or marked[:1]
            side = np.where(self.modes[guards] == 0.0, 1.0, self.modes[guards])
            tried = (-side, side), (side, side), (-side, -side)
            farthest = max(WAYS[self.machine.program.parts - 1])
            if any(self._crossed_by(guards, 0.0, *modes) for modes in tried) or any(
                self._crossed_by(guards, 0.0, *modes, farther=farthest) for modes in tried
            ):
                return True
            sides = map(np.array, product((1.0, -1.0), repeat=len(marked)))
            together = len(guards) < len(marked) <= TOGETHER
            return together and any(self._crossed_by(marked, 0.0, one, one) for one in sides)
        if not ahead:
            return False
        order = sorted(ahead, key=lambda j: abs(ahead[j]))
        j, left, mode = order[:1], abs(float(ahead[order[0]])), self.modes[order[:1]]
        if self._crossed_by(j, left, mode, -mode) or self._crossed_by(j, 2.0 * left, mode, mode):
            return True
        for last in range(1, min(len(order), TOGETHER)):  # several contacts may end almost at once
            j, left = order[: last + 1], abs(float(ahead[order[last]]))
            mode = self.modes[j]
            if self._crossed_by(j, left, mode, -mode):
                return True
        return False

    def _ends(self, guards: Sequence[int]) -> bool:
        """Go on with the other modes of guards whose arguments are 0 just when another one's is, if forces
        have a series then."""
        self.modes[guards] = -self.modes[guards]
        if self._infinite():
            self.modes[guards] = -self.modes[guards]
            return False
        self.mark(guards)
        self.begin_steps()
        return True

    @property
    def now(self) -> tuple[float, ...]:
        """The time, and its low part."""
        return tuple(self.memory[self._layout.at(part)] for part in (Clock.TIME, Clock.TIME_LOW))

    def goes_farther(self) -> bool:
        """Take a longer way than the last one, if hardly any step, or none, leads on from the end of that:
        there u is known to so few digits that no step can be proven, or changes so fast that coefficients of
        series overflow."""
        way, memory, now = self._way, self.memory.copy(), self.now
        self._way = None
        if way is None:
            return False
        self.memory[:] = way.origin
        past, length = now[0] - way.reached[0], way.reached[0] - self.now[0]
        given = way.guards, way.left, way.begin, way.mode
        if past <= length * LONGER and self._crossed_by(*given, farther=way.part):
            return True
        self.memory[:] = memory
        self.prepare()
        return False

    def _duration(self) -> float:
        """The ``span``, which has an effect from now on."""
        self.limited = True
        return self.span

    def _agrees(self) -> bool:
        """Whether the arguments of all guards have the signs of their modes, which a long way may change."""
        return bool(np.all(self._arguments() * self.modes[: self.count] >= 0.0))

    def _crossed_by(
        self, j: Sequence[int], left: float, begin: Array, mode: Array, *, farther: float = 0.0
    ) -> bool:
        """Move on by the time ``left`` until the arguments of guards are 0, and a little more, to where their
        modes are right, with the accelerations of those to ``begin`` with; on the first way that will do, or
        the first that is longer than the one ``farther`` on."""
        layout, memory, parts = self._layout, self.memory.copy(), self.machine.program.parts
        q, v = (np.max(np.abs(memory[layout.part(0)][one])) for one in (layout.q, layout.v))
        self.modes[j] = begin
        self._series()
        v = max(v, self._speed())
        usual = float(max(q / v if v > 0.0 else 0.0, abs(memory[layout.time]) * BRIEF)) or self._duration()
        rates = self._rates_of_rows()
        for later in (usual * part for part in LATER if not v > 0.0):  # from rest, where no force acts yet
            found = later * np.max(np.abs(self._accelerations(memory, rates, later, mode, j)))
            v = found if found < np.inf else v
        self.memory[:] = memory
        if not v > 0.0 or left > usual * NEAR:
            return False
        longest = max(usual, abs(float(memory[layout.time]))) if parts > 1 else usual
        least = abs(float(memory[layout.time])) * RESOLVED[parts - 1]
        ways = [one for one in WAYS[parts - 1] if longest * one >= least]
        if farther:
            before = float(memory[layout.at(Clock.LENGTH)]) or self._duration()
            most = max(longest, before) / longest * FARTHEST
            ways = list(takewhile(lambda one: one <= most, (farther * LONGER**k for k in count(1))))
        if ways:
            j, begin, mode = self.together(j, begin, mode, left + longest * ways[0])
        for way in ways:
            self.memory[:] = memory
            self.modes[j] = begin
            moved = self._moved(left, left + longest * way, begin, mode, j, (usual, float(v)))
            if moved and (not farther or self._agrees()):
                if not farther:
                    path = Path(memory, rates, [*j], left, begin.copy(), mode.copy())
                    self.lengthen(path, usual, left + longest * way)
                self.marks[:] = np.minimum(self.marks, 0.0)
                self.begin_steps()
                self._way = Way(self.now, memory, [*j], left, begin.copy(), mode.copy(), way)
                return True
        self.memory[:] = memory
        return False

    def _moved(
        self,
        left: float,
        length: float,
        begin: Array,
        mode: Array,
        j: Sequence[int],
        scales: tuple[float, float],
    ) -> bool:
        """Move by about this ``length``, with u = 0 after the time ``left``, where the modes to ``begin``
        with are changed; whether the others are right then, and the error small. The ``scales`` of times and
        velocities are those before."""
        layout, own = self._layout, self._layout.degrees
        length = ldexp(1.0, frexp(length)[1])  # so that velocities times it are exact
        self._series()
        at_zero = [*j, *np.flatnonzero(self.marks > 0.0)]
        rates, slopes = self._rates_of_rows(), self._slopes(at_zero)
        if not np.all(np.isfinite(rates)):
            return False
        start = self.memory.copy()
        velocities, places = self.changes(Path(start, rates, j, left, begin, mode), length)
        self.memory[:] = start
        self._move(length, rates)
        self._series()
        straight = self._values(at_zero)
        self._add(layout.rates, velocities)
        self._add(layout.q, places[:own])
        self.modes[j] = mode
        self._series()
        u, after = self._values(j), self._rates_of_rows()
        if not np.all(u * mode > 0.0) or not np.all(np.isfinite(after[:own])) or not self.told(j, u):
            return False
        if not np.all(np.isfinite(self._coefficients_of(layout.v.start, layout.v.stop))):
            return False
        felt = np.abs(after - rates)[:own]
        with np.errstate(divide="ignore", invalid="ignore"):
            bends = np.abs(self._slopes(at_zero) / slopes - 1.0)
            from_rest = np.abs(self._values(at_zero) / straight - 1.0)
        bends = np.where(slopes == 0.0, from_rest, bends)
        bend = float(np.max(np.where(bends < 1.0, bends, 1.0)))
        error = felt * length * (bend + QUADRATURE)
        high = self.memory[layout.part(0)]
        speed = max(np.max(np.abs(high[layout.v])), self._speed()) if np.any(start[layout.v]) else scales[1]
        least = FELT[self.machine.program.parts - 1] * speed
        if not np.all(error <= least):
            return False
        reached = self.memory.copy()
        both = [(left, begin, -1.0), (left, mode, 1.0)]
        unbounded = self._unbounded(start, rates, both, j, float(least), scales)
        self.memory[:] = reached
        return not unbounded

    def _unbounded(
        self, start: Array, rates: Array, sides: Sequence[tuple[float, Array, float]], j: Sequence[int],
        least: float, scales: tuple[float, float],
    ) -> bool:  # fmt: skip
        """Whether an acceleration grows without bound, as 1/sqrt(u) does: velocities change by more than
        ``least``, which is not negligible, while rounding decides where u = 0 is. A side is the time when u =
        0, a mode, and the sign of times on that side."""
        layout = self._layout
        q, v = (np.max(np.abs(start[layout.part(0)][one])) for one in (layout.q, layout.v))
        v = max(v, self._speed(), scales[1])
        usual = max(abs(float(start[layout.time])), float(q / v)) or scales[0]
        unsure = UNSURE[self.machine.program.parts - 1] * usual
        for root, side, sign in sides:
            near, far = np.abs([
                self._accelerations(start, rates, root + sign * away * unsure, side, j) for away in (1.0, FAR)
            ])  # fmt: skip
            with np.errstate(over="ignore", invalid="ignore"):
                if np.any((near > GROWS * far) & (near * unsure > SEVERAL * least)):
                    return True
        return False
