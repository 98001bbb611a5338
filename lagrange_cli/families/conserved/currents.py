"""What displacements of all particles conserve (``conservation``), as totals over families."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence

import numpy as np

from lagrange_cli.expression.index_arrays import Places
from lagrange_cli.expression.node import Node
from lagrange_cli.expression.vocabulary import COMPONENTS
from lagrange_cli.families.arrays import Array, Domain, Term, Total, total_of
from lagrange_cli.families.conserved.parts import parts_of
from lagrange_cli.families.conserved.rigid import Rigid
from lagrange_cli.families.description import Component, FamilySystem
from lagrange_cli.mechanics.conserved.displacements import TURNS
from lagrange_cli.spec.content import names_of
from lagrange_cli.spec.spec import grouped

OF_PART = "h_"
"""What the names of energies of parts begin with."""


def elements(system: FamilySystem, quantities: Sequence[str]) -> list[tuple[Total, int]]:
    """Where each of the conserved ``quantities`` is: in a total, and at which place."""
    numbers, energies = energies_of_parts(system, quantities)
    return [
        (energies, numbers[one]) if energies is not None and one in numbers else (current(system, one), 0)
        for one in quantities
    ]


def energies_of_parts(
    system: FamilySystem, quantities: Sequence[str]
) -> tuple[Mapping[str, int], Total | None]:
    """The energies of parts, and the number of each by its name, if any of these is asked for."""
    parts = parts_of(system) if any(one.startswith(OF_PART) for one in quantities) else None
    if parts is None:
        return {}, None
    names = names_of(system.spec.coordinates)
    return {f"{OF_PART}{names[i]}": k for k, i in enumerate(parts.first.tolist())}, parts.energies


def current(system: FamilySystem, quantity: str) -> Total:
    """The total of one member that is the conserved ``quantity``: P_x, L_z, K_x, or P_u of a family u."""
    kind, _, name = quantity.partition("_")
    if system.spec.lagrangian is not None:
        terms = [*of_family(system, name)]
    elif not system.straight:
        terms = [*of_coordinates(system, quantity)]
    elif kind == "L":
        i, j = TURNS[name]
        terms = [*turning(system, i, j), *turning(system, j, i, -1.0)]
    else:
        terms = [*moving(system, COMPONENTS.index(name), boosted=kind == "K")]
    return total_of(1, terms, system.slots.graph)


def of_family(system: FamilySystem, name: str) -> Iterator[Term]:
    """The sum of the momenta of a family of coordinates."""
    spec, first = system.spec, 0
    for family in grouped(names_of(spec.coordinates), spec.coordinate_families):
        count = len(family.members)
        if family.name == name:
            domain, rows = Domain(count), np.arange(first, first + count)
            momentum = system.slots.symbol(domain, system.momenta, rows)
            yield Term(domain, momentum, np.zeros(count, dtype=np.int64))
        first += count


def of_coordinates(system: FamilySystem, quantity: str) -> Iterator[Term]:
    """The same of chains and trees, and in a field: the momenta of what changes."""
    kind, _, name = quantity.partition("_")
    found = Rigid(system).parts(quantity)
    if found is None:
        yield from of_family(system, name)
        return
    time = system.time if kind == "K" else system.slots.graph.one
    for one in found:
        domain, rows = Domain(len(one.family.members)), np.arange(len(one.family.members))
        node = one.factor * time * system.slots.symbol(domain, system.momenta, rows + one.first)
        if one.other is not None:
            node = node * system.slots.symbol(domain, system.q, rows + one.other_first)
        yield Term(domain, node, np.zeros(len(rows), dtype=np.int64))
    if kind == "K":
        centre = system.centres[COMPONENTS.index(name)]
        where = np.zeros(1, dtype=np.int64)
        yield Term(system.root, -system.slots.symbol(system.root, centre, where), where)


def moving(system: FamilySystem, axis: int, *, boosted: bool) -> Iterator[Term]:
    """The sum of m v along an axis; ``boosted``, of m (t v - x)."""
    for one in system.components:
        if one.axis == axis:
            node = momentum(system, one)
            if boosted:
                node = system.time * node - one.mass * place(system, one, axis)
            yield Term(one.domain, node, nowhere(one.members))


def turning(system: FamilySystem, i: int, j: int, sign: float = 1.0) -> Iterator[Term]:
    """The sum of x_i m v_j."""
    for one in system.components:
        if one.axis == j:
            yield Term(one.domain, sign * place(system, one, i) * momentum(system, one), nowhere(one.members))


def momentum(system: FamilySystem, one: Component) -> Node:
    """m v of a component."""
    node: Node = one.mass * one.slope * system.slots.symbol(one.domain, system.v, one.rows)
    return node


def place(system: FamilySystem, one: Component, axis: int) -> Node:
    """Where the particles of a component are, along some axis."""
    array: Array = system.positions[one.family][axis]
    return system.slots.symbol(one.domain, array, one.members)


def nowhere(members: Places) -> Places:
    """All in one place."""
    return np.zeros(len(members), dtype=np.int64)
