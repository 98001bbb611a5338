"""Dry friction of families: forces on coordinates that jump where their velocities are 0, or those of belts;
and forces that jump with places, which may hold these.

With M diagonal, the force that holds a coordinate is opposite to all others on it, so no equations are
solved. Its mode is 0 meanwhile. It is held as long as the whole force with the friction against either
direction leads back: F(v < 0) >= 0 >= F(v > 0). These are ``limits``, as of ``native.guards``.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np

from lagrange_cli.expression.graph import Graph
from lagrange_cli.expression.indices import Unsuited
from lagrange_cli.expression.node import Node
from lagrange_cli.expression.zero import is_zero
from lagrange_cli.families.arrays import Array, Domain, Slot, Slots, Term, Total, placed
from lagrange_cli.families.bonds import Bonds
from lagrange_cli.families.description import FamilySystem, Halts, Locks
from lagrange_cli.families.values import FamilyValues
from lagrange_cli.mechanics.substitution import substituted
from lagrange_cli.mechanics.switching.switches import on_a_sphere, where_it_vanishes
from lagrange_cli.records import dataclass, replace

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from lagrange_cli.expression.graph import Graph
    from lagrange_cli.expression.index_arrays import Places

    Numbers = NDArray[np.float64]


SEED, CHOICES, STATES = 1, 2, 16
CARRIED = (
    "friction along velocities relative to what moves as t or places say, between members or in joints",
    "write a steep function that does not jump, such as tanh(100*u) for sign(u)",
)
"""What members are written out for, and how to do without."""


@dataclass(frozen=True, eq=False)
class Friction:
    """A term of the forces with friction: the ``switches`` in it that have one ``argument``."""

    term: Term
    argument: Node
    switches: Sequence[Node]

    @property
    def place(self) -> tuple[Domain, Node]:
        """Whose numbers are 0 where it jumps."""
        return self.term.domain, self.argument

    def like(self, other: Friction, slots: Slots) -> Friction | None:
        """The same in the domain of another one, if the arguments of both have the same numbers there."""
        domain, count = other.term.domain, self.term.domain.count
        if domain is self.term.domain:
            return self if other.argument is self.argument else None
        if domain.count != count:
            return None
        members = np.arange(count)
        argument, node, *listed = (
            placed(slots, one, domain, members) for one in (self.argument, self.term.node, *self.switches)
        )
        term = replace(self.term, domain=domain, node=node)
        return Friction(term, argument, listed) if argument is other.argument else None

    def side(self, graph: Graph, which: int) -> Term:
        """The term where the argument is positive (1), or negative (2)."""
        given = {one: one.arguments[which] for one in self.switches}
        return replace(self.term, node=substituted(graph, [self.term.node], given)[0])


@dataclass(frozen=True, eq=False)
class Decision:
    """Members of a domain that decide modes by an ``argument``, oriented as it is there, while what is
    ``loud`` is more than 0."""

    domain: Domain
    argument: Node
    modes: Places
    loud: Node


@dataclass(frozen=True, eq=False)
class FrictionModes:
    """Friction that is ``listed`` in the forces of a ``system``, and its ``modes``: which of them the members
    of a place where it jumps have (``numbers``), and by what each is decided. ``frozen`` puts modes in place
    of switches."""

    system: FamilySystem
    listed: Sequence[Friction]
    modes: Array
    numbers: Mapping[tuple[Domain, Node], Places]
    decisions: Sequence[Decision]
    frozen: Callable[[Term], Term]

    def of(self, one: Friction) -> Places:
        """The modes of a force."""
        return self.numbers[one.place]


@dataclass(frozen=True, eq=False)
class Rest:
    """The terms of the forces without friction; with modes all that is ``applied``, friction included, and
    the ``slopes`` of the potential."""

    terms: Sequence[Term]
    applied: Total
    slopes: Total


@dataclass(frozen=True, eq=False)
class Held:
    """The ``modes`` that hold coordinates, in order; two ``limits`` for each of them; all ``other`` forces,
    which the ``forces`` take; and what is ``applied``, which balances those of L where it holds.
    Coordinates that stick to others have bonds with these, and ``loose`` forces besides (see
    ``relative_friction``). Those of joints have ``locks``, those beside constraints ``halts``."""

    modes: Places
    limits: Total
    other: Total
    forces: Total
    applied: Total
    sticking: Bonds | None = None
    loose: Total | None = None
    locks: Locks | None = None
    halts: Halts | None = None
    before: Sequence[Total] = ()
    """What the other forces take."""
    vectors: Sequence[tuple[int, tuple[int, ...]]] = ()
    """The modes of lengths of vectors, each with the coordinates that it holds."""
    beside: Total | None = None
    """The components of each of these vectors, and of the force that holds it."""
    errors: Total | None = None
    """The rounding errors of accelerations by friction along them."""


def holds(system: FamilySystem, one: Friction, moving: int) -> bool:
    """Whether a force that jumps where an argument is 0 can hold the coordinate on which it acts: its
    velocity is that of others or of a belt there, or its place that of others or of a wall. Beside
    constraints, a velocity has to be that of the coordinate alone."""
    inside, targets = linear_in(system, one.argument, moving), one.term.targets
    if system.bonds is not None and (
        system.joints is not None
        or system.coupled_masses is not None
        or system.bonds.surplus
        or system.bonds.elimination is None
        or [slot.array for _, slot in inside] != [system.v]
    ):
        return False
    return any(np.array_equal(slot.table, targets) for _, slot in inside)


def passing(system: FamilySystem, listed: Sequence[Friction]) -> bool:
    """Whether motions pass where forces jump with one argument u of places: where u and du/dt are 0, d2u/dt2
    is the same on both sides, as for a dashpot in a contact, whose force vanishes with the velocity; or
    nothing holds them there, as where an attraction is cut off."""
    slots, graph, (domain, u) = system.slots, system.slots.graph, listed[0].place
    if system.joints or system.bonds:
        return False
    change, mass, masses = graph.zero, masses_at_random(system), dict[bytes, Node]()
    for one in listed:
        jump, targets = one.side(graph, 1).node - one.side(graph, 2).node, one.term.targets
        for symbol, slot in slots.inside(u):
            if slot.array is not system.q:
                continue
            if np.array_equal(slot.table, targets):
                weight = mass[:, targets].tobytes()
                own = masses.setdefault(weight, slots.symbol(domain, system.masses, targets))
                change += graph.diff(u, symbol) * jump / own
            elif np.any(slot.table == targets):
                return False
    if vanishes_at_rest(system, listed[0], change):
        return True
    moving = (slot.array for _, slot in slots.inside(u) if slot.array not in (system.given, system.whole))
    return set(moving) == {system.q} and unheld(system, listed[0], change)


def unheld(system: FamilySystem, one: Friction, change: Node) -> bool:
    """Whether motions pass where the gradient of U jumps, unless in a valley, such as |u|. There d2u/dt2 is
    less where u > 0, by this change, which is negative in states and with parameters at random: what comes to
    rest there is held. Where that depends on parameters, a motion that is to be held ends."""
    chance, none = np.random.default_rng(SEED), np.zeros(system.q.count)
    given = system.slots.graph, change, one.argument
    for left in (*where_it_vanishes(*given), *on_a_sphere(*given)):
        with np.errstate(all="ignore"):
            values = [
                FamilyValues(system, 0.0, chance.normal(size=none.shape), none, numbers).node(left)
                for numbers in chance.uniform(0.5, 1.5, (STATES, system.given.count))
            ]
        if all(np.all(np.asarray(one) <= 0.0) for one in values):
            return False
    return True


def yields(system: FamilySystem, one: Friction) -> bool:
    """Whether a force that jumps with an argument u of places is the same on both sides where u and du/dt are
    0, as that of a magnetic field that begins at a line."""
    graph = system.slots.graph
    return vanishes_at_rest(system, one, one.side(graph, 1).node - one.side(graph, 2).node)


def vanishes_at_rest(system: FamilySystem, one: Friction, node: Node) -> bool:
    """Whether an expression is 0 where the argument u of a force that jumps is one of places, and u and du/dt
    are 0."""
    slots, graph, (domain, u) = system.slots, system.slots.graph, one.place
    inside = [(s, slot) for s, slot in slots.inside(u) if slot.array not in (system.given, system.whole)]
    if any(slot.array is not system.q for _, slot in inside):
        return False
    speeds = {s: slots.symbol(domain, system.v, slot.table) for s, slot in inside}
    rates = [(graph.diff(u, system.time), graph.one)] + [(graph.diff(u, s), v) for s, v in speeds.items()]
    for slope, v in rates[1:]:
        if not slope.is_zero:
            others = graph.sum([(part / slope * by, -1.0) for part, by in rates if by is not v])
            left = substituted(graph, [node], {v: others})[0]
            return any(map(is_zero, (left, *where_it_vanishes(graph, left, u), *on_a_sphere(graph, left, u))))
    return False


def masses_at_random(system: FamilySystem) -> Numbers:
    """The masses of coordinates for some parameters, a row for each choice: those that are equal in all rows
    are equal."""
    chance, none = np.random.default_rng(SEED), np.zeros(system.q.count)
    choices = chance.uniform(0.5, 1.5, (CHOICES, system.given.count))
    with np.errstate(all="ignore"):
        return np.array([FamilyValues(system, 0.0, none, none, one).of(system.masses) for one in choices])


def linear_in(system: FamilySystem, argument: Node, moving: int) -> list[tuple[Node, Slot]]:
    """The coordinates, or the velocities, that an argument is linear in; none where it is of another kind.
    Places and t may say how fast something is that velocities are relative to."""
    slots = system.slots
    inside = [(s, slot) for s, slot in slots.inside(argument) if s.symbols & moving]
    arrays = {slot.array for _, slot in inside}
    fast = system.v in arrays
    if fast:
        inside = [(s, slot) for s, slot in inside if slot.array is system.v]
    if (argument.symbols & system.time.symbols and not fast) or not arrays <= {system.q, system.v}:
        return []
    constant = not any(slots.graph.diff(argument, s).symbols & moving for s, _ in inside)
    return inside if constant else []


def rate_at_rest(system: FamilySystem, argument: Node, domain: Domain) -> Node:
    """The rate that velocities have while they stay as an argument says that is linear in them: the opposite
    of that of what else is in it. Raises ``Unsuited`` where that is made of sums that move."""
    slots, graph, time = system.slots, system.slots.graph, system.time
    found = graph.diff(argument, time)
    for symbol, slot in slots.inside(argument):
        if slot.array is system.q:
            found = found + graph.diff(argument, symbol) * slots.symbol(domain, system.v, slot.table)
        elif isinstance(slot.array, Total) and not lasts(system, slot.array):
            raise Unsuited
    return -found


def lasts(system: FamilySystem, total: Total) -> bool:
    """Whether a sum does not move."""
    moving = system.time.symbols | system.slots.symbols_of(system.q, system.v)
    return not any(one.symbols & moving for one in system.slots.made_of([t.node for t in total.terms]))


def gate(slots: Slots, domain: Domain, modes: Array, numbers: Places) -> Node:
    """1, or 0 where a coordinate is held: the square of its mode, or of all its modes, (members, modes)."""
    columns = np.ascontiguousarray(numbers.reshape(domain.count, -1).T)
    found = slots.graph.one
    for column in columns:
        mode = slots.symbol(domain, modes, column)
        found = found * mode * mode
    return found
