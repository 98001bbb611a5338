"""Masses that depend on coordinates and on t: of particles on curves and in polar coordinates, and those of a
given Lagrangian.

A product c v_i v_j in L gives p_i = c v_j and p_j = c v_i. So M has the entry c, and the equations have what
is quadratic in velocities besides (H. Goldstein, Classical Mechanics, 2nd ed., sec. 1-6):

    M a = dL/dq + Q - (dp/dt at constant velocities).

The derivatives are taken once for each product of all members alike.
"""

from __future__ import annotations

from collections.abc import Iterable

from lagrange_cli.expression.node import Kind, Node, reachable
from lagrange_cli.families.arrays import Array, Chain, Slots, Source, Term, Total, total_of
from lagrange_cli.families.builder import FamilyBuilder
from lagrange_cli.families.coupled_masses import Product
from lagrange_cli.families.slopes import slopes


def fixed(builder: FamilyBuilder, node: Node) -> bool:
    """Whether it is a constant of the motion."""
    if node.symbols & builder.time.symbols:
        return False
    constant = builder.given, builder.whole
    arrays = (slot.array for _, slot in builder.slots.inside(node))
    return all(one in constant or still(builder, one) for one in arrays)


def bends(builder: FamilyBuilder, node: Node) -> bool:
    """Whether a mass may be this: a smooth function of coordinates, of sums of such functions, and of t."""
    slots, moving = builder.slots, builder.time.symbols | builder.slots.symbols_of(builder.q, totals=True)
    known = builder.q, builder.given, builder.whole
    for _, slot in slots.inside(node):
        if slot.array not in known and not (still(builder, slot.array) or summed(builder, slot.array)):
            return False
    return not any(one.kind is Kind.SWITCH and one.symbols & moving for one in reachable([node]))


def summed(builder: FamilyBuilder, array: Array) -> bool:
    """Whether an array has sums of smooth functions of coordinates."""
    if not isinstance(array, Total) or isinstance(array, Chain):
        return False
    nodes = [one.node for one in array.terms]
    return all(bends(builder, one) and not one.symbols & builder.time.symbols for one in nodes)


def still(builder: FamilyBuilder, array: Array) -> bool:
    """Whether an array has sums of constants."""
    if not isinstance(array, Total) or isinstance(array, Chain):
        return False
    moving = builder.time.symbols | builder.slots.symbols_of(builder.q, builder.v)
    return not any(one.symbols & moving for one in builder.slots.made_of([t.node for t in array.terms]))


def merged(slots: Slots, v: Array, products: Iterable[Product]) -> tuple[Product, ...]:
    """The products, those of the same velocities as one."""
    found: dict[frozenset[Node], Product] = {}
    for one in products:
        key = frozenset(slots.symbol(one.domain, v, table) for table in (one.first, one.second))
        node = one.node + found[key].node if key in found else one.node
        if not node.is_zero:
            found[key] = Product(one.domain, node, one.first, one.second)
    return tuple(found.values())


def inertia(
    builder: FamilyBuilder, products: Iterable[Product]
) -> tuple[list[Term], list[Term], list[Total]]:
    """-dT/dq, and dp/dt at constant velocities, for these parts of T; and the totals that the first one takes
    where masses contain sums."""
    slots, graph = builder.slots, builder.graph
    gradient, rates, summing = list[Term](), list[Term](), list[Term]()
    for one in products:
        v, w = (slots.symbol(one.domain, builder.v, table) for table in (one.first, one.second))
        inside = [*slots.inside(one.node)]
        if all(slot.array.source is not Source.TOTAL or still(builder, slot.array) for _, slot in inside):
            for symbol, slot in inside:
                if slot.array is builder.q:
                    slope = graph.diff(one.node, symbol)
                    gradient.append(Term(one.domain, -(slope * v * w), slot.table))
        else:
            summing.append(Term(one.domain, -(one.node * v * w), one.domain.together))
        change = builder.rate(one.node, one.domain)
        rates += [Term(one.domain, change * w, one.first), Term(one.domain, change * v, one.second)]
    if not summing:
        return gradient, rates, []
    whole = total_of(1, summing, graph)
    (more,), taken = slopes(
        slots.own(builder.root, whole), builder.root, [*builder.totals, whole], slots, builder.q
    )
    return [*gradient, *more.terms], rates, taken
