"""Constraints of families: expressions that stay 0, each once for all members that are written alike.

Holonomic ones f(q, t) act by A = df/dq, those g(q, q_dot, t) on velocities, which are linear in these, by A =
dg/dq_dot (d'Alembert's principle; see ``mechanics.constraints``). All of them make one system of equations.
Multipliers are found from A M^-1 A^T, where A has the slopes of the constraints and M is diagonal: it couples
constraints that have a coordinate in common. A constraint that contains a sum over members has a term for
each of these. It is coupled to many others, and eliminated last, as the border of the matrix.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from functools import cached_property

import numpy as np

from lagrange_cli.expression.graph import Graph
from lagrange_cli.expression.index_arrays import Places, distinct
from lagrange_cli.expression.indices import Unsuited
from lagrange_cli.expression.node import Kind, Node
from lagrange_cli.families.arrays import NONE, Chain, Domain, Slots, Source, Term, Total
from lagrange_cli.families.builder import FamilyBuilder
from lagrange_cli.families.elimination import DENSE, Blocks, elimination_of, in_blocks
from lagrange_cli.families.groups import group_of
from lagrange_cli.families.joints.joints import Articulation
from lagrange_cli.families.joints.responses import Responses, responses, trees_of
from lagrange_cli.families.tables import in_groups
from lagrange_cli.mechanics.substitution import substituted
from lagrange_cli.model.sparse import SparseElimination
from lagrange_cli.records import dataclass
from lagrange_cli.spec.family import Family
from lagrange_cli.spec.spec import Expression, Spec, grouped

MOST = 64
"""Constraints that are coupled to each up to which members are not written out, where M is diagonal."""


@dataclass(frozen=True, eq=False)
class Hold:
    """Nodes of chains that constraints contain, or sums of coordinates: a ``component`` of those at these
    ``places`` (a number of ``Articulation.places``), its ``symbol`` in the constraints, or that of its
    velocity, and the derivative by it."""

    component: int
    places: Places
    symbol: Node
    slope: Node


@dataclass(frozen=True, eq=False)
class Bound:
    """Constraints that are alike, the members of a ``domain``: ``node`` = 0, of these ``numbers``. They act
    on the coordinates at these ``rows``: ``symbols`` are those of coordinates, or of velocities if they are
    not ``holonomic``, and ``slopes`` the derivatives by these. ``speed`` is the rate of ``node``, or itself.
    Where they are not ``whole``, they are terms of constraints: all of those with the same number add up to
    0. ``holds`` has the nodes of chains in them."""

    domain: Domain
    node: Node
    numbers: Places
    rows: tuple[Places, ...]
    symbols: tuple[Node, ...]
    slopes: tuple[Node, ...]
    speed: Node
    whole: bool = True
    holds: tuple[Hold, ...] = ()
    holonomic: bool = True

    def at_rest(self, graph: Graph) -> Node:
        """A constraint on velocities where these are 0."""
        symbols = [*self.symbols, *(one.symbol for one in self.holds)]
        return substituted(graph, [self.node], dict.fromkeys(symbols, graph.zero))[0]


@dataclass(frozen=True, eq=False)
class CoupledMembers:
    """Members of two bounds with a coordinate in common: its ``rows``. ``first`` and ``second`` are the
    numbers of a bound and of one of its slopes, ``members`` those of both, and ``entries`` where the products
    go."""

    first: tuple[int, int]
    second: tuple[int, int]
    members: tuple[Places, Places]
    rows: Places
    entries: Places


@dataclass(frozen=True, eq=False)
class Bonds:
    """The ``bounds`` of a system, and the ``names`` of all constraints, so many ``holonomic`` ones first.
    The ``multipliers`` are computed from all equations together, and have no terms. On chains and trees,
    the ``responses`` say what is coupled. The numbers ``surplus`` are those of constraints that follow from
    others in turn (see ``native.linear.dependent``), in groups of those that are ``tied``."""

    bounds: tuple[Bound, ...]
    names: Sequence[str]
    multipliers: Total
    holonomic: int
    responses: Responses | None = None
    surplus: frozenset[int] = frozenset()
    tied: tuple[tuple[int, ...], ...] = ()

    @property
    def count(self) -> int:
        """The number of constraints."""
        return len(self.names)

    @property
    def terms(self) -> int:
        """How many terms they have together, where one that is no sum is a term."""
        return sum(one.domain.count for one in self.bounds)

    @cached_property
    def summed(self) -> Places:
        """The numbers of constraints that have several terms."""
        found = [one.numbers for one in self.bounds if not one.whole]
        return distinct(np.concatenate(found)) if found else np.zeros(0, dtype=np.int64)

    @cached_property
    def values(self) -> Total:
        """What should be 0."""
        terms = tuple(Term(one.domain, one.node, one.numbers) for one in self.bounds)
        return Total(Source.TOTAL, self.count, terms)

    @cached_property
    def pulls(self) -> Sequence[tuple[int, int]]:
        """All slopes, each the number of a bound and its own."""
        return [(b, a) for b, one in enumerate(self.bounds) for a, _ in enumerate(one.slopes)]

    def pulls_on_coordinates(self, slots: Slots) -> Iterator[Term]:
        """A^T lambda on coordinates."""
        for b, a in self.pulls:
            one = self.bounds[b]
            yield Term(one.domain, one.slopes[a] * self.multipliers_of(slots, one), one.rows[a])

    def multipliers_of(self, slots: Slots, bound: Bound) -> Node:
        """lambda of the members of a bound."""
        return slots.symbol(bound.domain, self.multipliers, bound.numbers)

    def idle(self, graph: Graph) -> bool:
        """Whether those on velocities hold at rest, where their forces do no work."""
        return all(one.holonomic or one.at_rest(graph).is_zero for one in self.bounds)

    @property
    def nodes(self) -> Iterator[Node]:
        """What the equations of motion have of them."""
        for one in self.bounds:
            yield one.node
            yield from one.slopes
            yield from (hold.slope for hold in one.holds)

    @cached_property
    def pairs(self) -> tuple[Sequence[CoupledMembers], Places]:
        """What A M^-1 A^T is made of, and the constraints (entries, 2) of each of its entries on the diagonal
        and below. Raises ``Unsuited`` where these are too many."""
        slots = self.pulls
        rows = np.concatenate([self.bounds[b].rows[a] for b, a in slots])
        numbers = np.concatenate([self.bounds[b].numbers for b, _ in slots])
        kinds = np.repeat(np.arange(len(slots)), [self.bounds[b].domain.count for b, _ in slots])
        members = np.concatenate([self.bounds[b].domain.every for b, _ in slots])
        order = np.argsort(rows, kind="stable")
        _, starts, degrees = np.unique(rows[order], return_index=True, return_counts=True)
        if int(np.sum(degrees**2)) > MOST * len(rows):
            raise Unsuited
        times, begins = np.repeat(degrees, degrees), np.repeat(starts, degrees)
        one, within = in_groups(times)
        first, second = order[one], order[begins[one] + within]
        below = numbers[first] >= numbers[second]
        first, second = first[below], second[below]
        keys, entries = np.unique(numbers[first] * self.count + numbers[second], return_inverse=True)
        found, which = np.unique(kinds[first] * len(slots) + kinds[second], return_inverse=True)
        made = []
        for k, key in enumerate(found.tolist()):
            mine = np.flatnonzero(which == k)
            mine = mine[np.lexsort((members[second[mine]], members[first[mine]]))]
            both = members[first[mine]], members[second[mine]]
            pair = slots[key // len(slots)], slots[key % len(slots)]
            made.append(CoupledMembers(*pair, both, rows[first[mine]], entries[mine]))
        return made, np.stack(np.divmod(keys, self.count), axis=1)

    @cached_property
    def elimination(self) -> SparseElimination | None:
        """How A M^-1 A^T is factored; None where it is taken as dense. Raises ``Unsuited`` where L has too
        many numbers."""
        return elimination_of(self.count, self.places_of_entries)

    @cached_property
    def blocks(self) -> Blocks:
        """How it is factored in blocks, as far as constraints are tied. Raises ``Unsuited`` likewise."""
        return in_blocks(self.count, self.places_of_entries, self.tied, 0)

    @property
    def places_of_entries(self) -> Places:
        """The constraints (entries, 2) of the entries of A M^-1 A^T, on the diagonal and below."""
        return self.pairs[1] if self.responses is None else self.responses.places


def unbound() -> Bonds:
    """No constraints."""
    return Bonds((), (), Total(Source.TOTAL, 0), 0)


def bound_families(spec: Spec) -> Iterator[tuple[Family, Mapping[str, Expression], bool]]:
    """The families of constraints, the section that each is in, and whether that has the holonomic ones."""
    for part, holonomic in (("constraints", True), ("nonholonomic", False)):
        section = getattr(spec, part)
        for family in grouped(section, spec.families.get(part, {})):
            yield family, section, holonomic


def bonds(builder: FamilyBuilder, spec: Spec, joints: Articulation | None = None) -> Bonds | None:
    """The constraints without those that are left out; None where there are none. On chains and trees they
    may contain the places of nodes. Raises ``Unsuited`` where they are of another kind, or many there."""
    found, names, count = list[Bound](), list[str](), 0
    left = {*spec.left_out}
    for family, section, holonomic in bound_families(spec):
        group = group_of(family, section)
        kept = [i for i, name in enumerate(family.members) if name not in left]
        own, numbers = np.array(kept, dtype=np.int64), np.zeros(group.count, dtype=np.int64)
        numbers[own] = np.arange(len(names), len(names) + len(own))
        names += [family.members[i] for i in kept] if left else family.members
        count += holonomic * len(own)
        for domain, value, which in builder.pieces(group, own) if len(own) else ():
            if isinstance(value, tuple):
                raise Unsuited
            found += bounds_of(builder, domain, value, numbers[which], joints, holonomic)
    bound = [np.zeros(0, dtype=np.int64), *(one.numbers for one in found if one.rows or one.holds)]
    if len(distinct(np.concatenate(bound))) < len(names):
        raise Unsuited  # no coordinate is in one of them
    multipliers = Total(Source.TOTAL, len(names))
    felt = responses_of(found, len(names), builder.q.count, joints) if names and joints is not None else None
    place = {name: i for i, name in enumerate(names)} if spec.in_turn else {}
    surplus = frozenset(place[name] for name in spec.in_turn if name in place)
    tied = (
        tuple(tuple(place[name] for name in group if name in place) for group in spec.tied) if place else ()
    )
    return Bonds(tuple(found), names, multipliers, count, felt, surplus, tied) if names else None


def responses_of(found: Sequence[Bound], count: int, coordinates: int, joints: Articulation) -> Responses:
    """Which of so many constraints on ``coordinates`` are coupled on chains and trees."""
    placed, moved = trees_of(joints, coordinates)
    touched = [(one.numbers, moved[rows]) for one in found for rows in one.rows]
    touched += [(one.numbers, placed[hold.component][hold.places]) for one in found for hold in one.holds]
    forest = 1 + max(int(one.max(initial=NONE)) for one in (*placed, moved))
    return responses(touched, count, forest, DENSE)


def bounds_of(
    builder: FamilyBuilder,
    domain: Domain,
    value: Node,
    numbers: Places,
    joints: Articulation | None,
    holonomic: bool,
) -> Iterator[Bound]:
    """Constraints that are alike, and those terms of them that are sums."""
    graph, slots = builder.graph, builder.slots
    chains = () if joints is None else (*joints.places, *joints.speeds)
    inside = [(s, slot) for s, slot in slots.inside(value) if slot.array not in chains]
    sums = [(s, slot) for s, slot in inside if isinstance(slot.array, Total) and moves(builder, slot.array)]
    for s, slot in sums:
        factor, total = graph.diff(value, s), slot.array
        if factor.kind is not Kind.NUMBER or isinstance(total, Chain) or not isinstance(total, Total):
            raise Unsuited
        number = np.full(total.count, NONE)
        number[slot.table] = numbers
        if len(distinct(slot.table)) < len(slot.table):
            raise Unsuited
        for term in total.terms:
            mine = number[term.targets]
            if np.any(mine == NONE):
                raise Unsuited
            yield bound_of(builder, term.domain, factor * term.node, mine, joints, holonomic, whole=False)
    (rest,) = substituted(graph, [value], {s: graph.zero for s, _ in sums})
    if not rest.is_zero:
        yield bound_of(builder, domain, rest, numbers, joints, holonomic, whole=not sums)


def bound_of(
    builder: FamilyBuilder,
    domain: Domain,
    node: Node,
    numbers: Places,
    joints: Articulation | None,
    holonomic: bool,
    *,
    whole: bool,
) -> Bound:
    """Constraints, or terms of them, without sums."""
    graph, slots = builder.graph, builder.slots
    nodes = joints.places if joints else ()
    rates = joints.speeds if joints else ()
    own, chains = (builder.q, nodes) if holonomic else (builder.v, rates)
    inside = [(s, slot) for s, slot in slots.inside(node) if slot.array is own]
    holds = tuple(
        Hold(chains.index(slot.array), slot.table, s, graph.diff(node, s))
        for s, slot in slots.inside(node)
        if isinstance(slot.array, Chain) and slot.array in chains
    )
    known = builder.q, builder.given, builder.whole, *nodes
    moving = () if holonomic else (builder.v, *rates)
    others = [slot.array for _, slot in slots.inside(node) if slot.array not in (*known, *moving)]
    if any(not isinstance(one, Total) or moves(builder, one) for one in others):
        raise Unsuited
    still = not (node.symbols & builder.time.symbols or slots.moving(node, {builder.q, *nodes}))
    if not inside and not holds and (whole or not still):
        raise Unsuited
    symbols, rows = tuple(s for s, _ in inside), tuple(slot.table for _, slot in inside)
    slopes = tuple(graph.diff(node, one) for one in symbols)
    curving = (*slopes, *(one.slope for one in holds))
    if any(slot.array in moving for one in curving for _, slot in slots.inside(one)):
        raise Unsuited  # not linear in the velocities
    speed = builder.rate(node, domain) if holonomic else node
    return Bound(domain, node, numbers, rows, symbols, slopes, speed, whole, holds, holonomic)


def moves(builder: FamilyBuilder, total: Total) -> bool:
    """Whether sums depend on the motion, or on t."""
    moving = builder.time.symbols | builder.slots.symbols_of(builder.q, builder.v)
    nodes = builder.slots.made_of([one.node for one in total.terms])
    return any(one.symbols & moving for one in nodes)
