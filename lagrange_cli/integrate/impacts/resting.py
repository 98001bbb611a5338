"""Resting contact (see ``mechanics.contacts``): when a motion comes to rest at an event, and leaves it."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from lagrange_cli.integrate.arrays import largest_of
from lagrange_cli.integrate.guards.modes import ROUNDING
from lagrange_cli.integrate.impacts.at_once import AtOnce
from lagrange_cli.integrate.impacts.sides import Sides
from lagrange_cli.integrate.impacts.touching import Touching
from lagrange_cli.native.guards import LOOSE, UNSEEN, Role
from lagrange_cli.native.state import Clock
from lagrange_cli.records import dataclass

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from lagrange_cli.integrate.arrays import Array

SOON = 2.0**-30, 2.0**-44
"""If all further impacts take no longer than this part of a step, the motion rests; in doubles and in
double-double."""
SHORT = 2.0**-26, 2.0**-44
"""The same where it is this part of the time, too, in which accelerations change velocities by their size, as
of others that move on."""
LAST = 2.0**-6
"""Of bodies that hit one another, flights of this part of that time are the last ones."""
SLOW = 256.0
"""Impacts that leave no speed are the last of infinitely many if they have so little, beside what is none."""
FEW = 4.0
"""Impacts that change velocities by so many rounding errors have no speed."""


@dataclass(frozen=True)
class Impact:
    """An impact at an event, from the state ``before`` it, which came from ``side`` with the argument's
    ``speed``. Up to ``noise`` a speed is 0; ``length`` was that of a step, and ``size`` is that of the
    argument's terms."""

    event: int
    side: float
    before: Array
    speed: float
    noise: float
    length: float
    size: float


