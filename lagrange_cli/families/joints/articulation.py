"""The joints of all particles: what moves these, along chains and trees."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from lagrange_cli.expression.index_arrays import Places
from lagrange_cli.expression.indices import Unsuited
from lagrange_cli.expression.node import Node
from lagrange_cli.families.arrays import NONE, Chain, Domain, Slot, Source, Term, Total, equal, placed
from lagrange_cli.families.builder import FamilyBuilder
from lagrange_cli.families.groups import group_of, particle_families
from lagrange_cli.families.joints.assembly import Assembly
from lagrange_cli.families.joints.carriages import on_carriages
from lagrange_cli.families.joints.free import with_free_energy
from lagrange_cli.families.joints.joints import Articulation, Part
from lagrange_cli.families.joints.relative import Relative, relative
from lagrange_cli.families.turning import Turned, unit_quaternions
from lagrange_cli.mechanics.substitution import substituted
from lagrange_cli.spec.spec import Spec, grouped


def articulation(builder: FamilyBuilder, spec: Spec) -> Articulation:
    """The joints of all particles. Raises ``Unsuited`` where there are others."""
    weights = on_carriages(builder, [*weights_of(builder, spec)])
    movers = Movers(builder, relative(builder, [x for _, x, _ in weights]))
    chains = chains_of(movers, weights)
    parts: list[Part] = []
    for component, nodes in enumerate(chains):
        for term in nodes.terms:
            for domain, which, (node,) in movers.apart(term.domain, [term.node]):
                parts.append(Part(domain, node, None, component, term.targets[which], movers.tables(node)))
    fixed: list[list[Term]] = [[] for _ in chains]
    for domain, _, (x, mass) in (one for d, *both in weights for one in movers.apart(d, both)):
        part = carried(movers, chains, domain, x, mass)
        if part is None:
            continue
        if part.tables:
            parts.append(part)
        elif part.nodes is not None and part.component is not None:
            fixed[part.component].append(Term(domain, mass_of(part), part.nodes))
    inertia = tuple(builder.added(one.count, terms) for one, terms in zip(chains, fixed))
    rates = tuple(builder.rates_of(one) for one in chains)
    made = Assembly(builder, chains, parts, movers.rows)
    joints = tuple(with_free_energy(builder, one) for one in made.joints())
    return Articulation(tuple(chains), rates, inertia, joints, movers.relative)


def weights_of(builder: FamilyBuilder, spec: Spec) -> Iterator[tuple[Domain, Node, Node]]:
    """The components of the places of all particles and of the masses that stand for the rotation of bodies,
    and the masses."""
    for domain, place, mass in places_of(builder, spec):
        yield from ((domain, x, mass) for x in place)


def places_of(builder: FamilyBuilder, spec: Spec) -> Iterator[tuple[Domain, tuple[Node, ...], Node]]:
    """The same, all components of a place together."""
    yield from particles_of(builder, spec)
    for one in turned(builder):
        for mass, place, _ in one.carriers(builder.algebra):
            if not constant(builder, mass):
                raise Unsuited
            yield one.domain, tuple(place), mass


def turned(builder: FamilyBuilder) -> Iterator[Turned]:
    """All rigid bodies, those that are written alike together. Raises ``SpecError`` for a matrix that is not
    a rotation."""
    for bodies in builder.bodies.values():
        for one in bodies.pieces(builder):
            if one.form == "matrix":
                from lagrange_cli.mechanics.rigidity import refuse_strained

                name = bodies.group.family.members[int(one.members[0])]
                units = unit_quaternions(builder.bodies.values(), one.domain)
                axes = [substituted(builder.algebra.graph, axis, units) for axis in one.turning.axes]
                refuse_strained(builder.spec, name, axes)
            yield one


def centres(builder: FamilyBuilder, spec: Spec) -> list[Total]:
    """The sum of m x over all particles, and so on along all axes."""
    terms: list[list[Term]] = []
    for domain, axis, x, mass in (
        (domain, axis, x, mass)
        for domain, place, mass in particles_of(builder, spec)
        for axis, x in enumerate(place)
    ):
        terms += [[] for _ in range(axis + 1 - len(terms))]
        terms[axis].append(Term(domain, mass * x, domain.together))
    return [builder.added(1, one) for one in terms]


def mass_of(part: Part) -> Node:
    """The mass of a part that has one."""
    assert part.mass is not None
    return part.mass


def particles_of(builder: FamilyBuilder, spec: Spec) -> Iterator[tuple[Domain, tuple[Node, ...], Node]]:
    """The places of all particles, and their masses."""
    for family in grouped(spec.embedding, particle_families(spec)):
        group, masses = builder.positions[family.name], group_of(family, spec.masses)
        for _, domain, mass, position in builder.with_places(masses, group):
            if isinstance(mass, tuple) or not constant(builder, mass):
                raise Unsuited
            yield domain, position if isinstance(position, tuple) else (position,), mass


class Movers:
    """What moves places: coordinates, or sums of these if they are ``relative``."""

    def __init__(self, builder: FamilyBuilder, relative: Relative | None) -> None:
        self.builder, self.relative = builder, relative

    def rows(self, slot: Slot) -> Places | None:
        """The numbers of the joints' coordinates in a slot, NONE of what rests; None where it has others."""
        if slot.array is self.builder.q:
            if self.relative is not None and not np.all(self.relative.alone[slot.table]):
                raise Unsuited  # such a coordinate is a difference of those of joints
            return slot.table
        if self.relative is not None and slot.array in self.relative.chains:
            return self.relative.chains[slot.array][slot.table]  # type: ignore[index]
        return None

    def tables(self, node: Node) -> tuple[Places, ...]:
        """The same of an expression that has nothing else that moves, but t."""
        found = []
        for _, slot in self.builder.slots.inside(node):
            rows = self.rows(slot)
            if rows is None:
                if not lasts(self.builder, slot):
                    raise Unsuited
            elif np.any(rows != NONE):
                found.append(rows)
        return tuple(found)

    def apart(self, domain: Domain, nodes: Sequence[Node]) -> Iterator[tuple[Domain, Places, list[Node]]]:
        """Expressions of those members for which the same slots move: their domain, and which they are.
        Sums that are equal to others are these."""
        every, slots = np.arange(domain.count), self.builder.slots
        nodes = [self.with_first(domain, node) for node in nodes]
        listed = [self.rows(slot) for node in nodes for _, slot in slots.inside(node)]
        rests = [rows == NONE for rows in listed if rows is not None and np.any(rows == NONE)]
        if not rests or all(one.all() for one in rests):
            yield domain, every, [*nodes]
            return
        _, kinds = np.unique(np.array(rests), axis=1, return_inverse=True)
        for kind in range(int(kinds.max()) + 1):
            which = np.flatnonzero(kinds.reshape(-1) == kind)
            own = Domain(len(which))
            yield own, which, [placed(slots, node, own, which) for node in nodes]

    def with_first(self, domain: Domain, node: Node) -> Node:
        """An expression with the first of sums that are equal."""
        same, slots = self.relative.same if self.relative else {}, self.builder.slots
        others = {
            symbol: slots.symbol(domain, same[slot.array], slot.table)
            for symbol, slot in slots.inside(node)
            if slot.array in same
        }
        return substituted(slots.graph, [node], others)[0] if others else node


