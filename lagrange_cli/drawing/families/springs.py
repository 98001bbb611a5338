"""The springs of families: terms k (d - l)^2/2 of the potential, for all members that are alike at once (see
``drawing.springs``)."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import combinations

import numpy as np

from lagrange_cli.drawing.families.crowd import Crowd, Mask, Piece, equal, lengths, steady
from lagrange_cli.drawing.families.rods import Lines, apart, ends_of, part_of
from lagrange_cli.drawing.probe import STATES
from lagrange_cli.expression.arrays import Array
from lagrange_cli.expression.index_arrays import Places
from lagrange_cli.expression.node import Kind, Node, factors_of
from lagrange_cli.families.arrays import Chain, Domain, Total
from lagrange_cli.records import dataclass


@dataclass(frozen=True, eq=False)
class Stretched:
    """``length`` of each member of a domain, whose square is a term of the potential; with a positive factor
    in the ``members``."""

    domain: Domain
    length: Node
    members: Places


def springs_of(crowd: Crowd) -> list[Lines]:
    """All springs of the potential."""
    found, axes = list[Lines](), list[tuple[Places, Places, int]]()
    crooked = np.zeros(crowd.count, dtype=bool)
    for domain, constant, timed, factors in terms(crowd):
        node, exponent = factors[0]
        if len(factors) > 1 or (node in crowd.slots.of and exponent not in (1, 2)):
            for one, _ in factors:
                for table in crowd.near(domain, one):
                    crooked[table] = True
        elif exponent == 2 and not timed:
            members = np.flatnonzero((constant > 0).all(axis=1))
            found += whole(crowd, Stretched(domain, node, members), axes)
    found += complete(crowd, axes, crooked)
    return apart(found, crowd.count)


def terms(crowd: Crowd) -> Iterator[tuple[Domain, Array, bool, Sequence[tuple[Node, float]]]]:
    """The terms of the potential but those that are linear, factors before sums multiplied out: the domain,
    what is constant of each (members, STATES), whether that contains t, and the other factors with their
    exponents."""
    root, builder = crowd.builder.root, crowd.builder
    pending: list[tuple[Domain, Array, bool, Node]] = []
    for expression in crowd.spec.potential.values():
        node = builder.of_root(expression.tree, expression.indices)
        pending.append((root, np.ones((1, STATES)), False, node))
    while pending:
        domain, outer, timed, node = pending.pop()
        if node.kind is Kind.SUM:
            pairs = zip(node.arguments, node.data[1])
            pending += [(domain, float(c) * outer, timed, one) for one, c in pairs]
            continue
        factors = factors_of(node)
        moving = [(one, float(e)) for one, e in factors if crowd.moves(one)]
        fixed = [(one, e) for one, e in factors if not crowd.moves(one)]
        if not moving:
            continue
        constant = crowd.graph.product(fixed)
        outer = outer * crowd.probe(domain, constant)
        timed = timed or crowd.timed(constant)
        if len(moving) > 1 or moving[0][1] != 1:
            yield domain, outer, timed, moving
            continue
        inner = moving[0][0]
        if inner.kind is Kind.SUM:
            pending.append((domain, outer, timed, inner))
        elif inner in crowd.slots.of:
            slot = crowd.slots.of[inner]
            if isinstance(slot.array, Total) and not isinstance(slot.array, Chain):
                placed = np.zeros((slot.array.count, STATES))
                placed[slot.table] = outer
                pending += [(one.domain, placed[one.targets], timed, one.node) for one in slot.array.terms]


def whole(crowd: Crowd, one: Stretched, axes: list[tuple[Places, Places, int]]) -> Iterator[Lines]:
    """The springs whose elongation a length is, up to its sign. What is a component of a distance instead is
    added to ``axes``: two particles, and which component; one particle twice for its distance from 0."""
    moved = shortened(crowd, one.length)
    rest = np.abs(crowd.probe(one.domain, one.length))
    long = np.abs(crowd.probe(one.domain, moved))
    left = one.members
    for start, end in ends_of(crowd, one.domain, one.length):
        assert end.particles is not None
        there = crowd.of(one.domain, start.place)
        distance = lengths(there - crowd.places[end.particles])
        good = left[(equal(long, distance) | equal(rest, distance))[left]]
        left = np.setdiff1d(left, good)
        slack = moved is one.length
        if not len(good):
            continue
        if start.particles is not None:
            yield Lines(end.particles[good], start.particles[good], slack=slack)
        else:
            piece = Piece(one.domain, start.place, np.arange(one.domain.count), crowd.families[0])
            part = part_of(crowd, piece, good)
            yield Lines(end.particles[good], None, part.domain, part.place, slack=slack)
    near = crowd.near(one.domain, one.length)
    for a, b in (*combinations(near, 2), *zip(near, near)):
        for k in range(crowd.dimension):
            across = crowd.places[a, k] - (0.0 if a is b else crowd.places[b, k])
            good = left[equal(np.abs(across), rest)[left]]
            if len(good):
                axes.append((a[good], b[good], k))


def complete(crowd: Crowd, axes: Sequence[tuple[Places, Places, int]], crooked: Mask) -> Iterator[Lines]:
    """The springs of which all components are there that change."""
    if not axes:
        return
    a, b = (np.concatenate([one[i] for one in axes]) for i in range(2))
    k = np.concatenate([np.full(len(one[0]), one[2]) for one in axes])
    pairs, which = np.unique(np.minimum(a, b) * crowd.count + np.maximum(a, b), return_inverse=True)
    there = np.zeros((len(pairs), crowd.dimension), dtype=bool)
    there[which, k] = True
    first, second = np.divmod(pairs, crowd.count)
    alone = first == second
    across = crowd.places[first] - np.where(alone[:, None, None], 0.0, crowd.places[second])
    due = ~steady(across.reshape(-1, across.shape[2])).reshape(there.shape)
    good = ~np.any(due & ~there, axis=1) & np.logical_not(crooked[first] | crooked[second])
    if np.any(good & ~alone):
        yield Lines(second[good & ~alone], first[good & ~alone], slack=True)
    held = second[good & alone]
    if len(held):
        yield Lines(held, None, Domain(len(held)), (crowd.graph.zero,) * crowd.dimension, slack=True)


def shortened(crowd: Crowd, node: Node) -> Node:
    """A sum less those of its terms that depend neither on a coordinate nor on t."""
    if node.kind is not Kind.SUM:
        return node
    kept = [(x, c) for x, c in zip(node.arguments, node.data[1]) if crowd.moves(x) or crowd.timed(x)]
    return node if len(kept) == len(node.arguments) and not node.data[0] else crowd.graph.sum(kept)
