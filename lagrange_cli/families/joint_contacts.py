"""Resting contact of the coordinates of chains, trees and rigid bodies, at events whose impacts reduce the
speed, such as stops of joints.

The force of contact is N M d, with the direction d of slow impacts (see ``impacts``). So accelerations are
those without contact, and N d besides: no mass is needed, and all N follow from

    sum over c of (grad g_b d_c) N_c = -(grad g_b a + g_b''),

with the accelerations a that all other forces give, for the contacts b that hold
(``native.families.joint_contacts``).
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

import numpy as np

from lagrange_cli.expression.indices import Unsuited
from lagrange_cli.expression.node import Kind, Node, reachable
from lagrange_cli.families.arrays import NONE, Array, Domain, Source, Term, Total, placed
from lagrange_cli.families.bonds import DENSE, Bonds
from lagrange_cli.families.builder import FamilyBuilder
from lagrange_cli.families.contacts import Coupled, Impacts, Push
from lagrange_cli.families.coupled import bounds_of
from lagrange_cli.families.events import SEEDS, Events, random_state
from lagrange_cli.families.impacts import ROUNDED, Finding
from lagrange_cli.families.joints import Articulation
from lagrange_cli.families.responses import trees_of
from lagrange_cli.families.values import FamilyValues

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from lagrange_cli.expression.index_arrays import Places

    Bits = NDArray[np.bool_]

SLOWED = (
    "impacts on chains and trees that reduce the speed and depend on places of particles",
    "let them depend on coordinates, reflect without loss, or give each link coordinates of its own",
    "events",
)
PRESSED = (
    "impacts that reduce the speed and push what constraints of a chain or tree contain",
    "let them reflect without loss, or give each link coordinates of its own",
    "events",
)
"""What members are written out for, how to do without, and the section of the file that has it."""


def impacts_on_joints(
    builder: FamilyBuilder, events: Events, slowing: Places, joints: Articulation, bound: Bonds | None
) -> Impacts | None:
    """The impacts among events that do not reflect the speed (``slowing``, numbers in order), with their
    contacts; coordinates are ``bound`` by constraints.

    Raises ``Unsuited`` where they depend on more than coordinates, or push what constraints contain.
    """
    refuse_places(builder, events, slowing)
    state = FamilyValues(builder, *random_state(builder, SEEDS[1]))
    with np.errstate(all="ignore"):
        found = Finding(builder, events, slowing)
        impacts = found.resting[np.unique(found.acts[0][found.pushing(state)])]
        if not len(impacts):
            return None
        if len(impacts) < len(slowing):
            found = Finding(builder, events, impacts)
        refuse_idle(found, state)
    pushes = tuple(pushes_of(found))
    if bound is not None:
        refuse_bound(pushes, bound, joints, builder.q.count)
    count = len(impacts)
    multipliers = Total(Source.TOTAL, count)
    names = [f"contact {number}" for number in impacts.tolist()]
    bonds = Bonds(tuple(bounds_of(found, 0)), names, multipliers, 0)
    if count > DENSE and any(len(one) > 1 for one in neighbours(found, count)):
        raise Unsuited
    domain, numbers = Domain(count), np.arange(count)
    force = builder.slots.symbol(domain, multipliers, numbers)
    forces = Total(Source.TOTAL, count, (Term(domain, force, numbers),))
    contacts = Coupled(impacts, bonds, 0, Array(Source.MODES, count), forces, pushes)
    return Impacts(impacts, found.speeds(), contacts)


def refuse_places(builder: FamilyBuilder, events: Events, slowing: Places) -> None:
    """Raise ``Unsuited`` where the arguments of impacts, or velocities that these give, contain sums."""
    slow = np.zeros(events.count, dtype=bool)
    slow[slowing] = True
    mine = [one.node for one in events.arguments.terms if slow[one.targets].any()]
    mine += [one.node for one in events.values.terms if slow[events.changed[0][one.targets]].any()]
    inside = (slot.array for node in mine for _, slot in builder.slots.inside(node))
    if any(isinstance(one, Total) for one in inside):
        raise Unsuited(*SLOWED)
    if any(one.kind is Kind.SWITCH for one in reachable(mine)):
        raise Unsuited


def refuse_idle(found: Finding, state: FamilyValues) -> None:
    """Raise ``Unsuited`` where a contact does not act on its own argument."""
    contacts, coordinates = found.acts
    own = found.slope_of(contacts, coordinates)
    which = np.flatnonzero((contacts >= 0) & (own >= 0))
    products = state.of(found.slopes)[own[which]] * state.of(found.directions)[which]
    total, size = (np.bincount(contacts[which], one, len(found.resting)) for one in (products, abs(products)))
    if not np.all(np.abs(total) > ROUNDED * size):
        raise Unsuited


def refuse_bound(pushes: tuple[Push, ...], bound: Bonds, joints: Articulation, coordinates: int) -> None:
    """Raise ``Unsuited`` where contacts push coordinates that constraints contain, or move nodes that they
    contain."""
    nodes, trees = trees_of(joints, coordinates)
    pushed = np.unique(np.concatenate([one.rows for one in pushes]))
    held = [rows for one in bound.bounds for rows in one.rows]
    moved = [nodes[hold.places] for one in bound.bounds for hold in one.holds]
    if any(np.isin(one, pushed).any() for one in held):
        raise Unsuited(*PRESSED)
    if any(np.isin(one, trees[pushed]).any() for one in moved):
        raise Unsuited(*PRESSED)


def neighbours(found: Finding, count: int) -> list[set[int]]:
    """The contacts that each one's direction moves."""
    readers: dict[int, list[int]] = {}
    for contact, coordinate in found.reads.T.tolist():
        readers.setdefault(coordinate, []).append(contact)
    moved: list[set[int]] = [set() for _ in range(count)]
    for contact, coordinate in found.acts.T.tolist():
        if contact >= 0:
            moved[contact].update(readers.get(coordinate, []))
    return moved