class Resting:
    """The contacts of a motion that begins at ``start``."""

    def __init__(self, sides: Sides, start: float, trial: Array) -> None:
        self._sides, self._start = sides, start
        if sides.program.joined:  # compiled code does impacts at one time, and notes the last step, too
            sides.settling.last_step = trial[sides.program.trial - 2 :]
            trial[sides.program.trial - 1] = abs(start)
        rests = [j for j, one in enumerate(sides.guards.guards) if one.role is Role.REST]
        self.impacts = sides.program.slowing.keys()
        """The events that are impacts which reduce the speed."""
        events = (e for e, one in sides.program.slowing.items() if one[2] != LOOSE)
        self.guards = dict(zip(events, rests))
        """The guards of resting contact, by event."""
        count = len(sides.program.events)
        self._rests, self._rows = np.zeros((2, count), dtype=np.intp)
        for event, rest in self.guards.items():
            self._rests[event], self._rows[event] = rest, sides.guards.guards[rest].row
        self.rests = self._rests > 0
        """Whether motions may rest at an event."""
        self.released: set[int] = set()
        """Events at which the motion has rested, until they happen again: it leaves them with no speed."""
        self._touching = Touching(sides, self.guards)
        self.at_once = AtOnce(count, start, sides.program.parts)
        self.times = sides.memory[sides.guards.times(sides.layout)].reshape(-1, 2)
        """When each event has acted last."""

    def note(self, event: int) -> None:
        """Record that the event acts now."""
        self.times[event] = self._sides.now, self._low()

    def _low(self) -> float:
        return float(self._sides.memory[self._sides.layout.at(Clock.TIME_LOW)])

    def noise(self) -> Array:
        """Up to which rates events' arguments are at rest."""
        now, length = self._sides.now, self._sides.settling.length()
        time = now - self._start
        rates, gained, near = self._sides.at_present("rates", self._rates)
        self._touching.time, self._touching.near = time, near
        return self.at_once.noise(now, rates, gained * min(1.0, length / time) if time else rates)

    def _rates(self) -> tuple[Array, Array, Array]:
        """The sizes of the terms of the rates of arguments, and of what they have gained by accelerations,
        and how far from 0 rounding has led arguments since the start, at most."""
        sides, n = self._sides, self._sides.program.degrees
        state, time = sides.state(sides.memory), sides.now - self._start
        rates = np.fmax(sides.sizes()[:, 1], sides.least_sizes()[1])
        state[n : 2 * n] = sides.settling.accelerations() * time
        gained = sides.act_on(state)[1][:, 1]
        return rates, gained, ROUNDING * time * (rates + gained)

    def held(self) -> Array:
        """Which contacts hold bodies together: their modes."""
        modes: Array = self._sides.settling.modes[self._rests[self.rests]]
        return modes

    def has_jumped(self, event: int) -> bool:
        """Whether an argument is beyond 0 because it jumps. What is only recorded does not happen either
        where the motion rests, and its argument is nothing but rounding errors."""
        sides = self._sides
        guard = sides.guards.guards[event + sides.first]
        if not (guard.jumps or guard.role is Role.RECORD) or sides.at_zero(event):
            return False
        if not sides.coefficients(event)[0] * sides.side(event) < 0.0:
            return False
        return sides.has_jumped(event, sides.settling.length(), self.near(event))

    def near(self, event: int) -> float:
        """How far from 0 an argument is by rounding, at most: besides what its own terms tell."""
        return float(self.nears()[event])

    def nears(self) -> Array:
        """The same of all events."""
        self.noise()
        return self._touching.near

    def due(self) -> int | None:
        """An impact that happens now, the one that comes first."""
        return self._touching.due(self.noise())

    def fastest(self, event: int) -> int:
        """Of impacts that happen now, the one that comes first."""
        return self._touching.fastest(event, self.noise())

    def together(self) -> None:
        """Let bodies rest on each other that touch without speed."""
        for _ in range(2):  # what others hold may lead back
            noise = self.noise()
            if not self._touching.any:
                break
            unseen = self._unseen()
            largest = float(np.max(unseen[self._touching.now()], initial=0.0))
            before = self._sides.modes.copy()
            self._touching.rest(np.fmax(noise, unseen), self.at_once.same, largest)
            if np.array_equal(self._sides.modes, before):
                break

    def recurs(self) -> bool:
        """Whether infinitely many actions happen at one time, one of them now; flights that rounding may hide
        take none."""
        time = self._none()
        if self._sides.program.carried:
            back = float(np.max(self._back()[self._touching.now()], initial=0.0))
            time = float(np.sqrt(4.0 * UNSEEN / back)) if back else 0.0
        return self.at_once.recurs(self._sides.now, time)

    def _unseen(self) -> Array:
        """The rates with which arguments leave 0 on flights that take a negligible time, or that rounding may
        hide (see ``_hidden``)."""
        sides = self._sides
        if not sides.program.carried:
            return self._back() * self._none()
        return np.sqrt(4.0 * self._back() * UNSEEN * sides.sizes()[:, 0])

    def _none(self) -> float:
        """Up to which length flights take no time where several bodies hit one another."""
        several = np.count_nonzero(self._sides.modes[self._touching.now()]) > 1
        return LAST * self._longest(self._sides.settling.length()) if several else 0.0

    def _back(self) -> Array:
        """What leads arguments back to 0."""
        return np.fmax(-self._sides.all_coefficients()[:, 2] * self._sides.modes, 0.0)

    def stands(self, event: int) -> bool:
        """Whether an event is an impact of what touches, but for rounding, without any speed, and is not led
        back: nothing happens there."""
        sides = self._sides
        if event not in self.guards or sides.at_zero(event) or not sides.side(event):
            return False
        value, rate, bend = (sides.coefficients(event)[:3] * sides.side(event)).tolist()
        near = max(ROUNDING * float(sides.sizes()[event, 0]), self.near(event))
        back = bend < -ROUNDING * float(sides.settling.scale()[1])
        return abs(value) <= near and abs(rate) <= self.noise()[event] and not back

    def let_stand(self, event: int) -> None:
        """Go on there; if rounding leads it beyond 0 again, from where that does not happen."""
        noise, settling, j = self.noise(), self._sides.settling, event + self._sides.first
        again = settling.marks[j] > 0.0
        settling.mark([j])
        if again and self._touching.part(event, noise):
            self.released.add(event)

    def touches(self, event: int) -> bool:
        """Whether an event is an impact without speed of what has touched before."""
        sides, n = self._sides, self._sides.program.degrees
        if not (sides.at_zero(event) or event in self.released) or event not in sides.sets:
            return False
        noise = self.noise()
        if sides.coefficients(event)[1] * sides.side(event) < -noise[event]:
            return False
        if event in self.impacts:
            return True
        before, least = sides.state(sides.memory), FEW * float(np.max(noise))
        values, own = sides.act_now()[0][0], sides.sets[event]
        return all(n <= place < 2 * n and abs(values[i] - before[place]) <= least for i, place in own)

    def touch(self, event: int) -> bool:
        """Go on from where bodies touch without speed, and accelerations or rounding errors lead back;
        whether that is possible."""
        sides, noise = self._sides, self.noise()
        noise[event] = max(noise[event], abs(sides.coefficients(event)[1]))  # a flight that no step shows
        self._touching.rest(noise, self.at_once.same)
        if not sides.side(event):
            return True
        closes = sides.coefficients(event)[2] * sides.side(event) < -ROUNDING * sides.settling.scale()[1]
        self.released.add(event)
        return not closes and self._touching.part(event, noise)

    def settle(self, impact: Impact) -> float | None:
        """Let the motion rest if all further impacts together take a negligible time. Where these are
        infinitely many, the time at which they end."""
        sides, event = self._sides, impact.event
        above, left, bend, *_ = map(float, sides.coefficients(event))
        since = (sides.now - self.times[event, 0]) + (self._low() - self.times[event, 1])
        flight = -left / bend if bend != 0.0 else np.inf
        none = impact.noise  # what leads on after an impact is as little as its rounded numbers make it
        if left * impact.speed > 0.0:
            none = max(none, ROUNDING * abs(impact.speed))
        if abs(left) <= none:
            self._stop(impact, above, left)
            self.hold(event, impact.side)
            return sides.now if 0.0 < abs(left) <= abs(impact.speed) <= SLOW * impact.noise else None
        if 0.0 < flight < since and sides.side(event) == impact.side:
            remaining = float(flight / (1.0 - flight / since))
            if remaining <= self._longest(impact.length) or self._hidden(impact, left, bend):
                ends = sides.now + remaining
                self._stop(impact, above, left)
                self.hold(event, impact.side)
                return ends
        return None

    def _longest(self, length: float) -> float:
        """How long all further impacts may take, beside a step of this ``length``."""
        sides, which = self._sides, self._sides.program.parts - 1
        length = min(length, sides.now - self._start)
        pull = largest_of(sides.settling.accelerations())
        usual = min(length, sides.largest_velocity() / pull) if pull else length
        return max(SOON[which] * length, SHORT[which] * usual)

    def _hidden(self, impact: Impact, left: float, bend: float) -> bool:
        """Whether rounding may hide the next flight, which begins with the speed ``left``."""
        height = left**2 / (4.0 * abs(bend))
        return bool(self._sides.program.carried) and height <= UNSEEN * impact.size

    def _stop(self, impact: Impact, above: float, left: float) -> None:
        """Take the speed that is ``left`` away, in the direction of the impact, and put the motion where the
        argument is 0, ``above`` which it is by rounding."""
        if left == impact.speed:
            return
        sides, n = self._sides, self._sides.program.degrees
        places = sides.outer[n : 2 * n]
        change = sides.memory[places] - impact.before[n : 2 * n]
        for rows, lost in ((sides.outer[:n], above), (places, left)):
            taken = change / (left - impact.speed) * lost
            sides.move(rows, -taken, ROUNDING * np.abs(taken))
        sides.begin_anew()

    def hold(self, event: int, side: float) -> None:
        """Rest at an event, if the force that holds the motion pushes to the ``side`` that it came from; else
        go on there."""
        settling, j, rest = self._sides.settling, event + self._sides.first, self.guards.get(event)
        if rest is None:
            settling.modes[j] = side
            settling.mark([j])
            settling.prepare()
            return
        settling.modes[rest], settling.modes[j] = side, 0.0
        force = settling.coefficients_of(self._sides.guards.guards[rest].row)[0][0]
        if not force * side > 0.0:
            settling.modes[rest], settling.modes[j] = 0.0, side
            settling.mark([j])
            settling.prepare()

    def go_on(self, events: NDArray[np.intp], speeds: Array, noise: Array) -> None:
        """Rest on at these events after the action of another one, where that has given the motion no speed,
        which is more than ``noise`` (all events,): what it had at rest is a rounding error."""
        settling = self._sides.settling
        while len(events):
            forces = settling.values_of(self._rows[events]) * settling.modes[self._rests[events]]
            firm = (np.abs(speeds[events]) <= noise[events]) & (forces > 0.0)
            if firm.all():
                return
            first = int(np.argmin(firm))
            event = int(events[first])
            self._try(event, float(speeds[event]), float(noise[event]))
            events = events[first + 1 :]  # may rest on others

    def _try(self, event: int, speed: float, noise: float) -> None:
        """Rest on, or leave the contact."""
        settling, j, rest = self._sides.settling, event + self._sides.first, self.guards[event]
        side = float(settling.modes[rest])
        settling.modes[rest], settling.modes[j] = 0.0, side
        settling.mark([j])
        if speed * side < -noise:  # towards the contact: an impact
            settling.marks[j] = 0.0
        if abs(speed) <= noise:
            self.hold(event, side)
        else:
            settling.prepare()

    def release(self, rest: int) -> None:
        """End a contact: the force that holds the motion would have to pull."""
        settling = self._sides.settling
        event = next(e for e, guard in self.guards.items() if guard == rest)
        j = event + self._sides.first
        settling.modes[j], settling.modes[rest] = settling.modes[rest], 0.0
        settling.mark([j])
        self.released.add(event)
        self._sides.begin_anew()
        settling.begin_switches()
