"""Chains and trees of particles: which coordinates move what, member by member of a kind.

Each *node* of a tree is its parent's place and what a *joint* adds to it, a function of the few coordinates
of that joint. Particles are at nodes, or where a joint that carries no further one puts them. So the
equations of motion couple a joint to its parent and its children only (see ``native.families.articulated``).
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING

import numpy as np

from lagrange_cli.expression.graph import Graph
from lagrange_cli.expression.index_arrays import Differ, Places, split
from lagrange_cli.expression.indices import Unsuited
from lagrange_cli.expression.node import Node
from lagrange_cli.families.arrays import (
    NONE,
    Array,
    Chain,
    Domain,
    Slot,
    Source,
    Term,
    Total,
    equal,
    placed,
    total_of,
)
from lagrange_cli.families.builder import FamilyBuilder
from lagrange_cli.families.groups import alike, group_of, particle_families
from lagrange_cli.records import dataclass
from lagrange_cli.spec.spec import Spec, grouped

if TYPE_CHECKING:
    from numpy.typing import NDArray

MOST = 3
"""Coordinates of a joint."""
ROUNDS = 4 * MOST
"""By then the coordinates of a joint have found each other."""


@dataclass(frozen=True, eq=False)
class Weight:
    """A mass at a place along one axis: ``move`` behind component number ``component`` of the joint's
    parent, or behind nothing (None)."""

    component: int | None
    move: Node
    mass: Node


@dataclass(frozen=True, eq=False)
class Joints:
    """Joints of one kind, the members of a domain: their ``coordinates`` (rows, and symbols), the nodes that
    are their ``parents`` (None: they hang from what does not move; so do those without weights that have the
    number behind the last node), their own ``nodes`` if they have any and the
    ``moves`` that these add to their parents, and the ``weights`` that they carry besides."""

    domain: Domain
    rows: tuple[Places, ...]
    coordinates: tuple[Node, ...]
    parents: Places | None
    nodes: Places | None
    moves: tuple[Node, ...]
    weights: tuple[Weight, ...]


@dataclass(frozen=True, eq=False)
class Articulation:
    """``nodes`` has their places, and ``rates`` their velocities, and ``inertia`` the masses at them, one
    array for each component."""

    nodes: tuple[Chain, ...]
    rates: tuple[Total | None, ...]
    inertia: tuple[Total, ...]
    joints: tuple[Joints, ...]

    @property
    def parents(self) -> Places:
        """The parent of each node."""
        return (
            self.nodes[0].tree.parents if self.nodes and self.nodes[0].tree else np.zeros(0, dtype=np.int64)
        )

    @property
    def moved(self) -> list[Node]:
        """What coordinates move."""
        return [
            node for one in self.joints for node in (*one.moves, *(weight.move for weight in one.weights))
        ]

    @property
    def count(self) -> int:
        """How many nodes there are."""
        return len(self.parents)


@dataclass(frozen=True, eq=False)
class Part:
    """Something of some members that joints carry: a component of a node (``nodes``: theirs), or a weight
    that hangs from some ``component`` of ``nodes``. ``members`` of the domain, by the joint."""

    domain: Domain
    node: Node
    mass: Node | None
    component: int | None
    nodes: Places | None
    tables: tuple[Places, ...]


def articulation(builder: FamilyBuilder, spec: Spec) -> Articulation:
    """The joints of all particles. Raises ``Unsuited`` where there are others."""
    weights = [*masses_of(builder, spec)]
    chains = chains_of(builder, weights)
    parts: list[Part] = []
    for component, chain in enumerate(chains):
        for term in chain.terms:
            parts.append(
                Part(term.domain, term.node, None, component, term.targets, moved_by(builder, term.node))
            )
    fixed: list[list[Term]] = [[] for _ in chains]
    for domain, x, mass in weights:
        part = carried(builder, chains, domain, x, mass)
        if part is None:
            continue
        if part.tables:
            parts.append(part)
        elif part.nodes is not None and part.component is not None:
            fixed[part.component].append(Term(domain, mass_of(part), part.nodes))
    inertia = tuple(builder.added(chain.count, terms) for chain, terms in zip(chains, fixed))
    rates = tuple(builder.rates_of(chain) for chain in chains)
    made = _Assembly(builder, chains, parts)
    return Articulation(tuple(chains), rates, inertia, tuple(made.joints()))


def mass_of(part: Part) -> Node:
    """The mass of a part that has one."""
    assert part.mass is not None
    return part.mass


def masses_of(builder: FamilyBuilder, spec: Spec) -> Iterator[tuple[Domain, Node, Node]]:
    """The components of all particles' places, and their masses."""
    for family in grouped(spec.embedding, particle_families(spec)):
        group, masses = builder.positions[family.name], group_of(family, spec.masses)
        pending = [*alike(group, masses)]
        while pending:
            which = pending.pop()
            domain = Domain(len(which))
            try:
                mass = builder.value(*masses.members(which, builder.sizes, domain))
                position = builder.member(group, which, domain)
            except Differ as differ:
                pending += split(which, differ)
                continue
            if isinstance(mass, tuple) or not constant(builder, mass):
                raise Unsuited
            for x in position if isinstance(position, tuple) else (position,):
                yield domain, x, mass


