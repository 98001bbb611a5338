"""Friction along a vector u (see ``mechanics.guards.vectors``): where u becomes 0, the motion is held, or
slides on in the direction in which it is pushed; where what holds it reaches its limit, sliding begins."""

from __future__ import annotations

from collections.abc import Container, Sequence
from typing import TYPE_CHECKING

import numpy as np

from lagrange_cli.integrate.guards.at_zero import ROUNDED_OFF
from lagrange_cli.integrate.guards.drag import Drag
from lagrange_cli.integrate.guards.modes import ROUNDING
from lagrange_cli.integrate.guards.resting import SOON
from lagrange_cli.integrate.guards.slopes import inverse_of
from lagrange_cli.native.guards import SMALLEST
from lagrange_cli.native.state import Clock

if TYPE_CHECKING:
    from lagrange_cli.integrate.arrays import Array

LONGEST, SHORTER, LEAST = (2.0**-4, 2.0**-12), 2.0**-2, (2.0**-40, 2.0**-80)
"""The longest way, as part of the time in which forces change: accelerations are known to doubles there; how
much shorter the next one is; and the shortest, as part of the time."""

EXACT = 2
"""How often a velocity that is 0 up to rounding is set to 0."""
TOGETHER = 2.0**-16
"""Vectors of which so much is left where steps on rates have taken one to 0 become 0 with it."""
FAR = 2.0**10
"""How much larger than the change of an argument those of velocities may be."""
FEW, SAME_TIME = 4.0, 16.0
"""A velocity of so many rounding errors may be 0; and times are one that differ by so many times as much."""


