"""Momenta and kinetic energy of chains and trees, and forces as coordinates feel them."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING

import numpy as np

from lagrange_cli.expression.graph import Graph
from lagrange_cli.expression.node import Node
from lagrange_cli.families.arrays import Array, Domain, Slots, Term, Total, total_of
from lagrange_cli.families.builder import FamilyBuilder
from lagrange_cli.families.joints.joints import Articulation, Joints, Weight

if TYPE_CHECKING:
    from numpy.typing import NDArray


def momenta(builder: FamilyBuilder, found: Articulation) -> Total:
    """p_k = dT/dq_dot_k: what a joint moves, from the tips on."""
    graph, slots, every = builder.graph, builder.slots, np.arange(found.count)
    parents = found.nodes[0].tree if found.nodes else None
    carried: list[Total] = []
    for component, (mass, rate) in enumerate(zip(found.inertia, found.rates)):
        domain = Domain(found.count)
        terms = []
        if rate is not None:
            terms.append(
                Term(domain, slots.symbol(domain, mass, every) * slots.symbol(domain, rate, every), every)
            )
        for one in found.joints:
            if one.parents is not None:
                for weight in one.weights:
                    if weight.component == component:
                        terms.append(
                            Term(one.domain, weight.mass * speed(builder, found, one, weight), one.parents)
                        )
        made = total_of(found.count, terms, graph, parents, back=True)
        builder.totals.append(made)
        carried.append(made)
    terms = []
    for one in found.joints:
        for b, (symbol, rows) in enumerate(zip(one.coordinates, one.rows)):
            p = one.free.momenta[b] if one.free else graph.zero
            for move, total in zip(one.moves, carried):
                assert one.nodes is not None
                p = p + graph.diff(move, symbol) * slots.symbol(one.domain, total, one.nodes)
            for weight in one.hung:
                p = p + graph.diff(weight.move, symbol) * weight.mass * speed(builder, found, one, weight)
            terms.append(Term(one.domain, p, rows))
    if found.relative is not None:
        terms = [*found.relative.on_coordinates(terms, builder.totals)]
    return total_of(builder.q.count, terms, graph)


def speed(builder: FamilyBuilder, found: Articulation, one: Joints, weight: Weight) -> Node:
    """The velocity of a weight along its axis."""
    own = builder.rate(weight.move, one.domain)
    rates: Array | None = None if weight.component is None else found.rates[weight.component]
    if rates is None or one.parents is None:
        return own
    return own + builder.slots.symbol(one.domain, rates, one.parents)


def kinetic_terms(builder: FamilyBuilder, found: Articulation) -> Iterator[Term]:
    """The terms of T."""
    every = np.arange(found.count)
    for mass, rate in zip(found.inertia, found.rates):
        if rate is not None and mass.terms:
            domain = Domain(found.count)
            m, v = (builder.slots.symbol(domain, one, every) for one in (mass, rate))
            yield Term(domain, 0.5 * m * v * v, np.zeros(found.count, dtype=np.int64))
    for one in found.joints:
        if one.free is not None:
            yield Term(one.domain, one.free.kinetic, one.domain.together)
        for weight in one.hung:
            v = speed(builder, found, one, weight)
            yield Term(one.domain, 0.5 * weight.mass * v * v, np.zeros(one.domain.count, dtype=np.int64))


def felt(
    slots: Slots, found: Articulation, pushes: Sequence[Sequence[Term]], made: list[Total]
) -> Iterator[Term]:
    """What acts on nodes, and on sums of coordinates behind these, as coordinates feel it: F . dr/dq_k of all
    that a joint carries; the totals that this takes are added to those ``made``."""
    terms, relative = felt_by_joints(slots, found, pushes, made), found.relative
    if relative is None:
        return terms
    return relative.on_coordinates([*terms, *relative.on_sums(pushes[len(found.nodes) :])], made)


def felt_by_joints(
    slots: Slots, found: Articulation, pushes: Sequence[Sequence[Term]], made: list[Total]
) -> Iterator[Term]:
    """The same of the joints' coordinates."""
    for component, (chain, terms) in enumerate(zip(found.nodes, pushes)):
        if not terms:
            continue
        whole = total_of(chain.count, terms, slots.graph, chain.tree, back=True)
        made.append(whole)
        for one in found.joints:
            if one.nodes is not None:
                push = slots.symbol(one.domain, whole, one.nodes)
                for symbol, rows in zip(one.coordinates, one.rows):
                    yield Term(one.domain, push * slots.graph.diff(one.moves[component], symbol), rows)


def curved(graph: Graph, found: Articulation, count: int) -> NDArray[np.bool_]:
    """The coordinates (``count`` of them) that T depends on, or may."""
    curved = np.zeros(count, dtype=bool)
    for one in found.joints:
        nodes = (*one.moves, *(weight.move for weight in one.weights))
        for symbol, rows in zip(one.coordinates, one.rows):
            slopes = [graph.diff(node, other) for node in nodes for other in one.coordinates]
            if any(slope.symbols & symbol.symbols for slope in slopes):
                curved[rows] = True
    return curved if found.relative is None else found.relative.behind(curved)
