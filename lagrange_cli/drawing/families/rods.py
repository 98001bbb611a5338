"""The rods of families: what holds particles at a fixed distance, for all members that are alike at once.

They are found as ``drawing.rods`` finds them: a place hangs on a rod if what one of its coordinates moves has
a fixed length. Along a chain that is what a node adds to its parent.
"""

from __future__ import annotations

from collections.abc import Iterator
from itertools import combinations

import numpy as np

from lagrange_cli.drawing.distances import centre_of, is_root
from lagrange_cli.drawing.families.crowd import Crowd, Mask, Piece, Place, equal, lengths, steady
from lagrange_cli.drawing.rods import PAIRS, TRIES, slides
from lagrange_cli.drawing.scene import without
from lagrange_cli.expression.index_arrays import Places
from lagrange_cli.expression.node import Node, reachable
from lagrange_cli.families.arrays import NONE, Chain, Domain, Slot, placed
from lagrange_cli.families.groups import group_of
from lagrange_cli.mechanics.substitution import substituted
from lagrange_cli.records import dataclass
from lagrange_cli.spec.spec import grouped

ALONG_A_CHAIN = 1.5
"""A node of a chain is tried after coordinates that one particle has, and before those of several."""


@dataclass(frozen=True, eq=False)
class Lines:
    """Lines to the particles ``ends``: from the particles ``starts``, or from the ``place`` of each member of
    a domain. The ends of ``slack`` springs are at one place when they rest."""

    ends: Places
    starts: Places | None = None
    domain: Domain | None = None
    place: Place = ()
    slack: bool = False


def rods_of(crowd: Crowd) -> list[Lines]:
    """All rods, those of the embedding first."""
    found = [] if crowd.flat else [*hanging(crowd)]
    held = np.zeros(crowd.count, dtype=bool)
    for one in found:
        held[one.ends] = True
    found += bars(crowd, held) if not crowd.flat else []
    found += constrained(crowd)
    return apart(found, crowd.count)


def apart(lines: list[Lines], count: int) -> list[Lines]:
    """Lines between two particles, each pair once."""
    seen, found = np.zeros(0, dtype=np.int64), list[Lines]()
    for one in lines:
        if one.starts is None:
            found.append(one)
            continue
        both = np.minimum(one.starts, one.ends) * count + np.maximum(one.starts, one.ends)
        _, first = np.unique(both, return_index=True)
        new = np.sort(first[~np.isin(both[first], seen)])
        seen = np.concatenate([seen, both[new]])
        if len(new):
            found.append(Lines(one.ends[new], one.starts[new], slack=one.slack))
    return found


# the embedding


def hanging(crowd: Crowd) -> Iterator[Lines]:
    """The rods by which places hang on something."""
    used = np.zeros(crowd.builder.q.count, dtype=np.int64)
    for piece in crowd.pieces:
        for table in {id(slot.table): slot.table for _, slot in inside(crowd, piece)}.values():
            np.add.at(used, table, 1)
    for whole in crowd.pieces:
        slot = next((slot for _, slot in inside(crowd, whole, chains=True)), None)
        roots = np.zeros(whole.domain.count, dtype=bool)
        if slot is not None:
            assert isinstance(slot.array, Chain) and slot.array.tree is not None
            roots = slot.array.tree.parents[slot.table] == NONE
        for kind in (roots, ~roots):
            members = np.flatnonzero(kind)
            if len(members):
                yield from hung(crowd, part_of(crowd, whole, members), used)


def hung(crowd: Crowd, piece: Piece, used: Places) -> Iterator[Lines]:
    """The rods of particles that are written alike, and are roots of a chain all or none."""
    left = np.arange(piece.domain.count)
    here = crowd.of(piece.domain, piece.place)
    for joint, turned in joints(crowd, piece, used):
        if not len(left):
            return
        there = crowd.of(piece.domain, joint)
        reach = lengths((here - there)[left])
        rigid = left[steady(reach) & (reach[:, 0] != 0)]
        owners = crowd.find(there[rigid])
        own = owners != NONE
        if np.any(own):
            yield Lines(piece.numbers[rigid[own]], owners[own])
        left = np.setdiff1d(left, rigid[own])
        free = rigid[~own]
        fixed = len(free) and not any(crowd.moves(one) for one in joint)
        if fixed and not on_a_hoop(crowd, piece, turned):
            part = part_of(crowd, Piece(piece.domain, joint, piece.numbers, piece.family), free)
            yield Lines(piece.numbers[free], None, part.domain, part.place)
            left = np.setdiff1d(left, free)


def joints(crowd: Crowd, piece: Piece, used: Places) -> Iterator[tuple[Place, Place]]:
    """Where a rod may begin, and what it would be: the place without what one coordinate moves, those first
    that few particles have."""
    graph, slots, tried = crowd.graph, crowd.slots, list[tuple[float, Place]]()
    for symbol, slot in inside(crowd, piece):
        joint = tuple(without(graph, one, symbol.symbols) for one in piece.place)
        tried.append((float(used[slot.table].max()), joint))
    links: dict[Node, Node] = {}
    for symbol, slot in inside(crowd, piece, chains=True):
        assert isinstance(slot.array, Chain) and slot.array.tree is not None
        parents = slot.array.tree.parents[slot.table]
        root = parents[0] == NONE
        links[symbol] = graph.zero if root else slots.symbol(piece.domain, slot.array, parents)
    if links:
        tried.append((ALONG_A_CHAIN, tuple(substituted(graph, piece.place, links))))
    for _, joint in sorted(tried, key=lambda one: one[0])[:TRIES]:
        yield joint, tuple(a - b for a, b in zip(piece.place, joint))


