"""After which impacts members go apart for good, whatever speed these leave: no contact has to keep them."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from lagrange_cli.expression.curvature import Curvature, curvature
from lagrange_cli.expression.node import Kind, reachable
from lagrange_cli.families.arrays import Total
from lagrange_cli.families.builder import FamilyBuilder
from lagrange_cli.families.events import ROUNDED, Events
from lagrange_cli.families.values import FamilyValues

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Bits = NDArray[np.bool_]

APART = {0: Curvature.LINEAR, -1: Curvature.CONVEX, 1: Curvature.CONCAVE}
"""What an argument is, if bodies on straight lines do not come back, by the direction of the event."""


def parting(
    builder: FamilyBuilder, events: Events, forces: Total, masses: Total, state: FamilyValues
) -> Bits:
    """Of which events the argument does not bend back to 0: not on straight lines, as it is convex seen from
    the side that members come from; and not by forces, as a random ``state`` shows."""
    moving = builder.time.symbols | builder.slots.symbols_of(builder.q)
    found = np.full(events.count, int(Curvature.LINEAR))
    for term in events.arguments.terms:
        found[term.targets] &= int(curvature(term.node, moving))
    sides = np.array([int(APART[one]) for one in events.directions.tolist()])
    straight: Bits = (found & sides) == sides
    return straight & undriven(builder, events, forces, masses, state)


def undriven(
    builder: FamilyBuilder, events: Events, forces: Total, masses: Total, state: FamilyValues
) -> Bits:
    """Of which events the argument has no acceleration by forces."""
    count = events.count
    if not forces.terms:
        return np.ones(count, dtype=bool)
    inside = reachable(builder.slots.made_of([one.node for one in forces.terms]))
    if any(one.kind is Kind.SWITCH for one in inside):  # other states may have other forces
        return np.zeros(count, dtype=bool)
    total, size = np.zeros(count), np.zeros(count)
    pushed = state.of(forces) / state.of(masses)
    for term in events.arguments.terms:
        for symbol, slot in builder.slots.inside(term.node):
            if slot.array is builder.q:
                part = state.node(builder.graph.diff(term.node, symbol)) * pushed[slot.table]
                total += np.bincount(term.targets, part, count)
                size += np.bincount(term.targets, np.abs(part), count)
    return np.abs(total) <= ROUNDED * size
