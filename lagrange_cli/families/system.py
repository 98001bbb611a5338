"""The equations of motion of a system of families, in which every family stays one.

Particles move along lines and circles, or L is quadratic in velocities: M is mostly constant and diagonal, so
that a_k = -dU/dq_k / M_k. Else it is taken in blocks (``coupled_masses``, ``curved_masses``), or along chains
and trees (``joints``). All that is said of a member is said once, however many there are. Systems of another
kind are derived member by member (``mechanics``).
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import suppress
from typing import Any, TypeAlias

import numpy as np

from lagrange_cli.errors import TooLarge
from lagrange_cli.expression.graph_algebra import GraphAlgebra
from lagrange_cli.expression.index_arrays import Differ
from lagrange_cli.expression.indices import Unsuited
from lagrange_cli.expression.node import Node, reachable
from lagrange_cli.expression.syntax import ExpressionError
from lagrange_cli.families.applied import applied_forces
from lagrange_cli.families.arrays import Domain, Source, Term, Total, opposite, total_of
from lagrange_cli.families.bonds import Bonds, bonds, unbound
from lagrange_cli.families.builder import FamilyBuilder
from lagrange_cli.families.chains import ChainBuilder
from lagrange_cli.families.curved_masses import inertia
from lagrange_cli.families.description import FamilySystem
from lagrange_cli.families.events import events_of
from lagrange_cli.families.groups import group_of
from lagrange_cli.families.impacts.actions import on_joints, with_actions, with_coupled_masses
from lagrange_cli.families.joints.articulation import articulation, centres
from lagrange_cli.families.joints.inertia import felt, kinetic_terms, momenta
from lagrange_cli.families.joints.platforms import put_on_platforms
from lagrange_cli.families.masses import energies_of
from lagrange_cli.families.refusals import (
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

FEWEST = 100
"""Terms of all sums below which members are written out. With more, loops compile and run faster."""
FEWEST_CURVED = 50
"""The same where M is no constant: there is more to do in each term."""
FEWEST_JOINTED = 12
"""Coordinates of chains and trees below which they are, too: about where both take as long a step."""
FEWEST_TURNING = 50
"""Coordinates of rigid bodies that hang on none below which they are, too."""
MOST_TURNING = 1000
"""Terms of forces on these up to which that is so. More, as of pairs of many points, take long to compile."""
FEWEST_SWITCHED = 50
"""The same where there are switches, which cost more one by one."""
FEWEST_NONHOLONOMIC = 60
"""Coordinates of chains and trees with constraints on velocities below which they are, too: what these
conserve is looked for in systems of up to so many (``mechanics.constrained.frobenius``)."""
FEWEST_BOUND = 12
"""Constraints, or terms of sums in them, below which they are, too, where forces have few terms: rods of a
chain take as long in both ways, constraints that are not coupled to others less time in loops from 6 on."""
FEWEST_COUPLED = 6
"""Contacts that depend on one another below which they are, too: each is an unknown of equations there."""
MOST_WRITTEN_OUT = 150
"""Coordinates up to which they are, too, if some constraints follow from others in turn, and too much is
coupled."""
ALONE = 300
"""Operations of expressions that stand alone up to which they do no harm beside loops."""
SPARED = 3
"""How many times as much there has to be to do as is written singly, for loops to pay."""
Reason: TypeAlias = "tuple[str, ...]"
UNKNOWN = ("replaced",)
"""Parts of a system that are derived member by member."""

_LATEST: list[tuple[Spec, type[GraphAlgebra], FamilySystem | None, Reason]] = []
"""The last two, which are asked for once more when they are compiled; and why there is none, if that is
known."""
_WHOLE: list[tuple[Spec, Spec]] = []
"""The last one with all constraints."""


def family_system(spec: Spec, algebra: type[GraphAlgebra] = GraphAlgebra) -> FamilySystem | None:
    """The system, if it is of this kind and has many terms; None otherwise, also where something is wrong:
    who goes through its members finds what. Numbers are those of an ``algebra``."""
    found = any_family_system(spec, algebra)
    if found is None or (spec.nonholonomic and found.q.count < fewest_bound(found)):
        return None
    if found.joints and found.joints.count:
        return found
    if found.bodies:
        few = found.q.count < FEWEST_TURNING and found.terms <= MOST_TURNING
    elif found.coupled is not None and found.coupled.count >= FEWEST_COUPLED:
        few = False
    elif found.bonds is not None:
        few = found.bonds.terms < FEWEST_BOUND and found.terms < FEWEST
    else:
        watched = sum(one.domain.count for one in found.events.arguments.terms) if found.events else 0
        least = FEWEST_CURVED if found.curved else FEWEST
        few = found.terms + watched < (least if found.smooth is None else FEWEST_SWITCHED)
    return None if few or mostly_single(found) else found


def fewest_bound(system: FamilySystem) -> int:
    """Coordinates below which members are written out where there are constraints on velocities, and M is no
    constant. Where joints are sums of coordinates, M couples all of them, which takes long to compile."""
    if system.joints is not None:
        return FEWEST_NONHOLONOMIC if system.joints.relative is None else FEWEST_JOINTED
    return FEWEST_NONHOLONOMIC if system.curved else 0


def mostly_single(system: FamilySystem) -> bool:
    """Whether loops would save little: most of the operations are those of expressions that stand alone."""
    nodes: dict[Domain, list[Node]] = {}
    for total in system.acting:
        for one in total.terms:
            nodes.setdefault(one.domain, []).append(one.node)
    sizes = {domain: sum(1 for _ in reachable(own)) for domain, own in nodes.items()}
    single = sum(size for domain, size in sizes.items() if domain.count == 1)
    return single > ALONE and SPARED * single > sum(domain.count * size for domain, size in sizes.items())


def any_family_system(spec: Spec, algebra: type[GraphAlgebra] = GraphAlgebra) -> FamilySystem | None:
    """The same, however few terms it has."""
    return _latest(spec, algebra)[0]


def reason(spec: Spec) -> Reason:
    """What members are written out for, and a way to do without, where that is known."""
    return _latest(spec, GraphAlgebra)[1]


def _latest(spec: Spec, algebra: type[GraphAlgebra]) -> tuple[FamilySystem | None, Reason]:
    found: FamilySystem | None
    why: Reason
    for known, numbers, found, why in _LATEST:
        if known is spec and numbers is algebra:
            return found, why
    found, why = None, ()
    if spec.coordinate_families and not any(getattr(spec, part) for part in UNKNOWN):
        try:
            found = made(spec, algebra)
        except Unsuited as error:
            why = error.args
        except (Differ, ExpressionError, TooLarge, ArithmeticError):
            pass
    _LATEST[:] = [(spec, algebra, found, why), *_LATEST[:1]]
    return found, why


def with_all_constraints(spec: Spec) -> Spec:
    """The same where none is left out: those that follow from others are treated as if this were in turn."""
    for known, whole in _WHOLE:
        if known is spec:
            return whole
    _WHOLE[:] = [(spec, replace(spec, in_turn=spec.left_out))]
    return _WHOLE[0][1]


def without_constraints(spec: Spec) -> FamilySystem | None:
    """The system that a file describes without its constraints and events, if it is of this kind."""
    if not spec.constrained and not spec.events:
        return any_family_system(spec)
    return any_family_system(replace(spec, constraints={}, nonholonomic={}, left_out=(), events={}))


def made(spec: Spec, algebra: type[GraphAlgebra] = GraphAlgebra) -> FamilySystem:
    """The system. Raises ``Unsuited`` where it is of another kind.

    Constraints that follow from others in turn are kept. Where that is not possible, members are written out,
    unless they are too many: then the same constraints are left out everywhere.
    """
    if not spec.in_turn:
        return of_any_kind(spec, algebra)
    turns = {*spec.in_turn}
    left_out, in_turn = (tuple(i for i in spec.left_out if (i in turns) is kept) for kept in (False, True))
    with suppress(Unsuited, Differ):
        found = of_any_kind(replace(spec, left_out=left_out, in_turn=in_turn), algebra)
        if found.bonds is not None and found.bonds.surplus:
            return replace(found, spec=spec)
    if len(spec.coordinates) <= MOST_WRITTEN_OUT:
        raise Unsuited
    return replace(of_any_kind(replace(spec, in_turn=()), algebra), spec=spec)


def of_any_kind(spec: Spec, algebra: type[GraphAlgebra]) -> FamilySystem:
    """The system, of the first kind that it is of; raises ``Unsuited``."""
    try:
        return separate(spec, algebra())
    except (Unsuited, Differ) as error:
        if error.args:
            raise
    why: Unsuited | Differ | None = None
    if spec.lagrangian is None and len(spec.coordinates) >= FEWEST_JOINTED:
        for platforms in (False, True):
            try:
                return articulated(spec, algebra(), platforms=platforms)
            except (Unsuited, Differ) as error:
                why = why or error
    for curved in (False, True):
        try:
            return separate(spec, algebra(), coupled=True, curved=curved)
        except (Unsuited, Differ) as error:
            if error.args:
                raise
            why = why or error
    assert why is not None
    raise why


def separate(
    spec: Spec, algebra: GraphAlgebra, *, coupled: bool = False, curved: bool = False
) -> FamilySystem:
    """The same without joints. M is constant unless it may be ``curved``, and diagonal unless it may be
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
    if not covered.all() or (coupled and whole is None):
        raise Unsuited
    if whole is not None:
        whole.elimination  # noqa: B018 - refuses what is coupled to too much
        builder.totals.append(whole.entries)
    (gradient, vector), needed = slopes(potential, builder.root, totals, slots, builder.q, builder.v)
    changes, gained = inertia(builder, whole.curved) if whole is not None else ([], [])
    quadratic = total_of(builder.q.count, [*changes, *gained], graph) if gained else None
    gradient = total_of(builder.q.count, [*gradient.terms, *changes], graph)
    if vector.terms:
        builder.totals += needed
        needed = []
        gained += [Term(one.domain, -builder.rate(one.node, one.domain), one.targets) for one in vector.terms]
    rates = total_of(builder.q.count, [*gradient.terms, *gained], graph) if gained else gradient
    terms, _, beside = applied_forces(builder, spec, ())
    forces = total_of(builder.q.count, [*opposite(rates.terms), *terms], graph)
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
    apart = masses, energy, *([] if whole is None else [whole.entries])
    used = [total for total in builder.totals if total not in apart]
    bound = bonds(builder, spec)
    if whole is not None and whole.alone is not None and bound is not None:
        whole = without_bound_spins(whole, bound)
    saddle = None
    if whole is not None and (bound is not None or whole.curved):
        saddle = SaddlePoint(whole, bound or unbound())
    if (equations := saddle or bound) is not None:
        refuse_coupled(equations)
    return described(
        builder, everyone=everyone, masses=masses, forces=forces, needed=[*used, *needed, *beside],
        energies=totals, slopes=rates, gradient=gradient, vector=vector if vector.terms else None,
        centres=centres(builder, spec) if vector.terms or whole is not None else (),
        coupled_masses=whole, saddle=saddle, inertia=quadratic,
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
    """The same, where particles are on chains and trees, or on several that hang from ``platforms``."""
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
