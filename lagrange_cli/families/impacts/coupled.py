"""Resting contact whose forces depend on one another, or on constraints: each acts as a constraint would,
while it pushes.

The impulses of slow impacts have the direction d (see ``impacts``). Where M d is along grad g, as of impacts
without friction, so is the force of contact: N grad g. The condition d2g/dt2 = 0 is then that of a constraint
g = 0 with the multiplier N, and all N and the multipliers of constraints follow from one symmetric matrix
(``native.families.constraints.contacts``).
"""

from __future__ import annotations

import numpy as np

from lagrange_cli.expression.index_arrays import Places
from lagrange_cli.expression.indices import Unsuited
from lagrange_cli.families.arrays import Array, Domain, Source, Term, Total
from lagrange_cli.families.bonds import Bonds, Bound, bound_of
from lagrange_cli.families.builder import FamilyBuilder
from lagrange_cli.families.contacts import Coupled, Impacts
from lagrange_cli.families.events import Events
from lagrange_cli.families.impacts.impacts import ROUNDED, Finding
from lagrange_cli.families.saddle_points import refuse_coupled
from lagrange_cli.families.values import FamilyValues
from lagrange_cli.records import replace

ALONG = (
    "impacts that reduce the speed, are coupled, and do not push along the gradient of their expression",
    "let them change velocities by (1 + e) times what two bodies exchange, or let them reflect without loss",
    "events",
)
"""What members are written out for, how to do without, and the section of the file that has it."""


def coupled_impacts(
    builder: FamilyBuilder,
    events: Events,
    slowing: Places,
    masses: Total,
    bound: Bonds | None,
    state: FamilyValues,
) -> Impacts | None:
    """The impacts among events that do not reflect the speed (``slowing``, numbers in order), with their
    contacts beside the constraints that coordinates are ``bound`` by.

    Raises ``Unsuited`` where they push in other directions, or are coupled to too many.
    """
    if not len(slowing):
        return None
    found = Finding(builder, events, slowing)
    impacts = found.pushed(state)
    if not len(impacts):
        return None
    if len(impacts) < len(slowing):
        found = Finding(builder, events, impacts)
    refuse_other_directions(found, masses, state)
    fixed = 0 if bound is None else bound.count
    names = [] if bound is None else [*bound.names]
    multipliers = Total(Source.TOTAL, fixed + len(impacts))
    bounds = [*(() if bound is None else bound.bounds), *bounds_of(found, fixed)]
    names += [f"contact {number}" for number in impacts.tolist()]
    if bound is None:
        bonds = Bonds(tuple(bounds), names, multipliers, 0)
    else:
        bonds = replace(bound, bounds=tuple(bounds), names=names, multipliers=multipliers)
    refuse_coupled(bonds)
    domain, numbers = Domain(len(impacts)), np.arange(len(impacts))
    force = builder.slots.symbol(domain, multipliers, fixed + numbers)
    forces = Total(Source.TOTAL, len(impacts), (Term(domain, force, numbers),))
    contacts = Coupled(impacts, bonds, fixed, Array(Source.MODES, len(impacts)), forces)
    return Impacts(impacts, found.speeds(), contacts, found.rates)


def bounds_of(found: Finding, fixed: int) -> list[Bound]:
    """Contacts as constraints, behind so many that are ``fixed``."""
    return [
        bound_of(found.builder, one.domain, one.node, fixed + one.targets, None, holonomic=True, whole=True)
        for one in found.arguments
    ]


def refuse_other_directions(found: Finding, masses: Total, state: FamilyValues) -> None:
    """Raise ``Unsuited`` where M d is not along grad g, with the same sign."""
    count, degrees = len(found.resting), found.degrees
    slopes, mass = state.of(found.slopes), state.of(masses)
    contacts, coordinates = found.acts
    own = np.flatnonzero(contacts >= 0)
    direction = state.of(found.directions)[own] * mass[coordinates[own]]
    pushes, gradient = np.zeros((2, len(slopes)))
    at = found.slope_of(contacts[own], coordinates[own])
    beside = np.bincount(contacts[own][at < 0], np.abs(direction[at < 0]), count)
    np.add.at(pushes, at[at >= 0], direction[at >= 0])
    gradient[:] = slopes
    reads = found.reads[0]
    dots = np.bincount(reads, pushes * gradient, count) / np.bincount(reads, gradient**2, count)
    off = np.bincount(reads, np.abs(pushes - dots[reads] * gradient), count) + beside
    size = np.bincount(reads, np.abs(pushes), count)
    if degrees and not np.all((off <= ROUNDED * size) & (dots > 0.0)):
        raise Unsuited(*ALONG)
