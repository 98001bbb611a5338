"""Energies, momenta and forces of a system whose families are not expanded, as places in totals."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np

from lagrange_cli.expression.node import Kind, reachable
from lagrange_cli.families.arrays import Source, Term, Total, total_of
from lagrange_cli.families.description import FamilySystem
from lagrange_cli.families.joints.inertia import felt
from lagrange_cli.families.slopes import slopes
from lagrange_cli.records import dataclass, replace

Element = tuple[Total, int]
"""A number: the total that contains it, and its place there."""


def of_time(system: FamilySystem) -> list[Term]:
    """The terms of -dL/dt, at moving coordinates: each term of U with t, times what U has of its sum."""
    slots, graph, root = system.slots, system.slots.graph, system.root
    alone = np.zeros(1, dtype=np.int64)
    found = [Term(root, graph.diff(system.potential, system.time), alone)]
    for total in system.totals:
        if not system.depends_on_time([total]):
            continue
        (factor,), _ = slopes(system.potential, root, system.totals, slots, total)
        for term in total.terms if factor.terms else ():
            node = slots.symbol(term.domain, factor, term.targets) * graph.diff(term.node, system.time)
            found.append(Term(term.domain, node, np.zeros_like(term.targets)))
    found += of_masses(system)
    return [one for one in found if not one.node.is_zero]


def of_masses(system: FamilySystem) -> Iterator[Term]:
    """The terms of -dT/dt, at moving coordinates and constant velocities, where M depends on t."""
    slots, graph = system.slots, system.slots.graph
    for one in system.coupled_masses.curved if system.coupled_masses else ():
        rate = graph.diff(one.node, system.time)
        if not rate.is_zero:
            v, w = (slots.symbol(one.domain, system.v, table) for table in (one.first, one.second))
            yield Term(one.domain, -(rate * v * w), one.domain.together)


def pulls_of_bonds(system: FamilySystem) -> Iterator[Term]:
    """A^T lambda."""
    bonds, slots = system.bonds, system.slots
    assert bonds is not None
    yield from bonds.pulls_on_coordinates(slots)
    pushes: list[list[Term]] = [[] for _ in (system.joints.places if system.joints else ())]
    for one in bonds.bounds:
        for hold in one.holds:
            push = hold.slope * bonds.multipliers_of(slots, one)
            pushes[hold.component].append(Term(one.domain, push, hold.places))
    if system.joints is not None:
        yield from felt(system.slots, system.joints, pushes, [])


def work_of_bonds(system: FamilySystem) -> Iterator[Term]:
    """The power of the forces of constraint, -lambda b (``mechanics.constraints``)."""
    graph, bonds = system.slots.graph, system.bonds
    for one in bonds.bounds if bonds else ():
        assert bonds is not None
        drift = graph.diff(one.node, system.time) if one.holonomic else one.at_rest(graph)
        if not drift.is_zero:
            power = -(drift * bonds.multipliers_of(system.slots, one))
            yield Term(one.domain, power, np.zeros(one.domain.count, dtype=np.int64))


@dataclass(frozen=True)
class Quantities:
    """What the planner asks of energies and momenta: where they are."""

    system: FamilySystem

    def whole(self, *nodes: Any) -> Element:
        """The sum of expressions that belong to no member."""
        system = self.system
        total = sum(nodes[1:], nodes[0])
        return Total(system.masses.source, 1, (Term(system.root, total, np.zeros(1, dtype=np.int64)),)), 0

    @property
    def kinetic(self) -> Element | None:
        """T."""
        apart = self.system.apart
        if apart is not None:
            return self.whole(apart[0])
        return None if self.system.spec.lagrangian is not None else self.kinetic_energy

    @property
    def kinetic_energy(self) -> Element:
        """The part of L that is quadratic in velocities."""
        return self.whole(self.system.kinetic)

    @property
    def potential(self) -> Element | None:
        """U."""
        if self.system.apart is not None:
            return self.whole(self.system.apart[1])
        return None if self.system.spec.lagrangian is not None else self.whole(self.system.potential)

    @property
    def energy_function(self) -> Element:
        """h = sum p_k q_dot_k - L, which is T + U where positions do not depend on t, nor U on velocities."""
        system = self.system
        if not system.moved_in_time and system.vector is None:
            return self.whole(system.kinetic, system.potential)
        everyone, places = system.everyone, np.arange(system.q.count)
        p, v = (system.slots.symbol(everyone, one, places) for one in (system.momenta, system.v))
        terms = (
            Term(everyone, p * v, np.zeros_like(places)),
            Term(system.root, system.potential - system.kinetic, np.zeros(1, dtype=np.int64)),
        )
        return Total(Source.TOTAL, 1, terms), 0

    @property
    def lagrangian(self) -> Element:
        """L."""
        return self.whole(self.system.kinetic, -self.system.potential)

    def energy_rate(self, time: Any) -> Element:
        """dh/dt: the power of the forces outside L, less dL/dt."""
        terms = [self._power(1.0, self.system.applied)] if self.system.driven else []
        return Total(Source.TOTAL, 1, (*terms, *of_time(self.system), *work_of_bonds(self.system))), 0

    @property
    def kinetic_rate(self) -> Element:
        """dT/dt: the power of all forces."""
        terms = [self._power(1.0, self.system.applied)] if self.system.driven else []
        terms += [self._power(-1.0, self.system.slopes), *work_of_bonds(self.system)]
        if self.system.inertia is not None:  # v M a lacks half of v M' v, with M' = dM/dt
            terms += [self._power(1.0, self.system.inertia), *of_masses(self.system)]
        return Total(Source.TOTAL, 1, tuple(terms)), 0

    def _power(self, factor: float, forces: Total) -> Term:
        """What forces on all coordinates do."""
        system, places = self.system, np.arange(self.system.q.count)
        force, v = (system.slots.symbol(system.everyone, one, places) for one in (forces, system.v))
        return Term(system.everyone, factor * (force * v), np.zeros_like(places))

    @property
    def may_jump_at_times(self) -> bool:
        """Whether the potential contains switches that are decided by t, not by coordinates."""
        system = self.system
        moving = system.slots.symbols_of(system.q, system.v)
        nodes = [system.potential, *(one.node for total in system.energies for one in total.terms)]
        switches = (one.arguments[0] for one in reachable(nodes) if one.kind is Kind.SWITCH)
        return any(u.symbols & system.time.symbols and not u.symbols & moving for u in switches)

    @property
    def torques(self) -> tuple[Element, ...]:
        """dL/dq_k + Q_k."""
        system, found = self.system, self.system.forces
        held = bool(self._held) and system.bonds is not None
        if system.vector is not None or system.curved or held:
            inside = (replace(one, node=-one.node) for one in system.gradient.terms)
            found = total_of(found.count, [*inside, *self._applied], system.slots.graph)
        if system.joints is not None:
            lagrangian = system.kinetic - system.potential
            (rates,), _ = slopes(lagrangian, system.root, system.totals, system.slots, system.q)
            found = total_of(rates.count, [*rates.terms, *self._applied], system.slots.graph)
        if system.bonds is not None:
            found = total_of(found.count, [*found.terms, *pulls_of_bonds(system)], system.slots.graph)
        return tuple((found, k) for k in range(system.q.count))

    @property
    def _applied(self) -> Sequence[Term]:
        """What is applied, as it is while friction holds joints, or coordinates beside constraints."""
        system = self.system
        if not self._held:
            return system.applied.terms
        places = np.arange(system.q.count)
        return [Term(system.everyone, system.slots.symbol(system.everyone, system.applied, places), places)]

    @property
    def _held(self) -> bool:
        """Whether friction may hold something."""
        smooth = self.system.smooth
        return smooth is not None and smooth.modes is not None and smooth.modes.limits is not None

    @property
    def momenta(self) -> tuple[Element, ...]:
        """p_k = dL/dq_dot_k."""
        return tuple((self.system.momenta, k) for k in range(self.system.q.count))
