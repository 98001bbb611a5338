"""Resting contact of chains, trees and rigid bodies, at events whose impacts reduce the speed, such as stops
of joints and walls.

The force of contact is N M d, with the direction d of slow impacts (see ``impacts``). So accelerations are
those without contact, and N d besides: no mass is needed, and all N follow from

    sum over c of (grad g_b d_c) N_c = -(grad g_b a + g_b''),

with the accelerations a that all other forces give, for the contacts b that hold
(``native.families.joints.contacts``).
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from lagrange_cli.expression.index_arrays import distinct
from lagrange_cli.expression.indices import Unsuited
from lagrange_cli.families.arrays import NONE, Array, Domain, Source, Term, Total
from lagrange_cli.families.bonds import Bonds
from lagrange_cli.families.builder import FamilyBuilder
from lagrange_cli.families.contacts import Coupled, Impacts
from lagrange_cli.families.elimination import DENSE
from lagrange_cli.families.events import SEEDS, Events, random_state
from lagrange_cli.families.impacts.impacts import Finding
from lagrange_cli.families.impacts.slowing import Slowing
from lagrange_cli.families.joints.joints import Articulation
from lagrange_cli.families.joints.responses import trees_of
from lagrange_cli.families.values import FamilyValues

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from lagrange_cli.expression.index_arrays import Places

    Bits = NDArray[np.bool_]

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

    Raises ``Unsuited`` where they depend on sums, or push what constraints contain.
    """
    state = FamilyValues(builder, *random_state(builder, SEEDS[1]))
    found = Slowing(builder, events, slowing, joints)
    with np.errstate(all="ignore"):
        pushing, driving = found.pushing(state)
    impacts = slowing[pushing]
    if not len(impacts):
        return None
    if not np.all(driving[pushing]):
        raise Unsuited
    if len(impacts) < len(slowing):
        found = Slowing(builder, events, impacts, joints)
    if bound is not None:
        refuse_bound(found, bound)
    count = len(impacts)
    multipliers = Total(Source.TOTAL, count)
    names = [f"contact {number}" for number in impacts.tolist()]
    bonds = Bonds(tuple(found.bounds), names, multipliers, 0)
    alone = separate(found)
    if count > DENSE and not alone:
        raise Unsuited
    domain, numbers = Domain(count), np.arange(count)
    force = builder.slots.symbol(domain, multipliers, numbers)
    forces = Total(Source.TOTAL, count, (Term(domain, force, numbers),))
    signs = Array(Source.MODES, count)
    contacts = Coupled(impacts, bonds, 0, signs, forces, tuple(found.pushes), tuple(found.reaches), alone)
    if any(one.holds for one in found.bounds):
        return Impacts(impacts, Total(Source.TOTAL, count), contacts)
    own = Finding(builder, events, impacts)
    return Impacts(impacts, own.speeds(), contacts, own.rates)


def apart(events: Events, contacts: Coupled, joints: Articulation, coordinates: int) -> Bits:
    """The events that set velocities of trees without contacts but their own, which are at coordinates."""
    _, trees = trees_of(joints, coordinates)
    bounds = contacts.bonds.bounds
    if any(one.holds for one in bounds):
        return np.zeros(events.count, dtype=bool)
    pairs = [(one.contacts, one.rows) for one in contacts.pushes]
    pairs += [(one.numbers, rows) for one in bounds for rows in one.rows]
    count = int(trees.max()) + 1
    keys = distinct(np.concatenate([contacts.events[own] * count + trees[rows] for own, rows in pairs]))
    owners, touched = np.divmod(keys, count)
    owner = np.full(count, NONE)
    owner[touched] = owners
    several = np.bincount(touched, minlength=len(owner)) > 1
    acting, places = events.changed
    speeds = (places >= coordinates) & (places < 2 * coordinates)
    on = trees[np.where(speeds, places - coordinates, 0)]
    wrong = ~speeds | several[on] | ((owner[on] != NONE) & (owner[on] != acting))
    found: Bits = np.bincount(acting, wrong, events.count) == 0
    return found


def refuse_bound(found: Slowing, bound: Bonds) -> None:
    """Raise ``Unsuited`` where contacts push coordinates that constraints contain, or move nodes that they
    contain."""
    placed, trees = trees_of(found.joints, found.degrees)
    rows = [*(one.rows for one in found.pushes), *(one.rows for one in found.reaches)]
    pushed = distinct(np.concatenate(rows))
    held = [rows for one in bound.bounds for rows in one.rows]
    moved = [placed[hold.component][hold.places] for one in bound.bounds for hold in one.holds]
    if any(np.isin(one, pushed).any() for one in held):
        raise Unsuited(*PRESSED)
    if any(np.isin(one, trees[pushed]).any() for one in moved):
        raise Unsuited(*PRESSED)


def separate(found: Slowing) -> bool:
    """Whether no contact pushes what another one is at."""
    reader = np.full(found.degrees, -1)
    for one in found.bounds:
        if one.holds:
            return False
        for rows in one.rows:
            if np.any((reader[rows] >= 0) & (reader[rows] != one.numbers)):
                return False
            reader[rows] = one.numbers
    return all(np.all((reader[one.rows] < 0) | (reader[one.rows] == one.contacts)) for one in found.pushes)
