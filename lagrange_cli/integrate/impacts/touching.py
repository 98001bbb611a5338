"""Bodies that touch without speed: which contacts hold them, all together, and which part.

A contact holds if its force pushes; one that does not hold must not be closed by the accelerations
(complementarity: P. Loetstedt, SIAM J. Appl. Math. 42, 1982). What impacts leave of relative velocities by
rounding is taken away by impulses along the directions of slow impacts.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from lagrange_cli.integrate.guards.modes import ROUNDING
from lagrange_cli.integrate.guards.pivoting import Pivoting
from lagrange_cli.integrate.impacts.pushes import Pushes
from lagrange_cli.native.state import Clock
from lagrange_cli.native.stepping.at_once import ALIKE
from lagrange_cli.records import dataclass

if TYPE_CHECKING:
    from collections.abc import Mapping

    from numpy.typing import NDArray

    from lagrange_cli.integrate.arrays import Array
    from lagrange_cli.integrate.impacts.sides import Sides

ROUNDS = 8
"""How often contacts are chosen, for each of them, until they agree."""
EACH, MORE = 4, 5
"""Impacts at one time are infinitely many if n contacts, which touch, have had so many times n (n + so
many)."""
LEFT = 2.0**-50
"""A relative velocity that is this part of its terms is as small as rounding lets it be."""
APART = {1: 2.0**-50, 2: 2.0**-100}
"""Bodies that rounding errors lead into one another are put apart by this part of where they are; in numbers
of so many parts."""
REPEATED = 2
"""How often what is left is taken away: rounding errors of the first time, too."""


@dataclass(frozen=True)
class Pressed:
    """Contacts that touch without speed: their events, in order, and the sides where bodies are."""

    events: NDArray[np.intp]
    sides: Array


class Touching:
    """The contacts of a motion, whose guards are given by event."""

    def __init__(self, sides: Sides, guards: Mapping[int, int]) -> None:
        self._sides, self._settling = sides, sides.settling
        self._events, self._own = np.array([*guards], dtype=np.intp), frozenset(guards)
        self._rests = np.array([*guards.values()], dtype=np.intp)
        self.time = 0.0
        """How long the motion takes until now."""
        self.near = np.zeros(len(sides.program.events))
        """How far from 0 arguments are by rounding, at most: besides what their own terms tell."""
        rows = [sides.guards.guards[one].row for one in guards.values()]
        self._rows = np.array(rows, dtype=np.intp)

    def rest(self, noise: Array, same: int, unseen: float = 0.0) -> None:
        """Let bodies rest on each other that touch, where relative velocities are no more than ``noise`` (all
        events,), unless others hit each other yet: ``same`` impacts have been at this time. Flights that
        begin with an ``unseen`` one may be hidden by rounding."""
        if not len(self._events):
            return
        due = self._due(noise)
        if due.any():
            count = int(np.count_nonzero(self._at_zero()))
            seen = np.abs(self._sides.all_coefficients()[self._events[due], 1]) > unseen
            often = EACH * count * (MORE + count) if seen.any() else count
            if not same > often or not self._collapse(noise):
                return
        pressed = self._pressed(noise)
        if len(pressed.events):
            self._choose(pressed)
            self._stop(pressed, noise)

    def fastest(self, event: int, noise: Array) -> int:
        """Of impacts at the same time as an event's, if it is one, too, the fastest: the others would hit one
        another very often before it."""
        found = self.due(noise) if event in self._own else None
        return event if found is None else found

    def due(self, noise: Array) -> int | None:
        """The impact that happens now and is the fastest beside the terms of its rate, or beside the largest
        velocity. Of those that are as fast, but for rounding, the first one."""
        sides, due = self._sides, self._events[self._due(noise)]
        if not len(due):
            return None
        scale = np.fmax(sides.sizes()[due, 1], sides.largest_velocity())
        speeds = -sides.all_coefficients()[due, 1] * sides.modes[due] / np.where(scale > 0.0, scale, 1.0)
        return int(due[np.argmax(speeds >= np.max(speeds) * (1.0 - ALIKE))])

    def _due(self, noise: Array) -> NDArray[np.bool_]:
        """Which impacts happen now."""
        sides, found = self._sides, self._at_zero()
        which = np.flatnonzero(found)  # a few of many
        own = self._events[which]
        values, rates = sides.all_coefficients()[own, :2].T
        modes = sides.modes[own]
        due = (rates * modes < -noise[own]) & (modes * sides.directions[own] <= 0.0)
        reached = np.fmax(LEFT * sides.sizes()[own, 0], ROUNDING * self.time * np.abs(rates))
        due &= (sides.marks[own] > 0.0) | (np.abs(values) <= reached)
        found[which] = due
        return found

    @property
    def any(self) -> bool:
        """Whether any bodies touch, or are held by one another."""
        return bool(self._at_zero().any() or self._settling.modes[self._rests].any())

    def now(self) -> NDArray[np.intp]:
        """The contacts' events whose arguments are 0 but for rounding."""
        found: NDArray[np.intp] = self._events[self._at_zero()]
        return found

    def _at_zero(self) -> NDArray[np.bool_]:
        """Where the arguments of contacts' events are 0 but for rounding."""
        sides = self._sides
        near, found = sides.at_present("zeros", lambda: (self.near, self._zeros()))
        at_zero: NDArray[np.bool_] = found if near is self.near else self._zeros()
        return at_zero | (sides.marks[self._events] > 0.0)

    def _zeros(self) -> NDArray[np.bool_]:
        """Where their values tell."""
        sides, own = self._sides, self._events
        least = np.fmax(ROUNDING * sides.sizes()[own, 0], self.near[own])
        found: NDArray[np.bool_] = np.abs(sides.all_coefficients()[own, 0]) <= least
        return found

    def _where(self) -> Array:
        """The sides where bodies are."""
        held = self._settling.modes[self._rests]
        return np.where(held != 0.0, held, self._sides.modes[self._events])

    def _pressed(self, noise: Array) -> Pressed:
        sides, held = self._sides, self._settling.modes[self._rests] != 0.0
        which = np.flatnonzero(self._at_zero() | held)
        own, where = self._events[which], self._where()[which]
        touches = np.abs(sides.all_coefficients()[own, 1]) <= noise[own]
        touches &= self._at_zero()[which] & (sides.modes[own] != 0.0)
        touches |= held[which]
        touches &= where * sides.directions[own] <= 0.0
        return Pressed(which[touches], where[touches])

    def _choose(self, pressed: Pressed) -> None:
        """Which of them hold."""
        settling, which, pivoting = self._settling, pressed.events, Pivoting()
        for _ in range(ROUNDS * (len(which) + 1)):
            held = settling.modes[self._rests[which]] != 0.0
            forces = settling.values_of(self._rows[which]) * pressed.sides
            bends = self._sides.all_coefficients()[self._events[which], 2] * pressed.sides
            noise = ROUNDING * settling.scale()[1]
            wrong = np.where(held, ~(forces > 0.0), bends < -noise)
            if not wrong.any():
                return
            for i in pivoting.chosen(np.flatnonzero(wrong).tolist()):
                self._set(int(which[i]), 0.0 if held[i] else float(pressed.sides[i]), float(pressed.sides[i]))

    def _set(self, k: int, rest: float, side: float) -> None:
        """Let a contact hold, with the mode ``rest``, or let it go (0)."""
        settling, j = self._settling, int(self._events[k]) + self._sides.first
        settling.modes[self._rests[k]], settling.modes[j] = rest, 0.0 if rest else side
        settling.marks[j] = 0.0
        if not rest:
            settling.mark([j])
        settling.prepare()

    def _collapse(self, noise: Array) -> bool:
        """The limit of infinitely many impacts at one time: all relative velocities that are not 0 then are
        those of bodies that part. Whether it is found."""
        sides, held = self._sides, self._settling.modes[self._rests] != 0.0
        which = np.flatnonzero(self._at_zero() | held)
        own, where = self._events[which], self._where()[which]
        pushes = Pushes(sides, own, where, self._usual(noise[own]))
        chosen, along, changes = pushes.coupled(np.flatnonzero(self._due(noise)[which]))
        speeds, least = sides.all_coefficients()[own, 1], noise[own]
        sums, hit, pivoting = np.zeros(len(chosen)), np.ones(len(chosen), dtype=bool), Pivoting()
        for _ in range(ROUNDS * (len(chosen) + 1)):
            sums[:] = 0.0
            off, matrix = -speeds[chosen[hit]], changes[np.ix_(chosen[hit], hit)]
            sums[hit] = np.linalg.lstsq(matrix, off, rcond=None)[0]
            left = (speeds + changes @ sums) * where
            wrong = np.where(hit, sums * where[chosen] < 0.0, left[chosen] < -least[chosen])
            if not wrong.any():
                pushes.move(np.stack([np.zeros(len(along)), along @ sums], axis=1))
                return not np.any(self._due(noise))
            for i in pivoting.chosen(np.flatnonzero(wrong).tolist()):
                hit[i] = not hit[i]
        return False

    def part(self, event: int, noise: Array) -> bool:
        """Put apart by less than rounding what touches at an event, where nothing holds it, but rounding
        errors lead back; whether its action does so."""
        sides, pressed = self._sides, self._pressed(noise)
        others = self._events[pressed.events]
        own = np.array([event, *others[others != event]])
        where = np.array([sides.side(event), *pressed.sides[others != event]])
        sizes = sides.sizes()[own]
        usual = self._usual(noise[own])
        pushes = Pushes(sides, own, where, usual)
        length = float(sides.memory[sides.layout.at(Clock.LENGTH)])
        off = sides.all_coefficients()[own, :2]
        off[0, 0] -= where[0] * APART[sides.program.parts] * max(float(sizes[0, 0]), usual * length)
        chosen, along, changes = pushes.coupled(np.array([0]))
        if 0 not in chosen:
            return False
        off[1:, 0] = 0.0
        pushes.move(along @ np.linalg.lstsq(changes[chosen], -off[chosen], rcond=None)[0])
        sides.settling.marks[event + sides.first] = 0.0
        return True

    def _usual(self, noise: Array) -> float:
        """The usual speed of bodies, whose rounding errors are known."""
        return float(np.max(noise, initial=0.0)) / ROUNDING or 1.0

    def _stop(self, pressed: Pressed, noise: Array) -> None:
        """Take away the relative velocities that are left of what touches, and distances."""
        sides, own = self._sides, self._events[pressed.events]
        found = np.zeros(0, dtype=np.intp)
        for _ in range(REPEATED):
            off = sides.all_coefficients()[own, :2]
            off[self._settling.modes[self._rests[pressed.events]] == 0.0, 0] = 0.0
            least = LEFT * np.fmax(sides.sizes()[own], sides.least_sizes())
            chosen = np.flatnonzero(np.any(np.abs(off) > least, axis=1))
            if not len(chosen):
                return
            if not np.isin(chosen, found).all():
                pushes = Pushes(sides, own, pressed.sides, self._usual(noise[own]))
                found, along, changes = pushes.coupled(chosen)
            if not len(found):
                return
            wanted = np.linalg.lstsq(changes[found], -off[found], rcond=None)[0]
            pushes.move(along @ wanted)
