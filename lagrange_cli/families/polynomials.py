"""Motions under constant forces are polynomials, and so may be what is followed beside them: their series
end, and orders beyond are all 0, whatever the tolerance is.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

from lagrange_cli.expression.node import Kind, Node, reachable
from lagrange_cli.families.arrays import Array, Total
from lagrange_cli.families.contacts import Coupled
from lagrange_cli.families.description import FamilySystem

BEYOND = 4
"""Orders of q beyond twice the degree of what is followed: terms in the upper half of a series would count as
its last ones, which tell where it converges (``native.stepping.roots``)."""


def order_of_all(system: FamilySystem) -> float:
    """The order of q's series by which that of the motion, and those of the arguments of events and of forces
    of contact, have ended; infinite where some do not end."""
    special = (system.joints, system.bonds, system.smooth)
    if any(one is not None for one in special) or isinstance(system.contacts, Coupled):
        return math.inf
    moving = {system.q: math.inf, system.v: math.inf}
    if degree_of(system, system.forces, moving, math.inf) > 0:
        return math.inf
    own = 2.0 if system.forces.terms else 1.0
    degrees = {system.q: own, system.v: own - 1.0}
    followed = [] if system.events is None else [system.events.arguments]
    followed += [] if system.contact is None else [system.contact.multipliers]
    beside = max((degree_of(system, one, degrees, 1.0) for one in followed), default=0.0)
    return 2.0 * max(own, beside) + BEYOND


def degree_of(system: FamilySystem, total: Total, degrees: Mapping[Array, float], of_time: float) -> float:
    """The highest degree in t of the sums of a total; those of the numbers of arrays are given, and that of t
    itself."""
    known: dict[Node, float] = {system.time: of_time}
    for one in reachable([term.node for term in total.terms]):
        slot = system.slots.of.get(one)
        if slot is not None and isinstance(slot.array, Total):
            known[one] = degree_of(system, slot.array, degrees, of_time)
        elif slot is not None:
            known[one] = degrees.get(slot.array, 0.0)
        elif one not in known:
            known[one] = _degree(one, [known[inner] for inner in one.arguments])
    return max((known[term.node] for term in total.terms), default=0.0)


def _degree(node: Node, inner: Sequence[float]) -> float:
    """That of an expression, by those of its arguments."""
    if node.kind is Kind.SUM:
        return max(inner, default=0.0)
    if not any(inner):
        return 0.0
    if node.kind is Kind.PRODUCT and all(e == int(e) >= 0 for e, d in zip(node.data, inner) if d):
        return float(sum(e * d for e, d in zip(node.data, inner) if d))
    return math.inf