def chains_of(builder: FamilyBuilder, weights: Sequence[tuple[Domain, Node, Node]]) -> list[Chain]:
    """The chains that particles are on: all of them have the same nodes."""
    found: dict[Chain, None] = {}
    for _, x, _ in weights:
        for _, slot in builder.slots.inside(x):
            if isinstance(slot.array, Chain) and not constant_total(builder, slot.array):
                found[slot.array] = None
    chains = [*found]
    for one in chains:
        assert one.tree is not None and chains[0].tree is not None
        if not equal(one.tree.parents, chains[0].tree.parents):
            raise Unsuited
        if any(
            isinstance(slot.array, Chain) and slot.array in found
            for t in one.terms
            for _, slot in builder.slots.inside(t.node)
        ):
            raise Unsuited
    return chains


def carried(
    builder: FamilyBuilder, chains: Sequence[Chain], domain: Domain, x: Node, mass: Node
) -> Part | None:
    """A component of particles' places, of that mass; None if it does not move."""
    on = [(s, slot) for s, slot in builder.slots.inside(x) if slot.array in chains]
    if not on:
        tables = moved_by(builder, x)
        if not tables and x.symbols & builder.time.symbols:
            raise Unsuited
        return Part(domain, x, mass, None, None, tables) if tables else None
    (symbol, slot), *others = on
    scale = builder.graph.diff(x, symbol)
    if others or not constant(builder, scale):
        raise Unsuited
    rest = x / scale - symbol
    tables = moved_by(builder, rest)
    if rest.symbols & symbol.symbols or (not tables and not constant(builder, rest)):
        raise Unsuited
    assert isinstance(slot.array, Chain)
    return Part(domain, rest, mass * scale * scale, chains.index(slot.array), slot.table, tables)


def moved_by(builder: FamilyBuilder, node: Node) -> tuple[Places, ...]:
    """The rows of the coordinates in an expression that has nothing else that moves, but t."""
    tables = []
    for _, slot in builder.slots.inside(node):
        if slot.array is builder.q:
            tables.append(slot.table)
        elif slot.array.source not in (Source.PARAMETERS, Source.WHOLE) and not (
            isinstance(slot.array, Total) and constant_total(builder, slot.array)
        ):
            raise Unsuited
    return tuple(tables)


def constant(builder: FamilyBuilder, node: Node) -> bool:
    """Whether it is a constant of the motion."""
    if node.symbols & builder.time.symbols:
        return False
    for _, slot in builder.slots.inside(node):
        if slot.array.source not in (Source.PARAMETERS, Source.WHOLE) and not (
            isinstance(slot.array, Total) and constant_total(builder, slot.array)
        ):
            return False
    return True


def constant_total(builder: FamilyBuilder, total: Total) -> bool:
    """The same of sums."""
    return all(constant(builder, one.node) for one in total.terms)


