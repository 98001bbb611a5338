"""Dry friction between members of families: forces that jump where a relative velocity is 0.

A force of friction F on coordinates acts along the slopes A of its relative velocity u by their velocities.
While its mode is 0, u stays 0: the force is then a multiplier f, up to the limit D = F(u < 0). Members that
stick to each other are coupled, so their multipliers are found together, from A M^-1 A^T as those of
constraints are (``native.families.constraints.sticking``).
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

import numpy as np

from lagrange_cli.expression.index_arrays import Places, distinct
from lagrange_cli.expression.indices import Unsuited
from lagrange_cli.expression.node import Node
from lagrange_cli.families.arrays import NONE, Domain, Slots, Source, Term, Total, placed, total_of
from lagrange_cli.families.bonds import Bonds, Bound, responses_of
from lagrange_cli.families.switching.friction import (
    CARRIED,
    Friction,
    FrictionModes,
    Held,
    gate,
    linear_in,
    rate_at_rest,
)
from lagrange_cli.families.switching.stuck_joints import sticking_joints
from lagrange_cli.families.values import FamilyValues
from lagrange_cli.mechanics.switching.switches import switches
from lagrange_cli.records import replace

if TYPE_CHECKING:
    from lagrange_cli.families.description import FamilySystem

SEED = 1
ROUNDED = 1e-10
"""Numbers that differ by less are equal."""
COUNTERFORCES = (
    "friction between members that does not act on all of them",
    "write it as dissipation: F*abs(x_dot[i] - x_dot[j]), which does",
)
LOOPS = (
    "friction by which members may hold each other in a circle",
    "leave out a force, so that each member is held in one way",
)
"""What members are written out for, and how to do without."""


def held(friction: FrictionModes, whole: tuple[Total, Total], moving: int) -> Held:
    """The forces with friction in them; the ``whole`` of these and of what is applied, with modes.

    Raises ``Unsuited`` where friction does not act against its own velocity, or may hold members in a circle.
    """
    modes = distinct(np.concatenate([friction.of(one) for one in friction.listed]))
    order = np.full(friction.modes.count, NONE)
    order[modes] = np.arange(len(modes))
    bounds = [*bounds_of(friction, order)]
    multipliers = Total(Source.TOTAL, len(modes))
    system, count = friction.system, len(modes)
    felt = None if system.joints is None else responses_of(bounds, count, system.q.count, system.joints)
    sticking = Bonds(tuple(bounds), [str(mode) for mode in modes.tolist()], multipliers, 0, felt)
    refuse_circles(system, sticking)
    sticking.elimination  # noqa: B018 - refuses what is coupled to too much
    limit = limits_of(friction, sticking, order, moving)
    loose, applied = (with_means(friction, one) for one in whole)
    locks, holding, slots = None, multipliers, system.slots
    if system.joints is not None:
        found = sticking_joints(system, bounds, (friction.modes, modes), loose)
        locks, holding = found or (None, multipliers)
    domain, numbers = Domain(len(modes)), np.arange(len(modes))
    most, force = (slots.symbol(domain, one, numbers) for one in (limit, holding))
    limits = [Term(domain, most - force, 2 * numbers), Term(domain, most + force, 2 * numbers + 1)]
    pulls = [
        Term(one.domain, slope * slots.symbol(one.domain, holding, one.numbers), rows)
        for one in bounds
        for slope, rows in zip(one.slopes, one.rows)
    ]
    made = Held(
        modes=modes, limits=total_of(2 * len(modes), limits, slots.graph), other=limit,
        forces=total_of(loose.count, [*loose.terms, *pulls], slots.graph),
        applied=total_of(applied.count, [*applied.terms, *pulls], slots.graph),
        sticking=sticking, loose=loose,
    )  # fmt: skip
    return made if locks is None else replace(made, forces=loose, sticking=None, loose=None, locks=locks)


def bounds_of(friction: FrictionModes, order: Places) -> Iterator[Bound]:
    """The relative velocities, each once, by the place of its mode in an ``order``."""
    system, slots = friction.system, friction.system.slots
    for one in friction.decisions:
        numbers = order[one.modes]
        kept = np.flatnonzero(numbers >= 0)
        if not len(kept):
            continue
        domain = Domain(len(kept))
        node = placed(slots, one.argument, domain, kept)
        fast = slots.moving(node, {system.v})
        inside = [one for one in slots.inside(node) if one[1].array is (system.v if fast else system.q)]
        if not inside:
            raise Unsuited  # of a member relative to itself
        if fast and not rate_at_rest(system, node, domain).is_zero:
            raise Unsuited(*CARRIED)
        rows = tuple(slot.table for _, slot in inside)
        slopes = tuple(slots.graph.diff(node, symbol) for symbol, _ in inside)
        symbols = tuple(slots.symbol(domain, system.v, table) for table in rows)
        speed = slots.graph.sum([(slope * v, 1.0) for slope, v in zip(slopes, symbols)])
        yield Bound(domain, speed, numbers[kept], rows, symbols, slopes, slots.graph.zero, holonomic=False)


def with_means(friction: FrictionModes, total: Total) -> Total:
    """Forces whose friction is the mean of both directions, and not that of u < 0, where a mode is 0."""
    slots = friction.system.slots
    terms = [*total.terms]
    for one in friction.listed:
        domain = one.term.domain
        sticks = 1.0 - gate(slots, domain, friction.modes, friction.of(one))
        change = friction.frozen(Term(domain, jump(slots, one), one.term.targets))
        terms.append(Term(domain, sticks * change.node, change.targets))
    return total_of(total.count, terms, slots.graph)


def jump(slots: Slots, one: Friction) -> Node:
    """Half of the difference of a force where u > 0 and where u < 0."""
    difference: Node = (one.side(slots.graph, 1).node - one.side(slots.graph, 2).node) / 2.0
    return difference


def limits_of(friction: FrictionModes, sticking: Bonds, order: Places, moving: int) -> Total:
    """The limit of each force of friction, -(jump of the force on a coordinate)/(its slope). It is the same
    for all coordinates; those of the first one are taken.

    Raises ``Unsuited`` where they differ, or depend on which way another friction acts."""
    system, slots, graph = friction.system, friction.system.slots, friction.system.slots.graph
    width = max(len(one.rows) for one in sticking.bounds)
    rows = np.full((sticking.count, width), NONE)
    for bound in sticking.bounds:
        rows[bound.numbers, : len(bound.rows)] = np.stack(bound.rows, axis=1)
    arguments = {one.argument for one in friction.listed}
    terms = []
    for one in friction.listed:
        strength = jump(slots, one)
        if any(other.arguments[0] in arguments for other in switches([strength], moving)):
            raise Unsuited  # the limit depends on which way another friction acts
        symbol = next(
            s
            for s, slot in linear_in(system, one.argument, moving)
            if np.array_equal(slot.table, one.term.targets)
        )
        numbers = order[friction.of(one)]
        own = np.argmax(rows[numbers] == one.term.targets[:, None], axis=1)
        node = -strength / graph.diff(one.argument, symbol)
        terms.append(friction.frozen(Term(one.term.domain, node, width * numbers + own)))
    each = total_of(sticking.count * width, terms, graph)
    chance = np.random.default_rng(SEED)
    q, v = (chance.uniform(0.2, 1.2, system.q.count) for _ in range(2))
    given = chance.uniform(0.7, 1.1, system.given.count)
    signs = np.where(chance.uniform(-1.0, 1.0, friction.modes.count) < 0.0, -1.0, 1.0)
    with np.errstate(all="ignore"):
        values = FamilyValues(system, 0.6, q, v, given, {friction.modes: signs}).of(each).reshape(-1, width)
    if np.any((rows >= 0) & ~(np.abs(values - values[:, :1]) <= ROUNDED * np.abs(values[:, :1]))):
        raise Unsuited(*COUNTERFORCES)
    domain, numbers = Domain(sticking.count), np.arange(sticking.count)
    return total_of(
        sticking.count, [Term(domain, slots.symbol(domain, each, width * numbers), numbers)], graph
    )


def refuse_circles(system: FamilySystem, sticking: Bonds) -> None:
    """Raise ``Unsuited`` where members that stick may be held in more than one way: forces that hold them are
    not determined then."""
    leaders = [*range(system.q.count + 1)]
    """Of each coordinate one that it may stick to, and of the ground, which is the last."""

    def leader(i: int) -> int:
        while leaders[i] != i:
            leaders[i] = leaders[leaders[i]]
            i = leaders[i]
        return i

    for bound in sticking.bounds:
        alone = [np.full(bound.domain.count, system.q.count)] if len(bound.rows) == 1 else []
        for members in zip(*(one.tolist() for one in (*bound.rows, *alone))):
            found = {leader(i) for i in members}
            if len(found) < len(members):
                raise Unsuited(*LOOPS)
            first = found.pop()
            for i in found:
                leaders[i] = first
