"""The forces outside L on families: on coordinates, on particles, and by a dissipation function."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from lagrange_cli.expression.indices import Unsuited
from lagrange_cli.expression.operations import cross
from lagrange_cli.families.arrays import NONE, Array, Chain, Domain, Term, Total, opposite, placed
from lagrange_cli.families.builder import FamilyBuilder
from lagrange_cli.families.groups import alike, among, group_of, particle_families
from lagrange_cli.families.joints.articulation import constant_total
from lagrange_cli.families.jumps import may_jump, refuse_angles
from lagrange_cli.families.slopes import slopes
from lagrange_cli.mechanics.substitution import substituted
from lagrange_cli.records import replace
from lagrange_cli.spec.spec import Spec, grouped

ON_COORDINATES, ON_PARTICLES, DISSIPATION = "generalized_forces", "forces", "dissipation"
ON_BODIES = "torques"


def applied_forces(
    builder: FamilyBuilder, spec: Spec, nodes: Sequence[Total]
) -> tuple[list[Term], list[list[Term]], list[Total]]:
    """The terms of Q_k, those of what acts on ``nodes`` besides, component by component, and the totals that
    all of these take, in the order of their computation."""
    if not spec.forces.keys() <= {ON_COORDINATES, ON_PARTICLES, ON_BODIES, DISSIPATION}:
        raise Unsuited
    known = [*builder.totals]
    terms, pushes = [*on_coordinates(builder, spec), *on_bodies(builder, spec)], [list[Term]() for _ in nodes]
    for array, term in on_particles(builder, spec, nodes):
        (terms if array is builder.q else pushes[nodes.index(array)]).append(term)
    lost: list[Total] = []
    for one in spec.forces.get(DISSIPATION, {}).values():
        power = builder.of_root(one.tree, one.indices)
        if may_jump(builder.slots, power, builder.v):
            raise Unsuited
        refuse_angles(builder.slots, [power])
        (rates,), taken = slopes(power, builder.root, builder.totals, builder.slots, builder.v)
        lost += taken
        terms += opposite(rates.terms)
    terms = [part for one in terms for part in opened(builder, one)]
    return terms, pushes, [*(one for one in builder.totals if one not in known), *lost]


def opened(builder: FamilyBuilder, term: Term) -> Iterator[Term]:
    """A force with the terms of sums that jump in place of these: whether members stay where it jumps depends
    on each of them."""
    slots, graph = builder.slots, builder.graph
    for symbol, slot in slots.inside(term.node):
        total, slope = slot.array, graph.diff(term.node, symbol)
        if not isinstance(total, Total) or isinstance(total, Chain) or slope.symbols & symbol.symbols:
            continue
        member = np.full(total.count, NONE)
        member[slot.table] = term.domain.every
        if np.any(member[slot.table] != term.domain.every):
            continue
        if not any(may_jump(slots, one.node, builder.q, builder.v) for one in total.terms):
            continue
        yield from opened(
            builder, replace(term, node=substituted(graph, [term.node], {symbol: graph.zero})[0])
        )
        for one in total.terms:
            kept = np.flatnonzero(member[one.targets] != NONE)
            if not len(kept):
                continue
            own, domain = member[one.targets[kept]], Domain(len(kept))
            node = placed(slots, slope, domain, own) * placed(slots, one.node, domain, kept)
            yield from opened(builder, Term(domain, node, term.targets[own]))
        return
    if not term.node.is_zero:
        yield term


def on_coordinates(builder: FamilyBuilder, spec: Spec) -> Iterator[Term]:
    """Q_k as they are given."""
    written = spec.forces.get(ON_COORDINATES, {})
    for family in grouped(written, spec.families.get(ON_COORDINATES, {})):
        group = group_of(family, written)
        own = builder.rows[family.name]
        rows = own.first + among(family, own.family)
        for domain, value, which in builder.pieces(group, np.arange(group.count)):
            if isinstance(value, tuple):
                raise Unsuited
            yield Term(domain, value, rows[which])


def on_bodies(builder: FamilyBuilder, spec: Spec) -> Iterator[Term]:
    """tau . domega/dq_dot_k of torques on rigid bodies: a torque is that of forces tau x e/2 at the tips of
    their axes e (see ``model.rigid_body``)."""
    written, graph = spec.forces.get(ON_BODIES, {}), builder.graph
    for family in grouped(written, {**spec.families.get("bodies", {}), **spec.families.get(ON_BODIES, {})}):
        if family.name not in builder.bodies:
            raise Unsuited
        torques, bodies = group_of(family, written), builder.bodies[family.name]
        own = among(family, bodies.group.family)
        for which in alike(torques, bodies.group, own):
            domain = Domain(len(which))
            torque = builder.value(*torques.members(which, builder.sizes, domain))
            if not isinstance(torque, tuple):
                raise Unsuited
            for axis in bodies.turned(builder, own[which], domain).turning.axes:
                for force, x in zip(cross(torque, axis), axis, strict=True):
                    for symbol, slot in builder.slots.inside(x):
                        if slot.array is builder.q:
                            yield Term(domain, 0.5 * force * graph.diff(x, symbol), slot.table)
                        elif isinstance(slot.array, Total):
                            raise Unsuited


def on_particles(builder: FamilyBuilder, spec: Spec, nodes: Sequence[Total]) -> Iterator[tuple[Array, Term]]:
    """F . dr/dq_k of forces on particles, and F of what is at ``nodes``: where it acts, and how."""
    written = spec.forces.get(ON_PARTICLES, {})
    for family in grouped(written, {**particle_families(spec), **spec.families.get(ON_PARTICLES, {})}):
        if family.name not in builder.positions:
            raise Unsuited
        forces, positions = group_of(family, written), builder.positions[family.name]
        own = among(family, positions.family)
        for _, domain, given, place in builder.with_places(forces, positions, own):
            pairs = [(one if isinstance(one, tuple) else (one,)) for one in (given, place)]
            for component, x in zip(*pairs, strict=True):
                for symbol, slot in builder.slots.inside(x):
                    if slot.array is builder.q or slot.array in nodes:
                        force = component * builder.graph.diff(x, symbol)
                        yield slot.array, Term(domain, force, slot.table)
                    elif isinstance(slot.array, Total) and not constant_total(builder, slot.array):
                        raise Unsuited
