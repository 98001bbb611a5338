"""Energies of families that do not jump: what members have in common shows it for all of them.

An expression is looked at once for all members that share it, with a symbol for each of their numbers. What
is continuous whatever these symbols are is so for every member, and so are sums of such terms (see
``mechanics.switching.jumps`` for what must not jump). Where this shows nothing, members are looked at.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping

import numpy as np

from lagrange_cli.errors import TooLarge
from lagrange_cli.expression.graph_algebra import GraphAlgebra, KnownParameters
from lagrange_cli.expression.index_arrays import Differ
from lagrange_cli.expression.indices import Unsuited
from lagrange_cli.expression.node import Node
from lagrange_cli.expression.syntax import ExpressionError, calls, names
from lagrange_cli.expression.syntax import Tree as Syntax
from lagrange_cli.expression.vocabulary import KINKED
from lagrange_cli.families.arrays import Array, Domain, Total
from lagrange_cli.families.bonds import bound_families
from lagrange_cli.families.chains import ChainBuilder
from lagrange_cli.families.groups import Group, group_of
from lagrange_cli.families.written_events import arguments_of
from lagrange_cli.mechanics.switching.jumping_values import Array as Values
from lagrange_cli.mechanics.switching.jumping_values import jumping
from lagrange_cli.mechanics.switching.jumps import Case, Continuous, cases, is_certain, sides, switching
from lagrange_cli.mechanics.switching.switches import vanishes_with
from lagrange_cli.spec.content import groups_by_name, names_of, written
from lagrange_cli.spec.spec import Spec, distinct

FEWEST = 12
"""Coordinates below which members are looked at one by one, which takes no longer."""


def continuous(spec: Spec, parameters: Mapping[str, float] | None = None) -> bool:
    """Whether it is certain that nothing jumps that must not: with these values of the parameters, or with
    any. False also where that is not known."""
    if not spec.coordinate_families or len(spec.coordinates) < FEWEST or spec.replaced:
        return False
    try:
        symbolic = Templates(spec, GraphAlgebra())
        left = [*symbolic.unproven()]
        if not left or parameters is None or any(map(symbolic.is_certain, left)):
            return not left
        return Templates(spec, KnownParameters(parameters)).continuous_with(parameters)
    except (Unsuited, Differ, ExpressionError, TooLarge, ArithmeticError):
        return False


class Templates:
    """What must not jump, each expression once for all members that share it. Raises ``Unsuited`` for what
    has to be looked at member by member."""

    def __init__(self, spec: Spec, algebra: GraphAlgebra) -> None:
        self.spec, self.builder = spec, ChainBuilder(spec, algebra)
        self.graph, self.slots, self.time = self.builder.graph, self.builder.slots, self.builder.time
        sections = spec.definitions, spec.embedding
        shared = [one.tree for section in sections for one in distinct(written(section))]
        self._names = {name for one in sections for name in groups_by_name(one)}
        self._shared = any(calls(one, KINKED) for one in shared)
        if any(calls(x.tree, KINKED) for one in spec.bodies.values() for x in one.expressions):
            raise Unsuited
        self.found = [*self._energies(), *self._positions(), *self._events(), *self._constraints()]

    @property
    def moving(self) -> int:
        """The symbols that change as the system moves."""
        moving: int = self.time.symbols
        return moving | self._numbers(self.builder.q, self.builder.v)

    def unproven(self) -> Iterator[Case]:
        """The switches on which something may jump."""
        for case in cases(self.graph, self.found):
            one, u, _, part = case
            above, below = sides(self.graph, part, u)
            if one.moves and not u.symbols & self.moving & ~self.time.symbols:
                yield case  # it may change infinitely fast
            elif not vanishes_with(self.graph, above - below, u):
                yield case

    def is_certain(self, case: Case) -> bool:
        """Whether there is a jump, unless a parameter is 0."""
        _, u, _, part = case
        return is_certain(self.graph, *sides(self.graph, part, u), u, self.moving)

    def continuous_with(self, parameters: Mapping[str, float]) -> bool:
        """Whether nothing jumps with these values, of which only those of families are symbols."""
        given = np.array([parameters[name] for name in names_of(self.spec.parameters)])
        for case in self.unproven():
            one, u, _, part = case
            columns = {
                str(symbol.data): slot.table.astype(float) if slot.array is self.builder.whole
                else given[slot.table]
                for symbol, slot in self.slots.inside(self.graph.sum([(part, 1.0), (u, 1.0)]))
                if slot.array in (self.builder.given, self.builder.whole)
            }  # fmt: skip
            if not columns and one.is_avoided(self.graph, u, self.moving):
                continue
            if one.moves and not u.symbols & self.moving & ~self.time.symbols:
                return False
            rows = different(columns)
            if jumping(self.graph, [case], rows, len(next(iter(rows.values()), [0]))).any():
                return False
        return True

    def _numbers(self, *arrays: Array) -> int:
        """The symbols of numbers of these arrays, and of all sums."""
        return self.slots.symbols_of(*arrays, totals=True)

    def _kinked(self, tree: Syntax) -> bool:
        """Whether an expression may have kinks, or what it takes."""
        if calls(tree, KINKED):
            return True
        return self._shared and any(one.identifier.partition(".")[0] in self._names for one in names(tree))

    def _all(
        self, key: str, root: Node, *arrays: Array, timed: bool = False, name: str = "", slope: bool = False
    ) -> Iterator[Continuous]:
        """An expression, and the sums that it contains, which must not jump as numbers of these arrays, or
        the time, change."""
        symbols = self._numbers(*arrays) | (self.time.symbols if timed else 0)
        for node in self.slots.made_of([root]):
            own = [one for one in self.graph.symbols_of(node) if one.symbols & symbols]
            yield Continuous(key, node, own, name, slope)

    def _energies(self) -> Iterator[Continuous]:
        """Energies, momenta and the dissipation."""
        spec, builder = self.spec, self.builder
        key, energies = "potential", [*spec.potential.values()]
        if spec.lagrangian is not None:
            key, energies = "lagrangian", [spec.lagrangian]
        energy = self.graph.sum([(builder.of_root(one.tree, one.indices), 1.0) for one in energies])
        yield from self._all(key, energy, builder.q, builder.v)
        for node in self.slots.made_of([energy]):
            for slope in self._by_speeds(node):
                yield from self._all(key, slope, timed=True)
        for one in spec.forces.get("dissipation", {}).values():
            yield from self._all("dissipation", builder.of_root(one.tree, one.indices), builder.v)

    def _by_speeds(self, node: Node) -> list[Node]:
        """Its derivatives by velocities, and by sums that contain velocities."""
        fast = [symbol for symbol, _ in self.slots.inside(node) if self._is_fast(symbol)]
        return [self.graph.diff(node, symbol) for symbol in fast]

    def _is_fast(self, symbol: Node) -> bool:
        """Whether it is a velocity, or a sum that contains some."""
        return any(self.slots.moving(one, {self.builder.v}) for one in self.slots.made_of([symbol]))

    def _parts(self, group: Group) -> Iterator[tuple[Domain, tuple[Node, ...]]]:
        """Those members of a group that may have kinks: the components of what is written."""
        own = np.isin(group.labels, [i for i, tree in enumerate(group.trees) if self._kinked(tree)])
        for domain, value, _ in self.builder.pieces(group, np.flatnonzero(own)) if own.any() else ():
            parts = value if isinstance(value, tuple) else (value,)
            if switching(self.slots.made_of(parts)):
                yield domain, parts

    def _positions(self) -> Iterator[Continuous]:
        """Positions, and the momenta of particles, whose masses do not change with coordinates."""
        builder, graph = self.builder, self.graph
        for name, group in builder.positions.items():
            for domain, places in self._parts(group):
                if any(calls(one.tree, KINKED) for one in distinct(written(self.spec.masses))):
                    raise Unsuited
                rates = [builder.rate(x, domain) for x in places]
                kinetic = graph.sum([(u * u, 0.5) for u in rates])
                for x in places:
                    yield from self._all("embedding", x, builder.q, timed=True, name=name)
                yield from self._all("embedding", kinetic, builder.q, name=name, slope=True)
                for slope in self._by_speeds(kinetic):
                    yield from self._all("embedding", slope, timed=True, name=name, slope=True)

    def _events(self) -> Iterator[Continuous]:
        """The arguments of events."""
        for _, parts in self._parts(arguments_of(self.spec)) if self.spec.events else ():
            for node in parts:
                yield from self._all("events", node, self.builder.q, self.builder.v, timed=True)

    def _constraints(self) -> Iterator[Continuous]:
        """Constraints, and the slopes of holonomic ones."""
        builder, graph = self.builder, self.graph
        for family, section, holonomic in bound_families(self.spec):
            for _, parts in self._parts(group_of(family, section)):
                (f,) = parts
                if any(isinstance(slot.array, Total) for _, slot in self.slots.inside(f)):
                    raise Unsuited
                places = self._numbers(builder.q) | self.time.symbols
                own = [one for one in graph.symbols_of(f) if one.symbols & places]
                key, zero = ("constraints", f) if holonomic else ("nonholonomic", None)
                yield Continuous(key, f, own, family.name, constraint=zero)
                for x in own if holonomic else ():
                    yield Continuous(key, graph.diff(f, x), own, family.name, slope=True, constraint=zero)


def different(columns: Mapping[str, Values]) -> Mapping[str, Values]:
    """The same numbers of members that differ in them, of each kind once."""
    if not columns:
        return {}
    rows = np.unique(np.stack([*columns.values()], axis=1), axis=0)
    return dict(zip(columns, rows.T, strict=True))
