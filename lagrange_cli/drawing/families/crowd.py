"""``Crowd``: all particles of families side by side, and where they are at random states.

Members that are written alike are a ``Piece``: one expression for all of them. What is asked of a particle is
asked of all at once, by their values at the states.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from functools import cached_property
from typing import Any

import numpy as np

from lagrange_cli.drawing.located import Located, listed
from lagrange_cli.drawing.probe import NEEDED, ROUNDING, STATES
from lagrange_cli.drawing.scene import HEIGHTS
from lagrange_cli.expression.arrays import Array
from lagrange_cli.expression.index_arrays import Places
from lagrange_cli.expression.indices import Unsuited
from lagrange_cli.expression.node import Node
from lagrange_cli.families.arrays import NONE, Chain, Domain, Slot, Source, Term, Total
from lagrange_cli.families.arrays import Array as Numbers
from lagrange_cli.families.chains import ChainBuilder
from lagrange_cli.families.groups import particle_families
from lagrange_cli.families.values import FamilyValues
from lagrange_cli.records import dataclass
from lagrange_cli.spec.content import names_of
from lagrange_cli.spec.family import Family
from lagrange_cli.spec.spec import Spec, grouped
from lagrange_cli.spec.values import Values

Place = tuple[Node, ...]
Mask = np.ndarray[Any, np.dtype[np.bool_]]
"""Which of some members."""


@dataclass(frozen=True, eq=False)
class Piece:
    """The ``place`` of particles of a family that are written alike, the members of a ``domain``: those of
    these ``numbers``."""

    domain: Domain
    place: Place
    numbers: Places
    family: Family


class Crowd:
    """The particles of a system file, and a few random states near the start. Raises ``Unsuited`` where their
    places are of a kind that arrays do not know."""

    def __init__(self, spec: Spec, values: Values, start: float) -> None:
        self.spec = spec
        self.builder = ChainBuilder(spec)
        self.graph, self.slots = self.builder.graph, self.builder.slots
        self.families = [*grouped(spec.embedding, particle_families(spec))]
        found = [*self._pieces()]
        self.count = sum(len(one.members) for one in self.families)
        components = {len(place) for _, place, _, _ in found}
        self.flat = components == {1}
        deep = any(len(place) == 3 and not place[2].is_zero for _, place, _, _ in found)
        self.dimension = 3 if deep else 2
        self.size = max(map(abs, values.q), default=0.0) or max(map(abs, values.v), default=0.0) or 1.0
        self.upright = self.flat and self._rises()
        self.pieces = [Piece(d, self.lifted(place), n, family) for d, place, n, family in found]
        drawn = np.random.default_rng(0)
        q, v = (np.array(row, dtype=np.float64)[:, None] for row in (values.q, values.v))
        self.q0, self.t0 = q, start
        some_q, some_v = (
            x + (0.2 + 0.4 * np.abs(x)) * drawn.uniform(-1, 1, (len(x), STATES)) for x in (q, v)
        )
        times = start + 3 * drawn.random(STATES)
        given = listed(spec, values.parameters)
        self.values = FamilyValues(self.builder, times, some_q, some_v, given)
        self.initial = FamilyValues(self.builder, np.array([start]), q, v, given)
        self.places = self.at(self.axes(self.pieces))
        self.owners = self._owners()
        self._weights = drawn.uniform(0.5, 1.5, (self.dimension, STATES))
        self._keys = self.key(self.places)
        self._order = np.argsort(self._keys, kind="stable")
        self._moving: dict[Total, bool] = {}

    def _pieces(self) -> Iterator[tuple[Domain, Place, Places, Family]]:
        first = 0
        for family in self.families:
            group = self.builder.positions[family.name]
            for domain, value, which in self.builder.pieces(group, np.arange(group.count)):
                place: Place = value if isinstance(value, tuple) else (value,)
                yield domain, place, first + which, family
            first += group.count

    def _rises(self) -> bool:
        """Whether places of one component are heights."""
        families = grouped(names_of(self.spec.coordinates), self.spec.coordinate_families)
        return {family.name.rstrip("0123456789_") for family in families} <= HEIGHTS

    def lifted(self, place: Sequence[Node]) -> Place:
        """A place of any number of components in the dimension of the drawing."""
        zero = self.graph.zero
        if len(place) == 1 and self.upright:
            place = (*(zero,) * (self.dimension - 1), place[0])
        return (*place, *(zero,) * self.dimension)[: self.dimension]

    # places

    def axes(self, pieces: Sequence[Piece], count: int | None = None) -> tuple[Total, ...]:
        """Totals of the places of some pieces."""
        return tuple(
            Total(
                Source.TOTAL,
                self.count if count is None else count,
                tuple(Term(one.domain, one.place[k], one.numbers) for one in pieces),
            )
            for k in range(self.dimension)
        )

    def located(self, pieces: Sequence[Piece], count: int) -> Located:
        """The points of these pieces."""
        return Located(self.builder, self.axes(pieces, count))

    def at(self, axes: Sequence[Total]) -> Array:
        """Places (points, dimension, STATES) at the random states."""
        with np.errstate(all="ignore"):
            return np.stack([self.values.of(one) for one in axes], axis=1)

    def of(self, domain: Domain, place: Place) -> Array:
        """A place of each member of a domain (members, dimension, STATES)."""
        return np.stack([self.probe(domain, one) for one in place], axis=1)

    def probe(self, domain: Domain, node: Node) -> Array:
        """An expression of each member of a domain (members, STATES)."""
        with np.errstate(all="ignore"):
            return np.broadcast_to(self.values.node(node), (domain.count, STATES))

    def key(self, places: Array) -> Array:
        """A number for each of some places, by which equal ones are found."""
        found: Array = (places * self._weights).sum(axis=(1, 2))
        return found

    def find(self, places: Array) -> Places:
        """The particles at some places (members, dimension, STATES), ``NONE`` where there is none."""
        found = np.full(len(places), NONE)
        if not len(places):
            return found
        at = np.searchsorted(self._keys[self._order], self.key(places))
        for step in (0, -1, 1):
            near = self._order[np.clip(at + step, 0, self.count - 1)]
            same = (found == NONE) & equal(self.places[near], places)
            found[same] = near[same]
        return found

    @cached_property
    def moved(self) -> Mask:
        """Which components of all places (particles, dimension) change."""
        rows = self.places.reshape(self.count * self.dimension, -1)
        return np.logical_not(steady(rows)).reshape(self.count, self.dimension)

    # who is who

    def moves(self, node: Node) -> bool:
        """Whether an expression contains a coordinate."""
        return any(self.changes(slot) for _, slot in self.slots.inside(node))

    def is_coordinate(self, node: Node) -> bool:
        """Whether an expression is a coordinate."""
        slot = self.slots.of.get(node)
        return slot is not None and slot.array is self.builder.q

    def changes(self, slot: Slot) -> bool:
        """Whether the numbers of a slot depend on coordinates."""
        if isinstance(slot.array, Total):
            if slot.array not in self._moving:
                self._moving[slot.array] = any(self.moves(one.node) for one in slot.array.terms)
            return self._moving[slot.array]
        return slot.array in (self.builder.q, self.builder.v)

    def timed(self, node: Node) -> bool:
        """Whether an expression contains t itself."""
        return bool(node.symbols & self.builder.time.symbols)

    def _owners(self) -> dict[Numbers, Places]:
        """The first particle whose place contains each coordinate, and each node of a chain, or ``NONE``."""
        found: dict[Numbers, Places] = {self.builder.q: np.full(self.builder.q.count, NONE)}
        for piece in reversed(self.pieces):
            for node in piece.place:
                for _, slot in self.slots.inside(node):
                    if slot.array is self.builder.q or isinstance(slot.array, Chain):
                        table = found.setdefault(slot.array, np.full(slot.array.count, NONE))
                        table[slot.table[::-1]] = piece.numbers[::-1]
        return found

    def near(self, domain: Domain, node: Node) -> list[Places]:
        """The particles that an expression of members of a domain is about, each a table (members,)."""
        found: list[Places] = []
        for _, slot in self.slots.inside(node):
            if slot.array in self.owners:
                table = self.owners[slot.array][slot.table]
                if np.all(table != NONE) and not any(np.array_equal(table, one) for one in found):
                    found.append(table)
        return found


def steady(values: Array) -> Mask:
    """Which rows of values (members, STATES) have equal numbers, as far as they are there."""
    there = np.isfinite(values)
    known = np.where(there, values, np.nan)
    low, high, size = np.fmin.reduce(known, 1), np.fmax.reduce(known, 1), np.fmax.reduce(np.abs(known), 1)
    found: Mask = (there.sum(axis=1) >= NEEDED) & (high - low <= ROUNDING * size)
    return found


def equal(a: Array, b: Array) -> Mask:
    """Which members have equal values (members, ...) in both, where both are there."""
    a, b = np.broadcast_arrays(a.reshape(len(a), -1), b.reshape(len(b), -1))
    both = np.isfinite(a) & np.isfinite(b)
    x, y = np.where(both, a, 0.0), np.where(both, b, 0.0)
    scale = np.maximum(np.abs(x).max(axis=1), np.abs(y).max(axis=1))
    close = (np.abs(x - y) <= ROUNDING * scale[:, None]).all(axis=1)
    found: Mask = close & (both.sum(axis=1) >= NEEDED)
    return found


def lengths(values: Array) -> Array:
    """The lengths (members, STATES) of vectors (members, dimension, STATES)."""
    return np.asarray(np.sqrt((values * values).sum(axis=1)))


def crowd_of(spec: Spec, values: Values, start: float) -> Crowd:
    """The crowd of a system file. Raises ``Unsuited``."""
    if not spec.coordinate_families or not spec.embedding:
        raise Unsuited
    return Crowd(spec, values, start)
