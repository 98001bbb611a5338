"""Forces of constraint on particles, R = m a - F, where M is diagonal.

A coordinate that moves one component of a place alone tells the force on it: A^T lambda by the slope. What no
coordinate moves has a = 0, so that R = -F there. F is that of U and D as functions of positions and
velocities, and what acts on particles (``mechanics.constrained.reactions``): these are built once more, with
places to which an array is added that is 0.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence

import numpy as np

from lagrange_cli.expression.algebra import Value
from lagrange_cli.expression.index_arrays import Differ, Places
from lagrange_cli.expression.indices import Unsuited
from lagrange_cli.families.applied import DISSIPATION, ON_PARTICLES
from lagrange_cli.families.arrays import Domain, Source, Term, Total, total_of
from lagrange_cli.families.chains import ChainBuilder, together
from lagrange_cli.families.description import FamilySystem
from lagrange_cli.families.groups import Group, alike, group_of, particle_families
from lagrange_cli.families.slopes import slopes
from lagrange_cli.mechanics.substitution import substituted
from lagrange_cli.spec.spec import grouped


class InSpace(ChainBuilder):
    """A builder in which 0 is added to each component of each place: ``shifts`` by family and axis, whose
    rates are ``speeds``. All else is where the ``system`` has it."""

    def __init__(self, system: FamilySystem) -> None:
        super().__init__(system.spec, system.algebra)
        self.slots, self.whole, self.given = system.slots, system.whole, system.given
        self.q, self.v, self.faster = system.q, system.v, {system.q: system.v}
        self._declare(system.spec)
        self.shifts: dict[tuple[str, int], Total] = {}
        self.speeds: dict[tuple[str, int], Total] = {}
        for name, axes in system.positions.items():
            for axis, one in enumerate(axes):
                shift, speed = (Total(Source.TOTAL, one.count) for _ in range(2))
                self.shifts[name, axis], self.speeds[name, axis] = shift, speed
                self._rates[shift] = speed

    def member(self, group: Group, which: Places, domain: Domain) -> Value:
        value, name = super().member(group, which, domain), group.family.name
        if self.positions.get(name) is not group:
            return value
        parts = value if isinstance(value, tuple) else (value,)
        return together(
            one + self.slots.symbol(domain, self.shifts[name, axis], which) for axis, one in enumerate(parts)
        )


def reactions(system: FamilySystem) -> Mapping[str, Sequence[Total]] | None:
    """R of the particles of each family, component by component; None where it is not determined."""
    assert system.bonds is not None
    if system.joints is not None:
        return None
    moved = np.concatenate([one.rows for one in system.components] or [np.zeros(0, dtype=np.int64)])
    if system.spec.lagrangian is not None or len(np.unique(moved)) < len(moved):
        return None
    slots, pull = system.slots, pulls(system)
    parts: dict[tuple[str, int], list[Term]] = {
        (name, axis): [] for name, axes in system.positions.items() for axis in range(len(axes))
    }
    rests = {key: np.ones(system.positions[key[0]][key[1]].count, dtype=bool) for key in parts}
    for one in system.components:
        force = slots.symbol(one.domain, pull, one.rows) / one.slope
        parts[one.family, one.axis].append(Term(one.domain, force, one.members))
        rests[one.family, one.axis][one.members] = False
    if any(one.any() for one in rests.values()):
        try:
            opposite = against(system)
        except (Unsuited, Differ):
            return None
        for key, total in opposite.items():
            which = np.flatnonzero(rests[key])
            if len(which) and total.terms:
                domain = Domain(len(which))
                parts[key].append(Term(domain, slots.symbol(domain, total, which), which))
    return {
        name: [Total(Source.TOTAL, one.count, tuple(parts[name, axis])) for axis, one in enumerate(axes)]
        for name, axes in system.positions.items()
    }


def pulls(system: FamilySystem) -> Total:
    """A^T lambda."""
    assert system.bonds is not None
    terms = []
    for b, a in system.bonds.pulls:
        bound = system.bonds.bounds[b]
        multiplier = system.slots.symbol(bound.domain, system.bonds.multipliers, bound.numbers)
        terms.append(Term(bound.domain, bound.slopes[a] * multiplier, bound.rows[a]))
    return Total(Source.TOTAL, system.q.count, tuple(terms))


def against(system: FamilySystem) -> dict[tuple[str, int], Total]:
    """-F on each component of the places of a family."""
    spec, builder = system.spec, InSpace(system)
    found: dict[tuple[str, int], list[Term]] = {key: [] for key in builder.shifts}
    dissipation = spec.forces.get(DISSIPATION, {})
    for energies, arrays in ((spec.potential, builder.shifts), (dissipation, builder.speeds)):
        for energy in energies.values():
            root = builder.of_root(energy.tree, energy.indices)
            listed, _ = slopes(root, builder.root, builder.totals, builder.slots, *arrays.values())
            for key, one in zip(arrays, listed):
                found[key] += one.terms
    for key, term in pushes(builder):
        found[key].append(Term(term.domain, -term.node, term.targets))
    graph, nothing = builder.graph, {*builder.shifts.values(), *builder.speeds.values()}
    at_rest = {symbol: graph.zero for symbol, slot in builder.slots.of.items() if slot.array in nothing}
    return {
        key: total_of(
            builder.shifts[key].count,
            [Term(one.domain, substituted(graph, [one.node], at_rest)[0], one.targets) for one in terms],
            graph,
        )
        for key, terms in found.items()
    }


def pushes(builder: InSpace) -> Iterator[tuple[tuple[str, int], Term]]:
    """What is applied to particles: the family and axis, and the force on its members."""
    spec = builder.spec
    written = spec.forces.get(ON_PARTICLES, {})
    for family in grouped(written, {**particle_families(spec), **spec.families.get(ON_PARTICLES, {})}):
        forces, positions = group_of(family, written), builder.positions[family.name]
        for which in alike(forces, positions):
            domain = Domain(len(which))
            given = builder.value(*forces.members(which, builder.sizes, domain))
            for axis, force in enumerate(given if isinstance(given, tuple) else (given,)):
                yield (family.name, axis), Term(domain, force, which)
