"""Friction in the joints of chains and trees, and other forces on their coordinates that hold them.

A coordinate that is held is one that its joint does not have: its slopes are 0 meanwhile, by a *gate*, and so
are the forces on it (see ``native.families.joints.kinds``). What would move it follows from what the joint
carries,

    H = Q - J^T R,

with all other forces Q, and R of what hangs from it. As where M is diagonal, it is held as long as H with the
friction against either direction leads back. H has a series of its own, and is 0 where nothing is held.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING

import numpy as np

from lagrange_cli.expression.indices import Unsuited
from lagrange_cli.expression.node import Node
from lagrange_cli.families.arrays import NONE, Array, Domain, Source, Term, Total, total_of
from lagrange_cli.families.description import FamilySystem, Locks
from lagrange_cli.families.joints.relative import Relative
from lagrange_cli.families.switching.friction import CARRIED, FrictionModes, Held, gate, rate_at_rest
from lagrange_cli.families.switching.holding import Holding, by_term, holding_of, limits_of
from lagrange_cli.families.switching.stuck_joints import Hinges
from lagrange_cli.records import replace

if TYPE_CHECKING:
    pass

DRIVEN = (
    "dry friction in a hinge between links one of which is turned as t says, too",
    "let t turn another hinge, without friction",
)
"""What members are written out for, and how to do without."""


def locked(friction: FrictionModes, others: Sequence[Term], applied: Total) -> Held:
    """The forces of chains and trees with friction, beside ``others``; ``applied`` is all that is, with
    modes."""
    system, modes, frozen = friction.system, friction.modes, friction.frozen
    slots, graph, count = system.slots, system.slots.graph, system.q.count
    fast = [one for one in friction.listed if slots.moving(one.argument, {system.v})]
    if any(not rate_at_rest(system, one.argument, one.term.domain).is_zero for one in fast):
        raise Unsuited(*CARRIED)
    holding = holding_of(friction)
    resting, free, own = holding.resting, holding.free, holding.own
    still, moving = Domain(len(resting)), Domain(len(free))
    gates = [Term(still, gate(slots, still, modes, own[resting]), resting), Term(moving, graph.one, free)]
    other = total_of(count, [*map(frozen, others)], graph)
    rubbing = [*map(frozen, by_term(friction.listed))]

    def sticks(one: Term) -> Node:
        return 1.0 - gate(slots, one.domain, modes, own[one.targets])

    left = Total(Source.TOTAL, count)
    idle = [Term(one.domain, -sticks(one) * one.node, one.targets) for one in rubbing]
    forces, driving = total_of(count, [*other.terms, *rubbing], graph), left
    locks = Locks(total_of(count, gates, graph), other, left)
    relative = system.joints.relative if system.joints else None
    if relative is not None:  # what is held acts on the joint before, too
        forces = total_of(count, [*forces.terms, *idle], graph)
        locks = replace(locks, other=forces, carries=[*carried(system, relative, holding, modes)])
        driving = total_of(count, relative.own(left), graph)
    balanced = [*applied.terms, Term(still, -slots.symbol(still, driving, resting), resting), *idle]
    return Held(
        modes=holding.modes, limits=limits_of(friction, holding, driving),
        other=other, forces=forces, applied=total_of(count, balanced, graph), locks=locks,
        before=() if driving is left else (driving,),
    )  # fmt: skip


def carried(system: FamilySystem, relative: Relative, holding: Holding, modes: Array) -> Iterator[Total]:
    """Where the joints' coordinates are sums, those that are held move as the ones before them: what their
    accelerations are of these, one by one of a joint's. Raises ``Unsuited`` where a joint does not hang from
    that of the coordinate before, or t moves it besides."""
    assert system.joints is not None
    slots, count = system.slots, system.q.count
    hinges = Hinges.of(system.joints, count)
    held = holding.resting[relative.before[holding.resting] != NONE]
    before = relative.before[held]
    if not np.all(hinges.behind(held, before)):
        raise Unsuited
    if any(np.isin(holding.resting, one.rows).any() for one in relative.driven):
        raise Unsuited(*DRIVEN)
    for b in range(1 + int(hinges.among[before].max(initial=NONE))):
        rows = held[hinges.among[before] == b]
        domain = Domain(len(rows))
        node = 1.0 - gate(slots, domain, modes, holding.own[rows])
        yield total_of(count, [Term(domain, node, rows)], slots.graph)
