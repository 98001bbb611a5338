"""What is known of a system of families: masses, forces, energies, and where each of them is."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from types import MappingProxyType
from typing import TYPE_CHECKING

import numpy as np

from lagrange_cli.expression.graph_algebra import GraphAlgebra
from lagrange_cli.expression.index_arrays import Places
from lagrange_cli.expression.node import Node
from lagrange_cli.families.arrays import Array, Domain, Slots, Total
from lagrange_cli.families.bonds import Bonds
from lagrange_cli.families.contacts import Contacts, Coupled, Impacts
from lagrange_cli.families.coupled_masses import CoupledMasses
from lagrange_cli.families.events import Events
from lagrange_cli.families.first_order import FirstOrder
from lagrange_cli.families.joints.joints import Articulation
from lagrange_cli.families.saddle_points import SaddlePoint
from lagrange_cli.mechanics.guards.guard import Rooted
from lagrange_cli.records import dataclass, field
from lagrange_cli.spec.content import names_of
from lagrange_cli.spec.spec import Spec

if TYPE_CHECKING:
    from lagrange_cli.families.turning import Bodies


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
class Locks:
    """Coordinates of joints that friction holds: ``gates`` are 0 of those, and 1 of all others. What would
    move them, ``left``, follows from the ``other`` forces on them and what they carry, and has no terms (see
    ``families.switching.locked``). Those that stick to coordinates of the joint before have the accelerations
    of these times ``carries``, one for each of its coordinates."""

    gates: Total
    other: Total
    left: Total
    carries: Sequence[Total] = ()


@dataclass(frozen=True, eq=False)
class Halts:
    """Coordinates that friction holds beside constraints: ``gates`` are 0 of those, and 1 of all others;
    ``other`` are all forces but friction and those of constraint."""

    gates: Total
    other: Total


@dataclass(frozen=True, eq=False)
class Modes:
    """What decides switches: the ``arguments``, and the modes that have their signs until these change.
    Those that are ``holding`` coordinates may be 0, with two ``limits`` for each of them (see
    ``families.switching.friction``). Friction between coordinates has forces that are the multipliers of
    ``sticking``, beside which all others are ``loose`` (see ``families.switching.relative_friction``)."""

    arguments: Total
    signs: Array
    holding: Places = field(default_factory=lambda: np.zeros(0, dtype=np.int64))
    limits: Total | None = None
    sticking: Bonds | None = None
    loose: Total | None = None
    locks: Locks | None = None
    """Coordinates of joints that may be held."""
    halts: Halts | None = None
    """The same of coordinates beside constraints."""
    placed: Places = field(default_factory=lambda: np.zeros(0, dtype=np.int64))
    """Of those that are holding, the ones that are decided by places."""
    vectors: Sequence[tuple[int, tuple[int, ...]]] = ()
    """The modes of lengths of vectors, each with the coordinates that it holds."""
    beside: Total | None = None
    """The components of each of these vectors, and of the force that holds it."""
    errors: Total | None = None
    """The rounding errors of accelerations by friction along them."""
    roots: Mapping[int, Rooted] = field(default_factory=dict)
    """Roots of arguments in forces, by the numbers of the modes."""
    silent: Sequence[tuple[int, int]] = ()
    """Modes that change nothing while others, which say so, are -1 (see ``families.switching.silencing``)."""

    @property
    def followed(self) -> tuple[Total, ...]:
        """What is followed beside the motion."""
        return tuple(one for one in (self.arguments, self.limits, self.beside) if one is not None)


@dataclass(frozen=True, eq=False)
class FamilySystem:
    """``masses`` and ``forces`` have an entry for each coordinate: M a = forces. If M is not diagonal,
    ``coupled_masses`` has it, and ``masses`` its diagonal. ``needed`` are the totals that the forces take, in
    the order in which they can be computed, ``totals`` all that expressions contain.
    ``energies`` are those that the potential is made of. The forces are those in L, opposite to the
    ``slopes``, and those that are ``applied`` besides. A U that is linear in velocities, such as that of
    charges in a magnetic field, has a derivative by these, ``vector``; the slopes are dU/dq - d/dt dU/dq_dot
    then (H. Goldstein, Classical Mechanics, 2nd ed., eq. 1-58), and dU/dq is the ``gradient``. Where M is no
    constant, -dL/dq is (see ``families.curved_masses``).
    ``potential`` and ``kinetic`` are expressions of a domain of one member, ``root``; with a given Lagrangian
    their difference is L.
    With ``joints``, M is none of its entries: the forces act on coordinates alone, and ``loads`` has what
    acts on nodes, and on sums of coordinates behind these, with the opposite sign.
    """

    spec: Spec
    algebra: GraphAlgebra
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
    gradient: Total
    applied: Total
    potential: Node
    kinetic: Node
    momenta: Total
    components: Sequence[Component]
    positions: Mapping[str, Sequence[Total]]
    observables: Mapping[str, tuple[Total, int]]
    accelerations: Total
    """Those of the coordinates. On chains and trees, and where M is not diagonal, they are computed from all
    equations together, and have no terms."""
    coupled_masses: CoupledMasses | None = None
    saddle: SaddlePoint | None = None
    """The same with constraints, or where M is no constant."""
    inertia: Total | None = None
    """What the slopes have of a T whose M is no constant: terms that are quadratic in velocities."""
    apart: tuple[Node, Node] | None = None
    """T and U, where they are not the parts of L that are quadratic in velocities, and the others: where
    axes move."""
    vector: Total | None = None
    joints: Articulation | None = None
    speeds: Mapping[str, Sequence[Total | None]] = MappingProxyType({})
    """The velocities of particles on chains and trees, or in a field; None of what rests."""
    centres: Sequence[Total] = ()
    """The sums of m x, m y and so on, likewise."""
    loads: Sequence[Total] = ()
    bodies: Mapping[str, Bodies] = MappingProxyType({})
    """Rigid bodies by family; their centres of mass are among the particles."""
    first_order: FirstOrder | None = None
    """Coordinates without mass, whose velocities follow from coordinates: ``masses`` and ``forces`` have them
    as if they had the mass 1."""
    bonds: Bonds | None = None
    """The constraints."""
    events: Events | None = None
    smooth: FamilySystem | None = None
    """The system with modes in place of switches in forces, if there are any."""
    modes: Modes | None = None
    """These modes, in that system."""
    contact: Contacts | Coupled | None = None
    """Resting contact, whose forces are among the others then (see ``families.impacts.resting``)."""
    passes: bool = False
    """Whether motions pass where the signs of parameters say whether forces jump, and nothing holds there."""

    @property
    def contacts(self) -> Contacts | Coupled | None:
        """Resting contact at events."""
        return None if self.impacts is None else self.impacts.contacts

    @property
    def coupled(self) -> Coupled | None:
        """The same, where its forces depend on one another."""
        contacts = self.contacts
        return contacts if isinstance(contacts, Coupled) and not contacts.separate else None

    @property
    def impacts(self) -> Impacts | None:
        """Impacts that reduce the speed."""
        return None if self.events is None else self.events.impacts

    @property
    def straight(self) -> bool:
        """Whether momenta are those of particles: M v, component by component."""
        return self.joints is None and self.vector is None and self.coupled_masses is None

    @property
    def curved(self) -> bool:
        """Whether M, without joints, is no constant."""
        return self.coupled_masses is not None and bool(self.coupled_masses.curved)

    @property
    def mixed(self) -> bool:
        """Whether a joint has several coordinates."""
        return self.joints is not None and any(len(one.rows) > 1 for one in self.joints.joints)

    @property
    def steady(self) -> bool:
        """Whether nothing depends on time explicitly."""
        given = *self.needed, self.forces, *self.loads, *(self.modes.followed if self.modes else ())
        return self.steady_potential and self.steady_bonds and not self.depends_on_time(given)

    @property
    def steady_bonds(self) -> bool:
        """Whether constraints do not depend on time explicitly."""
        return not any(one.symbols & self.time.symbols for one in (self.bonds.nodes if self.bonds else ()))

    @property
    def lasting_matrix(self) -> bool:
        """Whether the slopes of constraints, and M without joints, are constants of the motion."""
        if self.curved:
            return False
        nodes = [one for bound in (self.bonds.bounds if self.bonds else ()) for one in bound.slopes]
        moves = {self.q, self.v}
        return not any(one.symbols & self.time.symbols or self.slots.moving(one, moves) for one in nodes)

    @property
    def idle_bonds(self) -> bool:
        """Whether the forces of constraint do no work: what is at rest satisfies all constraints."""
        return self.steady_bonds and (self.bonds is None or self.bonds.idle(self.slots.graph))

    @property
    def moved_in_time(self) -> bool:
        """Whether positions depend on t besides coordinates, as T does then."""
        return self.apart is not None or self.driven_joints

    @property
    def timed_masses(self) -> bool:
        """Whether M depends on t, without joints."""
        curved = self.coupled_masses.curved if self.coupled_masses else ()
        return any(one.node.symbols & self.time.symbols for one in curved)

    @property
    def driven_joints(self) -> bool:
        """Whether the places of joints depend on t besides coordinates."""
        joints = self.joints
        if joints is None:
            return False
        driven = joints.relative is not None and joints.relative.driven
        return bool(driven) or any(one.symbols & self.time.symbols for one in joints.moved)

    @property
    def steady_potential(self) -> bool:
        """Whether L does not depend on time explicitly. In a rotating frame it need not."""
        if self.timed_masses or self.driven_joints:
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
        """The expressions that forces are made of, and constraints."""
        bound = self.bonds.nodes if self.bonds else ()
        return [*(one.node for total in self.acting for one in total.terms), *bound]

    @property
    def conserved(self) -> tuple[str, ...]:
        """h, and the momenta of cyclic coordinates, as far as their form shows that they are constants."""
        acted = np.zeros(self.q.count, dtype=bool)
        straight = self.vector is None and not self.curved
        for total in (self.forces,) if straight else (self.gradient, self.applied):
            for term in total.terms:
                acted[term.targets] = True
        for one in self.joints.joints if self.joints else ():
            for rows in one.rows:
                acted[rows] = True
        for bound in self.bonds.bounds if self.bonds else ():
            for rows in bound.rows:
                acted[rows] = True
        names = names_of(self.spec.coordinates)
        momenta = [f"p_{names[k]}" for k in np.flatnonzero(~acted).tolist()]
        idle = self.steady and self.idle_bonds and not self.driven
        return (*momenta, "h") if idle else tuple(momenta)
