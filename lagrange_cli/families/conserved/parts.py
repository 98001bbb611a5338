"""Parts of a system of families whose coordinates share no term of L, no force and no constraint with others:
each conserves its own energy (see ``mechanics.conserved.separation``).

They are found for all members at once, from the tables of places.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from typing import TYPE_CHECKING, Protocol

import numpy as np

from lagrange_cli.expression.index_arrays import Places
from lagrange_cli.expression.node import Node
from lagrange_cli.families.arrays import Domain, Source, Term, Total, total_of
from lagrange_cli.families.description import FamilySystem
from lagrange_cli.families.slopes import factors
from lagrange_cli.mechanics.conservation import Conserved
from lagrange_cli.mechanics.conserved.separation import energy_of_part, terms_of_sum
from lagrange_cli.mechanics.substitution import substituted
from lagrange_cli.records import dataclass
from lagrange_cli.spec.content import names_of

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Flags = NDArray[np.bool_]
    Values = NDArray[np.float64]

ROUNDED = 1e-10
"""What is left of terms that cancel, but for rounding, is at most so large a part of them."""
MOST = 2000
"""Coordinates of systems that are looked at: each part is a quantity of its own."""


@dataclass(frozen=True, eq=False)
class Tie:
    """What the members of a ``domain`` have in one term: coordinates at these ``tables``, and what it adds to
    h, if it is one of L. ``timed`` ones contain t."""

    domain: Domain
    tables: Sequence[Places]
    energy: Node | None
    timed: bool = False


@dataclass(frozen=True, eq=False)
class Parts:
    """The part of each coordinate, and the ``energies`` of all parts, by number: those of its first
    coordinates (``first``) are conserved as far as they are ``steady``."""

    of: Places
    first: Places
    steady: Flags
    energies: Total


def parts_of(system: FamilySystem) -> Parts | None:
    """The parts; None where there is but one, and where this is not looked at."""
    count = system.q.count
    if system.joints is not None or system.first_order is not None or not 1 < count <= MOST:
        return None
    terms, ties = terms_in(system), forces_in(system)
    if terms is None or ties is None:
        return None
    ties += bound_in(system)
    label = joined(count, [one.tables for one in (*terms, *ties)])
    first, of = np.unique(label, return_inverse=True)
    if len(first) == 1:
        return None
    steady = np.ones(len(first), dtype=bool)
    for one in (*terms, *ties):
        if one.timed:
            steady[of[one.tables[0]]] = False
    added = [Term(one.domain, one.energy, of[one.tables[0]]) for one in terms if one.energy is not None]
    return Parts(of, first, steady, total_of(len(first), added, system.slots.graph))


def terms_in(system: FamilySystem) -> list[Tie] | None:
    """The terms of L; None where sums are in functions."""
    slots, graph, everyone = system.slots, system.slots.graph, system.everyone
    linear = factors(system.potential, slots)
    given = [(system.root, system.potential, graph.one)]
    given += [(one.domain, one.node, factor) for total, factor in linear.items() for one in total.terms]
    found = list[Tie]()
    for domain, node, factor in given:
        for term, coefficient in terms_of_sum(node, 1.0):
            inside = [slot for _, slot in slots.inside(term)]
            if any(slot.array in linear for slot in inside):
                continue  # their terms are looked at
            tables = moving(system, term)
            if tables is None:
                return None
            if tables:
                still = {s: graph.zero for s, slot in slots.inside(term) if slot.array is system.v}
                energy = coefficient * factor * substituted(graph, [term], still)[0]
                found.append(Tie(domain, tables, energy, bool(term.symbols & system.time.symbols)))
    mass, speed = (slots.own(everyone, one) for one in (system.masses, system.v))
    found.append(Tie(everyone, [everyone.every], 0.5 * mass * speed * speed))
    coupled = system.coupled_masses
    if coupled is not None:
        i, j = coupled.pairs[coupled.below].T
        product = coupled.energy(slots, system.v)
        found.append(Tie(product.domain, [i, j], product.node))
    for one in coupled.curved if coupled else ():
        for node, _ in terms_of_sum(one.node, 1.0):
            tables = moving(system, node)
            if tables is None:
                return None
            timed = bool(node.symbols & system.time.symbols)
            found.append(Tie(one.domain, [one.first, one.second, *tables], None, timed))
    return found


def forces_in(system: FamilySystem) -> list[Tie] | None:
    """What forces outside L read."""
    found = list[Tie]()
    for one in system.applied.terms:
        tables = moving(system, one.node)
        if tables is None:
            return None
        found.append(Tie(one.domain, [one.targets, *tables], None))
    return found


def bound_in(system: FamilySystem) -> list[Tie]:
    """What constraints tie; ``timed`` are those whose forces do work."""
    bonds, found = system.bonds, list[Tie]()
    if bonds is None:
        return found
    first = np.full(bonds.count, system.q.count)
    for one in bonds.bounds:
        for rows in one.rows:
            np.minimum.at(first, one.numbers, rows)
    for one in bonds.bounds:
        inside = [slot for _, slot in system.slots.inside(one.node)]
        tables = [slot.table for slot in inside if slot.array in (system.q, system.v)]
        graph = system.slots.graph
        drift = graph.diff(one.node, system.time) if one.holonomic else one.at_rest(graph)
        found.append(Tie(one.domain, [first[one.numbers], *tables], None, not drift.is_zero))
    return found


def moving(system: FamilySystem, node: Node) -> list[Places] | None:
    """The tables of coordinates and velocities in an expression; None if it contains sums that move."""
    tables = []
    for _, slot in system.slots.inside(node):
        if slot.array in (system.q, system.v):
            tables.append(slot.table)
        elif slot.array.source is Source.TOTAL:
            made = system.slots.made_of([one.node for one in getattr(slot.array, "terms", ())])
            moves = system.time.symbols | system.slots.symbols_of(system.q, system.v)
            if not isinstance(slot.array, Total) or any(one.symbols & moves for one in made):
                return None
    return tables


def joined(count: int, ties: Iterable[Sequence[Places]]) -> Places:
    """The least coordinate of those that each of ``count`` is tied to, directly or not."""
    label, listed = np.arange(count), [np.stack(one) for one in ties if len(one) > 1]
    while True:
        before = label.copy()
        for tables in listed:
            least = label[tables].min(axis=0)
            for table in tables:
                np.minimum.at(label, label[table], least)
                np.minimum.at(label, table, least)
        label = label[label]
        if np.array_equal(before, label):
            return label


class State(Protocol):
    """Velocities at a state, and the forces outside L with their sizes."""

    v: Values
    applied: Values
    applied_sizes: Values


def energies_of_parts(system: FamilySystem, states: Sequence[State], kept: Flags) -> Iterator[Conserved]:
    """Those that are conserved, as forces do no work at some random states; without those of coordinates
    whose momenta are all ``kept``. A single such part gives nothing."""
    parts, names = parts_of(system), names_of(system.spec.coordinates)
    if parts is None:
        return
    work = [np.bincount(parts.of, one.v * one.applied) for one in states]
    sizes = [np.bincount(parts.of, np.abs(one.v) * one.applied_sizes) for one in states]
    idle = np.all([np.abs(one) <= ROUNDED * size for one, size in zip(work, sizes)], axis=0)
    count = len(parts.first)
    free = np.bincount(parts.of[~kept], minlength=count) > 0
    order = np.argsort(parts.of, kind="stable")
    starts = np.searchsorted(parts.of[order], np.arange(count + 1))
    for k in np.flatnonzero(free & parts.steady & idle).tolist() if np.sum(free) > 1 else ():
        yield energy_of_part([names[i] for i in order[starts[k] : starts[k + 1]].tolist()])