class _Assembly:
    """Joins the parts that share coordinates."""

    def __init__(self, builder: FamilyBuilder, chains: Sequence[Chain], parts: Sequence[Part]) -> None:
        self.builder, self.chains, self.parts = builder, chains, parts
        self.nodes, self.rows = chains[0].count if chains else 0, builder.q.count
        tree = chains[0].tree if chains else None
        self.parents = tree.parents if tree else np.zeros(0, dtype=np.int64)
        self.joint_of = self.joined()
        """The joint of each node, then of each coordinate."""

    def is_step(self, part: Part) -> bool:
        return part.mass is None

    def joined(self) -> Places:
        """Numbers of joints: nodes and coordinates that meet in a part have one."""
        ones, others = [], []
        for part in self.parts:
            tables = [one + self.nodes for one in part.tables]
            if self.is_step(part) and part.nodes is not None:
                tables.insert(0, part.nodes)
            ones += [tables[0]] * (len(tables) - 1)
            others += tables[1:]
        labels = np.arange(self.nodes + self.rows)
        if ones:
            one, other = np.concatenate(ones), np.concatenate(others)
            for _ in range(ROUNDS):
                before = labels.copy()
                np.minimum.at(labels, one, labels[other])
                np.minimum.at(labels, other, labels[one])
                if np.array_equal(before, labels):
                    break
            else:
                raise Unsuited
        if np.any(labels[: self.nodes] != np.arange(self.nodes)):
            raise Unsuited  # coordinates that move several nodes
        _, numbers = np.unique(labels, return_inverse=True)
        return np.asarray(numbers, dtype=np.int64)

    def columns(self, count: int) -> Iterator[tuple[Part, Places]]:
        """Parts, each at most once in a joint, and which of their members each joint has (-1: none)."""
        for part in self.parts:
            at = part.nodes if self.is_step(part) else part.tables[0] + self.nodes
            assert at is not None
            owners = self.joint_of[at]
            order = np.argsort(owners, kind="stable")
            ranked = owners[order]
            first = np.concatenate([[True], ranked[1:] != ranked[:-1]]) if len(ranked) else np.zeros(0, bool)
            starts = np.maximum.accumulate(np.where(first, np.arange(len(ranked)), 0))
            rank = np.arange(len(ranked)) - starts
            for k in range(int(rank.max(initial=-1)) + 1):
                member = np.full(count, NONE, dtype=np.int64)
                member[ranked[rank == k]] = order[rank == k]
                yield part, member

    def joints(self) -> Iterator[Joints]:
        """All joints, each kind together."""
        count = int(self.joint_of.max()) + 1
        node_of = np.full(count, NONE, dtype=np.int64)
        node_of[self.joint_of[: self.nodes]] = np.arange(self.nodes)
        sizes = np.bincount(self.joint_of[self.nodes :], minlength=count)
        if sizes.max(initial=0) > MOST:
            raise Unsuited
        columns = [*self.columns(count)]
        parent_of = np.full(count, NONE, dtype=np.int64)
        has_node = node_of != NONE
        parent_of[has_node] = self.parents[node_of[has_node]]
        own = np.zeros((len(columns), count), dtype=np.int64)
        for k, (part, member) in enumerate(columns):
            if self.is_step(part) or part.nodes is None:
                continue
            which = member != NONE
            hung = part.nodes[member[which]]
            mine = hung == node_of[which]
            leaf = ~has_node[which]
            known = parent_of[which]
            if np.any(~mine & ~leaf & (hung != known)) or np.any(leaf & (known != NONE) & (hung != known)):
                raise Unsuited
            parent_of[np.flatnonzero(which)[leaf]] = hung[leaf]
            own[k, which] = mine
        weighs = np.any(
            [one != NONE for part, one in columns if not self.is_step(part)] or [has_node & False], axis=0
        )
        hangs = (parent_of != NONE) | (
            has_node & ~weighs
        )  # what carries no weights may hang from nothing, too
        signature = np.array(
            [has_node, hangs, sizes, *(one != NONE for _, one in columns), *own], dtype=np.int64
        )
        _, kinds = np.unique(signature.T, axis=0, return_inverse=True)
        kinds = np.asarray(kinds).reshape(-1)
        for kind in range(int(kinds.max()) + 1):
            which = np.flatnonzero(kinds == kind)
            here = [(part, one[which], bool(own[k, which[0]])) for k, (part, one) in enumerate(columns)]
            here = [one for one in here if one[1][0] != NONE]
            yield self.kind(which, here, node_of[which], parent_of[which], int(sizes[which[0]]))

    def kind(
        self,
        which: Places,
        parts: Sequence[tuple[Part, Places, bool]],
        nodes: Places,
        parents: Places,
        size: int,
    ) -> Joints:
        """Joints that are alike."""
        domain, graph = Domain(len(which)), self.builder.graph
        moves = [graph.zero for _ in self.chains]
        weights: list[Weight] = []
        for part, members, _ in parts:
            if self.is_step(part) and part.component is not None:
                moves[part.component] = placed(self.builder.slots, part.node, domain, members)
        for part, members, own in parts:
            if part.mass is not None:
                move, mass = (
                    placed(self.builder.slots, one, domain, members) for one in (part.node, part.mass)
                )
                if own and part.component is not None:
                    move = moves[part.component] + move
                weights.append(Weight(part.component, move, mass))
        symbols: dict[Node, Slot] = {}
        for node in (*moves, *(one.move for one in weights)):
            inside = self.builder.slots.inside(node)
            symbols |= {symbol: slot for symbol, slot in inside if slot.array is self.builder.q}
        has_node = nodes[0] != NONE
        if len(symbols) != size or (not size and not has_node):
            raise Unsuited
        if not has_node and not size:
            raise Unsuited
        return Joints(
            domain, tuple(slot.table for slot in symbols.values()), tuple(symbols),
            None if np.all(parents == NONE) else np.where(parents == NONE, self.nodes, parents),
            nodes if has_node else None,
            tuple(moves) if has_node else (), tuple(weights),
        )  # fmt: skip


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
        for symbol, rows in zip(one.coordinates, one.rows):
            p = graph.zero
            for move, total in zip(one.moves, carried):
                assert one.nodes is not None
                p = p + graph.diff(move, symbol) * slots.symbol(one.domain, total, one.nodes)
            for weight in one.weights:
                p = p + graph.diff(weight.move, symbol) * weight.mass * speed(builder, found, one, weight)
            terms.append(Term(one.domain, p, rows))
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
        for weight in one.weights:
            v = speed(builder, found, one, weight)
            yield Term(one.domain, 0.5 * weight.mass * v * v, np.zeros(one.domain.count, dtype=np.int64))


def felt(builder: FamilyBuilder, found: Articulation, pushes: Sequence[Sequence[Term]]) -> Iterator[Term]:
    """What acts on nodes, as coordinates feel it: F . dr/dq_k of all that a joint carries."""
    for chain, terms in zip(found.nodes, pushes):
        if terms:
            whole = total_of(chain.count, terms, builder.graph, chain.tree, back=True)
            builder.totals.append(whole)
            for step in chain.terms:
                push = builder.slots.symbol(step.domain, whole, step.targets)
                for symbol, slot in builder.slots.inside(step.node):
                    if slot.array is builder.q:
                        yield Term(step.domain, push * builder.graph.diff(step.node, symbol), slot.table)


def curved(graph: Graph, found: Articulation, count: int) -> NDArray[np.bool_]:
    """The coordinates (``count`` of them) that T depends on, or may."""
    curved = np.zeros(count, dtype=bool)
    for one in found.joints:
        nodes = (*one.moves, *(weight.move for weight in one.weights))
        for symbol, rows in zip(one.coordinates, one.rows):
            slopes = [graph.diff(node, other) for node in nodes for other in one.coordinates]
            if any(slope.symbols & symbol.symbols for slope in slopes):
                curved[rows] = True
    return curved