def inside(crowd: Crowd, piece: Piece, *, chains: bool = False) -> Iterator[tuple[Node, Slot]]:
    """The coordinates in a place, or the nodes of chains in it."""
    seen = set[Node]()
    for node in piece.place:
        for symbol, slot in crowd.slots.inside(node):
            wanted = (
                isinstance(slot.array, Chain) and crowd.changes(slot)
                if chains
                else (slot.array is crowd.builder.q)
            )
            if wanted and symbol not in seen:
                seen.add(symbol)
                yield symbol, slot


def on_a_hoop(crowd: Crowd, piece: Piece, turned: Place) -> bool:
    """Whether particles at a fixed distance from a point slide on a hoop rather than swing on a rod."""
    if slides(crowd.spec, piece.family.name):
        return True
    alone = len({id(slot.table) for _, slot in inside(crowd, piece)}) == 1
    return alone and any(crowd.timed(one) for one in turned)


def part_of(crowd: Crowd, piece: Piece, members: Places) -> Piece:
    """Some members of a piece."""
    if len(members) == piece.domain.count:
        return piece
    domain = Domain(len(members))
    place = tuple(placed(crowd.slots, one, domain, members) for one in piece.place)
    return Piece(domain, place, piece.numbers[members], piece.family)


def bars(crowd: Crowd, held: Mask) -> list[Lines]:
    """Pairs of particles at a fixed distance that are not both held already."""
    first, second = np.arange(crowd.count - 1), np.arange(1, crowd.count)
    if crowd.count <= PAIRS:
        first, second = np.triu_indices(crowd.count, 1)
    moved = crowd.moved.sum(axis=1) > 0
    both = moved[first] & moved[second] & ~(held[first] & held[second])
    distance = lengths(crowd.places[first] - crowd.places[second])
    kept = both & steady(distance) & (distance[:, 0] > 0)
    return [Lines(second[kept], first[kept])] if np.any(kept) else []


# constraints


def constrained(crowd: Crowd) -> Iterator[Lines]:
    """The rods given by constraints."""
    spec, builder = crowd.spec, crowd.builder
    for family in grouped(spec.constraints, spec.families.get("constraints", {})):
        group = group_of(family, spec.constraints)
        for domain, value, _ in builder.pieces(group, np.arange(group.count)):
            if not isinstance(value, tuple):
                yield from held_by(crowd, domain, value)


def held_by(crowd: Crowd, domain: Domain, node: Node) -> Iterator[Lines]:
    """The rods that constraints which are alike are: the distance of two points is all that they depend on,
    so that their slopes are parallel to those of its square."""
    symbols = [s for s, slot in crowd.slots.inside(node) if crowd.changes(slot)]
    if len(symbols) < 2:
        return
    slopes = crowd.of(domain, tuple(crowd.graph.diff(node, one) for one in symbols))
    left = np.arange(domain.count)
    for start, end in ends_of(crowd, domain, node):
        across = tuple(a - b for a, b in zip(start.place, end.place))
        square = crowd.graph.sum([(one * one, 1.0) for one in across])
        others = crowd.of(domain, tuple(crowd.graph.diff(square, one) for one in symbols))
        sizes = lengths(slopes) * lengths(others)
        dots = np.abs((slopes * others).sum(axis=1))
        good = left[(equal(sizes, dots) & np.any(sizes > 0, axis=1))[left]]
        left = np.setdiff1d(left, good)
        if not len(good):
            continue
        assert end.particles is not None
        if start.particles is not None:
            yield Lines(end.particles[good], start.particles[good])
        elif not slides(crowd.spec, end.name):
            part = part_of(crowd, Piece(domain, start.place, good, crowd.families[0]), good)
            yield Lines(end.particles[good], None, part.domain, part.place)


@dataclass(frozen=True, eq=False)
class End:
    """An end of a distance: a ``place`` of each member of a domain, and the ``particles`` that are there."""

    place: Place
    particles: Places | None = None
    name: str = ""


def ends_of(crowd: Crowd, domain: Domain, node: Node) -> Iterator[tuple[End, End]]:
    """The possible ends of a distance in an expression: two particles, or one and a fixed point."""
    ends = [end for table in crowd.near(domain, node) if (end := end_of(crowd, domain, table)) is not None]
    for end in ends:
        for square in (node, *(one.arguments[0] for one in reachable([node]) if is_root(one))):
            centre = centre_of(crowd.graph, square, end.place, crowd.moves, crowd.is_coordinate)
            if centre is not None:
                yield End(centre), end
    yield from combinations(ends, 2)
    zero = End((crowd.graph.zero,) * crowd.dimension)
    for end in ends:
        yield zero, end


def end_of(crowd: Crowd, domain: Domain, particles: Places) -> End | None:
    """The particles of a table, if all of them are written alike."""
    for piece in crowd.pieces:
        at = np.searchsorted(piece.numbers, particles)
        at = np.minimum(at, len(piece.numbers) - 1)
        if np.array_equal(piece.numbers[at], particles):
            place = tuple(placed(crowd.slots, one, domain, at) for one in piece.place)
            return End(place, particles, piece.family.name)
    return None