class Sliding(Drag):
    """The modes of lengths of vectors."""

    end = np.inf
    """The time at which the motion ends, which no way goes beyond."""
    undetermined = False
    """Whether several forces hold the motion, whose sum alone follows from the equations, so that it is not
    found how it goes on."""

    def vectors(self) -> list[int]:
        """The guards of lengths of vectors that friction may hold."""
        return [j for j in self._rows.vectors if self._rows.guards[j].multiplier]

    def stops(self) -> bool:
        """Hold the motion where a length is about to be 0, or slide on; whether there is one."""
        vectors = self.vectors()
        u, rate = self._lengths(vectors)
        soon = self._size_of_time * SOON
        due = (u <= self._rounding_of_speeds) | ((rate < 0.0) & (u > 0.0) & (u <= -rate * soon))
        for j in np.array(vectors)[due & (self.modes[vectors] != 0.0)].tolist():
            return self.slide_or_hold(j)
        beyond = self._beyond()  # where a motion begins, steps on rates may not tell
        for j in (one for one in vectors if one in beyond):
            return self.slide_or_hold(j)
        return self.turns()

    def stands_still(self) -> bool:
        """Hold the motion where steps no longer change the time, and friction would take a length away before
        that changes: what rounding leaves of the velocity against a contact, which friction cannot change,
        keeps it from being 0. Whether there is one."""
        vectors = [j for j in self.vectors() if self.modes[j] != 0.0]
        time = self._size_of_time * self._unit
        if not vectors or abs(self.memory[self._layout.at(Clock.STEP)]) > time:
            return False
        lengths = self._lengths(vectors)[0]
        due = lengths <= self._largest_acceleration() * time
        return any(self.slide_or_hold(j) for j in np.array(vectors)[due].tolist()[:1])

    def _lengths(self, vectors: Sequence[int]) -> Array:
        """The lengths of vectors, and their rates."""
        self._series()
        found: Array = self._coefficients_of_arguments()[vectors, :2].T
        return found

    @property
    def _size_of_time(self) -> float:
        return max(abs(float(self.memory[self._layout.time])), SMALLEST)

    @property
    def _rounding_of_speeds(self) -> float:
        """How large a velocity may be that is 0 but for rounding."""
        return self._unit * float(np.max(np.abs(self.memory[self._own])))

    @property
    def _unit(self) -> float:
        """What rounding takes from a number, or adds to it, as part of it, at most."""
        return FEW * ROUNDED_OFF[self.machine.program.parts - 1]

    def slide_or_hold(self, j: int) -> bool:
        """Choose the mode of a length that has become 0, or whose force has reached its limit; whether the
        motion goes on."""
        before, reached = self.memory.copy(), self.modes[j] == 0.0
        self.begin_steps()
        vectors, least = self.vectors(), np.zeros(1)
        if self.modes[vectors].any():  # all may come to rest now, so that no speed tells what is none
            same_time = self._size_of_time * self._unit * SAME_TIME
            least = np.nan_to_num(np.abs(self._lengths(vectors)[1]) * same_time, posinf=0.0)
            least[self.modes[vectors] == 0.0] = 0.0
        if not reached and self.machine.program.carried:
            least = np.fmax(least, self._sizes(vectors) * TOGETHER)
            self._move_to_zero(j)
        self._stop(j)
        self.modes[j] = 0.0
        with_it = self._sizes(vectors) <= np.fmax(least, self._rounding_of_speeds)
        self.modes[np.array(vectors)[with_it]] = 0.0  # with it, or at that time
        self._take_rounding([k for k in self.vectors() if self.modes[k] == 0.0])
        self._take_away(np.zeros(self._layout.degrees), exactly=True)  # what is behind the digits of 0, too
        if reached:
            self._move_to_limit(j)
        beyond = self._beyond()
        loose = {j: 1.0} if reached else {}
        loose |= {k: 1.0 for k in beyond if k in vectors}
        found = not loose or self._slide(loose, beyond)
        if not found:
            self.undetermined = self._shares_unknown()
            self.memory[:] = before
        self.prepare()
        return found

    def _shares_unknown(self) -> bool:
        """Whether vectors are held by forces of which nothing but the sum is known."""
        held = [k for k in self.vectors() if self.modes[k] == 0.0]
        if len(held) < 2 or self._apart:
            return False
        slopes = self._slopes_of_parts(*held)
        return not np.all(np.isfinite(slopes)) or int(np.linalg.matrix_rank(slopes)) < len(slopes)

    def _sizes(self, vectors: Sequence[int]) -> Array:
        """The largest part of each vector."""
        found: Array = np.maximum.reduceat(np.abs(self._parts(*vectors)), self._first_parts(vectors))
        return found

    def _move_to_limit(self, j: int) -> None:
        """Move to where the force that holds a vector is as large as its limit, which is near: a method that
        takes steps on rates has found this time with its own error."""
        self._series()
        excess, rate = self._coefficients(self._rows.guards[j].limit + 1)[:2]
        t = -excess / rate if rate else np.inf
        if abs(t) <= SOON * abs(self.memory[self._layout.time]):
            self._move(t, self._rates_of_rows())

    def _move_to_zero(self, j: int) -> None:
        """Move to where a vector is 0, which is near: steps on rates end before, as friction has no direction
        there."""
        self._series()
        u, rate = self._coefficients(self._rows.first + j)[:2]
        t = -u / rate if rate < 0.0 < u else 0.0
        if not t or self.memory[self._layout.time] + t >= self.end:
            return
        before = self.memory.copy()
        self._move(t, self._rates_of_rows())
        self.modes[j] = 0.0
        if not self._on_their_sides():
            self.memory[:] = before

    def _stop(self, j: int) -> None:
        """Take a vector away that is 0 up to rounding, as friction does."""
        if not np.any(self._parts(j)):
            return
        if self._apart:
            self._take_rounding([j])
            return
        memory = self.memory.copy()
        self._take_rounding([j])
        self.modes[j] = 0.0
        velocities = self._friction(j).velocities
        self.memory[:] = memory
        self._take_parts([j], velocities)

    def _take_rounding(self, vectors: Sequence[int]) -> None:
        """Take vectors away in any direction: what rounding has left of them."""
        if vectors and np.any(self._parts(*vectors)):
            slopes = self._slopes_of_parts(*vectors)
            self._take_parts(vectors, slopes.T if self._apart else inverse_of(slopes))

    def _take_parts(self, vectors: Sequence[int], velocities: Array) -> None:
        for _ in range(2):
            change = np.zeros(self._layout.degrees)
            change[: len(velocities)] = velocities @ self._parts(*vectors)
            self._take_away(change, exactly=True)

    def _take_away(self, change: Array, *, exactly: bool) -> None:
        """Subtract it from the velocities; ``exactly``: what is left of one up to rounding becomes 0."""
        layout = self._layout
        self._add(layout.v, -change)
        stopped = np.abs(self.memory[layout.part(0)][layout.v]) <= ROUNDING * np.abs(change) * exactly
        for begin in (0, layout.width, layout.third)[: self.machine.program.parts + 1]:
            self.memory[begin:][layout.v][stopped] = 0.0

    def _move_as_one(self) -> None:
        """Let velocities that are equal be so with all that is behind their digits: what sticks to something
        would differ from it in the last digit now and then, and steps on rates would follow that."""
        layout, parts = self._layout, self.machine.program.parts
        starts = (0, layout.width, layout.third)[: parts + 1]
        high, *low, rest = (self.memory[start:][layout.v] for start in starts)
        if len({*high.tolist()}) == len(high):
            return
        _, alike = np.unique(high + 1j * low[0] if low else high, return_inverse=True)
        rest[np.bincount(alike)[alike] > 1] = 0.0

    def _stop_at(self, j: int) -> None:
        """Take away the velocity with which the motion passes u = 0 ever more often, or which is rounding
        beside the accelerations there, along the direction in which the force jumps: v - a' u'/u'', where a'
        and u'' are the jumps of the accelerations and of u''."""
        own, found = float(self.modes[j]), []
        for mode in (1.0, -1.0):
            self.modes[j] = mode
            accelerations = self._series()[: self._layout.degrees]
            found.append((accelerations, self._coefficients(self._rows.first + j)))
        self.modes[j] = own
        (first, u), (second, other) = found
        jump = 2.0 * (u[2] - other[2])
        often = self.memory[self._layout.at(Clock.PASSES)] >= self._rows.changes
        slow = abs(u[1]) <= ROUNDING * max(np.max(np.abs(one)) for one, _ in found)
        if u[1] == other[1] and jump != 0.0 and (often or slow):
            self._take_away((first - second) * (u[1] / jump), exactly=True)
            self.memory[self._layout.at(Clock.PASSES)] = 0.0

    def _take_to(self, j: int, value: float) -> None:
        """Set the argument of a guard that may hold the motion, or its rate if it is a place, to a value that
        it has up to rounding: by a change of velocities in the direction of the force that holds."""
        own, order = float(self.modes[j]), int(self._rows.guards[j].placed)
        for _ in range(EXACT):
            self._series()
            off = float(self._coefficients(self._rows.first + j)[order]) - value
            if off == 0.0:
                return
            accelerations: list[Array] = []
            slopes: list[float] = []
            for mode in (1.0, -1.0):
                self.modes[j] = mode
                accelerations.append(self._series()[: self._layout.degrees])
                u = self._coefficients(self._rows.first + j)
                slopes.append((order + 1) * float(u[order + 1]))
            self.modes[j] = own
            change = (accelerations[0] - accelerations[1]) * (off / (slopes[0] - slopes[1] or np.inf))
            if not np.all(np.abs(change) <= FAR * abs(off)):  # as where something else holds it
                return
            self._take_away(change, exactly=value == 0.0)

    def _slide(self, loose: dict[int, float], beyond: Container[int]) -> bool:
        """Begin to slide where the forces of some guards are ``beyond`` their limits, or have reached them, a
        little way: with all that slides then (see ``choice``), or at least what nothing holds."""
        self._hold_all()
        origin = self.memory.copy()
        held = self.held([j for j in self.vectors() if self.modes[j] == 0.0], loose)
        now, drag = float(origin[self._layout.time]), [j for j in self.dragged() if self.modes[j] == 0.0]
        which = self.machine.program.parts - 1
        length = LONGEST[which] * min(held.scale, self.span)
        loose = {j: mode for j, mode in loose.items() if j in beyond or self._exceeds(j, length)}
        if not loose:
            return True
        while length >= LEAST[which] * max(abs(now), self.span):
            more = held.sliding(length) or loose
            sliding = more | dict.fromkeys(drag, 1.0)
            while more:
                self.memory[:] = origin
                held.friction.update(
                    {j: self._friction(j) for j in sliding if j in held.forces and j not in held.friction}
                )
                found = self._collocated(length, min(length, self.end - now), held, sliding)
                if found is None:
                    break
                sliding, more = sliding | found, found
            else:
                values = self._arguments()
                self.modes[[j for j in drag if values[j] == 0.0]] = 0.0
                return True
            length *= SHORTER
        self.memory[:] = origin
        return False
