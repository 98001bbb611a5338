"""The first part of a motion that friction along vectors has held, from where it begins to slide.

At u = 0 the direction u/|u| has no series, though it has a limit. The motion is taken a little way from there
by collocation: rates at Gauss's nodes are those of the polynomial through them. Newton's method begins with
the motion that is held, whose force has a direction, and what friction in this direction changes about it."""

from __future__ import annotations

import math
from collections.abc import Container, Iterable, Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np

from lagrange_cli.integrate.guards.apart import Newton, Stage
from lagrange_cli.integrate.guards.at_zero import ROUNDED_OFF
from lagrange_cli.integrate.guards.collocation import STAGES, rule
from lagrange_cli.integrate.guards.resting import Choosing, Friction, Resting, unit
from lagrange_cli.native.guards import HELD
from lagrange_cli.records import dataclass, replace

if TYPE_CHECKING:
    from lagrange_cli.integrate.arrays import Array

ROUNDS, TURNS = 12, 3
"""Iterations of Newton's method, at most; and of directions before it."""
EXACT, ROUNDED = 2.0**-48, (2.0**-48, 2.0**-100)
"""Changes in the last iteration and the last coefficient of polynomials: of accelerations, beside that of
friction or, where its direction has low parts, beside their sum; or of velocities, beside these."""
UNTOLD = 2.0**-50
"""Changes of accelerations that are rounding, beside their sum: friction may be a small part of it."""
SETTLED, SEVERAL = 2.0**-40, 8.0
"""Changes that iterations leave, as part of accelerations, if these are settled up to rounding; how many
last changes a last coefficient may be."""
FAINT = 2.0**-60
"""Accelerations that are so small beside others are left out, if nothing moves there without them."""
BALANCED = 2.0**6
"""Friction that is so many times as large as the acceleration along it has the direction of other forces."""
NUDGE, STEEP = 2.0**-10, 2.0**-17
"""By which part of |u| velocities are changed to find how forces depend on them; where friction is in balance
with others, and changes only with the direction, but by far more."""
COARSE, KNOWN = 2.0**-1, 2.0**5
"""The same where |u| is not much more than rounding: at most; and as many rounding errors of velocities."""


@dataclass(frozen=True)
class Held:
    """The motion while vectors are held: the series of its ``accelerations`` (velocities, coefficients), of
    the ``forces`` that hold the vectors (parts, coefficients), and what ``friction`` does to them. Friction
    may soon turn vectors that slide already: no more than the present accelerations count of these. What is
    held may depend on the rest of it (``resting``)."""

    accelerations: Array
    forces: Mapping[int, Array]
    friction: dict[int, Friction]
    resting: Resting | None

    def sliding(self, t: float) -> dict[int, float]:
        """The guards that slide after a time, if nothing has until then, with their modes."""
        found = {} if self.resting is None else self.resting.sliding(t)
        return {j: 1.0 if j in self.forces else float(one[0]) for j, one in found.items()}

    def directions(self, t: float, sliding: Iterable[int]) -> dict[int, Array]:
        """Those of vectors that slide then: where forces do not depend on one another, of these."""
        found = {} if self.resting is None else self.resting.sliding(t)
        powers = t ** np.arange(self.accelerations.shape[1])
        return {
            j: found[j] if j in found else unit(self.forces[j] @ powers)
            for j in sliding
            if j in self.friction
        }

    @property
    def scale(self) -> float:
        """A time in which accelerations and forces change by as much as they are, at most."""
        times, usual = [math.inf], max((one.usual for one in self.friction.values()), default=0.0)
        for series, least in ((self.accelerations, usual), *((one, 0.0) for one in self.forces.values())):
            sizes = np.max(np.abs(series), axis=0)
            whole = max(sizes[0], least)
            times += [(whole / size) ** (1.0 / m) for m, size in enumerate(sizes) if m and size > 0.0]
        return min(times)


@dataclass(frozen=True)
class Way:
    """The motion from the memory ``origin`` on for a ``length`` of time, by its ``rates`` at Gauss's nodes
    (nodes, rows but q). How fast friction turns vectors at its end, and in what time forces change:
    ``turning`` and ``scale``."""

    origin: Array
    length: float
    rates: Array
    turning: float
    scale: float


