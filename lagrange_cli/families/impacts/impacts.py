"""Resting contact of families: members come to rest at events whose impacts reduce the speed.

As ``mechanics.contacts`` has it, the force of contact is N M d, where d = -(dD/dv) grad g, and N follows from
d2g/dt2 = 0. Where no contact acts on what another one reads, each N follows from its own event alone:

    N = -(grad g M^-1 F + g'')/(grad g d),

with g'' for d2g/dt2 without accelerations. N is followed beside the motion, whether it acts or not. Where g
depends on one coordinate alone, its acceleration is -g''/(dg/dq), without rounding errors of its forces.
"""

from __future__ import annotations

from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from lagrange_cli.expression.index_arrays import distinct
from lagrange_cli.expression.indices import Unsuited
from lagrange_cli.expression.node import Kind, Node, reachable
from lagrange_cli.families.arrays import NONE, Array, Domain, Slots, Source, Term, Total, placed, total_of
from lagrange_cli.families.builder import FamilyBuilder
from lagrange_cli.families.contacts import Contacts, Impacts
from lagrange_cli.families.events import Events
from lagrange_cli.families.impacts.parting import parting
from lagrange_cli.families.tables import found_in
from lagrange_cli.families.values import FamilyValues
from lagrange_cli.records import replace

if TYPE_CHECKING:
    from lagrange_cli.expression.index_arrays import Places

ROUNDED = 1e-10
"""A sum that is smaller, in terms of what it is made of, is 0."""
COUPLED = (
    "events after which members may rest on each other",
    "let each event act on what no other one depends on, or reflect without loss",
    "events",
)
"""What members are written out for, how to do without, and the section of the file that has it."""
WALLS = 2
"""So many contacts may have one coordinate: those of walls on both sides."""


def impacts_of(
    builder: FamilyBuilder, events: Events, slowing: Places, pulls: tuple[Total, Total], state: FamilyValues
) -> Impacts | None:
    """The impacts among events that do not reflect the speed (``slowing``, numbers in order), and their
    contacts, with forces and masses (``pulls``). Which of their directions are 0 is seen at a ``state``.

    Raises ``Unsuited`` where a contact acts on what another one depends on.
    """
    if not len(slowing):
        return None
    found = Finding(builder, events, slowing)
    impacts = found.pushed(state)
    if not len(impacts):
        return None
    driven = np.zeros(events.count, dtype=bool)
    driven[impacts] = ~parting(builder, events, *pulls, state)[impacts]
    contacts = contacts_of(builder, events, np.flatnonzero(driven), state)
    if contacts is not None:
        touched = distinct(found.reads[0][np.isin(found.reads[1], contacts.acts[1])])
        driven[np.intersect1d(found.resting[touched], impacts)] = True
        contacts = contacts_of(builder, events, np.flatnonzero(driven), state)
    found = found if len(impacts) == len(slowing) else Finding(builder, events, impacts)
    return Impacts(impacts, found.speeds(), contacts, found.rates)


def contacts_of(
    builder: FamilyBuilder, events: Events, resting: Places, state: FamilyValues
) -> Contacts | None:
    """The contacts of these impacts."""
    if not len(resting):
        return None
    found = Finding(builder, events, resting)
    made = found.made(found.pushing(state))
    if not np.all(np.abs(state.of(made.divisors)) > 0.0):
        raise Unsuited
    return made


