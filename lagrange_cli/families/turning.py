"""Rigid bodies of families: how they turn, and the masses that stand for this (see ``model.rigid_body``)."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from functools import cached_property, partial
from typing import Any, Protocol

import numpy as np

from lagrange_cli.expression.graph_algebra import GraphAlgebra
from lagrange_cli.expression.index_arrays import Places, of_each_kind
from lagrange_cli.expression.node import Kind, Node
from lagrange_cli.expression.operations import cross
from lagrange_cli.families.arrays import Domain, Term, Total, total_of
from lagrange_cli.families.groups import Group, group_of, parts_of, placed_parts
from lagrange_cli.mechanics.conserved.allowed_states import on_sphere
from lagrange_cli.model.orientation import Turning, turning
from lagrange_cli.model.rigid_body import equimomental, second_moments
from lagrange_cli.records import dataclass, field
from lagrange_cli.spec.spec import Expression, Spec, grouped


class Builds(Protocol):
    """The interface of what builds expressions over arrays (``families.builder``)."""

    algebra: GraphAlgebra
    bodies: dict[str, BodyGroup]

    @property
    def sizes(self) -> Any: ...
    def value(self, tree: Any, members: Any) -> Any: ...
    def rate(self, node: Node, domain: Domain) -> Node: ...


@dataclass(frozen=True, eq=False)
class Turned:
    """Bodies of a family that are written alike, the ``members`` of a ``domain``: how they turn, and the
    second moments and products of their mass. ``form`` is how the orientation is given, by ``entries``."""

    members: Places
    domain: Domain
    form: str
    entries: Sequence[Node]
    turning: Turning[Node]
    moments: Sequence[Node]
    products: Mapping[tuple[int, int], Node]

    def carriers(self, algebra: GraphAlgebra) -> Iterator[tuple[Node, Sequence[Node], Sequence[Node]]]:
        """The masses that stand for the rotation, where they are, and their velocities."""
        for _, *one in equimomental(algebra, self.turning, self.moments, self.products):
            mass, place, velocity = one
            if not mass.is_zero:
                yield mass, place, velocity


@dataclass
class BodyGroup:
    """The bodies of a family as they are written, and their masses."""

    group: Group
    masses: Group
    known: dict[tuple[Domain, bytes], Turned] = field(default_factory=dict)
    listed: list[Turned] = field(default_factory=list)

    def turned(self, builder: Builds, which: Places, domain: Domain) -> Turned:
        """How some members turn. Raises ``Differ`` where they are written differently."""
        key = domain, which.tobytes()
        if key not in self.known:
            body, members = self.group.members(which, builder.sizes, domain)

            def value(one: Expression) -> Any:
                return builder.value(one.tree, members)

            def mass() -> Any:
                return builder.value(*self.masses.members(which, builder.sizes, domain))

            how = body.orientation
            given = [*map(value, how.entries)]
            rate = partial(builder.rate, domain=domain)
            turns = turning(builder.algebra, how.form, how.sequence, given, rate)
            moments = second_moments(builder.algebra, body.inertia, value, mass)
            self.known[key] = Turned(which, domain, how.form, given, turns, *moments)
        return self.known[key]

    def pieces(self, builder: Builds) -> Sequence[Turned]:
        """All members, those of each kind together."""
        if not self.listed:
            every = np.arange(self.group.count)
            made = of_each_kind(every, lambda which: self.turned(builder, which, Domain(len(which))))
            self.listed = [*made]
        return self.listed


def unit_quaternions(bodies: Iterable[BodyGroup], domain: Domain) -> dict[Node, Node]:
    """What makes the length of each quaternion over a domain 1 that consists of four symbols, in place of
    these."""
    known: dict[Node, Node] = {}
    every = (one for group in bodies for one in group.known.values())
    for one in (one for one in every if one.form == "quaternion" and one.domain == domain):
        if all(x.kind is Kind.SYMBOL and x not in known for x in one.entries):
            known |= on_sphere(one.entries, one.entries[0].graph.one)
    return known


def body_groups(spec: Spec) -> dict[str, BodyGroup]:
    """The families of bodies."""
    found = {}
    for family in grouped(spec.bodies, spec.families.get("bodies", {})):
        group = placed_parts(family, parts_of(family, spec.bodies), of=lambda body: body)
        found[family.name] = BodyGroup(group, group_of(family, spec.masses))
    return found


@dataclass(frozen=True, eq=False)
class Bodies:
    """The bodies of a family, as arrays: ``count`` of them, in ``pieces``."""

    algebra: GraphAlgebra
    count: int
    pieces: Sequence[Turned]

    def total(self, of: Callable[[Turned], Node]) -> Total:
        """A number of each body."""
        terms = [Term(one.domain, of(one), one.members) for one in self.pieces]
        return total_of(self.count, terms, self.algebra.graph)

    @cached_property
    def axes(self) -> Sequence[Sequence[Total]]:
        """The components of the three axes in space."""
        return [
            [self.total(lambda one, i=i, k=k: one.turning.axes[i][k]) for k in range(3)]  # type: ignore[misc]
            for i in range(3)
        ]

    @cached_property
    def rates(self) -> Sequence[Sequence[Total]]:
        """Their velocities."""
        return [
            [self.total(lambda one, i=i, k=k: one.turning.rates[i][k]) for k in range(3)]  # type: ignore[misc]
            for i in range(3)
        ]

    @cached_property
    def spin(self) -> Sequence[Total]:
        """The angular velocities, in space."""
        return [self.total(lambda one, k=k: one.turning.in_space[k]) for k in range(3)]  # type: ignore[misc]

    @cached_property
    def momentum(self) -> Sequence[Total]:
        """The angular momenta about the centres of mass, in space."""

        def component(one: Turned, k: int) -> Node:
            parts = [cross(x, [mass * u for u in v])[k] for mass, x, v in one.carriers(self.algebra)]
            return self.algebra.total(parts)

        return [self.total(lambda one, k=k: component(one, k)) for k in range(3)]  # type: ignore[misc]

    @cached_property
    def energy(self) -> Total:
        """The kinetic energies of the rotation."""

        def energy(one: Turned) -> Node:
            parts = [0.5 * mass * u * u for mass, _, v in one.carriers(self.algebra) for u in v]
            return self.algebra.total(parts)

        return self.total(energy)


def bodies_of(builder: Builds) -> dict[str, Bodies]:
    """All rigid bodies by family."""
    return {
        name: Bodies(builder.algebra, one.group.count, [*one.pieces(builder)])
        for name, one in builder.bodies.items()
    }