def pushes_of(found: Finding) -> Iterator[Push]:
    """d = -(dD/dv) grad g with D = v+ - v, as expressions of coordinates, velocities and parameters."""
    fresh = found.acts[0] >= 0
    for value in found.values:
        own = fresh[value.targets]
        fresh[value.targets] = False
        for argument in found.arguments:
            yield from pushes_by(found, argument, value, own)
    stopped = np.flatnonzero(fresh)
    if len(stopped):
        zero = Term(Domain(len(stopped)), found.graph.zero, stopped)
        for argument in found.arguments:
            yield from pushes_by(found, argument, zero, fresh[stopped])


def pushes_by(found: Finding, argument: Term, value: Term, own: Bits) -> Iterator[Push]:
    """What some arguments and some of the velocities that impacts give have of it, that by v included for
    their ``own`` members."""
    slots, graph, builder = found.slots, found.graph, found.builder
    contacts, coordinates = (one[value.targets] for one in found.acts)
    member = np.full(len(found.resting), -1)
    member[argument.targets] = np.arange(argument.domain.count)
    reads = [(s, slot.table) for s, slot in slots.inside(argument.node) if slot.array is builder.q]
    sets: list[tuple[Node | None, Places]] = [(None, np.where(own, coordinates, NONE))]
    sets += [(s, slot.table) for s, slot in slots.inside(value.node) if slot.array is builder.v]
    made: dict[bytes, tuple[Domain, Places, list[Node]]] = {}
    for read, places in reads:
        for speed, rows in sets:
            of_argument = member[contacts]
            mine = np.flatnonzero((of_argument >= 0) & (places[of_argument] == rows))
            if not len(mine):
                continue
            domain, _, nodes = made.setdefault(mine.tobytes(), (Domain(len(mine)), mine, []))
            slope = placed(slots, graph.diff(argument.node, read), domain, of_argument[mine])
            if speed is not None:
                slope = -slope * placed(slots, graph.diff(value.node, speed), domain, mine)
            nodes.append(slope)
    for domain, mine, nodes in made.values():
        node = graph.sum([(one, 1.0) for one in nodes])
        if not node.is_zero:
            yield Push(domain, node, contacts[mine], coordinates[mine])
