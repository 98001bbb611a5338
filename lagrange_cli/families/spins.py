"""Spins: coordinates with a constant mass that T does not contain, as the last of Euler's angles of a top.

With s for a spin and r_d = M_ds/M_ss, u = (a_d, a_s + sum r_d a_d) solves P^T M P u = P^T F, where a = P u.
The spin stands alone in this matrix, and beside it are the masses M_bd - r_b M_sd. Their terms may cancel:
those of a top's axis are I1 sin^2 + I3 cos^2 - (I3 cos)^2/I3. Multiplied out, they are I1 sin^2, with all
digits also where the axis is vertical.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from lagrange_cli.expression.index_arrays import Places, distinct
from lagrange_cli.expression.node import Node
from lagrange_cli.families.arrays import Domain, Term
from lagrange_cli.families.bonds import Bonds
from lagrange_cli.families.builder import FamilyBuilder
from lagrange_cli.families.coupled_masses import Alone, CoupledMasses, Product, Spin
from lagrange_cli.families.curved_masses import fixed, merged
from lagrange_cli.mechanics.multiplied_out import beside
from lagrange_cli.records import replace


def with_spins(builder: FamilyBuilder, diagonal: Sequence[Term], products: Sequence[Product]) -> Alone | None:
    """The matrix in which spins stand alone, from M's ``diagonal`` and ``products``; None where no terms
    cancel by that."""
    squares = [Product(one.domain, 0.5 * one.node, one.targets, one.targets) for one in diagonal]
    by_domain: dict[Domain, list[Product]] = {}
    for one in merged(builder.slots, builder.v, [*squares, *products]):
        by_domain.setdefault(one.domain, []).append(one)
    found, spins = list[Product](), list[Spin]()
    for domain, own in by_domain.items():
        others = [one for each, some in by_domain.items() if each is not domain for one in some]
        spun = spinning(builder, domain, own, others)
        found += own if spun is None else spun[0]
        spins += [] if spun is None else [spun[1]]
    curved = tuple(one for one in found if not fixed(builder, one.node))
    return Alone(tuple(found), curved, tuple(spins)) if spins else None


def spinning(
    builder: FamilyBuilder, domain: Domain, own: Sequence[Product], others: Sequence[Product]
) -> tuple[list[Product], Spin] | None:
    """The products of one domain with the best spin alone, and this; None where there is none."""
    slots, graph = builder.slots, builder.graph
    rows: dict[Node, Places] = {}
    for one in own:
        for table in (one.first, one.second):
            rows[slots.symbol(domain, builder.v, table)] = table
    listed = [*rows]
    masses = [[graph.zero for _ in listed] for _ in listed]
    for one in own:
        i, j = (listed.index(slots.symbol(domain, builder.v, table)) for table in (one.first, one.second))
        masses[i][j] = masses[j][i] = one.node if i != j else 2.0 * one.node
    elsewhere = [table for one in others for table in (one.first, one.second)]
    best, found = 0, None
    for spin, (symbol, row) in enumerate(zip(listed, masses)):
        table = rows[symbol]
        turned = slots.symbol(domain, builder.q, table).symbols
        meeting = [*elsewhere, *(rows[one] for one in listed if one is not symbol)]
        alone = len(distinct(table)) == len(table) and not any(np.isin(table, one).any() for one in meeting)
        if not alone or any(one.node.symbols & turned for one in own):
            continue
        if row[spin].is_zero or not fixed(builder, row[spin]):
            continue
        shorter, made = beside(graph, masses, spin)
        if shorter > best:
            best, found = shorter, (spin, made)
    if found is None:
        return None
    spin, made = found
    products = [
        Product(domain, made[b][d] if b != d else 0.5 * made[b][b], rows[listed[b]], rows[listed[d]])
        for b, _ in enumerate(listed)
        for d in range(b, len(listed))
        if b == d or spin not in (b, d)
    ]
    ratios = [
        (masses[spin][d] / masses[spin][spin], rows[one])
        for d, one in enumerate(listed)
        if d != spin and not masses[spin][d].is_zero
    ]
    return [one for one in products if not one.node.is_zero], Spin(domain, rows[listed[spin]], tuple(ratios))


def without_bound_spins(masses: CoupledMasses, bonds: Bonds) -> CoupledMasses:
    """The masses as they are if constraints contain a spin: it is tied to others then."""
    bound = [rows for one in bonds.bounds for rows in one.rows]
    spins = masses.factored.spins
    tied = any(np.isin(spin.rows, rows).any() for spin in spins for rows in bound)
    return replace(masses, alone=None) if tied else masses
