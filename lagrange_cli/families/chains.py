"""What follows from member to member: x[i] = x[i - 1] + .., and sums over all members up to one, or from one
on.

Both are ``Chain`` totals: their terms are built once, and each member knows its parent.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager

import numpy as np

from lagrange_cli.expression.algebra import Value
from lagrange_cli.expression.array_builder import Members
from lagrange_cli.expression.graph_algebra import GraphAlgebra
from lagrange_cli.expression.index_arrays import Differ, Places, Whole, integers
from lagrange_cli.expression.indices import Unsuited
from lagrange_cli.expression.node import Kind, Node
from lagrange_cli.expression.syntax import Sum, names, plain_names, sums
from lagrange_cli.families.arrays import (
    NONE,
    Array,
    Chain,
    Domain,
    Slot,
    Source,
    Term,
    Total,
    merged,
    placed,
    tree_of,
)
from lagrange_cli.families.builder import FamilyBuilder
from lagrange_cli.families.groups import Group, components_in
from lagrange_cli.families.shifted_chains import shifted
from lagrange_cli.mechanics.substitution import substituted
from lagrange_cli.records import dataclass
from lagrange_cli.spec.spec import Spec


@dataclass(frozen=True, eq=False)
class Growing:
    """A group whose members are being built from one another: what stands for their components."""

    group: Group
    parents: tuple[Array, ...]


@dataclass(frozen=True, eq=False)
class Moved:
    """Where the members of a chain are in larger trees: the number of the one ``of`` these ``arrays``, and
    the place in it."""

    arrays: Sequence[Array]
    of: Places
    places: Places


class ChainBuilder(FamilyBuilder):
    """A builder that knows chains and trees."""

    def __init__(self, spec: Spec, algebra: GraphAlgebra | None = None) -> None:
        self._growing: list[Growing] = []
        self._chains: dict[Group, tuple[Chain, ...] | None] = {}
        self._shifts: dict[Chain, Sequence[Term]] = {}
        """How far chains are before their members (``shifted_chains``)."""
        self._moved: dict[Chain, Moved] = {}
        """Chains that are parts of larger trees."""
        self._running: dict[int, tuple[Sum, tuple[Chain, ...]]] = {}
        self._summed: dict[tuple[Group, int], tuple[Node, ...] | None] = {}
        self._begun: dict[tuple[Chain, Node], Chain] = {}
        super().__init__(spec, algebra)

    # members from their parents

    def member(self, group: Group, which: Places, domain: Domain) -> Value:
        for growing in self._growing:
            if growing.group is group:
                return together(self.slots.symbol(domain, one, which) for one in growing.parents)
        arrays = self.chained(group)
        if arrays is None:
            return super().member(group, which, domain)
        return together(self.on(one, which, domain) for one in arrays)

    def on(self, chain: Chain, which: Places, domain: Domain) -> Node:
        """Some members of a chain."""
        node = self.of_chain(chain, which, domain)
        shifts = self._shifts.get(chain, ())
        kinds, at = (np.full(chain.count, NONE, dtype=np.int64) for _ in range(2))
        for k, one in enumerate(shifts):
            kinds[one.targets], at[one.targets] = k, np.arange(one.domain.count)
        mine = kinds[which]
        if np.any(mine != mine[:1]):
            raise Differ(mine)
        if not len(mine) or mine[0] == NONE:
            return node
        return node - placed(self.slots, shifts[mine[0]].node, domain, at[which])

    def of_chain(self, chain: Chain, which: Places, domain: Domain) -> Node:
        """The numbers of a chain itself, or those of the trees that it is a part of."""
        if chain not in self._moved:
            return self.slots.symbol(domain, chain, which)
        moved = self._moved[chain]
        of = moved.of[which]
        if np.any(of != of[:1]):
            raise Differ(of)
        return self.slots.symbol(domain, moved.arrays[of[0]], moved.places[which])

    def move(self, chain: Chain, moved: Moved) -> None:
        """A chain is a part of larger trees from here on."""
        self._moved[chain] = moved

    def restart(self, kept: Iterable[Total]) -> None:
        """Only chains are known from here on, and the totals that are ``kept``."""
        self.totals = [*kept]
        for known in (self._written, self._summed, self._rates):
            known.clear()

    def chained(self, group: Group) -> tuple[Chain, ...] | None:
        """The members of a group that follow from one another; None if they do not, or otherwise."""
        if group not in self._chains:
            own = any(
                one.identifier.partition(".")[0] == group.family.name
                for tree in group.trees
                for one in names(tree)
            )
            known, self._chains[group] = len(self.totals), None
            if own:
                try:
                    self._chains[group] = self.grown(group)
                except Unsuited:
                    del self.totals[known:]
        return self._chains[group]

    def grown(self, group: Group) -> tuple[Chain, ...]:
        """The same. Raises ``Unsuited`` where they follow in another way than by an addition."""
        known = {**self.groups, **self.positions}
        count = max(components_in(tree, known, group) for tree in group.trees)
        arrays = tuple(Array(Source.TOTAL, group.count) for _ in range(count))
        parents = [np.full(group.count, NONE, dtype=np.int64) for _ in arrays]
        terms: list[list[Term]] = [[] for _ in arrays]
        with self.growing(Growing(group, arrays)):
            for domain, value, which in self.pieces(group, np.arange(group.count)):
                parts = value if isinstance(value, tuple) else (value,)
                if len(parts) != count:
                    raise Unsuited
                for k, part in enumerate(parts):
                    found = [(s, slot) for s, slot in self.slots.inside(part) if slot.array in arrays]
                    if found:
                        part, parents[k][which] = self.added_to(part, found, arrays[k])
                    terms[k].append(Term(domain, part, which))
        made = []
        for one, up in zip(terms, parents):
            tree = tree_of(up)
            steps, shifts = shifted(self.slots, self.q, one, tree)
            chain = self.added(group.count, merged(self.slots, steps), tree)
            assert isinstance(chain, Chain)
            self._shifts[chain] = shifts
            made.append(chain)
        return tuple(made)

    def added_to(self, part: Node, found: Sequence[tuple[Node, Slot]], array: Array) -> tuple[Node, Places]:
        """What is added to the parent in ``part``, and who that is."""
        (symbol, slot), *others = found
        rest: Node = part - symbol
        if others or slot.array is not array or rest.symbols & symbol.symbols:
            raise Unsuited
        return rest, slot.table

    @contextmanager
    def growing(self, one: Growing) -> Iterator[None]:
        """A context in which a group's members stand for their parents."""
        self._growing.append(one)
        try:
            yield
        finally:
            self._growing.pop()

    # sums that go on from member to member

    def written(self, group: Group, which: Places, domain: Domain) -> Value:
        tree, members = group.members(which, self.sizes, domain)
        inside = [one for one, around in sums(tree) if not around]
        if not inside or not all(self.runs(one, members) for one in inside):
            return super().written(group, which, domain)
        label = int(group.labels[which[0]])
        own = np.flatnonzero(group.labels == label)
        key = group, label
        if key not in self._summed:
            try:
                whole = Domain(len(own))
                value = self.value(*group.members(own, self.sizes, whole))
                parts = value if isinstance(value, tuple) else (value,)
                self._summed[key] = tuple(self.begun(part) for part in parts)
            except Differ:
                self._summed[key] = None
        known = self._summed[key]
        if known is None:
            return self.value(tree, members)
        places = np.searchsorted(own, which)
        return together(placed(self.slots, part, domain, places) for part in known)

    def begun(self, part: Node) -> Node:
        """What is added to a chain, and is the same for all of its members, as what the chain begins with."""
        graph = self.graph
        chains = [(s, slot) for s, slot in self.slots.inside(part) if isinstance(slot.array, Chain)]
        if len(chains) != 1:
            return part
        symbol, slot = chains[0]
        scale = graph.diff(part, symbol)
        if scale.symbols & symbol.symbols or any(True for _ in self.slots.inside(scale)):
            return part
        common = graph.sum([(one, 1.0) for one in addends(part - scale * symbol) if self.is_common(one)])
        if not common.symbols:
            return part
        assert isinstance(slot.array, Chain)
        start = common / scale
        (start,) = substituted(
            graph,
            [start],
            {
                s: self.slots.symbol(self.root, one.array, one.table[:1])
                for s, one in self.slots.inside(start)
            },
        )
        key = slot.array, start
        if key not in self._begun:
            tree = slot.array.tree
            assert tree is not None
            roots = np.flatnonzero(tree.parents == NONE)
            terms = []
            for term in slot.array.terms:
                first = np.isin(term.targets, roots)
                for which, more in ((~first, False), (first, True)):
                    if np.any(which):
                        members = np.flatnonzero(which)
                        domain = Domain(len(members))
                        node = placed(self.slots, term.node, domain, members)
                        if more:
                            node = node + placed(
                                self.slots, start, domain, np.zeros(len(members), dtype=np.int64)
                            )
                        terms.append(Term(domain, node, term.targets[members]))
            made = self.added(slot.array.count, terms, tree)
            assert isinstance(made, Chain)
            self._begun[key] = made
        other = self.of_chain(self._begun[key], slot.table, slot.domain)
        found: Node = part - common + scale * (other - symbol)
        return found

    def is_common(self, node: Node) -> bool:
        """Whether it is the same for all members, and moves."""
        inside = [slot for _, slot in self.slots.inside(node)]
        if any(isinstance(slot.array, Total) or np.any(slot.table != slot.table[0]) for slot in inside):
            return False
        return bool(node.symbols & self.time.symbols) or any(slot.array is self.q for slot in inside)

    def runs(self, tree: Sum, members: Members) -> bool:
        """Whether a sum has the members of a loop up to one, or from one on, that is different for each."""
        if members.alike is None or tree.conditions or len(tree.bounds) > 2:
            return False
        own = self.own(members)
        moving = [bool(own & plain_names(bound)) for bound in tree.bounds]
        return sum(moving) == 1 and not own & (plain_names(tree.body) - {tree.index})

    def own(self, members: Members) -> frozenset[str]:
        """The names of the members' own indices."""
        return frozenset(members.alike or ()) - self.sizes.keys()

    def summed(self, tree: Sum, members: Members) -> Value:
        if not self.runs(tree, members):
            return super().summed(tree, members)
        assert members.alike is not None
        start, stop = bounds_of(tree, members)
        least, beyond = (np.asarray(one) for one in bounds_of(tree, members.alike))
        first, last = int(least.min()), int(beyond.max())
        empty = np.broadcast_to(np.asarray(stop) <= start, members.count)
        if np.any(empty):
            if not np.all(empty):
                raise Differ(empty.astype(np.int64))
            return self.algebra.graph.zero
        forward = len(tree.bounds) == 1 or not self.own(members) & plain_names(tree.bounds[0])
        if id(tree) not in self._running:
            self._running[id(tree)] = tree, self.run(tree, members, first, last, forward=forward)
        chains = self._running[id(tree)][1]
        at = (np.asarray(stop) - 1 if forward else np.asarray(start)) - first
        places = np.broadcast_to(at.astype(np.int64), members.count)
        return together(self.of_chain(one, places, members.domain) for one in chains)

    def run(self, tree: Sum, members: Members, first: int, last: int, *, forward: bool) -> tuple[Chain, ...]:
        """The sums over all members of the loop from ``first`` on, below ``last``."""
        own, terms = np.arange(first, last, dtype=np.int64), list[list[Term]]()
        found: dict[str, Whole] = {**self.sizes, tree.index: own}
        for mine, value, which in self.each(tree.body, found, len(own), found):
            parts = value if isinstance(value, tuple) else (value,)
            terms += [[] for _ in range(len(parts) - len(terms))]
            for k, part in enumerate(parts):
                terms[k].append(Term(mine.domain, part, which))
        places = np.arange(len(own))
        up = tree_of(places - 1 if forward else np.append(places[1:], NONE))
        made = [self.added(len(own), one, up) for one in terms]
        return tuple(one for one in made if isinstance(one, Chain))


def addends(node: Node) -> list[Node]:
    """The terms of a sum."""
    if node.kind is not Kind.SUM:
        return [node]
    constant, coefficients = node.data
    terms: list[Node] = [float(a) * one for one, a in zip(node.arguments, coefficients)]
    return [*terms, node.graph.lift(constant)]


def bounds_of(tree: Sum, indices: Mapping[str, Whole]) -> tuple[Whole, Whole]:
    """Where the loop of a sum begins and ends."""
    bounds = [integers(bound, indices) for bound in tree.bounds]
    return (0, bounds[0]) if len(bounds) == 1 else (bounds[0], bounds[1])


def together(values: Iterator[Node]) -> Value:
    """Components as a value."""
    found = tuple(values)
    return found if len(found) > 1 else found[0]
