"""Friction in the joints of chains and trees, and other forces on their coordinates that hold them.

A coordinate that is held is one that its joint does not have: its slopes are 0 meanwhile, by a *gate*, and so
are the forces on it (see ``native.families.joints.kinds``). What would move it follows from what the joint
carries,

    H = Q - J^T R,

with all other forces Q, and R of what hangs from it. As where M is diagonal, it is held as long as H with the
friction against either direction leads back. H has a series of its own, and is 0 where nothing is held.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING

from lagrange_cli.expression.indices import Unsuited
from lagrange_cli.expression.node import Node
from lagrange_cli.families.arrays import Array, Domain, Source, Term, Total, total_of
from lagrange_cli.families.description import FamilySystem, Locks
from lagrange_cli.families.switching.friction import CARRIED, Friction, Held, gate, rate_at_rest
from lagrange_cli.families.switching.holding import by_term, holding_of, limits_of

if TYPE_CHECKING:
    from lagrange_cli.expression.index_arrays import Places


def locked(
    system: FamilySystem,
    listed: Sequence[Friction],
    others: Sequence[Term],
    applied: Total,
    modes: Array,
    numbers: Mapping[tuple[Domain, Node], Places],
    frozen: Callable[[Term], Term],
) -> Held:
    """The forces of chains and trees with friction that is ``listed``, beside ``others``; ``applied`` is all
    that is, with modes."""
    slots, graph, count = system.slots, system.slots.graph, system.q.count
    fast = [one for one in listed if slots.moving(one.argument, {system.v})]
    if any(not rate_at_rest(system, one.argument, one.term.domain).is_zero for one in fast):
        raise Unsuited(*CARRIED)
    holding = holding_of(system, listed, numbers, modes)
    resting, free, own = holding.resting, holding.free, holding.own
    still, moving = Domain(len(resting)), Domain(len(free))
    gates = [Term(still, gate(slots, still, modes, own[resting]), resting), Term(moving, graph.one, free)]
    other = total_of(count, [*map(frozen, others)], graph)
    rubbing = [*map(frozen, by_term(listed))]
    left = Total(Source.TOTAL, count)
    balanced = [*applied.terms, Term(still, -slots.symbol(still, left, resting), resting)]
    for one in rubbing:
        sticks = 1.0 - gate(slots, one.domain, modes, own[one.targets])
        balanced.append(Term(one.domain, -sticks * one.node, one.targets))
    return Held(
        modes=holding.modes, limits=limits_of(slots, listed, holding, left, modes, numbers, frozen),
        other=other, forces=total_of(count, [*other.terms, *rubbing], graph),
        applied=total_of(count, balanced, graph),
        locks=Locks(total_of(count, gates, graph), other, left),
    )  # fmt: skip
