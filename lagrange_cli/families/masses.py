"""Masses of particles, or in a given Lagrangian, without those of joints."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence

import numpy as np

from lagrange_cli.expression.index_arrays import Places, distinct
from lagrange_cli.expression.indices import Unsuited
from lagrange_cli.expression.node import Kind, Node, reachable
from lagrange_cli.families.arrays import Domain, Slot, Slots, Term, Total, placed, total_of
from lagrange_cli.families.builder import FamilyBuilder
from lagrange_cli.families.coupled_masses import CoupledMasses, Product, coupled_masses
from lagrange_cli.families.curved_masses import bends, fixed, merged
from lagrange_cli.families.description import Component
from lagrange_cli.families.groups import group_of, particle_families
from lagrange_cli.families.slopes import factors
from lagrange_cli.families.spins import with_spins
from lagrange_cli.families.velocity_sums import MOST_CURVED, products_of, sums_in
from lagrange_cli.mechanics.multiplied_out import halved_squares, without_time
from lagrange_cli.mechanics.substitution import substituted
from lagrange_cli.records import dataclass, replace
from lagrange_cli.spec.spec import Spec, grouped


@dataclass(frozen=True)
class Energies:
    """L = sum M v^2/2 - U, with a ``potential`` U that is linear in velocities and consists of ``totals``,
    and the ``components`` of particles that move along fixed axes. Where axes move, T and U as they are
    written, ``apart``. Where M is not diagonal, it is ``coupled``, and ``masses`` has its diagonal."""

    potential: Node
    masses: Total
    totals: Sequence[Total]
    components: Sequence[Component] = ()
    apart: tuple[Node, Node] | None = None
    coupled: CoupledMasses | None = None


def energies_of(
    builder: FamilyBuilder, spec: Spec, *, coupled: bool = False, curved: bool = False
) -> Energies:
    """The energies of a system whose M is constant unless it may be ``curved``, and diagonal unless it may be
    ``coupled``. Raises ``Unsuited`` where it is not."""
    products: list[Product] | None = [] if coupled else None
    if spec.lagrangian is not None:
        lagrangian = builder.of_root(spec.lagrangian.tree, spec.lagrangian.indices)
        potential, masses = separated(builder, lagrangian, products, curved=curved)
        return with_products(builder, Energies(potential, masses, [*builder.totals]), products)
    parts = [builder.of_root(one.tree, one.indices) for one in spec.potential.values()]
    potential = builder.graph.sum([(one, 1.0) for one in parts])
    totals = [*builder.totals]
    try:
        if spec.bodies:
            raise Unsuited
        moving = [*particles(builder, spec)]
        return Energies(potential, masses_of(builder, moving), totals, moving)
    except Unsuited:
        kinetic = moving_axes(builder, spec)
        parted = separated(builder, kinetic - potential, products, curved=curved)
        moved = any(x.symbols & builder.time.symbols for _, _, _, x, _ in components(builder, spec))
        apart = (kinetic, potential) if moved else None
        return with_products(builder, Energies(*parted, [*builder.totals], apart=apart), products)


def with_products(builder: FamilyBuilder, energies: Energies, products: Sequence[Product] | None) -> Energies:
    """The energies with an M that is coupled by ``products`` of velocities, or no constant, if it is."""
    diagonal, squares, count = list[Term](), list[Product](), builder.q.count
    for term in energies.masses.terms:
        if fixed(builder, term.node):
            diagonal.append(term)
        else:
            squares.append(Product(term.domain, 0.5 * term.node, term.targets, term.targets))
    if not products and not squares:
        return energies
    plain = [one for one in products or () if fixed(builder, one.node)]
    others = [*squares, *(one for one in products or () if not fixed(builder, one.node))]
    curved = merged(builder.slots, builder.v, others)
    own = [one.first[one.first == one.second] for one in (*plain, *curved)]
    if not curved and len(distinct(np.concatenate([*own, *(one.targets for one in diagonal)]))) < count:
        raise Unsuited  # no pivot can be where M has no entry on its diagonal, unless pivots are chosen
    alone = with_spins(builder, diagonal, [*plain, *curved]) if curved else None
    made = coupled_masses(builder.root, count, diagonal, plain, builder.graph.one, curved, alone)
    return replace(energies, masses=made.diagonal(builder.slots, Domain(count)), coupled=made)


def components(
    builder: FamilyBuilder, spec: Spec
) -> Iterator[tuple[tuple[str, int], Places, Domain, Node, Node]]:
    """The components of the places of all particles, of those together that are alike: the family and axis,
    which members, the expression, and the mass, which is a constant."""
    families = grouped(spec.embedding, particle_families(spec))
    for family in families:
        group, masses = builder.positions[family.name], group_of(family, spec.masses)
        for which, domain, mass, position in builder.with_places(masses, group):
            if not fixed(builder, mass):
                raise Unsuited
            for axis, x in enumerate(position if isinstance(position, tuple) else (position,)):
                yield (family.name, axis), which, domain, x, mass


def particles(builder: FamilyBuilder, spec: Spec) -> Iterator[Component]:
    """The components of all particles that move. Each contains one coordinate at most."""
    for (family, axis), which, domain, x, mass in components(builder, spec):
        if x.symbols & builder.time.symbols:
            raise Unsuited
        inside = [(s, slot) for s, slot in builder.slots.inside(x) if slot.array is not builder.given]
        inside = [(s, slot) for s, slot in inside if slot.array is not builder.whole]
        if len(inside) > 1 or any(slot.array is not builder.q for _, slot in inside):
            raise Unsuited
        for symbol, slot in inside:
            yield Component(family, axis, which, domain, slot.table, mass, builder.graph.diff(x, symbol))


def masses_of(builder: FamilyBuilder, particles: Sequence[Component]) -> Total:
    """M, which is constant where places are linear in coordinates, and on circles. Raises ``Unsuited`` where
    it is not."""
    terms = [Term(one.domain, one.mass * one.slope * one.slope, one.rows) for one in particles]
    masses = total_of(builder.q.count, terms, builder.graph)
    if not all(fixed(builder, one.node) for one in masses.terms):
        raise Unsuited
    return masses


def moving_axes(builder: FamilyBuilder, spec: Spec) -> Node:
    """T of particles whose places are made of coordinates and t alone, as along axes that turn, or of several
    coordinates, and of bodies that turn."""
    speeds: dict[Domain, list[tuple[Node, Node]]] = {}
    for _, _, domain, x, mass in components(builder, spec):
        speeds.setdefault(domain, []).append((mass, builder.rate(x, domain)))
    for body in (piece for group in builder.bodies.values() for piece in group.pieces(builder)):
        turning = [(mass, u) for mass, _, velocity in body.carriers(builder.algebra) for u in velocity]
        speeds.setdefault(body.domain, []).extend(turning)
    terms = []
    for domain, parts in speeds.items():
        energy = halved_squares(builder.graph, parts)
        if energy is None:  # as of a bicycle: masses have the derivatives of places as factors then
            energy = builder.graph.sum([(mass * u * u, 0.5) for mass, u in parts])
        terms.append(Term(domain, energy, domain.together))
    return builder.slots.own(builder.root, builder.added(1, terms))


def kinked(node: Node, by: Iterable[Node]) -> bool:
    """Whether switches in an expression depend on some symbols."""
    symbols = sum(one.symbols for one in by)
    return any(one.kind is Kind.SWITCH and one.symbols & symbols for one in reachable([node]))


def everywhere(slots: Slots, node: Node, domain: Domain) -> Node:
    """An expression of the one member of its domain, for all members of another."""
    return placed(slots, node, domain, np.zeros(domain.count, dtype=np.int64))


def separated(
    builder: FamilyBuilder, lagrangian: Node, products: list[Product] | None = None, *, curved: bool = False
) -> tuple[Node, Total]:
    """A given Lagrangian as sum M v^2/2 - U, with a U that is linear in velocities: U, and M. The terms of
    totals lose M v^2/2. ``products`` of different velocities are noted there; without it, they are refused.
    So are masses that are no constants, unless they may be ``curved``.
    """
    graph, slots = builder.graph, builder.slots
    linear = factors(lagrangian, slots, lambda slope: curved and bends(builder, slope))
    masses, noted = list[Term](), list[Product]() if products is None else products

    def known(mass: Node) -> bool:
        return fixed(builder, mass) or (curved and bends(builder, mass))

    def parted(domain: Domain, node: Node, factor: Node | None) -> Node:
        """Without its terms M v^2/2, whose masses are noted, and multiplied out where t vanishes then."""
        node = without_time(graph, node, builder.time)
        speeds = [(s, slot) for s, slot in slots.inside(node) if slot.array is builder.v]
        node = without_products(node, factor, speeds)
        if not speeds:
            return node
        at_rest = {s: graph.zero for s, _ in speeds}
        momenta = [graph.diff(node, s) for s, _ in speeds]
        left, *offsets = substituted(graph, [node, *momenta], at_rest)
        constant = factor is None or not factor.symbols
        scale = factor if factor is None or constant else everywhere(slots, factor, domain)
        for (symbol, slot), momentum, own in zip(speeds, momenta, offsets):
            mass = graph.diff(momentum, symbol)
            others = [(graph.diff(momentum, s), other) for s, other in speeds if s is not symbol]
            coupled = [(each, other) for each, other in others if not each.is_zero]
            masses_known = all(known(one) for one in (mass, *(each for each, _ in coupled)))
            if (coupled and products is None) or not masses_known or kinked(momentum, at_rest):
                raise Unsuited
            left += own * symbol
            if mass.is_zero and not coupled:
                continue
            if scale is None or not (constant or curved):
                raise Unsuited
            if not mass.is_zero:
                masses.append(Term(domain, scale * mass, slot.table))
            for each, other in coupled:  # a product comes twice
                noted.append(Product(domain, 0.5 * scale * each, slot.table, other.table))
        return left

    def without_products(node: Node, factor: Node | None, speeds: Sequence[tuple[Node, Slot]]) -> Node:
        """Without products of sums of velocities with these, or with velocities, which are noted."""
        sums, before = sums_in(slots, node, builder.v), len(noted)
        for i, (symbol, slot) in enumerate(sums):
            momentum = graph.diff(node, symbol)
            for other, of_other in [*speeds, *sums[i:]]:
                each = graph.diff(momentum, other)
                if each.is_zero:
                    continue
                if products is None or factor is None or factor.symbols or not known(each):
                    raise Unsuited
                each = 0.5 * each if other is symbol else each
                found = [*products_of(slots, factor * each, slot, of_other, builder.v)]
                if not all(known(one.node) for one in found):
                    raise Unsuited
                noted.extend(found)
                if sum(p.domain.count for p in noted if not fixed(builder, p.node)) > MOST_CURVED:
                    raise Unsuited
        if len(noted) > before:
            at_rest = {s: graph.zero for s, _ in sums}
            linear_in = [graph.diff(node, s) for s, _ in sums]
            zeros = at_rest | {s: graph.zero for s, _ in speeds}
            node, *_ = substituted(graph, [node], at_rest)
            for (symbol, _), own in zip(sums, substituted(graph, linear_in, zeros)):
                node += own * symbol
        return node

    replaced: dict[Total, Total] = {}
    for i, total in enumerate(builder.totals):
        factor = linear.get(total)
        terms = [Term(one.domain, parted(one.domain, one.node, factor), one.targets) for one in total.terms]
        if any(new.node is not old.node for new, old in zip(terms, total.terms)):
            replaced[total] = builder.totals[i] = total_of(total.count, terms, graph)
    potential = -parted(builder.root, lagrangian, graph.one)
    for symbol, slot in [*slots.of.items()]:
        if isinstance(slot.array, Total) and slot.array in replaced:
            made = replaced[slot.array]
            other = slots.symbol(slot.domain, made, slot.table) if made.terms else graph.zero
            potential = substituted(graph, [potential], {symbol: other})[0]
            for total in builder.totals:
                if any(one.node.symbols & symbol.symbols for one in total.terms):
                    raise Unsuited
    return potential, total_of(builder.q.count, masses, graph)
