"""The expressions of a system file over arrays: a family is one expression, and a sum one term of a total.

Where members of a sum differ in kind, as a chain's ends do from its middle, each kind is built by itself.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any

import numpy as np

from lagrange_cli.expression.algebra import Value
from lagrange_cli.expression.array_builder import ArrayBuilder, Members
from lagrange_cli.expression.graph_algebra import GraphAlgebra
from lagrange_cli.expression.index_arrays import Places, Whole, flat, of_each_kind, one_if_equal
from lagrange_cli.expression.indices import Unsuited
from lagrange_cli.expression.node import Node
from lagrange_cli.expression.syntax import Sum, sums
from lagrange_cli.expression.syntax import Tree as Syntax
from lagrange_cli.expression.vocabulary import (
    BODY_COMPONENTS,
    COMPONENTS,
    TIME,
    VELOCITY_COMPONENTS,
    velocity_name,
)
from lagrange_cli.families.arrays import Array, Chain, Domain, Slots, Source, Term, Total, Tree, total_of
from lagrange_cli.families.groups import Group, Rows, alike, group_of, particle_families
from lagrange_cli.spec.content import groups_of, names_of
from lagrange_cli.spec.spec import Parameter, Spec, grouped
from lagrange_cli.spec.whole import WrittenFamily

if TYPE_CHECKING:
    from lagrange_cli.families.turning import BodyGroup, Turned

DEEPEST = 3
"""How often members of a family may stand in one another's definitions: x[i] = x[i - 1] + ... is unwound."""


@contextmanager
def recursion(group: Group, within: list[Group]) -> Iterator[None]:
    """A context in which members of a group are built, ``within`` others. Raises ``Unsuited`` where members
    follow from others of their own group, one after the other."""
    if within.count(group) == DEEPEST:
        raise Unsuited
    within.append(group)
    try:
        yield
    finally:
        within.pop()


