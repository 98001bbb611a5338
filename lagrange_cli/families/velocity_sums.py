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
from lagrange_cli.records import dataclass

MOST = 2**22
"""Products up to which they are looked at one by one."""


@dataclass(frozen=True, eq=False)
class Velocities:
    """What a factor has of velocities: of the ``owners`` among the members of a domain, those at ``rows``
    times a ``slope``, an expression of the ``members`` of another domain, or 1."""

    owners: Places
    rows: Places
    slope: Node | None
    members: Places


def sums_in(slots: Slots, node: Node, velocities: Array) -> list[tuple[Node, Slot]]:
    """The sums in an expression that contain velocities."""
    return [
        (symbol, slot)
        for symbol, slot in slots.inside(node)
        if isinstance(slot.array, Total)
        and any(slots.moving(one.node, {velocities}) for one in slot.array.terms)
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
        speeds = [(s, one) for s, one in slots.inside(term.node) if one.array is velocities]
        (rest,) = substituted(slots.graph, [term.node], {s: slots.graph.zero for s, _ in speeds})
        if not rest.is_zero:
            raise Unsuited
        owners, members = joined(slot.table, term.targets)
        for symbol, one in speeds:
            slope = slots.graph.diff(term.node, symbol)
            if slots.moving(slope, {velocities}):
                raise Unsuited
            yield Velocities(owners, one.table[members], slope, members)


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
