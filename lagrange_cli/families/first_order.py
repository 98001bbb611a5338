"""Coordinates without mass, whose equations of motion give their velocities, q_dot = f(q, t): vortices,
oscillators that are coupled by their phases, beads in a viscous liquid.

The equation of motion of such a coordinate contains no accelerations (see ``run.massless``). Here it contains
the velocity of one coordinate without mass, which need not be its own, and any of those that have a mass:

    A_k q_dot_j + b_k = 0,    q_dot_j = -b_k/A_k

The accelerations are the rates of these velocities, as if each coordinate had the mass 1 and a force df/dt.
After each step the state is taken back to q_dot = f(q, t) (``native.families.first_order``), since otherwise
errors of the velocities would last.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from lagrange_cli.expression.graph import Graph
from lagrange_cli.expression.index_arrays import Places
from lagrange_cli.expression.indices import Unsuited
from lagrange_cli.expression.node import Kind, Node, reachable
from lagrange_cli.expression.zero import is_zero
from lagrange_cli.families.arrays import NONE, Array, Domain, Slots, Term, Total, placed, total_of
from lagrange_cli.families.builder import FamilyBuilder
from lagrange_cli.families.jumps import may_jump
from lagrange_cli.mechanics.substitution import substituted
from lagrange_cli.records import dataclass


@dataclass(frozen=True, eq=False)
class FirstOrder:
    """The coordinates in these ``rows`` have no mass: their ``velocities`` and ``accelerations``, which are 0
    in all other rows, and the ``forces`` on the others."""

    rows: Places
    velocities: Total
    accelerations: Total
    forces: Total

    def as_with_mass(self, masses: Total, graph: Graph) -> tuple[Total, Total]:
        """M and the forces of all coordinates: of these, as if they had the mass 1."""
        own = Term(Domain(len(self.rows)), graph.one, self.rows)
        return (
            total_of(masses.count, [*masses.terms, own], graph),
            total_of(masses.count, [*self.forces.terms, *self.accelerations.terms], graph),
        )


def first_order_of(builder: FamilyBuilder, rows: Places, masses: Total, forces: Total) -> FirstOrder:
    """What moves the coordinates in these ``rows``, which have no mass, and the others, whose ``masses`` are
    the entries of M: ``forces`` act on all.

    Raises ``Unsuited`` where an equation does not give one velocity, or one that may jump.
    """
    graph, slots, count = builder.graph, builder.slots, builder.q.count
    light = np.zeros(count, dtype=bool)
    light[rows] = True
    own, others = parted(slots, forces.terms, light)
    refuse_jumps(builder, own, others)
    partner = np.full(count, NONE, dtype=np.int64)
    factors, rest = list[Term](), list[Term]()
    fast = with_velocities(builder)
    for term in own:
        speeds = [(symbol, slot) for symbol, slot in slots.inside(term.node) if slot.array in fast]
        if any(slot.array is not builder.v for _, slot in speeds):
            raise Unsuited
        slopes = [graph.diff(term.node, symbol) for symbol, _ in speeds]
        if any(slope.symbols & symbol.symbols for slope in slopes for symbol, _ in speeds):
            raise Unsuited
        at_rest = dict[Node, Node]()
        for slope, (symbol, slot) in zip(slopes, speeds):
            if not light[slot.table].any():
                continue
            at_rest[symbol] = graph.zero
            if not is_zero(slope):
                join(partner, term.targets, slot.table)
                factors.append(Term(term.domain, slope, term.targets))
        (left,) = substituted(graph, [term.node], at_rest)
        rest.append(Term(term.domain, left, term.targets))
    if not np.array_equal(np.sort(partner[rows]), rows):
        raise Unsuited
    heavy = np.flatnonzero(~light)
    pulled = total_of(count, others, graph)
    if heavy.size:
        members = Domain(len(heavy))
        force, mass = (slots.symbol(members, one, heavy) for one in (builder.added(count, others), masses))
        builder.faster[builder.v] = builder.added(count, [Term(members, force / mass, heavy)])
    factor, force = (
        slots.symbol(each, builder.added(count, total_of(count, some, graph).terms), rows)
        for each in [Domain(len(rows))]
        for some in (factors, rest)
    )
    velocities = builder.added(count, [Term(slots.of[factor].domain, -force / factor, partner[rows])])
    accelerations = builder.rates_of(velocities) or builder.added(count, [])
    builder.faster.pop(builder.v, None)
    return FirstOrder(rows, velocities, accelerations, pulled)


def parted(slots: Slots, terms: Sequence[Term], light: Places) -> tuple[list[Term], list[Term]]:
    """The terms that belong to ``light`` places, and the others."""
    found: tuple[list[Term], list[Term]] = [], []
    for term in terms:
        inside = light[term.targets]
        for some, members in zip(found, (np.flatnonzero(inside), np.flatnonzero(~inside))):
            if len(members) == term.domain.count:
                some.append(term)
            elif len(members):
                domain = Domain(len(members))
                some.append(Term(domain, placed(slots, term.node, domain, members), term.targets[members]))
    return found


def refuse_jumps(builder: FamilyBuilder, own: Sequence[Term], others: Sequence[Term]) -> None:
    """Raise ``Unsuited`` where velocities that follow from forces of their ``own`` may jump, with coordinates
    or in time, or where ``others`` do with coordinates and velocities: these might hold what they act on."""
    slots = builder.slots
    inside = reachable(slots.made_of([term.node for term in own]))
    if any(one.kind is Kind.SWITCH and one.arguments[0].symbols & builder.time.symbols for one in inside):
        raise Unsuited
    if any(may_jump(slots, term.node, builder.q, builder.v) for term in (*own, *others)):
        raise Unsuited


def join(partner: Places, rows: Places, columns: Places) -> None:
    """Note whose velocities equations contain. Raises ``Unsuited`` where it is more than one."""
    if np.any((partner[rows] != NONE) & (partner[rows] != columns)):
        raise Unsuited
    partner[rows] = columns
    if np.any(partner[rows] != columns):
        raise Unsuited


def with_velocities(builder: FamilyBuilder) -> set[Array]:
    """The arrays that velocities are in."""
    found: set[Array] = {builder.v}
    for total in builder.totals:
        if any(builder.slots.moving(one.node, found) for one in total.terms):
            found.add(total)
    return found