class FamilyBuilder(ArrayBuilder):
    """Builds the trees of one file over arrays. Raises ``Unsuited`` for what it does not know."""

    def __init__(self, spec: Spec, algebra: GraphAlgebra | None = None) -> None:
        self.algebra: GraphAlgebra
        self.spec = spec
        super().__init__(self._unknown, algebra or GraphAlgebra(), spec.sizes)
        self.graph = self.algebra.graph
        self.slots = Slots(self.graph)
        self.time = self.graph.symbol(TIME)
        count = len(spec.coordinates)
        self.q = Array(Source.COORDINATES, count)
        self.v = Array(Source.VELOCITIES, count)
        self.faster = {self.q: self.v}
        """The rates of coordinates."""
        self.given = Array(Source.PARAMETERS, len(spec.parameters))
        self.whole = Array(Source.WHOLE, 0)
        self.root = Domain(1)
        self.totals: list[Total] = []
        """In the order in which they can be computed."""
        self.rows: dict[str, Rows] = {}
        self.groups: dict[str, Group] = {}
        self.positions: dict[str, Group] = {}
        self.bodies: dict[str, BodyGroup] = {}
        scalars = [one.name for one in groups_of(spec.parameters) if isinstance(one, Parameter)]
        self.parameters = {name: self.algebra.symbol(name) for name in scalars}
        self.within: list[Group] = []
        """The groups whose members are being built."""
        self._written: dict[tuple[int, int], tuple[Total, ...]] = {}
        self._rates: dict[Total, Total | None] = {}
        self._newest: Node | None = None
        """The symbol of the sum that was built last."""
        self._declare(spec)

    def _declare(self, spec: Spec) -> None:
        first = 0
        for family in grouped(names_of(spec.coordinates), spec.coordinate_families):
            self.rows[family.name] = Rows(self.q, first, family)
            self.rows[velocity_name(family.name)] = Rows(self.v, first, family)
            first += len(family.members)
        starts = names_of(spec.parameters).starts
        for one in groups_of(spec.parameters):
            if isinstance(one, WrittenFamily):
                if one.order is not None or not one.family.complete:
                    raise Unsuited
                self.rows[one.name] = Rows(self.given, starts[one.name], one.family)
        for family in grouped(spec.definitions, spec.families.get("definitions", {})):
            self.groups[family.name] = group_of(family, spec.definitions)
        for family in grouped(spec.embedding, particle_families(spec)):
            self.positions[family.name] = group_of(family, spec.embedding)
        if spec.bodies:
            from lagrange_cli.families.turning import body_groups

            self.bodies |= body_groups(spec)

    def _unknown(self, identifier: str) -> Value:
        raise Unsuited

    # names

    def domain(self, count: int) -> Domain:
        return Domain(count)

    def named(self, identifier: str, places: list[Whole], members: Members) -> Value:
        domain: Domain = members.domain
        name, _, component = identifier.partition(".")
        if not component and not places and name in self.parameters:
            return self.parameters[name]
        if name in self.rows:
            if component:
                raise Unsuited
            rows = self.rows[name]
            table = flat(places, rows.family.shape, domain.count) + rows.first
            return self.slots.symbol(domain, rows.array, table)
        group = self.groups.get(name) or self.positions.get(name)
        if group is None:
            raise Unsuited
        which = group.numbers_at(flat(places, group.family.shape, domain.count))
        if np.any(which < 0):
            raise Unsuited
        if component in BODY_COMPONENTS:
            return self.oriented(name, component, which, domain)
        value = self.member(group, which, domain)
        if not component:
            return value
        if not isinstance(value, tuple):
            value = (value,)
        if component in VELOCITY_COMPONENTS:
            return self.rate(value[VELOCITY_COMPONENTS.index(component)], domain)
        if component not in COMPONENTS[: len(value)]:
            raise Unsuited
        return value[COMPONENTS.index(component)]

    def number(self, value: Whole, members: Members) -> Node:
        if not isinstance(value, int):
            value = one_if_equal(value)
        if isinstance(value, int):
            number: Node = self.graph.constant(float(value))
            return number
        least = min(0, int(value.min()))
        symbol: Node = self.slots.symbol(members.domain, self.whole, value - least)
        made: Node = symbol + float(least)
        return made

    def turned(self, name: str, which: Places, domain: Domain) -> Turned:
        """How some bodies of a family turn."""
        if name not in self.bodies:
            raise Unsuited
        return self.bodies[name].turned(self, which, domain)

    def oriented(self, name: str, component: str, which: Places, domain: Domain) -> Node:
        """A component of how they stand or turn (``vocabulary.BODY_COMPONENTS``)."""
        return self.turned(name, which, domain).turning.component(component)

    def member(self, group: Group, which: Places, domain: Domain) -> Value:
        """The members of a group that the members of a domain name."""
        return self.written(group, which, domain)

    def written(self, group: Group, which: Places, domain: Domain) -> Value:
        """The members of a group, for those of a domain. What contains sums is computed once for each."""
        tree, members = group.members(which, self.sizes, domain)
        if not any(True for _ in sums(tree)):
            with recursion(group, self.within):
                return self.value(tree, members)
        label = int(group.labels[which[0]])
        key = id(group), label
        if key not in self._written:
            own = np.flatnonzero(group.labels == label)
            self._written[key] = self.computed(group, own)
        arrays = self._written[key]
        found = tuple(self.slots.symbol(domain, one, which) for one in arrays)
        return found if len(found) > 1 else found[0]

    def computed(self, group: Group, own: Places) -> tuple[Total, ...]:
        """Totals, one for each component, that have the values of these members of a group."""
        terms: list[list[Term]] = []
        for domain, value, which in self.pieces(group, own):
            parts = value if isinstance(value, tuple) else (value,)
            terms += [[] for _ in range(len(parts) - len(terms))]
            for k, part in enumerate(parts):
                terms[k].append(Term(domain, part, which))
        return tuple(self.added(group.count, one) for one in terms)

    def pieces(self, group: Group, own: Places) -> Iterator[tuple[Domain, Value, Places]]:
        """The values of members of a group, of each kind by itself: their domain, and which they are."""

        def alike(which: Places) -> tuple[Domain, Value, Places]:
            domain = Domain(len(which))
            return domain, self.value(*group.members(which, self.sizes, domain)), which

        return of_each_kind(own, alike)

    def with_places(
        self, group: Group, positions: Group, own: Places | None = None
    ) -> Iterator[tuple[Places, Domain, Any, Any]]:
        """The values of the members of a group and the places of the same particles, of each kind by itself:
        which they are, and their domain. ``own`` says which particles they are, if they are not all."""

        def made(which: Places) -> tuple[Places, Domain, Any, Any]:
            domain = Domain(len(which))
            value = self.value(*group.members(which, self.sizes, domain))
            return which, domain, value, self.member(positions, which if own is None else own[which], domain)

        for some in alike(group, positions, own):
            yield from of_each_kind(some, made)

    def added(self, count: int, terms: Sequence[Term], tree: Tree | None = None) -> Total:
        """A total, which can be computed from here on."""
        made = total_of(count, terms, self.graph, tree)
        self.totals.append(made)
        self._newest = None
        return made

    def rate(self, node: Node, domain: Domain) -> Node:
        """The velocity of what depends on coordinates."""
        found: Node = self.graph.diff(node, self.time)
        for symbol, slot in self.slots.inside(node):
            rates: Array | None = None
            if slot.array in (self.q, self.v):
                rates = self.faster.get(slot.array)
                if rates is None:
                    raise Unsuited
            elif isinstance(slot.array, Total):
                rates = self.rates_of(slot.array)
            elif slot.array.source is Source.TOTAL:
                raise Unsuited
            if rates is not None:
                found += self.graph.diff(node, symbol) * self.slots.symbol(domain, rates, slot.table)
        return found

    def rates_of(self, total: Total) -> Total | None:
        """The velocities of all numbers of a total; None where they are 0."""
        if total not in self._rates:
            terms = [Term(one.domain, self.rate(one.node, one.domain), one.targets) for one in total.terms]
            terms = [one for one in terms if not one.node.is_zero]
            tree = total.tree if isinstance(total, Chain) else None
            self._rates[total] = self.added(total.count, terms, tree) if terms else None
        return self._rates[total]

    # sums

    def summed(self, tree: Sum, members: Members) -> Value:
        terms: list[list[Term]] = []
        for mine, value, owners in self.terms(tree, members):
            parts = value if isinstance(value, tuple) else (value,)
            terms += [[] for _ in range(len(parts) - len(terms))]
            for k, part in enumerate(parts):
                terms[k] += self.spread(mine.domain, part, owners)
        if not terms:
            return self.graph.zero
        made = [self.total(members.domain, one) for one in terms]
        return tuple(made) if len(made) > 1 else made[0]

    def total(self, domain: Domain, terms: Sequence[Term]) -> Node:
        """The symbol of a new total of the members of a domain."""
        total = self.added(domain.count, terms)
        self._newest = self.slots.own(domain, total)
        return self._newest

    def spread(self, domain: Domain, node: Node, targets: Places) -> list[Term]:
        """A term; of a sum within a sum, the terms of that one."""
        scale, rest = self.graph.split_coefficient(node)
        if rest is not self._newest:
            return [Term(domain, node, targets)]
        within = self.totals.pop()
        self._newest = None
        return [Term(one.domain, scale * one.node, targets[one.targets]) for one in within.terms]

    def of_root(self, tree: Syntax, indices: Mapping[str, int]) -> Node:
        """A scalar that belongs to no member."""
        value: Any = self._value(tree, Members(self.root, 1, {**self.sizes, **indices}))
        if isinstance(value, tuple):
            raise Unsuited
        node: Node = value
        return node
