"""The forces of resting contact of families, by modes that are 0 where nothing rests."""

from __future__ import annotations

import numpy as np

from lagrange_cli.families.arrays import NONE, Domain, Term, total_of
from lagrange_cli.families.contacts import Contacts, Coupled
from lagrange_cli.families.description import FamilySystem
from lagrange_cli.records import replace


def with_contacts(system: FamilySystem) -> FamilySystem:
    """The system with the forces of contact, where its events have some."""
    contacts = system.contacts
    if contacts is None:
        return system
    if isinstance(contacts, Coupled):  # their forces are multipliers
        return replace(system, contact=contacts)
    slots, graph, count, degrees = system.slots, system.slots.graph, contacts.count, system.q.count
    reading, each = Domain(contacts.reads.shape[1]), Domain(count)
    numbers, (events, rows) = np.arange(count), contacts.reads
    force, mass = (slots.symbol(reading, one, rows) for one in (system.forces, system.masses))
    slope = slots.symbol(reading, contacts.slopes, np.arange(reading.count))
    approach = [
        Term(reading, slope * force / mass, events),
        Term(each, slots.symbol(each, contacts.bends, numbers), numbers),
    ]
    rates = total_of(count, approach, graph)
    rests = total_of(count, resting(system, contacts), graph)
    listed = rates, contacts.divisors, rests
    rate, divisor, holds = (slots.symbol(each, one, numbers) for one in listed)
    # a slope may be 0 where nothing rests
    multipliers = total_of(count, [Term(each, -rate / (holds * divisor + (1.0 - holds)), numbers)], graph)
    everyone, every = system.everyone, np.arange(degrees)
    alone = np.flatnonzero(np.bincount(events, minlength=count) == 1)
    lone, first = Domain(len(alone)), np.searchsorted(events, alone)
    rest = slots.symbol(lone, rests, alone)
    free = [Term(everyone, graph.one, every), Term(lone, -rest, rows[first])]
    moves = total_of(degrees, free, graph)
    own = slots.symbol(everyone, system.forces, every) * slots.symbol(everyone, moves, every)
    terms = [Term(everyone, own, every)]
    if contacts.bends.terms:
        bend, mass = slots.symbol(lone, contacts.bends, alone), slots.symbol(lone, system.masses, rows[first])
        slope = slots.symbol(lone, contacts.slopes, first)
        terms.append(Term(lone, -rest * mass * bend / (rest * slope + (1.0 - rest)), rows[first]))
    held = np.full(count, NONE)
    held[alone] = rows[first]
    others = np.flatnonzero(held[contacts.acts[0]] != contacts.acts[1])
    acting, (pushed, targets) = Domain(len(others)), contacts.acts[:, others]
    lists = (rests, pushed), (system.masses, targets), (contacts.directions, others), (multipliers, pushed)
    on, mass, direction, multiplier = (slots.symbol(acting, one, places) for one, places in lists)
    terms.append(Term(acting, on * mass * direction * multiplier, targets))
    needed = [*system.needed, system.forces, contacts.slopes, contacts.bends, contacts.directions]
    return replace(
        system, forces=total_of(degrees, terms, graph),
        needed=[*needed, contacts.divisors, rates, rests, multipliers, moves],
        contact=replace(contacts, multipliers=multipliers),
    )  # fmt: skip


def resting(system: FamilySystem, contacts: Contacts) -> list[Term]:
    """1 of each contact at which the motion rests, and not at the other one of its coordinate."""
    slots, found = system.slots, []
    for which in (contacts.others == NONE, contacts.others != NONE):
        numbers = np.flatnonzero(which)
        if not len(numbers):
            continue
        domain = Domain(len(numbers))
        mode = slots.symbol(domain, contacts.signs, numbers)
        node = mode * mode
        if contacts.others[numbers[0]] != NONE:
            other = slots.symbol(domain, contacts.signs, contacts.others[numbers])
            node = node * (1.0 - other * other)
        found.append(Term(domain, node, numbers))
    return found
