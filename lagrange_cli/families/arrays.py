"""Expressions of many members at once: each is written once, over symbols that stand for one number of each.

A ``Domain`` has members: all pairs of bodies, all springs of a chain. What an expression has of each of them
are ``Slot`` symbols: the number of an ``Array`` at the place that a table lists for the member. A ``Total``
is an array of sums: every ``Term`` adds, for each member of its domain, an expression to the place that the
table of its targets lists.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from enum import Enum
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from lagrange_cli.expression.graph import Graph
from lagrange_cli.expression.indices import Unsuited
from lagrange_cli.expression.node import Kind, Node, bits, union
from lagrange_cli.mechanics.substitution import substituted
from lagrange_cli.records import dataclass, field

if TYPE_CHECKING:
    from lagrange_cli.expression.index_arrays import Places


NONE = -1
"""No member."""
LOOKED_AT = 64
"""Numbers of a long table that are looked at first."""


class Source(Enum):
    """Where the numbers of an array are from."""

    COORDINATES = "q"
    VELOCITIES = "v"
    PARAMETERS = "parameters"
    WHOLE = "whole numbers, 0 and up"
    MODES = "modes of switches"
    TOTAL = "total"


@dataclass(frozen=True, eq=False)
class Array:
    """Numbers side by side, ``count`` of them."""

    source: Source
    count: int


@dataclass(frozen=True, eq=False)
class Domain:
    """Members that are looked at together."""

    count: int

    @cached_property
    def every(self) -> Places:
        """The numbers of all members: the table of what each of them has of its own."""
        return np.arange(self.count)

    @cached_property
    def together(self) -> Places:
        """The table of what all of them have in common: the first number of an array."""
        return np.zeros(self.count, dtype=np.int64)


@dataclass(frozen=True, eq=False)
class Slot:
    """What the members of a ``domain`` have of an array: what is at the places of ``table`` (members,)."""

    domain: Domain
    array: Array
    table: Places


@dataclass(frozen=True, eq=False)
class Term:
    """``node`` of each member of ``domain``, added at the places ``targets`` (members,)."""

    domain: Domain
    node: Node
    targets: Places


@dataclass(frozen=True, eq=False)
class Total(Array):
    """Sums of terms."""

    terms: tuple[Term, ...] = ()


@dataclass(frozen=True, eq=False)
class Tree:
    """``parents`` has the parent of each member, ``NONE`` where there is none, and ``order`` the members,
    parents before their children."""

    parents: Places
    order: Places

    @cached_property
    def is_chain(self) -> bool:
        """Whether each member is the parent of the next one."""
        numbers = np.arange(len(self.order))
        return np.array_equal(self.order, numbers) and np.array_equal(self.parents[1:], numbers[:-1])


@dataclass(frozen=True, eq=False)
class Chain(Total):
    """Sums of terms that add up along a chain or a tree: to each one, that of its parent is added. If it goes
    ``back``, each one is added to that of its parent instead, from the tips on."""

    tree: Tree | None = None
    back: bool = False


@dataclass
class Slots:
    """The symbols of one system's slots in its graph: equal slots are one symbol."""

    graph: Graph
    of: dict[Node, Slot] = field(default_factory=dict)
    known: dict[tuple[int, int, int], list[Node]] = field(default_factory=dict)
    by_bit: dict[int, Node] = field(default_factory=dict)

    def symbol(self, domain: Domain, array: Array, table: Places) -> Node:
        """The symbol of a slot."""
        key = id(domain), id(array), digest(table)
        for node in self.known.setdefault(key, []):
            if equal(self.of[node].table, table):
                return node
        node = self.graph.symbol(f"slot {len(self.of)}")
        self.of[node] = Slot(domain, array, table)
        self.known[key].append(node)
        self.by_bit[node.symbols.bit_length() - 1] = node
        return node

    def own(self, domain: Domain, array: Array) -> Node:
        """The symbol of an array that has a number for each member of a domain."""
        return self.symbol(domain, array, domain.every)

    def inside(self, node: Node) -> Iterator[tuple[Node, Slot]]:
        """The slots that an expression contains."""
        for bit in bits(node.symbols):
            if bit in self.by_bit:
                symbol = self.by_bit[bit]
                yield symbol, self.of[symbol]

    def symbols_of(self, *arrays: Array, totals: bool = False) -> int:
        """The symbols of numbers of these arrays, and of all ``totals``, as a bit set."""
        chosen = {*arrays}
        return union(
            symbol
            for symbol, slot in self.of.items()
            if slot.array in chosen or (totals and isinstance(slot.array, Total))
        )

    def made_of(self, nodes: Iterable[Node]) -> list[Node]:
        """Expressions, and the terms of all sums that they contain."""
        found = dict.fromkeys(nodes)
        pending = [*found]
        for node in pending:
            totals = [slot.array for _, slot in self.inside(node) if isinstance(slot.array, Total)]
            inner = dict.fromkeys(one.node for total in totals for one in total.terms)
            pending += [one for one in inner if one not in found]
            found |= inner
        return pending

    def moving(self, node: Node, moves: set[Array]) -> bool:
        """Whether an expression contains a slot of one of these arrays."""
        return any(slot.array in moves for _, slot in self.inside(node))


