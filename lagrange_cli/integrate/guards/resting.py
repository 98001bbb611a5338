"""What friction does to velocities that are 0, and which of them it lets go (see ``choice``)."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from functools import cached_property, partial
from typing import TYPE_CHECKING, TypeAlias

import numpy as np

from lagrange_cli.integrate.guards.apart import unit_slopes
from lagrange_cli.integrate.guards.choice import Choice, places_of
from lagrange_cli.integrate.guards.leading import Leading
from lagrange_cli.integrate.guards.slopes import LinearSlopes, inverse_of
from lagrange_cli.records import dataclass

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from lagrange_cli.integrate.arrays import Array
    from lagrange_cli.native.guards import GuardRow

    Sides: TypeAlias = Sequence[tuple[Array, Array]]
    """Series (rows, orders) where friction that has held something acts as if this slid along each of its
    parts, and the other way."""

SOON = 2.0**-30
"""A velocity that becomes 0 within this fraction of the time is set to 0."""
ORDERS = 3
"""So many coefficients of such series are kept: up to the second derivatives of places."""


@dataclass(frozen=True)
class Friction:
    """Friction along a vector where that is 0: the ``slopes`` of its parts by velocities (parts,
    velocities), the ``velocities`` that friction gives it, for each part that then is 1 (velocities, parts);
    how large accelerations by friction are, ``usual``, and the ``rate`` of the vector by it. All of this
    follows from the ``sides``."""

    slopes: Array
    velocities: Array
    usual: float
    rate: float
    sides: Sides

    def moving(self, along: Array) -> Array:
        """Velocities with which the vector has a direction: those that friction gives it, and any others in
        directions in which constraints leave nothing to friction, as driven ones do."""
        given = self.velocities @ along
        found: Array = given + inverse_of(self.slopes) @ (along - self.slopes @ given)
        return found


class Choosing(Leading):
    """Motions that friction holds."""

    @property
    def _own(self) -> slice[int, int, None]:
        """The velocities, without those of auxiliary coordinates."""
        first = self._layout.v.start
        return slice(first, first + self.machine.program.degrees)

    @property
    def _tiny(self) -> float:
        """A velocity that is small beside those of the motion."""
        return SOON * (float(np.max(np.abs(self.memory[self._own]))) or self.span)

    def _parts(self, *vectors: int) -> Array:
        """The parts of vectors, one after the other."""
        self._series()
        guards = [self._rows.guards[j] for j in vectors]
        return np.concatenate(
            [self._coefficients_of(one.beside, one.beside + one.parts)[:, 0] for one in guards]
        )

    def _first_parts(self, vectors: Sequence[int]) -> NDArray[np.intp]:
        """Where each of these vectors begins among their parts."""
        return np.cumsum([0, *(self._rows.guards[j].parts for j in vectors[:-1])], dtype=np.intp)

    @cached_property
    def _apart(self) -> bool:
        """Whether all vectors are held apart from one another."""
        guards = [self._rows.guards[j] for j in self._rows.vectors]
        return bool(guards) and all(one.alone for one in guards)

    def _slopes_of_parts(self, *vectors: int) -> Array:
        """Their derivatives by velocities (parts, velocities); they are linear in these."""
        if self._apart:
            pivots = [self._rows.guards[j].pivots for j in vectors]
            return unit_slopes(pivots, self.machine.program.degrees)
        every = self._rows.vectors
        slopes = self._linear_slopes.at(partial(self._changed_parts, every))
        firsts = dict(zip(every, self._first_parts(every)))
        return np.concatenate([slopes[firsts[j] :][: self._rows.guards[j].parts] for j in vectors])

    @cached_property
    def _linear_slopes(self) -> LinearSlopes:
        """What the slopes of parts follow from."""
        return LinearSlopes(self.machine.program.degrees)

    def _changed_parts(self, vectors: Sequence[int], speeds: Array) -> Array:
        """The parts of vectors with changed velocities."""
        memory = self.memory.copy()
        self.memory[self._own] += speeds
        parts = self._parts(*vectors)
        self.memory[:] = memory
        return parts

    def _rates_at(self, t: float, places: Array, speeds: Array) -> Array:
        """The rates of all rows but q after a time, in which coordinates and velocities change by so much
        more than in uniform motion. That state stays in the memory."""
        layout = self._layout
        self._move(t, np.zeros(layout.rates.stop - layout.rates.start))
        self._add(slice(layout.q.start, layout.q.start + len(places)), places)
        self._add(self._own, speeds)
        self._series()
        return self._rates_of_rows()

    def _both_ways(self, j: int) -> Sides:
        """The first orders of series where friction that holds a vector, or a switch, acts as if it slid
        along each of its parts, and the other way."""
        memory, vector = self.memory.copy(), self._rows.guards[j].parts > 0
        still, found = np.zeros(self.machine.program.degrees), []
        nudges = (self._tiny * inverse_of(self._slopes_of_parts(j))).T if vector else still[None]
        for nudge in nudges:
            sides = []
            for side in (1.0, -1.0):
                self.modes[j] = 1.0 if vector else side
                self._rates_at(0.0, still, side * nudge)
                sides.append(self._here[:, :ORDERS].copy())
                self.memory[:] = memory
            found.append((sides[0], sides[1]))
        return found

    def _friction(self, j: int) -> Friction:
        """What friction does to a vector that is held."""
        slopes, sides, own = self._slopes_of_parts(j), self._both_ways(j), self.machine.program.degrees
        given = np.array([(ahead[:own, 0] - behind[:own, 0]) / 2.0 for ahead, behind in sides]).T
        rates = slopes @ given
        if not np.all(np.isfinite(given)) or not np.any(rates):
            return Friction(slopes, inverse_of(slopes), 0.0, 0.0, sides)
        usual, rate = (float(np.max(np.abs(one))) for one in (given, rates))
        return Friction(slopes, given @ inverse_of(rates), usual, rate, sides)

    def _hold_all(self) -> None:
        """Hold switches, too, whose velocities are 0: they may have been let go by what holds vectors."""
        if self._apart:
            return
        self._series()
        for j, (u, rate) in enumerate(self._coefficients_of_arguments()[:, :2].tolist()):
            guard = self._rows.guards[j]
            if guard.multiplier and u == 0.0 and not (guard.placed and rate):
                self.modes[j] = 0.0

    def _resting(self, friction: Mapping[int, Friction]) -> Resting | None:
        """What is held now; None if that is one thing alone, or if things are held apart from one another, so
        that there is nothing to choose, or if forces have no value."""
        rows = self._rows.guards[: self.count]
        guards = {j: one for j, one in enumerate(rows) if one.multiplier and self.modes[j] == 0.0}
        if len(guards) < 2 or self._apart:
            return None
        self._series()
        held, first = self._here, self._layout.v.start
        sides = [friction[j].sides if j in friction else self._both_ways(j) for j in guards]
        return resting(guards, first, held, sides)


@dataclass(frozen=True)
class Resting:
    """The ``guards`` that are held, by number, and series (rows from the ``first``, orders) while they are.
    The squares of parts add up with the squares of these ``scales``; forces may have the opposite ``signs``.
    Limits that do not change are ``fixed``, others nan."""

    guards: Mapping[int, GuardRow]
    first: int
    held: Array
    scales: Array
    signs: Array
    fixed: Array
    choice: Choice

    def sliding(self, t: float) -> dict[int, Array]:
        """Those that slide after a time if nothing has until then, with their directions; none if that is not
        found."""
        rows = self.held @ t ** np.arange(self.held.shape[1])
        forces, limits = read(self.guards.values(), self.first, rows)
        limits = np.where(np.isnan(self.fixed), limits, self.fixed)
        rates = self.choice.rates(self.signs * self.scales * forces, limits)
        if rates is None:
            return {}
        each = zip(self.guards, places_of(self.choice.parts))
        return {j: unit(rates[one] / self.scales[one]) for j, one in each if rates[one].any()}


def resting(
    guards: Mapping[int, GuardRow], first: int, held: Array, sides: Sequence[Sides]
) -> Resting | None:
    """How the forces that hold guards depend on the rates of what they hold, by the ``sides`` of each; None
    if they have no value."""
    rows = [*guards.values()]
    parts = [max(one.parts, 1) for one in rows]
    width, places = sum(parts), places_of(parts)
    scales, signs, fixed = np.ones(width), np.ones(width), np.full(len(rows), np.nan)
    for one, place, both in zip(rows, places, sides):
        if one.parts:  # of which one is not 0
            lengths, beside = [ahead[one.row - first, 0] for ahead, _ in both], one.beside - first
            sizes = [ahead[beside + p, 0] for p, (ahead, _) in enumerate(both)]
            scales[place] = np.divide(lengths, sizes)
    here = scales * read(rows, first, held[:, 0])[0]
    slopes, falls = np.zeros((width, width)), np.zeros((len(rows), width))
    for i, (one, place, both) in enumerate(zip(rows, places, sides)):
        found = [[read(rows, first, side[:, 0]) for side in pair] for pair in both]
        forces, limits = (np.array([[side[k] for side in pair] for pair in found]) for k in (0, 1))
        rates = np.array([[scales[place] * rates_of(one, first, side) for side in pair] for pair in both])
        if not all(np.all(np.isfinite(each)) for each in (here, forces, limits, rates)):
            return None
        own, inverse = limits[:, :, i], inverse_of(rates[:, 0] - rates[:, 1], SOON)
        change = scales * (forces[:, 0] - forces[:, 1])
        change[:, place] = np.diag(own.sum(axis=1))
        slopes[:, place] = (inverse @ change).T
        falls[:, place] = (inverse @ (limits[:, 0] - limits[:, 1])).T
        holds = np.diag(own[:, 0] - own[:, 1]) - rates.sum(axis=1) @ slopes[place, place].T
        if holds.sum(axis=0) @ here[place] < 0.0:  # the limit is less than 0
            signs[place] = -1.0
            slopes[place, place] *= -1.0
        if np.ptp(own) == 0.0:
            fixed[i] = own[0, 0]
    falls[~np.isnan(fixed)] = 0.0
    return Resting(guards, first, held, scales, signs, fixed, Choice(parts, signs[:, None] * slopes, falls))


def read(guards: Collection[GuardRow], first: int, values: Array) -> tuple[Array, Array]:
    """The forces that hold guards (parts,), and their limits (guards,), from the ``values`` of rows."""
    forces: list[Array] = []
    limits = np.ones(len(guards))
    for i, one in enumerate(guards):
        found = values[one.multiplier - first :][: max(one.parts, 1)]
        if one.limit:
            above, below = values[one.limit - first :][:2]
            limits[i] = abs(above + below) / 2.0
            if one.parts:
                limits[i] **= 0.5
            elif one.limited:
                found = np.array([above - below]) / 2.0
        forces.append(found)
    return np.concatenate(forces), limits


def rates_of(guard: GuardRow, first: int, series: Array) -> Array:
    """Those of the parts of a guard, or the acceleration of a place (parts,)."""
    if guard.parts:
        return series[guard.beside - first :][: guard.parts, 1]
    order = 2 if guard.placed else 1
    found: Array = order * series[guard.row - first][order : order + 1]
    return found


def unit(vector: Array) -> Array:
    """Its direction."""
    found: Array = vector / (float(np.linalg.norm(vector)) or 1.0)
    return found
