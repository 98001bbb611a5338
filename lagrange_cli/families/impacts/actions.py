"""Actions of events of families: which of them are simple, and where members may rest.

All of this follows from tables: which coordinates, velocities and parameters each event reads and sets.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING

import numpy as np

from lagrange_cli.expression.indices import Unsuited
from lagrange_cli.expression.node import Node
from lagrange_cli.families.arrays import Source, Term, Total
from lagrange_cli.families.bonds import Bonds
from lagrange_cli.families.builder import FamilyBuilder
from lagrange_cli.families.contacts import Contacts, Coupled, Impacts
from lagrange_cli.families.coupled_masses import CoupledMasses
from lagrange_cli.families.events import SEEDS, Events, random_state
from lagrange_cli.families.impacts.coupled import coupled_impacts
from lagrange_cli.families.impacts.impacts import COUPLED, impacts_of
from lagrange_cli.families.impacts.joint_contacts import apart, impacts_on_joints
from lagrange_cli.families.impacts.reflection import EventStates, turned
from lagrange_cli.families.joints.joints import Articulation
from lagrange_cli.families.refusals import RELATIVE
from lagrange_cli.families.tables import in_groups
from lagrange_cli.families.values import FamilyValues
from lagrange_cli.records import replace
from lagrange_cli.spec.content import names_of

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from lagrange_cli.expression.index_arrays import Places

LONG = (
    "events that act on chains and trees with constraints and very many joints in a row",
    "let them record or stop only, or give each link coordinates of its own",
    "events",
)
"""What members are written out for, how to do without, and the section of the file that has it."""
MOST = 2**18
"""Entries of the mass matrix on the diagonal and below, as of 700 links, that are still computed."""
AFFECTED = 16
"""So many events, on the average, have arguments that each simple action changes, at most."""


class Reading:
    """Which places arguments read: at ``places`` the events ``readers``; ``wide`` are those that sums read,
    and ``adding`` the events in whose arguments such sums are."""

    def __init__(self, builder: FamilyBuilder, arguments: Total) -> None:
        self._builder = builder
        self._first = {builder.q: 0, builder.v: builder.q.count, builder.given: 2 * builder.q.count}
        starts = names_of(builder.spec.parameters).starts
        self._scalars = {node: starts[name] for name, node in builder.parameters.items()}
        self.wide = np.zeros(2 * builder.q.count + builder.given.count, dtype=bool)
        self.adding = np.zeros(arguments.count, dtype=bool)
        self._seen: set[Total] = set()
        readers, places = [], []
        for term in arguments.terms:
            sums = (isinstance(slot.array, Total) for _, slot in builder.slots.inside(term.node))
            self.adding[term.targets] |= any(sums)
            for table in self._tables(term):
                readers.append(term.targets)
                places.append(table)
        empty = np.zeros(0, dtype=np.int64)
        found, order = np.concatenate([empty, *places]), np.concatenate([empty, *readers])
        which = np.argsort(found, kind="stable")
        self.places, self.readers = found[which], order[which]

    def _tables(self, term: Term) -> Iterable[Places]:
        builder = self._builder
        for _, slot in builder.slots.inside(term.node):
            if slot.array in self._first:
                yield slot.table + self._first[slot.array]
            elif isinstance(slot.array, Total):
                self._mark(slot.array)
        for node, place in self._scalars.items():
            if term.node.symbols & node.symbols:
                yield np.full(term.domain.count, 2 * builder.q.count + place)

    def _mark(self, total: Total) -> None:
        if total not in self._seen:
            self._seen.add(total)
            for term in total.terms:
                for table in self._tables(term):
                    self.wide[table] = True


def with_actions(
    builder: FamilyBuilder, events: Events, masses: Total, forces: Total, *, bound: Bonds | None
) -> Events:
    """Events with what follows from what actions set, if they set anything. Where coordinates are ``bound``
    by constraints, these have impulses, too.

    Raises ``Unsuited`` for actions that change masses, and for contacts that are not followed here.
    """
    if not events.changed.size:
        return events
    n, (acting, places) = builder.q.count, events.changed
    read = Reading(builder, events.arguments)
    refuse_masses(builder, events, masses)
    states = EventStates(builder, events)
    slowing = slowing_in(events, read, states, n)
    impacts = None if slowing is None else impacts_in(builder, events, slowing, (masses, forces), bound)
    simple, pairs = simple_in(events, read)
    contacts = None if impacts is None else impacts.contacts
    if isinstance(contacts, Coupled):
        simple[acting[(places < n) | (places >= 2 * n)]] = False
    elif contacts is not None:
        simple[disturbing(events, contacts, n)] = False
    pushing = np.zeros(events.count, dtype=bool)
    if bound is not None:
        pushing[pushed(events, bound, n)] = True
        if not (isinstance(contacts, Coupled) and alone(events, contacts, read, n)):
            simple[pushing] = False
    every = np.ones(events.count, dtype=bool)
    speeds = bool(np.all((places >= n) & (places < 2 * n)))
    lossless = states.reversed if bound is not None else lambda: states.lossless(masses)
    keeps = speeds and bool(states.judge(lossless, every).all())
    affected = affected_by(simple, pairs)
    found = replace(events, simple=simple, affected=affected, keeps_energy=keeps, impacts=impacts)
    return replace(found, pushing=simple & pushing)


def alone(events: Events, contacts: Coupled, read: Reading, n: int) -> bool:
    """Whether each action is an impact that sets the velocities of all coordinates on which its argument
    depends, and no argument depends on velocities: impulses of constraints leave the speed of the impact as
    it was set, and change no argument."""
    acting, places = events.changed
    if np.any((read.places >= n) & (read.places < 2 * n)) or np.any(read.wide[n : 2 * n]):
        return False
    own = [one for one in contacts.bonds.bounds if one.numbers[0] >= contacts.fixed]
    needed = [contacts.events[one.numbers - contacts.fixed] * n + rows for one in own for rows in one.rows]
    whole = bool(np.isin(np.concatenate(needed), acting * n + places - n).all())
    return whole and bool(np.isin(acting, contacts.events).all())


def on_joints(
    builder: FamilyBuilder, events: Events, found: Articulation, kinetic: Node, *, bound: Bonds | None
) -> Events:
    """The same on chains and trees, of this T.

    Raises ``Unsuited`` for actions that change masses, and for contacts that are not followed here.
    """
    if not events.changed.size:
        return events
    n, (_, places) = builder.q.count, events.changed
    refuse_masses(builder, events, weights_on(found))
    read = Reading(builder, events.arguments)
    impact, touched = impacting(events, read, n)
    if np.any(read.wide[n : 2 * n]):
        impact[read.adding] = False
    touched |= read.adding
    reflected, lossless = turned(builder, events, kinetic)
    slowing, impacts = np.flatnonzero(impact & touched & ~reflected), None
    simple, pairs = simple_in(events, read)
    if found.relative is not None and bound is not None:
        raise Unsuited(*RELATIVE)
    if len(slowing):
        impacts = impacts_on_joints(builder, events, slowing, found, bound)
        contacts = None if impacts is None else impacts.contacts
        if isinstance(contacts, Coupled):  # their forces change with velocities of their trees
            simple &= apart(events, contacts, found, n)
    if bound is not None:
        refuse_long(found)
        simple[pushed(events, bound, n, found)] = False
    keeps = bool(np.all((places >= n) & (places < 2 * n)))
    if keeps and bound is not None:
        lossless &= EventStates(builder, events).reversed()
    keeps = keeps and bool(lossless.all())
    affected = affected_by(simple, pairs)
    return replace(events, simple=simple, affected=affected, keeps_energy=keeps, impacts=impacts)


def refuse_long(found: Articulation) -> None:
    """Raise ``Unsuited`` where the matrix that impulses of constraints follow from has very many entries."""
    if len(found.movers(np.arange(found.count))[0]) > MOST:
        raise Unsuited(*LONG)


def pushed(events: Events, bound: Bonds, n: int, joints: Articulation | None = None) -> Places:
    """The events after which constraints have impulses: those that set more than velocities which no
    constraint contains."""
    acting, places = events.changed
    free = np.ones(n, dtype=bool)
    for one in bound.bounds:
        for rows in one.rows:
            free[rows] = False
        for hold in one.holds:
            if joints is not None:
                free[joints.movers(hold.places)[1]] = False
    speeds = (places >= n) & (places < 2 * n)
    found: Places = acting[~speeds | ~free[np.where(speeds, places - n, 0)]]
    return found


def refuse_masses(builder: FamilyBuilder, events: Events, masses: Total, *, first: int = 0) -> None:
    """Raise ``Unsuited`` where actions set what masses depend on, from the ``first`` place of a state on."""
    places, of_masses = events.changed[1], Reading(builder, masses)
    places = places[places >= first]
    if np.any(of_masses.wide[places]) or np.any(np.isin(places, of_masses.places)):
        raise Unsuited


def weights_on(found: Articulation) -> Total:
    """All masses of joints together."""
    terms = [term for one in found.inertia for term in one.terms]
    terms += [Term(one.domain, weight.mass, one.rows[0]) for one in found.joints for weight in one.weights]
    count = 1 + max((int(one.targets.max(initial=0)) for one in terms), default=0)
    return Total(Source.TOTAL, count, tuple(terms))


def simple_in(events: Events, read: Reading) -> tuple[NDArray[np.bool_], Places]:
    """Which events have simple actions, and the pairs (2, pairs) of one with an action and one whose argument
    this changes."""
    acting, places = events.changed
    left, right = (np.searchsorted(read.places, places, side) for side in ("left", "right"))
    counts = right - left
    simple = np.zeros(events.count, dtype=bool)
    if int(counts.sum()) <= AFFECTED * (events.count + len(acting)):
        simple[acting] = True
    else:
        counts[:] = 0
    which, within = in_groups(counts)
    doing, reading = acting[which], read.readers[left[which] + within]
    simple[acting[read.wide[places]]] = False
    simple[doing[doing == reading]] = False
    return simple, np.stack([doing, reading])


def affected_by(simple: NDArray[np.bool_], pairs: Places) -> tuple[tuple[int, int], ...]:
    """The pairs of simple actions, each once."""
    doing, reading = pairs[:, simple[pairs[0]]]
    keys = doing * len(simple) + reading
    keys = keys[np.sort(np.unique(keys, return_index=True)[1])]
    return tuple(zip(*(one.tolist() for one in np.divmod(keys, len(simple)))))


def disturbing(events: Events, contacts: Contacts, n: int) -> Places:
    """The events that set something else than velocities, or one with which another contact's argument
    changes: whether members rest on has to be found then."""
    coordinates: dict[int, set[int]] = {}
    for contact, coordinate in contacts.reads.T.tolist():
        coordinates.setdefault(coordinate, set()).add(int(contacts.events[contact]))
    found = (
        e
        for e, place in events.changed.T.tolist()
        if not n <= place < 2 * n or not coordinates.get(place - n, set()) <= {e}
    )
    return np.array([*found], dtype=np.int64)


def with_coupled_masses(
    builder: FamilyBuilder, events: Events, masses: CoupledMasses, kinetic: Node, *, bound: Bonds | None
) -> Events:
    """The same where M is not diagonal.

    Raises ``Unsuited`` for actions that set parameters of masses, and for impacts that reduce the speed: the
    forces of contact there are those of all members.
    """
    if not events.changed.size:
        return events
    n, (_, places) = builder.q.count, events.changed
    read = Reading(builder, events.arguments)
    refuse_masses(builder, events, masses.entries, first=2 * n if masses.curved else 0)
    slowing = slowing_in(events, read, EventStates(builder, events), n)
    if slowing is not None and len(slowing):
        raise Unsuited
    simple, pairs = simple_in(events, read)
    if bound is not None:
        simple[pushed(events, bound, n)] = False
    keeps = bound is None and bool(np.all((places >= n) & (places < 2 * n)))
    keeps = keeps and bool(turned(builder, events, kinetic)[1].all())
    return replace(events, simple=simple, affected=affected_by(simple, pairs), keeps_energy=keeps)


def impacting(events: Events, read: Reading, n: int) -> tuple[NDArray[np.bool_], NDArray[np.bool_]]:
    """Which events set velocities and nothing else, and have arguments without velocities; and which have
    coordinates in theirs."""
    acting, places = events.changed
    impact, touched = np.zeros((2, events.count), dtype=bool)
    impact[acting] = True
    impact[acting[(places < n) | (places >= 2 * n)]] = False
    impact[read.readers[(read.places >= n) & (read.places < 2 * n)]] = False
    touched[read.readers[read.places < n]] = True
    return impact, touched


def slowing_in(events: Events, read: Reading, states: EventStates, n: int) -> Places | None:
    """The impacts that do not reflect the speed; None if there are no impacts."""
    impact, touched = impacting(events, read, n)
    if not impact.any():
        return None
    if np.any(impact & read.adding):
        raise Unsuited
    impact &= touched
    return np.flatnonzero(impact & ~states.judge(states.reflected, impact))


def impacts_in(
    builder: FamilyBuilder, events: Events, slowing: Places, given: tuple[Total, Total], bound: Bonds | None
) -> Impacts | None:
    """The impacts that do not reflect the speed, with what they take: the motion may come to rest there (see
    ``mechanics.contacts``), if something drives it back. Masses and forces are ``given``."""
    masses, forces = given
    state = FamilyValues(builder, *random_state(builder, SEEDS[1]))
    with np.errstate(all="ignore"):
        try:
            if bound is None:
                return impacts_of(builder, events, slowing, (forces, masses), state)
        except Unsuited as error:
            if error.args != COUPLED:
                raise
        return coupled_impacts(builder, events, slowing, masses, bound, state)