def placed(slots: Slots, node: Node, domain: Domain, members: Places) -> Node:
    """An expression of some members of its domain, as one of the members of another."""
    others = {
        symbol: slots.symbol(domain, slot.array, slot.table[members]) for symbol, slot in slots.inside(node)
    }
    return substituted(slots.graph, [node], others)[0] if others else node


def digest(table: Places) -> int:
    """What equal tables have in common, and most others have not: a few of the numbers."""
    return hash(table[:: max(1, len(table) // LOOKED_AT)].tobytes())


def equal(one: Places, other: Places) -> bool:
    """Whether tables are equal."""
    return one is other or np.array_equal(one, other)


def total_of(
    count: int, terms: Iterable[Term], graph: Graph, tree: Tree | None = None, *, back: bool = False
) -> Total:
    """The sums of these terms, along a ``tree`` if there is one; those of one domain at the same places are
    one, and those that are 0 none."""
    found: dict[tuple[int, int], list[Term]] = {}
    for term in terms:
        if term.domain.count == 0:
            continue
        same = found.setdefault((id(term.domain), digest(term.targets)), [])
        for i, one in enumerate(same):
            if equal(one.targets, term.targets):
                same[i] = Term(one.domain, one.node + term.node, one.targets)
                break
        else:
            same.append(term)
    listed = [one for same in found.values() for one in same if not one.node.is_zero]
    if tree is not None:
        return Chain(Source.TOTAL, count, tuple(listed), tree, back)
    return Total(Source.TOTAL, count, tuple(listed))


def opposite(terms: Iterable[Term]) -> list[Term]:
    """Terms with the other sign."""
    return [Term(one.domain, -one.node, one.targets) for one in terms]


def merged(slots: Slots, terms: Sequence[Term]) -> list[Term]:
    """Terms that are alike but for where their slots are, as one: what a chain begins with may be like what
    it goes on with."""
    graph, found = slots.graph, dict[tuple[Node, tuple[int, ...]], list[tuple[Term, list[Slot]]]]()
    for term in terms:
        inside = [*slots.inside(term.node)]
        stand_ins = {symbol: graph.symbol(f"place {k}") for k, (symbol, _) in enumerate(inside)}
        (shape,) = substituted(graph, [term.node], stand_ins)
        key = shape, tuple(id(slot.array) for _, slot in inside)
        found.setdefault(key, []).append((term, [slot for _, slot in inside]))
    made = []
    for (shape, _), alike in found.items():
        if len(alike) == 1:
            made.append(alike[0][0])
            continue
        targets = np.concatenate([term.targets for term, _ in alike])
        order, domain = np.argsort(targets), Domain(len(targets))
        others = {}
        for k, same in enumerate(zip(*(listed for _, listed in alike))):
            table = np.concatenate([slot.table for slot in same])[order]
            others[graph.symbol(f"place {k}")] = slots.symbol(domain, same[0].array, table)
        (node,) = substituted(graph, [shape], others)
        made.append(Term(domain, node, targets[order]))
    return made


def tree_of(parents: Places) -> Tree:
    """The tree of these parents. Raises ``Unsuited`` where a member is its own ancestor."""
    count = len(parents)
    members = np.arange(count)
    if np.all(parents < members):
        return Tree(parents, members)
    if np.all((parents > members) | (parents == NONE)):
        return Tree(parents, members[::-1].copy())
    children: list[list[int]] = [[] for _ in range(count)]
    order: list[int] = []
    for member, parent in enumerate(parents.tolist()):
        (order if parent == NONE else children[parent]).append(member)
    for member in order:
        order += children[member]
    if len(order) < count:
        raise Unsuited
    return Tree(parents, np.array(order, dtype=np.int64))


def number_of(total: Total) -> Node | None:
    """The number that a total of one is, where it is made of nothing else."""
    if total.count != 1 or any(
        one.domain.count != 1 or one.node.kind is not Kind.NUMBER for one in total.terms
    ):
        return None
    nodes = [one.node for one in total.terms]
    return nodes[0].graph.sum([(one, 1.0) for one in nodes]) if nodes else None
