"""Products of velocities and of sums of velocities, such as the square of a total momentum, member by member
of both factors."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from lagrange_cli.expression.index_arrays import Places
from lagrange_cli.expression.indices import Unsuited
from lagrange_cli.expression.node import Node
from lagrange_cli.families.arrays import Array, Chain, Domain, Slot, Slots, Total, placed
from lagrange_cli.families.coupled_masses import Product
from lagrange_cli.families.tables import count_met, met
from lagrange_cli.mechanics.substitution import substituted
from lagrange_cli.records import dataclass, replace

MOST = 2**22
"""Products up to which they are looked at one by one."""
MOST_CURVED = 2**16
"""Those that are no constants up to which each may have a series of its own."""


@dataclass(frozen=True, eq=False)
class Velocities:
    """What a factor has of velocities: of the ``owners`` among the members of a domain, those at ``rows``
    times a ``slope``, an expression of the ``members`` of another domain, or 1."""

    owners: Places
    rows: Places
    slope: Node | None
    members: Places


def speeds(slots: Slots, array: Array, velocities: Array) -> bool:
    """Whether an array has velocities, or sums of them or of such sums."""
    if not isinstance(array, Total):
        return array is velocities
    made = slots.made_of([one.node for one in array.terms])
    return any(slots.moving(one, {velocities}) for one in made)


def sums_in(slots: Slots, node: Node, velocities: Array) -> list[tuple[Node, Slot]]:
    """The sums in an expression that contain velocities."""
    return [
        (symbol, slot)
        for symbol, slot in slots.inside(node)
        if isinstance(slot.array, Total) and speeds(slots, slot.array, velocities)
    ]


def velocities_of(slots: Slots, slot: Slot, velocities: Array) -> Iterator[Velocities]:
    """Those of a factor, a velocity or a sum. Raises ``Unsuited`` where a sum is not linear in velocities
    alone."""
    total = slot.array
    if not isinstance(total, Total):
        yield Velocities(np.arange(len(slot.table)), slot.table, None, np.zeros(0, dtype=np.int64))
        return
    if isinstance(total, Chain):
        raise Unsuited
    for term in total.terms:
        inside = [(s, one) for s, one in slots.inside(term.node) if speeds(slots, one.array, velocities)]
        (rest,) = substituted(slots.graph, [term.node], {s: slots.graph.zero for s, _ in inside})
        if not rest.is_zero:
            raise Unsuited
        owners, members = joined(slot.table, term.targets)
        for symbol, one in inside:
            slope = slots.graph.diff(term.node, symbol)
            if any(speeds(slots, other.array, velocities) for _, other in slots.inside(slope)):
                raise Unsuited
            if one.array is velocities:
                yield Velocities(owners, one.table[members], slope, members)
                continue
            for own in velocities_of(slots, replace(one, table=one.table[members]), velocities):
                yield multiplied(slots, slope, members, owners, own)


def multiplied(slots: Slots, slope: Node, members: Places, owners: Places, own: Velocities) -> Velocities:
    """The velocities of sums within a sum: of some ``members`` of a term, each with its owner, times the
    term's ``slope`` by them."""
    which = members[own.owners]
    if own.slope is None:
        return Velocities(owners[own.owners], own.rows, slope, which)
    domain = Domain(len(which))
    both = placed(slots, slope, domain, which) * placed(slots, own.slope, domain, own.members)
    return Velocities(owners[own.owners], own.rows, both, domain.every)


def joined(first: Places, second: Places) -> tuple[Places, Places]:
    """All pairs of places at which both have the same number."""
    if count_met(first, second) > MOST:
        raise Unsuited
    return met(first, second)


def products_of(
    slots: Slots, coefficient: Node, first: Slot, second: Slot, velocities: Array
) -> Iterator[Product]:
    """The products of velocities that a ``coefficient`` of a domain's members times two factors has."""
    found = [*velocities_of(slots, second, velocities)]
    for one in velocities_of(slots, first, velocities):
        for other in found:
            a, b = joined(one.owners, other.owners)
            if len(a):
                yield product(slots, coefficient, (one, a), (other, b))


def product(slots: Slots, coefficient: Node, *factors: tuple[Velocities, Places]) -> Product:
    """Some velocities of two factors, multiplied."""
    (one, a), (_, _) = factors
    domain = Domain(len(a))
    node = placed(slots, coefficient, domain, one.owners[a])
    rows: list[Places] = []
    for factor, which in factors:
        rows.append(factor.rows[which])
        if factor.slope is not None:
            node = node * placed(slots, factor.slope, domain, factor.members[which])
    return Product(domain, node, *rows)