def chains_of(movers: Movers, weights: Sequence[tuple[Domain, Node, Node]]) -> list[Chain]:
    """The chains that particles are on: all of them have the same nodes."""
    builder, relative = movers.builder, movers.relative
    sums = {*relative.chains, *relative.same} if relative else set()
    found: dict[Chain, None] = {}
    for _, x, _ in weights:
        for _, slot in builder.slots.inside(x):
            array = slot.array
            if isinstance(array, Chain) and array not in sums and not constant_total(builder, array):
                found[array] = None
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


def carried(movers: Movers, chains: Sequence[Chain], domain: Domain, x: Node, mass: Node) -> Part | None:
    """A component of particles' places, of that mass; None if it does not move."""
    builder = movers.builder
    on = [(s, slot) for s, slot in builder.slots.inside(x) if slot.array in chains]
    if not on:
        tables = movers.tables(x)
        if not tables and x.symbols & builder.time.symbols:
            raise Unsuited
        return Part(domain, x, mass, None, None, tables) if tables else None
    (symbol, slot), *others = on
    scale = builder.graph.diff(x, symbol)
    if others or not constant(builder, scale):
        raise Unsuited
    rest = x / scale - symbol
    tables = movers.tables(rest)
    if rest.symbols & symbol.symbols or (not tables and rest.symbols & builder.time.symbols):
        raise Unsuited
    assert isinstance(slot.array, Chain)
    return Part(domain, rest, mass * scale * scale, chains.index(slot.array), slot.table, tables)


def constant(builder: FamilyBuilder, node: Node) -> bool:
    """Whether it is a constant of the motion."""
    if node.symbols & builder.time.symbols:
        return False
    return all(lasts(builder, slot) for _, slot in builder.slots.inside(node))


def lasts(builder: FamilyBuilder, slot: Slot) -> bool:
    """The same of a slot."""
    if slot.array.source in (Source.PARAMETERS, Source.WHOLE):
        return True
    return isinstance(slot.array, Total) and constant_total(builder, slot.array)


def constant_total(builder: FamilyBuilder, total: Total) -> bool:
    """The same of sums."""
    return all(constant(builder, one.node) for one in total.terms)
