"""The joints of all particles: what moves these, along chains and trees."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from lagrange_cli.expression.index_arrays import Places
from lagrange_cli.expression.indices import Unsuited
from lagrange_cli.expression.node import Node
from lagrange_cli.families.arrays import Chain, Domain, Source, Term, Total, equal
from lagrange_cli.families.builder import FamilyBuilder
from lagrange_cli.families.groups import group_of, particle_families
from lagrange_cli.families.joints.assembly import Assembly
from lagrange_cli.families.joints.carriages import on_carriages
from lagrange_cli.families.joints.joints import Articulation, Part
from lagrange_cli.families.turning import Turned
from lagrange_cli.spec.spec import Spec, grouped


def articulation(builder: FamilyBuilder, spec: Spec) -> Articulation:
    """The joints of all particles. Raises ``Unsuited`` where there are others."""
    weights = on_carriages(builder, [*weights_of(builder, spec)])
    chains = chains_of(builder, weights)
    parts: list[Part] = []
    for component, nodes in enumerate(chains):
        for term in nodes.terms:
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
    inertia = tuple(builder.added(one.count, terms) for one, terms in zip(chains, fixed))
    rates = tuple(builder.rates_of(one) for one in chains)
    made = Assembly(builder, chains, parts)
    return Articulation(tuple(chains), rates, inertia, tuple(made.joints()))


def weights_of(builder: FamilyBuilder, spec: Spec) -> Iterator[tuple[Domain, Node, Node]]:
    """The components of the places of all particles and of the masses that stand for the rotation of bodies,
    and the masses."""
    for domain, _, x, mass in masses_of(builder, spec):
        yield domain, x, mass
    for one in turned(builder):
        for mass, place, _ in one.carriers(builder.algebra):
            if not constant(builder, mass):
                raise Unsuited
            yield from ((one.domain, x, mass) for x in place)


def turned(builder: FamilyBuilder) -> Iterator[Turned]:
    """All rigid bodies, those that are written alike together. Raises ``SpecError`` for a matrix that is not
    a rotation."""
    for bodies in builder.bodies.values():
        for one in bodies.pieces(builder):
            if one.form == "matrix":
                from lagrange_cli.mechanics.constrained.rigidity import refuse_strained

                name = bodies.group.family.members[int(one.members[0])]
                refuse_strained(builder.spec, name, one.turning.axes)
            yield one


def centres(builder: FamilyBuilder, spec: Spec) -> list[Total]:
    """The sum of m x over all particles, and so on along all axes."""
    terms: list[list[Term]] = []
    for domain, axis, x, mass in masses_of(builder, spec):
        terms += [[] for _ in range(axis + 1 - len(terms))]
        terms[axis].append(Term(domain, mass * x, np.zeros(domain.count, dtype=np.int64)))
    return [builder.added(1, one) for one in terms]


def mass_of(part: Part) -> Node:
    """The mass of a part that has one."""
    assert part.mass is not None
    return part.mass


def masses_of(builder: FamilyBuilder, spec: Spec) -> Iterator[tuple[Domain, int, Node, Node]]:
    """The components of all particles' places, with their axes, and the masses."""
    for family in grouped(spec.embedding, particle_families(spec)):
        group, masses = builder.positions[family.name], group_of(family, spec.masses)
        for _, domain, mass, position in builder.with_places(masses, group):
            if isinstance(mass, tuple) or not constant(builder, mass):
                raise Unsuited
            for axis, x in enumerate(position if isinstance(position, tuple) else (position,)):
                yield domain, axis, x, mass


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
