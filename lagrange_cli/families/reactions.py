"""Forces of constraint on particles of families, R = m a - F, in components of space.

F is that of U and D as functions of places and velocities, and what acts on particles
(``mechanics.constrained.reactions``): these are built once more, with places that are given. a is the second
derivative of the places, along chains and trees as these are, with the accelerations of coordinates in it.
Where M is diagonal, a coordinate that moves one component alone tells the force on it without a difference:
A^T lambda by the slope.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence

import numpy as np

from lagrange_cli.expression.algebra import Value
from lagrange_cli.expression.index_arrays import Differ, Places
from lagrange_cli.expression.indices import Unsuited
from lagrange_cli.expression.node import Node
from lagrange_cli.expression.vocabulary import AXES_COMPONENTS, AXES_RATES, COMPONENTS
from lagrange_cli.families.applied import DISSIPATION, ON_COORDINATES, ON_PARTICLES
from lagrange_cli.families.arrays import Array, Domain, Source, Term, Total, opposite, total_of
from lagrange_cli.families.chains import ChainBuilder, together
from lagrange_cli.families.description import FamilySystem
from lagrange_cli.families.groups import Group, alike, among, group_of, particle_families
from lagrange_cli.families.joints.responses import trees_of
from lagrange_cli.families.slopes import slopes
from lagrange_cli.mechanics.embedding import MOST_AT_ONCE
from lagrange_cli.records import dataclass
from lagrange_cli.spec.content import names_of
from lagrange_cli.spec.spec import grouped

Axis = tuple[str, int]
"""A family of particles, and an axis."""


@dataclass(frozen=True, eq=False)
class Reactions:
    """R by family, component by component, of those on which the applied force is ``known``, and why it is
    not, of the others."""

    known: Mapping[str, Sequence[Total]]
    unknown: Mapping[str, str]


class InSpace(ChainBuilder):
    """A builder for which the places of particles and how bodies stand are given: arrays that are theirs."""

    def __init__(self, system: FamilySystem) -> None:
        super().__init__(system.spec, system.algebra)
        self.system, self.slots, self.whole, self.given = system, system.slots, system.whole, system.given
        self.q, self.v = system.q, system.v
        self.faster = {system.q: system.v, system.v: system.accelerations}
        self._declare(system.spec)
        if system.joints is not None:
            self._rates |= system.joints.followed
        for name, speeds in system.speeds.items():
            self._rates |= zip(system.positions[name], speeds)
        self.places: dict[Axis, Total] = {
            (name, axis): one for name, axes in system.positions.items() for axis, one in enumerate(axes)
        }
        self.speeds = {axis: self.rates_of(one) for axis, one in self.places.items()}
        self.orientations: dict[tuple[str, str], Total] = {}

    def member(self, group: Group, which: Places, domain: Domain) -> Value:
        name = group.family.name
        if self.positions.get(name) is not group:
            return super().member(group, which, domain)
        return together(self.slots.symbol(domain, one, which) for one in self.system.positions[name])

    def oriented(self, name: str, component: str, which: Places, domain: Domain) -> Node:
        if name not in self.system.bodies:
            raise Unsuited
        return self.slots.symbol(domain, self.orientation(name, component), which)

    def orientation(self, name: str, component: str) -> Total:
        """That component of all bodies of a family."""
        if (name, component) not in self.orientations:
            bodies = self.system.bodies[name]
            made = bodies.total(lambda one: one.turning.component(component))
            self.orientations[name, component] = made
            if component in AXES_COMPONENTS:
                rate = AXES_RATES[AXES_COMPONENTS.index(component)]
                self._rates[made] = self.orientation(name, rate)
        return self.orientations[name, component]


def reactions(system: FamilySystem) -> Reactions | None:
    """R of the particles of each family; None where members have to be looked at one by one."""
    if system.spec.lagrangian is not None or system.contacts is not None or held(system):
        return None
    try:
        return _Reactions(system).found()
    except (Unsuited, Differ):
        return None


def held(system: FamilySystem) -> bool:
    """Whether dry friction may hold coordinates, by forces that q and v do not determine."""
    modes = None if system.smooth is None else system.smooth.modes
    return modes is not None and (modes.limits is not None or modes.sticking is not None)


class _Reactions:
    def __init__(self, system: FamilySystem) -> None:
        self.system, self.slots, self.graph = system, system.slots, system.slots.graph

    def found(self) -> Reactions:
        """R, or why it is not known."""
        alone = [*self.alone()]
        parts: dict[Axis, list[Term]] = {
            (name, axis): [] for name, axes in self.system.positions.items() for axis in range(len(axes))
        }
        rests = {key: np.ones(self.system.positions[key[0]][key[1]].count, dtype=bool) for key in parts}
        for key, term in alone:
            parts[key].append(term)
            rests[key][term.targets] = False
        unknown: Mapping[str, str] = {}
        if any(one.any() for one in rests.values()):
            builder = InSpace(self.system)
            against, along = self.against(builder)
            unknown = self.unknown(rests, along)
            for key, terms in self.inertia(builder):
                against[key] = [*against.get(key, ()), terms]
            for key, which in rests.items():
                total = total_of(len(which), against.get(key, ()), self.graph)
                places = np.flatnonzero(which)
                if len(places) and total.terms:
                    domain = Domain(len(places))
                    parts[key].append(Term(domain, self.slots.symbol(domain, total, places), places))
        known = {
            name: [Total(Source.TOTAL, one.count, tuple(parts[name, axis])) for axis, one in enumerate(axes)]
            for name, axes in self.system.positions.items()
            if name not in unknown
        }
        return Reactions(known, unknown)

    def alone(self) -> Iterator[tuple[Axis, Term]]:
        """R on the components that a coordinate moves which moves nothing else: A^T lambda by the slope."""
        system = self.system
        moved = [one.rows for one in system.components]
        often = np.bincount(np.concatenate([*moved, np.zeros(0, dtype=np.int64)]), minlength=system.q.count)
        bonds = system.bonds
        pull = total_of(system.q.count, bonds.pulls_on_coordinates(self.slots) if bonds else (), self.graph)
        for one in system.components:
            if np.all(often[one.rows] == 1):
                force = self.slots.symbol(one.domain, pull, one.rows) / one.slope
                node = force if pull.terms else self.graph.zero
                yield (one.family, one.axis), Term(one.domain, node, one.members)

    def against(self, builder: InSpace) -> tuple[dict[Axis, list[Term]], dict[int, str]]:
        """-F on each component of the places of a family, and the coordinates along which there are forces
        besides, with what is said of these."""
        spec, system = self.system.spec, self.system
        if system.vector is not None:
            raise Unsuited  # the rate of dU/dv is a force, too
        found: dict[Axis, list[Term]] = {}
        along: dict[int, str] = {}
        dissipation = spec.forces.get(DISSIPATION, {})
        for energies, arrays, own, what in (
            (spec.potential, builder.places, system.q, "U contains"),
            (dissipation, builder.speeds, system.v, "the dissipation contains the velocity of"),
        ):
            by = {key: one for key, one in arrays.items() if one is not None}
            for energy in energies.values():
                root = builder.of_root(energy.tree, energy.indices)
                given = own, *by.values(), *builder.orientations.values()
                (others, *listed), _ = slopes(root, builder.root, builder.totals, self.slots, *given)
                for key, one in zip(by, listed):
                    found.setdefault(key, []).extend(one.terms)
                along |= {int(k): what for term in others.terms for k in term.targets}
        written = spec.forces.get(ON_COORDINATES, {})
        for family in grouped(written, spec.families.get(ON_COORDINATES, {})):
            rows = builder.rows[family.name]
            listed_rows = rows.first + among(family, rows.family)
            along |= dict.fromkeys(listed_rows.tolist(), "a generalized force is given along")
        for key, term in pushes(builder):
            found.setdefault(key, []).extend(opposite([term]))
        return found, along

    def inertia(self, builder: InSpace) -> Iterator[tuple[Axis, Term]]:
        """m a on each component that moves."""
        spec = self.system.spec
        for family in grouped(spec.embedding, particle_families(spec)):
            masses = group_of(family, spec.masses)
            (mass,) = builder.computed(masses, np.arange(masses.count))
            for axis, _ in enumerate(self.system.positions[family.name]):
                speed = builder.speeds[family.name, axis]
                rate = None if speed is None else builder.rates_of(speed)
                if rate is not None:
                    domain = Domain(rate.count)
                    m, a = (self.slots.own(domain, one) for one in (mass, rate))
                    yield (family.name, axis), Term(domain, m * a, domain.every)

    def unknown(self, rests: Mapping[Axis, Places], along: Mapping[int, str]) -> Mapping[str, str]:
        """Why forces on a family are not known: those ``along`` coordinates say what work is done, not on
        which particle. Raises ``Unsuited`` where there may be as many components as coordinates."""
        system, found = self.system, dict[str, str]()
        for (name, axis), rest in rests.items():
            moved = self.moved(system.positions[name][axis]) if rest.any() else set[int]()
            acting = min(moved.intersection(along), default=None)
            if acting is None:
                continue
            if system.joints is None:
                raise Unsuited
            trees = trees_of(system.joints, system.q.count)[1]
            if np.bincount(trees)[trees[[*moved.intersection(along)]]].min() <= MOST_AT_ONCE:
                raise Unsuited
            coordinate, particle = names_of(system.spec.coordinates)[acting], self.first_of(name)
            found.setdefault(
                name,
                f"the forces on '{name}' are not known, since {along[acting]} the coordinate '{coordinate}'; "
                f"write it in positions, such as {particle}.{COMPONENTS[axis]}",
            )
        return found

    def first_of(self, name: str) -> str:
        """The first particle of a family."""
        spec = self.system.spec
        families = grouped(spec.embedding, particle_families(spec))
        return next(one.members[0] for one in families if one.name == name)

    def moved(self, total: Total) -> set[int]:
        """The coordinates that a total depends on."""
        found, seen, pending = set[int](), set[Array](), [total]
        while pending:
            one = pending.pop()
            if one in seen:
                continue
            seen.add(one)
            for term in one.terms:
                for _, slot in self.slots.inside(term.node):
                    if slot.array is self.system.q:
                        found.update(slot.table.tolist())
                    elif isinstance(slot.array, Total):
                        pending.append(slot.array)
        return found


def pushes(builder: InSpace) -> Iterator[tuple[Axis, Term]]:
    """What is applied to particles: the family and axis, and the force on its members."""
    spec = builder.spec
    written = spec.forces.get(ON_PARTICLES, {})
    for family in grouped(written, {**particle_families(spec), **spec.families.get(ON_PARTICLES, {})}):
        forces, positions = group_of(family, written), builder.positions[family.name]
        own = among(family, positions.family)
        for which in alike(forces, positions, own):
            domain = Domain(len(which))
            given = builder.value(*forces.members(which, builder.sizes, domain))
            for axis, force in enumerate(given if isinstance(given, tuple) else (given,)):
                yield (family.name, axis), Term(domain, force, own[which])
