"""Which impacts of families reflect the speed, and keep the energy: at a random state, moved to where each
event happens.

An action may do so there alone, as that of hard discs does that divides by 4 R^2 instead of the square of
the distance. So each event has a state of its own, on a line along its gradient.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import numpy as np

from lagrange_cli.expression.index_arrays import distinct
from lagrange_cli.expression.node import Node
from lagrange_cli.families.arrays import NONE, Term, Total, total_of
from lagrange_cli.families.builder import FamilyBuilder
from lagrange_cli.families.events import ROUNDED, SEEDS, Events, random_state
from lagrange_cli.families.tables import found_in
from lagrange_cli.families.values import FamilyValues
from lagrange_cli.records import replace

if TYPE_CHECKING:
    from lagrange_cli.expression.index_arrays import Places

    Values = np.ndarray[tuple[int, ...], np.dtype[np.float64]]

ITERATIONS = 50
"""Steps of Newton's method to where an event happens."""
NUMBERS = 2**21
"""Velocities at all states that are looked at together."""
REACHED = 1e-13
"""An argument is 0 if it is this part of its terms."""


class EventStates(FamilyValues):
    """The values of what events read and set, each at its own state: coordinates are ``moved`` by numbers for
    the pairs ``keys`` of event and coordinate (the event times all coordinates, plus the coordinate)."""

    def __init__(self, builder: FamilyBuilder, events: Events) -> None:
        t, q, v, parameters = random_state(builder, SEEDS[1])
        super().__init__(builder, t, q, v, parameters)
        self.builder, self.events, self.v = builder, events, v
        self.degrees, self.count = builder.q.count, events.count
        self.keys = distinct(np.concatenate([np.zeros(1, dtype=np.int64), *self._listed()]))
        self.moved = np.zeros(len(self.keys))
        self._changed = events.changed
        self._reading: Places | None = None
        """The event of each member of what is evaluated."""

    def _listed(self) -> list[Places]:
        """The pairs of what arguments read."""
        return [
            term.targets * self.degrees + slot.table
            for term in self.events.arguments.terms
            for _, slot in self.builder.slots.inside(term.node)
            if slot.array is self.builder.q
        ]

    def of_events(self, node: Node, events: Places) -> Values:
        """The values of an expression for each of these events."""
        self._reading = events
        values = np.asarray(self.node(node), dtype=float)
        self._reading = None
        return np.broadcast_to(values, len(events))

    def of(self, total: Total) -> Values:
        """Sums, which are those of the state that is not moved."""
        reading, self._reading = self._reading, None
        values = super().of(total)
        self._reading = reading
        return values

    def _value(self, node: Node, arguments: Any) -> Any:
        value, slot = super()._value(node, arguments), self.slots.of.get(node)
        if self._reading is None or slot is None or slot.array is not self.builder.q:
            return value
        at, known = found_in(self.keys, self._reading * self.degrees + slot.table)
        return value + np.where(known, self.moved[at], 0.0)

    def _move(self) -> None:
        """Move each to where its event happens; those for which there is no such place stay."""
        of_key = self.keys // self.degrees
        for _ in range(ITERATIONS):
            value, slopes = np.zeros(self.count), np.zeros(len(self.keys))
            for term in self.events.arguments.terms:
                own = self.of_events(term.node, term.targets)
                value += np.bincount(term.targets, own, self.count)
                for symbol, slot in self.builder.slots.inside(term.node):
                    if slot.array is self.builder.q:
                        at, _ = found_in(self.keys, term.targets * self.degrees + slot.table)
                        slope = self.of_events(self.builder.graph.diff(term.node, symbol), term.targets)
                        slopes += np.bincount(at, slope, len(self.keys))
            reach = np.bincount(of_key, np.abs(slopes), self.count)
            near = np.abs(value) <= REACHED * reach
            if near.all():
                break
            square = np.bincount(of_key, slopes**2, self.count)
            self.moved -= np.where(near, 0.0, value / square)[of_key] * slopes
        self.moved[~near[of_key]] = 0.0

    @property
    def _new(self) -> Values:
        """What actions set."""
        new, acting = np.zeros(self.events.values.count), self._changed[0]
        for term in self.events.values.terms:
            new += np.bincount(term.targets, self.of_events(term.node, acting[term.targets]), len(new))
        return new

    def reflected(self) -> Any:
        """Of which events the action changes the sign of the rate of the argument, and nothing else of it."""
        acting, places = self._changed
        speeds = (places >= self.degrees) & (places < 2 * self.degrees)
        sets = np.where(speeds, acting * self.degrees + places - self.degrees, NONE)
        order = np.argsort(sets, kind="stable")
        sets, new = sets[order], self._new[order]
        total, size = np.zeros(self.count), np.zeros(self.count)
        graph = self.builder.graph

        def add(term: Term, values: Values) -> None:
            total[:] += np.bincount(term.targets, values, self.count)
            size[:] += np.bincount(term.targets, np.abs(values), self.count)

        for term in self.events.arguments.terms:
            add(term, 2.0 * self.of_events(graph.diff(term.node, self.builder.time), term.targets))
            for symbol, slot in self.builder.slots.inside(term.node):
                if slot.array is self.builder.q:
                    slope = self.of_events(graph.diff(term.node, symbol), term.targets)
                    at, known = found_in(sets, term.targets * self.degrees + slot.table)
                    before = self.v[slot.table]
                    add(term, slope * before)
                    add(term, slope * np.where(known, new[at], before))
        return np.abs(total) <= ROUNDED * size

    def lossless(self, masses: Total) -> Any:
        """Which events do not change T; actions set velocities alone."""
        acting, places = self._changed
        rows, mass, new = places - self.degrees, self.of(masses), self._new
        change, size = (
            np.bincount(acting, mass[rows] * (new**2 + sign * self.v[rows] ** 2), self.count)
            for sign in (-1.0, 1.0)
        )
        return np.abs(change) <= ROUNDED * size

    def reversed(self) -> Any:
        """Which events give all velocities that they set the opposite sign: T stays the same with whatever
        impulses of constraints there are besides."""
        acting, places = self._changed
        new, old = self._new, self.v[places - self.degrees]
        wrong = np.abs(new + old) > ROUNDED * (np.abs(new) + np.abs(old))
        return np.bincount(acting, wrong, self.count) == 0

    def judge(self, test: Callable[[], Any], asked: Any) -> Any:
        """Which of the events ``asked`` (booleans) pass a test at a random state, or where they happen."""
        with np.errstate(all="ignore"):
            found = test()
            if not np.all(found[asked]):
                if not self.moved.any():
                    self._move()
                found |= test()
        return found & asked


