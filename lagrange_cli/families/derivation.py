"""The equations of motion of systems of families, from the energies and forces of a file: of those that have
joints, and of all others. Which kind a system is of is decided in ``system``."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np

from lagrange_cli.expression.graph_algebra import GraphAlgebra
from lagrange_cli.expression.indices import Unsuited
from lagrange_cli.families.applied import applied_forces
from lagrange_cli.families.arrays import Domain, Source, Term, Total, opposite, total_of
from lagrange_cli.families.bonds import Bonds, bonds, unbound
from lagrange_cli.families.builder import FamilyBuilder
from lagrange_cli.families.chains import ChainBuilder
from lagrange_cli.families.curved_masses import inertia
from lagrange_cli.families.description import FamilySystem
from lagrange_cli.families.events import events_of
from lagrange_cli.families.first_order import first_order_of
from lagrange_cli.families.groups import group_of
from lagrange_cli.families.impacts.actions import on_joints, with_actions, with_coupled_masses
from lagrange_cli.families.joints.articulation import articulation, centres
from lagrange_cli.families.joints.inertia import felt, kinetic_terms, momenta
from lagrange_cli.families.joints.platforms import put_on_platforms
from lagrange_cli.families.masses import energies_of
from lagrange_cli.families.refusals import (
    refuse_friction,
    refuse_holding,
    refuse_others,
    refuse_singular,
    refuse_speeds,
    with_pivoting,
)
from lagrange_cli.families.saddle_points import SaddlePoint, refuse_coupled
from lagrange_cli.families.slopes import slopes
from lagrange_cli.families.spins import without_bound_spins
from lagrange_cli.families.switching.smooth import passing_where_parameters_jump, smooth_of
from lagrange_cli.records import replace
from lagrange_cli.spec.spec import Spec, grouped


def separate(
    spec: Spec, algebra: GraphAlgebra, *, coupled: bool = False, curved: bool = False
) -> FamilySystem:
    """The system without joints. M is constant unless it may be ``curved``, and diagonal unless it may be
    ``coupled``."""
    if spec.bodies and not curved:
        raise Unsuited
    builder = ChainBuilder(spec, algebra)
    graph, slots = builder.graph, builder.slots
    everyone = Domain(builder.q.count)
    energies = energies_of(builder, spec, coupled=coupled, curved=curved)
    potential, masses, totals = energies.potential, energies.masses, energies.totals
    whole = energies.coupled
    covered = np.zeros(builder.q.count, dtype=bool)
    for term in masses.terms:
        covered[term.targets] = True
    light = np.flatnonzero(~covered)
    if coupled and whole is None and not spec.bodies:
        raise Unsuited
    if light.size and (not spec.first_order or whole is not None or spec.constrained or spec.acts):
        raise Unsuited
    if whole is not None:
        whole.elimination  # noqa: B018 - refuses what is coupled to too much
        builder.totals.append(whole.entries)
    (gradient, vector), needed = slopes(potential, builder.root, totals, slots, builder.q, builder.v)
    changes, gained, taken = inertia(builder, whole.curved) if whole is not None else ([], [], [])
    quadratic = total_of(builder.q.count, [*changes, *gained], graph) if gained else None
    gradient = total_of(builder.q.count, [*gradient.terms, *changes], graph)
    if vector.terms:
        builder.totals += needed
        needed = []
        gained += [Term(one.domain, -builder.rate(one.node, one.domain), one.targets) for one in vector.terms]
    needed += taken
    rates = total_of(builder.q.count, [*gradient.terms, *gained], graph) if gained else gradient
    terms, _, beside = applied_forces(builder, spec, ())
    forces = total_of(builder.q.count, [*opposite(rates.terms), *terms], graph)
    without_mass = None
    if light.size:
        builder.totals += [*needed, *(one for one in beside if one not in builder.totals), masses]
        needed, beside = [], []
        without_mass = first_order_of(builder, light, masses, forces)
    else:
        builder.totals.append(masses)
    mass, speed = (slots.own(everyone, one) for one in (masses, builder.v))
    squares = [Term(everyone, 0.5 * mass * speed * speed, everyone.together)]
    momentum = [*opposite(vector.terms), Term(everyone, mass * speed, everyone.every)]
    if whole is not None:
        squares.append(whole.energy(slots, builder.v))
        momentum += whole.momenta(slots, builder.v)
    energy = builder.added(1, squares)
    kinetic = slots.own(builder.root, energy)
    momenta = total_of(builder.q.count, momentum, graph)
    apart = [masses, energy, *([] if whole is None else [whole.entries])]
    used = [total for total in builder.totals if total not in apart]
    bound = bonds(builder, spec)
    if whole is not None and whole.alone is not None and bound is not None:
        whole = without_bound_spins(whole, bound)
    if without_mass is not None:
        masses, forces = without_mass.as_with_mass(masses, graph)
        builder.totals.append(masses)
    saddle = None
    if whole is not None and (bound is not None or whole.curved):
        saddle = SaddlePoint(whole, bound or unbound())
    if (equations := saddle or bound) is not None:
        refuse_coupled(equations)
    return described(
        builder, everyone=everyone, masses=masses, forces=forces, needed=[*used, *needed, *beside],
        energies=totals, slopes=rates, gradient=gradient, vector=vector if vector.terms else None,
        centres=centres(builder, spec) if vector.terms or whole is not None else (),
        coupled_masses=whole, saddle=saddle, inertia=quadratic, first_order=without_mass,
        applied=total_of(builder.q.count, terms, graph),
        potential=potential, kinetic=kinetic, momenta=momenta, components=energies.components, bonds=bound,
        apart=energies.apart,
        accelerations=unknown(builder) if whole else divided(builder, everyone, forces, masses, bound),
    )  # fmt: skip


def unknown(builder: FamilyBuilder) -> Total:
    """Accelerations that are found together."""
    return Total(Source.TOTAL, builder.q.count)


def divided(
    builder: FamilyBuilder, everyone: Domain, forces: Total, masses: Total, bound: Bonds | None
) -> Total:
    """The accelerations of the coordinates where M is diagonal, (F + A^T lambda) / M."""
    count, slots = builder.q.count, builder.slots
    terms = [*forces.terms, *(bound.pulls_on_coordinates(slots) if bound else ())]
    whole = total_of(count, terms, builder.graph)
    force, mass = (slots.own(everyone, one) for one in (whole, masses))
    return total_of(count, [Term(everyone, force / mass, everyone.every)], builder.graph)


def articulated(spec: Spec, algebra: GraphAlgebra, *, platforms: bool = False) -> FamilySystem:
    """The system where particles are on chains and trees, or on several that hang from ``platforms``."""
    builder = ChainBuilder(spec, algebra)
    if platforms:
        put_on_platforms(builder, spec)
    graph, slots = builder.graph, builder.slots
    energies = [builder.of_root(one.tree, one.indices) for one in spec.potential.values()]
    potential = graph.sum([(one, 1.0) for one in energies])
    totals = [*builder.totals]
    found = articulation(builder, spec)
    given = *found.nodes, *(found.relative.chains if found.relative else ())
    (rates, *loads), needed = slopes(potential, builder.root, totals, slots, builder.q, *given)
    (whole,), _ = slopes(potential, builder.root, totals, slots, builder.q)
    refuse_speeds(builder, potential, (*totals, rates, *loads, *needed))
    terms, pushes, beside = applied_forces(builder, spec, given)
    forces = total_of(builder.q.count, [*opposite(rates.terms), *terms], graph)
    pulls = [total_of(one.count, [*one.terms, *opposite(push)], graph) for one, push in zip(loads, pushes)]
    energy = builder.added(1, [*kinetic_terms(builder, found)])
    kinetic = slots.own(builder.root, energy)
    applied = total_of(builder.q.count, [*terms, *felt(slots, found, pushes, builder.totals)], graph)
    momentum = momenta(builder, found)
    bound = bonds(builder, spec, found)
    if bound is not None and bound.surplus:
        refuse_coupled(bound)
    return described(
        builder, everyone=Domain(builder.q.count), masses=total_of(builder.q.count, [], graph), forces=forces,
        needed=[*needed, *beside], energies=totals, slopes=whole, gradient=whole, applied=applied,
        potential=potential, kinetic=kinetic, momenta=momentum, components=[], joints=found, loads=pulls,
        centres=centres(builder, spec), bonds=bound, vector=None,
        accelerations=unknown(builder),
    )  # fmt: skip


def described(builder: ChainBuilder, **parts: Any) -> FamilySystem:
    """The system that has been built of these parts."""
    spec = builder.spec
    positions = {
        name: builder.computed(group, np.arange(group.count)) for name, group in builder.positions.items()
    }
    observables = dict(observed(builder, spec))
    bound = parts["bonds"]
    joints, whole = parts.get("joints"), parts.get("coupled_masses")
    events = events_of(builder, spec)
    if events is not None and joints is not None:
        parts["events"] = on_joints(builder, events, joints, parts["kinetic"], bound=bound)
    elif events is not None and whole is not None:
        parts["events"] = with_coupled_masses(builder, events, whole, parts["kinetic"], bound=bound)
    elif events is not None:
        parts["events"] = with_actions(builder, events, parts["masses"], parts["forces"], bound=bound)
    if builder.bodies:
        from lagrange_cli.families.turning import bodies_of

        parts["bodies"] = bodies_of(builder)
    if joints is not None or parts["vector"] is not None or whole is not None:
        parts["speeds"] = {name: [*map(builder.rates_of, listed)] for name, listed in positions.items()}
    found = FamilySystem(
        spec=spec, algebra=builder.algebra, slots=builder.slots, q=builder.q, v=builder.v,
        given=builder.given, whole=builder.whole, time=builder.time, parameters=builder.parameters,
        root=builder.root, totals=builder.totals, positions=positions, observables=observables, **parts,
    )  # fmt: skip
    refuse_others(found)
    refuse_singular(found)
    found = with_pivoting(found)
    try:
        found = replace(found, smooth=smooth_of(found))
    except Unsuited:
        found = passing_where_parameters_jump(found)
    refuse_holding(found)
    if found.first_order is not None and found.smooth is not None:
        refuse_friction(found.smooth)
    return found


def observed(builder: FamilyBuilder, spec: Spec) -> Iterator[tuple[str, tuple[Total, int]]]:
    """Where each observable is computed."""
    for family in grouped(spec.observables, spec.families.get("observables", {})):
        group = group_of(family, spec.observables)
        arrays = builder.computed(group, np.arange(group.count))
        if len(arrays) != 1:
            raise Unsuited
        for i, name in enumerate(family.members):
            yield name, (arrays[0], i)
