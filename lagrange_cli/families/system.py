"""The equations of motion of a system of families, in which every family stays one.

The coordinates are places of particles, or L is quadratic in velocities: M is diagonal and constant, and
a_k = -dU/dq_k / M_k. All that is said of a member is said once, however many there are. Systems of another
kind are derived member by member (``mechanics``).
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import suppress
from typing import Any

import numpy as np

from lagrange_cli.errors import TooLarge
from lagrange_cli.expression.index_arrays import Differ, Places
from lagrange_cli.expression.indices import Unsuited
from lagrange_cli.expression.node import Kind, Node, reachable
from lagrange_cli.expression.syntax import ExpressionError
from lagrange_cli.families.applied import applied_forces
from lagrange_cli.families.arrays import Array, Domain, Slots, Term, Total, total_of
from lagrange_cli.families.builder import FamilyBuilder
from lagrange_cli.families.chains import ChainBuilder
from lagrange_cli.families.groups import alike, group_of, particle_families
from lagrange_cli.families.joints import Articulation, articulation, felt, kinetic_terms, momenta
from lagrange_cli.families.slopes import factors, slopes
from lagrange_cli.mechanics.substitution import substituted
from lagrange_cli.records import dataclass
from lagrange_cli.spec.spec import Spec, grouped

FEWEST = 1000
"""Terms of all sums below which members are written out."""
FEWEST_JOINTED = 20
"""Coordinates of chains and trees below which they are, too: about where both take as long a step."""
UNKNOWN = "constraints", "nonholonomic", "bodies", "events", "replaced"
"""Parts of a system that are derived member by member."""

_LATEST: list[tuple[Spec, FamilySystem | None]] = []
"""The last one, which is asked for once more when it is compiled."""


@dataclass(frozen=True, eq=False)
class Component:
    """A component of the places of some particles, which moves: x of ``axis`` of the ``members`` of a family,
    with dx/dq, the ``slope``, for the coordinates in these ``rows``."""

    family: str
    axis: int
    members: Places
    domain: Domain
    rows: Places
    mass: Node
    slope: Node


@dataclass(frozen=True, eq=False)
class FamilySystem:
    """``masses`` and ``forces`` have an entry for each coordinate: M a = forces. ``needed`` are the totals
    that the forces take, in the order in which they can be computed, ``totals`` all that expressions contain.
    ``energies`` are those that the potential is made of. The forces are those in L, -dU/dq of the ``slopes``,
    and those that are ``applied`` besides.
    ``potential`` and ``kinetic`` are expressions of a domain of one member, ``root``; with a given Lagrangian
    their difference is L.
    With ``joints``, M is none of its entries: the forces act on coordinates alone, and ``loads`` has what
    acts on nodes, with the opposite sign.
    """

    spec: Spec
    slots: Slots
    q: Array
    v: Array
    given: Array
    whole: Array
    time: Node
    parameters: Mapping[str, Node]
    root: Domain
    everyone: Domain
    totals: Sequence[Total]
    masses: Total
    forces: Total
    needed: Sequence[Total]
    energies: Sequence[Total]
    slopes: Total
    applied: Total
    potential: Node
    kinetic: Node
    momenta: Total
    components: Sequence[Component]
    positions: Mapping[str, Sequence[Total]]
    observables: Mapping[str, tuple[Total, int]]
    joints: Articulation | None = None
    loads: Sequence[Total] = ()

    @property
    def steady(self) -> bool:
        """Whether nothing depends on time explicitly."""
        return self.steady_potential and not self.depends_on_time((*self.needed, self.forces, *self.loads))

    @property
    def steady_potential(self) -> bool:
        """Whether L does not depend on time explicitly."""
        if self.joints is not None and any(one.symbols & self.time.symbols for one in self.joints.moved):
            return False
        return not self.potential.symbols & self.time.symbols and not self.depends_on_time(self.energies)

    def depends_on_time(self, totals: Iterable[Total]) -> bool:
        """Whether a term of one of them contains t."""
        return any(one.node.symbols & self.time.symbols for total in totals for one in total.terms)

    @property
    def driven(self) -> bool:
        """Whether a force is not in L."""
        return bool(self.applied.terms)

    @property
    def terms(self) -> int:
        """How many terms all forces have together."""
        return sum(one.domain.count for total in self.acting for one in total.terms)

    @property
    def acting(self) -> Sequence[Total]:
        """What forces are made of."""
        moved = self.joints.nodes if self.joints else ()
        return self.forces, *self.loads, *self.needed, *moved

    @property
    def force_nodes(self) -> list[Node]:
        """The expressions that forces are made of."""
        return [one.node for total in self.acting for one in total.terms]

    @property
    def conserved(self) -> tuple[str, ...]:
        """h, and the momenta of cyclic coordinates, as far as their form shows that they are constants."""
        acted = np.zeros(self.q.count, dtype=bool)
        for term in self.forces.terms:
            acted[term.targets] = True
        for one in self.joints.joints if self.joints else ():
            for rows in one.rows:
                acted[rows] = True
        momenta = [f"p_{self.spec.coordinates[k].name}" for k in np.flatnonzero(~acted).tolist()]
        return (*momenta, "h") if self.steady and not self.driven else tuple(momenta)


def family_system(spec: Spec) -> FamilySystem | None:
    """The system, if it is of this kind and has many terms; None otherwise, also where something is wrong:
    who goes through its members finds what."""
    found: FamilySystem | None
    for known, found in _LATEST:
        if known is spec:
            return found
    found = None
    if spec.families.get("coordinates") and not any(getattr(spec, part) for part in UNKNOWN):
        with suppress(Unsuited, Differ, ExpressionError, TooLarge, ArithmeticError):
            found = made(spec)
    if found is not None and found.terms < FEWEST and not (found.joints and found.joints.count):
        found = None
    _LATEST[:] = [(spec, found)]
    return found


def made(spec: Spec) -> FamilySystem:
    """The system. Raises ``Unsuited`` where it is of another kind."""
    try:
        return separate(spec)
    except (Unsuited, Differ):
        if spec.lagrangian is not None or len(spec.coordinates) < FEWEST_JOINTED:
            raise
    return articulated(spec)


def separate(spec: Spec) -> FamilySystem:
    """The same, where M is diagonal and constant."""
    builder = ChainBuilder(spec)
    graph, slots = builder.graph, builder.slots
    everyone = Domain(builder.q.count)
    if spec.lagrangian is None:
        energies = [builder.of_root(one.tree, one.indices) for one in spec.potential.values()]
        potential = graph.sum([(one, 1.0) for one in energies])
        totals = [*builder.totals]
        components = [*particles(builder, spec)]
        inertia = [Term(one.domain, one.mass * one.slope * one.slope, one.rows) for one in components]
        masses = total_of(builder.q.count, inertia, graph)
    else:
        components = []
        lagrangian = builder.of_root(spec.lagrangian.tree, spec.lagrangian.indices)
        potential, masses = separated(builder, lagrangian)
        totals = [*builder.totals]
    covered = np.zeros(builder.q.count, dtype=bool)
    for term in masses.terms:
        covered[term.targets] = True
    if not covered.all():
        raise Unsuited
    (rates,), needed = slopes(potential, builder.root, totals, slots, builder.q)
    refuse_speeds(builder, potential, (*totals, rates, *needed))
    terms, _, beside = applied_forces(builder, spec, ())
    forces = total_of(builder.q.count, [*opposite(rates), *terms], graph)
    builder.totals.append(masses)
    mass = slots.symbol(everyone, masses, np.arange(builder.q.count))
    speed = slots.symbol(everyone, builder.v, np.arange(builder.q.count))
    zeros = np.zeros(builder.q.count, dtype=np.int64)
    energy = builder.added(1, [Term(everyone, 0.5 * mass * speed * speed, zeros)])
    kinetic = slots.symbol(builder.root, energy, np.zeros(1, dtype=np.int64))
    momenta = total_of(builder.q.count, [Term(everyone, mass * speed, np.arange(builder.q.count))], graph)
    used = [total for total in builder.totals if total not in (masses, energy)]
    return described(
        builder, everyone=everyone, masses=masses, forces=forces, needed=[*used, *needed, *beside],
        energies=totals, slopes=rates, applied=total_of(builder.q.count, terms, graph), potential=potential,
        kinetic=kinetic, momenta=momenta, components=components,
    )  # fmt: skip


def articulated(spec: Spec) -> FamilySystem:
    """The same, where particles are on chains and trees."""
    builder = ChainBuilder(spec)
    graph, slots = builder.graph, builder.slots
    energies = [builder.of_root(one.tree, one.indices) for one in spec.potential.values()]
    potential = graph.sum([(one, 1.0) for one in energies])
    totals = [*builder.totals]
    found = articulation(builder, spec)
    (rates, *loads), needed = slopes(potential, builder.root, totals, slots, builder.q, *found.nodes)
    (whole,), _ = slopes(potential, builder.root, totals, slots, builder.q)
    refuse_speeds(builder, potential, (*totals, rates, *loads, *needed))
    terms, pushes, beside = applied_forces(builder, spec, found.nodes)
    forces = total_of(builder.q.count, [*opposite(rates), *terms], graph)
    pulls = [
        total_of(one.count, [*one.terms, *(Term(t.domain, -t.node, t.targets) for t in push)], graph)
        for one, push in zip(loads, pushes)
    ]
    energy = builder.added(1, [*kinetic_terms(builder, found)])
    kinetic = slots.symbol(builder.root, energy, np.zeros(1, dtype=np.int64))
    applied = total_of(builder.q.count, [*terms, *felt(builder, found, pushes)], graph)
    momentum = momenta(builder, found)
    return described(
        builder, everyone=Domain(builder.q.count), masses=total_of(builder.q.count, [], graph), forces=forces,
        needed=[*needed, *beside], energies=totals, slopes=whole, applied=applied,
        potential=potential, kinetic=kinetic, momenta=momentum, components=[], joints=found, loads=pulls,
    )  # fmt: skip


def described(builder: ChainBuilder, **parts: Any) -> FamilySystem:
    """The system that has been built of these parts."""
    spec = builder.spec
    positions = {
        name: builder.computed(group, np.arange(group.count)) for name, group in builder.positions.items()
    }
    observables = dict(observed(builder, spec))
    found = FamilySystem(
        spec=spec, slots=builder.slots, q=builder.q, v=builder.v, given=builder.given, whole=builder.whole,
        time=builder.time, parameters=builder.parameters, root=builder.root, totals=builder.totals,
        positions=positions, observables=observables, **parts,
    )  # fmt: skip
    refuse_others(found)
    return found


def opposite(total: Total) -> list[Term]:
    """Terms with the other sign."""
    return [Term(one.domain, -one.node, one.targets) for one in total.terms]


def particles(builder: FamilyBuilder, spec: Spec) -> Iterator[Component]:
    """The components of all particles that move. Each contains one coordinate at most, linearly."""
    families = grouped(spec.embedding, particle_families(spec))
    for family in families:
        group, masses = builder.positions[family.name], group_of(family, spec.masses)
        for which in alike(group, masses):
            domain = Domain(len(which))
            values = [builder.value(*one.members(which, builder.sizes, domain)) for one in (group, masses)]
            position, mass = values
            if not fixed(builder, mass):
                raise Unsuited
            for axis, x in enumerate(position if isinstance(position, tuple) else (position,)):
                if x.symbols & builder.time.symbols:
                    raise Unsuited
                inside = [(s, slot) for s, slot in builder.slots.inside(x) if slot.array is not builder.given]
                inside = [(s, slot) for s, slot in inside if slot.array is not builder.whole]
                if len(inside) > 1 or any(slot.array is not builder.q for _, slot in inside):
                    raise Unsuited
                for symbol, slot in inside:
                    slope = builder.graph.diff(x, symbol)
                    if not fixed(builder, slope):
                        raise Unsuited
                    yield Component(family.name, axis, which, domain, slot.table, mass, slope)


def fixed(builder: FamilyBuilder, node: Node) -> bool:
    """Whether it is a constant of the motion."""
    if node.symbols & builder.time.symbols:
        return False
    constant = builder.given, builder.whole
    return all(slot.array in constant for _, slot in builder.slots.inside(node))


def separated(builder: FamilyBuilder, lagrangian: Node) -> tuple[Node, Total]:
    """A given Lagrangian as sum M v^2/2 - U: U, and M. The terms of totals that contain velocities lose
    them."""
    graph, slots = builder.graph, builder.slots
    linear = factors(lagrangian, builder.totals, slots)
    masses: list[Term] = []

    def parted(domain: Domain, node: Node, factor: Node | None) -> Node:
        """Without its velocities, whose masses are noted."""
        speeds = [(s, slot) for s, slot in slots.inside(node) if slot.array is builder.v]
        for symbol, slot in speeds:
            momentum = graph.diff(node, symbol)
            mass = graph.diff(momentum, symbol)
            if factor is None or not fixed(builder, mass) or momentum is not mass * symbol:
                raise Unsuited
            masses.append(Term(domain, factor * mass, slot.table))
        return substituted(graph, [node], {s: graph.zero for s, _ in speeds})[0] if speeds else node

    replaced: dict[Total, Total] = {}
    for i, total in enumerate(builder.totals):
        factor = linear.get(total)
        terms = [Term(one.domain, parted(one.domain, one.node, factor), one.targets) for one in total.terms]
        if any(new.node is not old.node for new, old in zip(terms, total.terms)):
            replaced[total] = builder.totals[i] = total_of(total.count, terms, graph)
    potential = -parted(builder.root, lagrangian, graph.one)
    for symbol, slot in [*slots.of.items()]:
        if isinstance(slot.array, Total) and slot.array in replaced:
            other = slots.symbol(slot.domain, replaced[slot.array], slot.table)
            potential = substituted(graph, [potential], {symbol: other})[0]
            for total in builder.totals:
                if any(one.node.symbols & symbol.symbols for one in total.terms):
                    raise Unsuited
    return potential, total_of(builder.q.count, masses, graph)


def observed(builder: FamilyBuilder, spec: Spec) -> Iterator[tuple[str, tuple[Total, int]]]:
    """Where each observable is computed."""
    for family in grouped(spec.observables, spec.families.get("observables", {})):
        group = group_of(family, spec.observables)
        arrays = builder.computed(group, np.arange(group.count))
        if len(arrays) != 1:
            raise Unsuited
        for i, name in enumerate(family.members):
            yield name, (arrays[0], i)


def refuse_speeds(builder: FamilyBuilder, potential: Node, totals: Iterable[Total]) -> None:
    """Raise ``Unsuited`` where an energy depends on velocities beyond the masses."""
    for node in (potential, *(one.node for total in totals for one in total.terms)):
        if any(slot.array is builder.v for _, slot in builder.slots.inside(node)):
            raise Unsuited


def refuse_others(system: FamilySystem) -> None:
    """Raise ``Unsuited`` where forces may jump, or have kinks."""
    for node in reachable([*system.force_nodes, system.potential]):
        if node.kind in (Kind.SWITCH, Kind.DDT) or (node.kind is Kind.FUNCTION and node.data == "atan2"):
            raise Unsuited