class Finding:
    """The terms of contacts."""

    def __init__(self, builder: FamilyBuilder, events: Events, resting: Places) -> None:
        self.builder, self.events, self.resting = builder, events, resting
        self.slots, self.graph, self.degrees = builder.slots, builder.graph, builder.q.count
        self.order = np.full(events.count, NONE)
        self.order[resting] = np.arange(len(resting))
        """The contact of each event."""
        listed = [
            one
            for term in events.arguments.terms
            if (one := part_of(self.slots, term, self.order[term.targets]))
        ]
        self.arguments = listed
        """Their arguments, at the numbers of contacts."""
        keys = [
            term.targets * self.degrees + slot.table
            for term in listed
            for _, slot in self.slots.inside(term.node)
            if slot.array is builder.q
        ]
        self._keys = distinct(np.concatenate(keys))
        self.reads = np.stack(np.divmod(self._keys, self.degrees))
        self._contact, self._coordinate = self.order[events.changed[0]], events.changed[1] - self.degrees
        self._refuse_switches()

    def _refuse_switches(self) -> None:
        nodes = [one.node for one in (*self.arguments, *self._values)]
        if any(one.kind is Kind.SWITCH for one in reachable(nodes)):
            raise Unsuited
        if any(isinstance(slot.array, Total) for one in nodes for _, slot in self.slots.inside(one)):
            raise Unsuited

    @cached_property
    def _values(self) -> list[Term]:
        """The velocities that impacts give, at the numbers of what actions set."""
        found = []
        for term in self.events.values.terms:
            contacts = self._contact[term.targets]
            own = part_of(self.slots, term, np.where(contacts >= 0, term.targets, NONE))
            found += [own] if own else []
        return found

    def slope_of(self, contacts: Places, coordinates: Places) -> Places:
        """The numbers of these slopes, or ``NONE``."""
        at, known = found_in(self._keys, contacts * self.degrees + coordinates)
        return np.where(known, at, NONE)

    @cached_property
    def slopes(self) -> Total:
        """dg/dq."""
        terms = [
            Term(one.domain, self.graph.diff(one.node, symbol), self.slope_of(one.targets, slot.table))
            for one in self.arguments
            for symbol, slot in self.slots.inside(one.node)
            if slot.array is self.builder.q
        ]
        return total_of(len(self._keys), terms, self.graph)

    @property
    def rates(self) -> Total:
        """dg/dt."""
        terms = [replace(one, node=self._rate(one.node, one.domain)) for one in self.arguments]
        return total_of(len(self.resting), terms, self.graph)

    @cached_property
    def bends(self) -> Total:
        """d2g/dt2 with constant velocities."""
        terms = [
            replace(one, node=self._rate(self._rate(one.node, one.domain), one.domain))
            for one in self.arguments
        ]
        return total_of(len(self.resting), terms, self.graph)

    def _rate(self, node: Node, domain: Domain) -> Node:
        """The rate of an expression with constant velocities."""
        graph, slots, parts = self.graph, self.slots, [self.graph.diff(node, self.builder.time)]
        for symbol, slot in slots.inside(node):
            if slot.array is self.builder.q:
                parts.append(graph.diff(node, symbol) * slots.symbol(domain, self.builder.v, slot.table))
        found: Node = graph.sum([(one, 1.0) for one in parts])
        return found

    @cached_property
    def acts(self) -> Places:
        """The contact and the coordinate of what each action sets; ``NONE`` of other actions."""
        return np.stack([self._contact, self._coordinate])

    @cached_property
    def directions(self) -> Total:
        """d = -(dD/dv) grad g with D = v+ - v, for all that actions set."""
        every = np.flatnonzero(self._contact >= 0)
        terms = []
        own = self.slope_of(self._contact[every], self._coordinate[every])
        which = np.flatnonzero(own >= 0)
        if len(which):
            domain = Domain(len(which))
            terms.append(Term(domain, self.slots.symbol(domain, self.slopes, own[which]), every[which]))
        for term in self._values:
            for symbol, slot in self.slots.inside(term.node):
                slope = self.slope_of(self._contact[term.targets], slot.table)
                members = np.flatnonzero(slope >= 0)
                if slot.array is not self.builder.v or not len(members):
                    continue
                domain = Domain(len(members))
                rate = placed(self.slots, self.graph.diff(term.node, symbol), domain, members)
                node = -rate * self.slots.symbol(domain, self.slopes, slope[members])
                terms.append(Term(domain, node, term.targets[members]))
        return total_of(len(self._contact), terms, self.graph)

    def pushing(self, state: FamilyValues) -> Places:
        """The directions that are not 0."""
        values, sizes = (
            state.added(self.directions.count, self.directions.terms, sizes=one) for one in (False, True)
        )
        return np.flatnonzero(np.abs(values) > ROUNDED * sizes)

    def pushed(self, state: FamilyValues) -> Places:
        """The events whose contacts have a direction that is not 0."""
        found: Places = self.resting[distinct(self.acts[0][self.pushing(state)])]
        return found

    def made(self, kept: Places) -> Contacts:
        """The contacts with the directions that are ``kept``, which are not 0."""
        count, acts = len(self.resting), self.acts[:, kept]
        both = self.slope_of(*acts)
        shared = np.flatnonzero(both >= 0)
        domain = Domain(len(shared))
        slope = self.slots.symbol(domain, self.slopes, both[shared])
        direction = self.slots.symbol(domain, self.directions, kept[shared])
        divisors = total_of(count, [Term(domain, slope * direction, acts[0, shared])], self.graph)
        own = Domain(len(kept))
        picked = Term(own, self.slots.symbol(own, self.directions, kept), np.arange(len(kept)))
        return Contacts(
            self.resting, self.reads, self.slopes, self.bends, acts,
            total_of(len(kept), [picked], self.graph), divisors, Array(Source.MODES, count),
            self._others(acts), Total(Source.TOTAL, count),
        )  # fmt: skip

    def speeds(self) -> Total:
        """dg/dt after each one's own action."""
        setting = np.full(len(self._keys), NONE)
        own = self.slope_of(self._contact, self._coordinate)
        every = np.flatnonzero((self._contact >= 0) & (own >= 0))
        setting[own[every]] = every
        terms = []
        for array, read in (
            (self.builder.v, np.flatnonzero(setting == NONE)),
            (self.events.values, np.flatnonzero(setting != NONE)),
        ):
            if len(read):
                domain = Domain(len(read))
                places = self.reads[1, read] if array is self.builder.v else setting[read]
                speed = self.slots.symbol(domain, array, places)
                slope = self.slots.symbol(domain, self.slopes, read)
                terms.append(Term(domain, slope * speed, self.reads[0, read]))
        time = self.builder.time
        for one in self.arguments:
            if one.node.symbols & time.symbols:
                terms.append(replace(one, node=self.graph.diff(one.node, time)))
        return total_of(len(self.resting), terms, self.graph)

    def _others(self, acts: Places) -> Places:
        """Of each contact the one before it with the same coordinate."""
        others = np.full(len(self.resting), NONE)
        readers: dict[int, list[int]] = {}
        for e, k in self.reads.T.tolist():
            readers.setdefault(k, []).append(e)
        alone = np.bincount(self.reads[0], minlength=len(others)) == 1
        alone &= np.bincount(acts[0], minlength=len(others)) == 1
        time = self.builder.time.symbols
        for one in self.arguments:
            if one.node.symbols & time:
                alone[one.targets] = False
        for e, k in acts.T.tolist():
            both = readers.get(k, [])
            if both in ([], [e]):
                continue
            if len(both) > WALLS or not all(alone[one] for one in (e, *both)) or e not in both:
                raise Unsuited(*COUPLED)
            others[both[1]] = both[0]
        return others


def part_of(slots: Slots, term: Term, places: Places) -> Term | None:
    """What a term has of those members that have other ``places``, there; those that have none have
    ``NONE``."""
    members = np.flatnonzero(places >= 0)
    if not len(members):
        return None
    if len(members) == term.domain.count:
        return replace(term, targets=places)
    domain = Domain(len(members))
    return Term(domain, placed(slots, term.node, domain, members), places[members])