def turned(builder: FamilyBuilder, events: Events, kinetic: Node) -> tuple[Any, Any]:
    """On chains and trees, of which events the action changes the sign of the rate of the argument, and
    nothing else of it; and which of them do not change T, all at a random state."""
    t, q, v, parameters = random_state(builder, SEEDS[1])
    acting, places = events.changed
    given = (one for one in events.arguments.terms if not builder.slots.moving(one.node, {builder.v}))
    terms = [replace(one, node=builder.rate(one.node, one.domain)) for one in given]
    rates = total_of(events.count, terms, builder.graph)
    reflected, lossless = np.ones((2, events.count), dtype=bool)
    with np.errstate(all="ignore"):
        here = FamilyValues(builder, t, q, v, parameters)
        new, before, energy = here.of(events.values), here.of(rates), here.node(kinetic)
        speeds = (places >= len(q)) & (places < 2 * len(q))
        for some in np.array_split(distinct(acting), -(-len(q) * events.count // NUMBERS)):
            mine = np.flatnonzero(np.isin(acting, some) & speeds)
            columns = np.repeat(v[:, None], len(some), axis=1)
            columns[places[mine] - len(q), np.searchsorted(some, acting[mine])] = new[mine]
            there = FamilyValues(builder, t, np.repeat(q[:, None], len(some), axis=1), columns, parameters)
            after = there.of(rates)[some, np.arange(len(some))]
            reflected[some] = np.abs(after + before[some]) <= ROUNDED * (np.abs(after) + np.abs(before[some]))
            lossless[some] = np.abs(there.node(kinetic) - energy) <= ROUNDED * np.abs(energy)
    return reflected, lossless