class Onset(Choosing):
    """Motions that begin to slide."""

    onset: Way | None = None
    """How sliding has begun last, until this is forgotten."""

    def held(self, vectors: Iterable[int], sliding: Iterable[int]) -> Held:
        """The motion from here on if nothing slides; what friction does is found of all, or where they are
        apart, of those that are ``sliding`` then."""
        self._series()
        accelerations = self._coefficients_of(self._own.start, self._own.stop).copy()
        forces = {}
        for j in vectors:
            guard = self._rows.guards[j]
            forces[j] = self._coefficients_of(guard.multiplier, guard.multiplier + guard.parts).copy()
        known = (j for j in sliding if j in forces) if self._apart else forces
        for j in self._others(forces):
            accelerations[[*self._rows.guards[j].pivots], 1:] = 0.0
        friction = {j: self._friction(j) for j in known}
        return Held(accelerations, forces, friction, self._resting(friction))

    def _others(self, vectors: Container[int]) -> list[int]:
        """The vectors that slide, without some."""
        guards = self._rows.guards
        listed = (j for j in self._rows.vectors if guards[j].multiplier and self.modes[j] > 0.0)
        return [j for j in listed if j not in vectors]

    def _guess(self, t: float, held: Held, sliding: Iterable[int]) -> tuple[Array, dict[int, Array]]:
        """About the accelerations after a time, and the directions in which vectors slide then."""
        memory, orders = self.memory.copy(), np.arange(held.accelerations.shape[1])
        powers = t**orders
        usual = held.accelerations @ powers
        places = held.accelerations @ (powers * t**2 / ((orders + 1) * (orders + 2)))
        speeds = held.accelerations @ (powers * t / (orders + 1))
        along = held.directions(t, sliding)
        found = usual
        for _ in range(TURNS):
            nudges = [held.friction[j].moving(one) for j, one in along.items()]
            found = self._rates_at(t, places, speeds + self._tiny * np.sum(nudges, axis=0))[: len(usual)]
            self.memory[:] = memory
            rates = {j: held.friction[j].slopes @ (found - usual) for j in along}
            along = {j: unit(held.friction[j].rate * one + rates[j]) for j, one in along.items()}
        for j, one in along.items():
            found = found - held.friction[j].velocities @ (rates[j] - one * (one @ rates[j]))
        return found, along

    def _in_balance(
        self,
        guesses: Sequence[tuple[Array, dict[int, Array]]],
        held: Held,
        times: Array,
        once: Array,
        begun: Mapping[int, Array],
    ) -> Array | None:
        """About the accelerations at some times, which ``once`` integrates, where friction is far more than
        what it leaves of other forces; None if it is not. Its direction is theirs, and so is that of the
        vectors whose parts were ``begun``."""
        balanced, found = False, np.array([one for one, _ in guesses])
        usual = times[:, None] ** np.arange(held.accelerations.shape[1]) @ held.accelerations.T
        for j, parts in begun.items():
            friction = held.friction[j]
            along = np.array([one[j] for _, one in guesses])
            rates = (found - usual) @ friction.slopes.T
            gains = np.sum(along * rates, axis=1)
            if friction.rate > BALANCED * float(np.max(np.abs(gains))):
                speeds = float(np.linalg.norm(parts)) + once @ gains
                wanted = np.linalg.solve(once, speeds[:, None] * along - parts)
                balanced, found = True, found + (wanted - rates) @ friction.velocities.T
        return found if balanced else None

    def _collocated(
        self, length: float, until: float, held: Held, sliding: Mapping[int, float], rest: Array | None = None
    ) -> dict[int, float] | None:
        """Move on ``until`` a time, at most a ``length``, in which guards that have been ``held`` have other
        modes: they are ``sliding``. (If they are so already, ``rest`` is the memory in which they are not.)
        Returns further ones, where forces exceed their limits on this way; None where polynomials of that
        length do not describe the motion."""
        own = self.machine.program.degrees
        usual = max((held.friction[j].usual for j in sliding if j in held.friction), default=0.0)
        self.modes[[*sliding]] = [*sliding.values()]
        origin, gauss_rule = self.memory.copy(), rule()
        parts = self.machine.program.parts
        speeds = np.abs(origin[self._own])  # surfaces move with the time, which is rounded, too
        by_time = abs(origin[self._layout.time]) * np.max(np.abs(held.accelerations[:, 0])) / 8.0
        rounded = ROUNDED[parts - 1] * float(max(np.max(speeds), by_time))
        once, twice, times = gauss_rule.once, gauss_rule.twice, gauss_rule.nodes * length
        others = self._others(sliding)
        vectors = [*(j for j in sliding if j in held.friction), *others]  # friction turns slow ones soon
        pivots = [self._rows.guards[j].pivots for j in vectors]
        units = ROUNDED_OFF[parts - 1] * np.array([np.max(speeds[[*one]]) for one in pivots])
        begins = self._parts(*others) if others else np.zeros(0)

        def rates(t: float, places: Array, speeds: Array) -> Array:
            self.memory[:] = origin
            return self._rates_at(t, places, speeds)

        newton = Newton(pivots, length * once, rates)
        step = newton.apart if self._apart else newton.whole
        begun = {j: self._parts(j) for j in sliding if j in held.friction}
        if rest is not None:
            self.memory[:] = rest
            self.modes[[*sliding]] = [*sliding.values()]
        guesses = [self._guess(t, held, sliding) for t in times]
        found, part = self._in_balance(guesses, held, times, length * once, begun), STEEP
        if found is None:
            found, part = np.array([one for one, _ in guesses]), NUDGE
        for _ in range(ROUNDS):
            if not np.all(np.isfinite(found)):
                return None
            speeds, places = length * (once @ found), length**2 * (twice @ found)
            accelerations, stages = np.empty((STAGES, own)), list[Stage]()
            for i, one in enumerate(zip(times, places, speeds)):
                accelerations[i] = rates(*one)[:own]
                sizes = np.array([self._speed_along(j, held) for j in vectors])
                nudges = np.fmax(part * sizes, np.fmin(COARSE * sizes, KNOWN * units))
                stages.append(Stage(*one, nudges))
            if not np.all(np.isfinite(accelerations)):
                return None
            change = step(stages, accelerations - found)
            if not np.all(np.isfinite(change)):
                return None
            found = found + change
            sum_of_all = float(np.max(np.abs(found)))
            exact = max(EXACT * usual, UNTOLD * sum_of_all) if parts == 1 else EXACT * sum_of_all
            if np.max(np.abs(change)) <= exact or np.max(np.abs(length * (once @ change))) <= rounded:
                break
        else:  # what iterations leave is rounding, such as of directions of slow vectors beside fast ones
            if not np.max(np.abs(change)) <= SETTLED * sum_of_all:
                return None
        exact = max(exact, SEVERAL * float(np.max(np.abs(change))))
        faint = np.max(np.abs(found), axis=0) <= FAINT * sum_of_all
        without = np.where(faint, 0.0, found)
        ways = zip(times, length**2 * (twice @ without), length * (once @ without))
        if not any(np.any(rates(*one)[:own][faint]) for one in ways):
            found = without  # what is left of their errors decays fast, in short steps
        speeds, places = length * (once @ found), length**2 * (twice @ found)
        highest = [float(np.max(np.abs(gauss_rule.series[-1] @ one))) for one in (found, speeds)]
        if highest[0] > exact and highest[1] > rounded:
            return None
        here, beyond = [], dict[int, float]()
        for t, (_, along), *changes in zip(times, guesses, places, speeds):
            here.append(rates(t, *changes))
            beyond |= self._beyond()
            forward = all(self._parts(j) @ one > 0.0 for j, one in along.items())
            if not (forward and self._go_on(others, begins) and self._on_their_sides()):
                return None
        if beyond:
            return beyond
        way = Way(origin, length, np.hstack([found, np.array(here)[:, own:]]), 0.0, held.scale)
        self._follow(way, until)
        turning = [held.friction[j].rate / float(np.linalg.norm(self._parts(j)) or np.inf) for j in begun]
        self.onset = replace(way, turning=max(turning, default=0.0))
        self.marks[:] = np.fmin(self.marks, 0.0)
        return {} if self._go_on(others, begins) and self._on_their_sides() else None

    def _follow(self, way: Way, t: float) -> None:
        """Move to where a motion is after a time."""
        layout, own = self._layout, self.machine.program.degrees
        to_speeds, to_places = rule().until(t / way.length)
        self.memory[:] = way.origin
        self._move(t, np.zeros(way.rates.shape[1]))
        places = way.length**2 * (to_places @ way.rates[:, :own])
        self._add(slice(layout.q.start, layout.q.start + own), places)
        self._add(layout.rates, way.length * (to_speeds @ way.rates))

    def samples(self, way: Way, times: Array) -> Array:
        """The states (rows of every part, n) at some times."""
        memory, layout, found = self.memory.copy(), self._layout, []
        for t in np.fmax(times - way.origin[layout.time], 0.0):
            self._follow(way, t)
            high, low = (self.memory[layout.part(part)].copy() for part in (0, 1))
            found.append(high + low if self.machine.program.parts == 1 else np.append(high, low))
        self.memory[:] = memory
        states: Array = np.array(found).reshape(len(times), layout.rows * self.machine.program.parts).T
        return states

    def _speed_along(self, j: int, held: Held) -> float:
        """How large velocities are that make up a vector."""
        slopes = held.friction[j].slopes if j in held.friction else np.ones(1)
        return float(np.linalg.norm(self._parts(j)) / np.max(np.abs(slopes)))

    def _beyond(self) -> dict[int, float]:
        """The guards whose forces exceed their limits while they are held, with the modes of their sides."""
        self._series()
        rows = enumerate(self._rows.guards[: self.count])
        held = [j for j, guard in rows if guard.multiplier and self.modes[j] == 0.0]
        found = zip(held, self._multipliers(held).tolist())
        return {j: 1.0 if size > 0.0 else -1.0 for j, size in found if not abs(size) <= HELD}

    def _exceeds(self, j: int, t: float) -> bool:
        """Whether the force that holds a vector, which is as large as its limit, exceeds it after a time."""
        self._series()
        limit = self._rows.guards[j].limit
        rows = self._coefficients_of(limit, limit + 2)
        above, below = (rows @ t ** np.arange(rows.shape[1])).tolist()
        return not below >= (1.0 - HELD) / 2.0 * (above + below)

    def _go_on(self, vectors: Sequence[int], begins: Array) -> bool:
        """Whether none of the vectors, whose parts were ``begins``, has turned round: friction would."""
        if not vectors:
            return True
        along = np.add.reduceat(self._parts(*vectors) * begins, self._first_parts(vectors))
        return bool(np.all(along > 0.0))

    def _on_their_sides(self) -> bool:
        """Whether arguments have the signs of their modes."""
        arguments = self.coefficients_between(self._rows.first, self._rows.first + self._rows.count)[:, 0]
        return bool(np.all(arguments * self.modes[: len(arguments)] >= 0.0))
