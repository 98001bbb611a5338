"""What holds coordinates where their own forces jump: at velocities, and at places (see ``friction``).

A coordinate may be held at several velocities and at several places. At one of each at once it can only go on
to the side where both are greater, or both less: so each of the two has the side of the other there.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np

from lagrange_cli.expression.index_arrays import distinct
from lagrange_cli.expression.indices import Unsuited
from lagrange_cli.expression.node import Node
from lagrange_cli.families.arrays import NONE, Array, Domain, Slots, Term, Total, placed, total_of
from lagrange_cli.families.description import FamilySystem, Halts
from lagrange_cli.families.switching.friction import Friction, FrictionModes, Held, Rest, gate, rate_at_rest
from lagrange_cli.families.values import FamilyValues
from lagrange_cli.mechanics.substitution import substituted
from lagrange_cli.records import dataclass, replace

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from lagrange_cli.expression.index_arrays import Places

    Numbers = NDArray[np.float64]


ROUNDED = 1e-10
"""Places that differ by a smaller part are one."""
SIDES = (0, 1.0), (1, -1.0)
"""The two limits of a mode, and the sign of the forces in them."""
PLACES = (
    "forces that jump at several places or velocities of one coordinate, which parameters set",
    "write these as numbers",
)
"""What members are written out for, and how to do without."""


@dataclass(frozen=True, eq=False)
class Holding:
    """The ``modes`` that hold coordinates, in order, and the ``rows`` of these; the modes of each coordinate
    (``own``, see ``modes_of``), and whether one has some of places and some of velocities (``both``)."""

    rows: Places
    modes: Places
    own: Places
    both: bool

    @property
    def resting(self) -> Places:
        """The coordinates that may be held."""
        return distinct(self.rows)

    @property
    def free(self) -> Places:
        """All others."""
        return np.flatnonzero(self.own[:, 0] == NONE)


def held(friction: FrictionModes, rest: Rest) -> Held:
    """The forces of a system with friction, beside the ``rest``. One coordinate may be held at several
    places. Beside constraints, those of constraint act on what is held, too."""
    system, modes, frozen = friction.system, friction.modes, friction.frozen
    slots, count = system.slots, system.q.count
    holding = holding_of(friction)
    resting, free, own = holding.resting, holding.free, holding.own
    other = total_of(count, [*map(frozen, rest.terms)], slots.graph)
    still, moving = Domain(len(resting)), Domain(len(free))
    whole, applied, slope = (slots.symbol(still, one, resting) for one in (other, rest.applied, rest.slopes))
    moves = gate(slots, still, modes, own[resting])
    driving, halts, before = other, None, tuple[Total, ...]()
    if system.bonds is not None:
        pulls, driving = pulled(system, other)
        slope = slope - slots.symbol(still, pulls, resting)
        gates = [Term(still, moves, resting), Term(moving, slots.graph.one, free)]
        halts, before = Halts(total_of(count, gates, slots.graph), other), (pulls, driving)
    forces = [Term(still, moves * whole, resting)]
    balanced = [Term(still, moves * applied + (1.0 - moves) * slope, resting)]
    if len(free):
        forces.append(Term(moving, slots.symbol(moving, other, free), free))
        balanced.append(Term(moving, slots.symbol(moving, rest.applied, free), free))
    for term in by_term(friction.listed):
        force = frozen(term)
        moves = gate(slots, term.domain, modes, own[term.targets])
        forces.append(replace(force, node=moves * force.node))
    limits = limits_of(friction, holding, driving)
    carried, taken = carried_along(friction, holding)
    forces += carried
    balanced += carried
    return Held(
        modes=holding.modes, limits=replace(limits, terms=(*limits.terms, *taken)), other=other,
        forces=total_of(count, forces, slots.graph),
        applied=total_of(count, balanced, slots.graph), halts=halts, before=before,
    )  # fmt: skip


def pulled(system: FamilySystem, other: Total) -> tuple[Total, Total]:
    """The forces of constraint, A^T lambda, and their sums with all ``other`` forces."""
    assert system.bonds is not None
    slots, everyone = system.slots, system.everyone
    pulls = total_of(system.q.count, [*system.bonds.pulls_on_coordinates(slots)], slots.graph)
    whole = slots.own(everyone, other) + slots.own(everyone, pulls)
    return pulls, total_of(system.q.count, [Term(everyone, whole, everyone.every)], slots.graph)


def carried_along(friction: FrictionModes, holding: Holding) -> tuple[list[Term], list[Term]]:
    """What accelerates coordinates as what they are held by, and what the limits lose by that."""
    system, modes = friction.system, friction.modes
    slots, graph = system.slots, system.slots.graph
    row, order = (np.full(modes.count, NONE) for _ in range(2))
    row[holding.modes], order[holding.modes] = holding.rows, np.arange(len(holding.rows))
    forces, limits = list[Term](), list[Term]()
    for one in friction.decisions:
        rate = graph.zero
        if slots.moving(one.argument, {system.v}):
            rate = rate_at_rest(system, one.argument, one.domain)
        members = np.flatnonzero(row[one.modes] != NONE)
        if rate.is_zero or not len(members):
            continue
        domain, numbers = Domain(len(members)), one.modes[members]
        speeds = ((s, slot) for s, slot in slots.inside(one.argument) if slot.array is system.v)
        slope = graph.sum([(graph.diff(one.argument, s), 1.0) for s, _ in speeds])
        own = placed(slots, rate / slope, domain, members)
        force = slots.symbol(domain, system.masses, row[numbers]) * own
        sticks = 1.0 - gate(slots, domain, modes, numbers)
        forces.append(Term(domain, sticks * force, row[numbers]))
        limits += [Term(domain, -sign * force, 2 * order[numbers] + k) for k, sign in SIDES]
    return forces, limits


def holding_of(friction: FrictionModes) -> Holding:
    """What holds coordinates.

    Raises ``Unsuited`` where one mode holds several of them, or several may hold one at the same place.
    """
    listed = [np.stack([one.term.targets, friction.of(one)], axis=1) for one in friction.listed]
    pairs = np.unique(np.concatenate(listed), axis=0)
    rows, holding = np.ascontiguousarray(pairs.T)
    if len(distinct(holding)) < len(holding):
        raise Unsuited
    fast = speeds_of(friction)[holding]
    refuse_same(rows, fast, places_of(friction)[holding])
    both = bool(np.intersect1d(rows[fast], rows[~fast]).size)
    return Holding(rows, holding, modes_of(rows, holding, friction.system.q.count), both)


def limits_of(friction: FrictionModes, holding: Holding, other: Total) -> Total:
    """The limits: the whole force on either side, of friction and of all ``other`` forces."""
    slots, modes, frozen = friction.system.slots, friction.modes, friction.frozen
    rows, own = holding.rows, holding.own
    order = np.full(modes.count, NONE)
    order[holding.modes] = np.arange(len(rows))
    every = Domain(len(rows))
    everywhere = slots.symbol(every, other, rows)
    limits = [Term(every, sign * everywhere, 2 * np.arange(len(rows)) + k) for k, sign in SIDES]
    for term, given in by_term(friction.listed).items():
        force, targets = frozen(term), term.targets
        mine = [friction.of(one) for one in given]
        for one, which in zip(given, mine):
            others = [*mine, *own[targets].T] if holding.both else []
            for k, sign in SIDES:
                node = frozen(one.side(slots.graph, 2 - k)).node
                node = on_side(slots, node, term.domain, modes, others, sign)
                limits.append(Term(term.domain, sign * node, 2 * order[which] + k))
        for k in range(own.shape[1]):  # those that hold the same coordinates by other terms
            which = own[targets, k]
            apart = np.all([which != one for one in (*mine, *own[targets, :k].T)], axis=0)
            members = np.flatnonzero(apart)
            if len(members):
                domain = Domain(len(members))
                at, places = placed(slots, force.node, domain, members), 2 * order[which[members]]
                theirs = [one[members] for one in mine] if holding.both else []
                for side, sign in SIDES:
                    node = on_side(slots, at, domain, modes, theirs, sign)
                    limits.append(Term(domain, sign * node, places + side))
    return total_of(2 * len(rows), limits, slots.graph)


def on_side(
    slots: Slots, node: Node, domain: Domain, modes: Array, numbers: Sequence[Places], sign: float
) -> Node:
    """A force with modes of these ``numbers``, those that are 0 being on the side that a limit of this
    ``sign`` has: below, or above."""
    changed = {}
    for mode in dict.fromkeys(slots.symbol(domain, modes, one) for one in numbers):
        changed[mode] = mode - sign * (1.0 - mode * mode)
    return substituted(slots.graph, [node], changed)[0] if changed else node


def refuse_same(rows: Places, fast: Places, places: Numbers) -> None:
    """Raise ``Unsuited`` where a coordinate may be held twice at one place, or at one velocity (``fast``)."""
    order = np.lexsort((places, fast, rows))  # nan comes last
    same = (np.diff(rows[order]) == 0) & (fast[order][1:] == fast[order][:-1])
    places = places[order]
    if not np.all(np.diff(places)[same] > ROUNDED * np.abs(places[1:][same])):
        raise Unsuited(*PLACES)


def speeds_of(friction: FrictionModes) -> Places:
    """Which modes change with velocities."""
    system, found = friction.system, np.zeros(friction.modes.count, dtype=bool)
    for one in friction.listed:
        found[friction.of(one)] = system.slots.moving(one.argument, {system.v})
    return found


def places_of(friction: FrictionModes) -> Numbers:
    """The place or the velocity of a coordinate at which each mode changes, nan if it is not a number that is
    known now."""
    system, found = friction.system, np.full(friction.modes.count, np.nan)
    slots, graph = system.slots, system.slots.graph
    none, given = np.zeros(system.q.count), np.zeros(system.given.count)
    values = FamilyValues(system, 0.0, none, none, given)
    for one in friction.listed:
        inside = [*slots.inside(one.argument)]
        moving = [symbol for symbol, slot in inside if slot.array in (system.q, system.v)]
        fixed = [symbol for symbol, slot in inside if slot.array is system.whole]
        if len(moving) == 1 and one.argument.symbols == sum(s.symbols for s in (*moving, *fixed)):
            at_zero = substituted(graph, [one.argument], {moving[0]: graph.zero})[0]
            found[friction.of(one)] = -values.node(at_zero / graph.diff(one.argument, moving[0]))
    return found


def modes_of(rows: Places, holding: Places, count: int) -> Places:
    """The modes that hold each coordinate, (coordinates, modes): its last one stands for those that it does
    not have; ``NONE`` where it has none."""
    each = np.bincount(rows, minlength=count)
    first = np.cumsum(each) - each
    found = np.full((count, each.max()), NONE)
    for k in range(each.max()):
        places = first[each > 0] + np.minimum(k, each[each > 0] - 1)
        found[each > 0, k] = holding[places]
    return found


def by_term(listed: Sequence[Friction]) -> Mapping[Term, Sequence[Friction]]:
    """Friction by the terms in which it is."""
    found: dict[Term, list[Friction]] = {}
    for one in listed:
        found.setdefault(one.term, []).append(one)
    return found
