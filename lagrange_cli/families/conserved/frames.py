"""Whether L depends on t where positions do: in frames that turn evenly it does not."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING, Protocol

import numpy as np

from lagrange_cli.expression.node import Kind, Node, factors_of, reachable
from lagrange_cli.families.arrays import Array
from lagrange_cli.families.description import FamilySystem
from lagrange_cli.families.values import FamilyValues

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Values = NDArray[np.float64]

LATER = 0.7
"""The time after which L is compared."""
SAME = 1e-10
"""L is the same if it differs by no more than so large a part of T and U."""
EVEN = "sin", "cos"
"""Functions of t that are as large later as they are at first."""


class State(Protocol):
    """A state of a system at ``t``, its parameters, the signs of its modes, and the ``values`` of
    expressions."""

    t: float
    q: Values
    v: Values
    parameters: Values
    signs: dict[Array, Values]
    values: FamilyValues


def contains_time(system: FamilySystem, states: Sequence[State]) -> bool:
    """Whether L depends on t explicitly. Where joints move with t, it is compared at two times, in random
    states; if functions of t other than sin, cos and powers are in it, it is said to depend on t."""
    if system.steady_potential:
        return False
    if not system.driven_joints or system.timed_masses or not all(map(is_even, timed(system))):
        return True
    with np.errstate(all="ignore"):
        return any(differs(system, one) for one in states)


def timed(system: FamilySystem) -> Iterator[Node]:
    """What contains t, of all that L is made of."""
    nodes = [system.potential, system.kinetic, *(t.node for total in system.totals for t in total.terms)]
    nodes += system.joints.moved if system.joints else []
    return (one for one in reachable(nodes) if one.symbols & system.time.symbols)


def is_even(node: Node) -> bool:
    """Whether a function of t, by its own form, is a sum of sines, cosines and powers of t."""
    if node.kind is Kind.FUNCTION:
        return node.data in EVEN
    if node.kind is Kind.PRODUCT:
        return all(e > 0 and e == int(e) for one, e in factors_of(node) if one.symbols & node.symbols)
    return node.kind in (Kind.SYMBOL, Kind.SUM)


def differs(system: FamilySystem, state: State) -> bool:
    """Whether L is not the same later, in the same state."""
    later = FamilyValues(system, state.t + LATER, state.q, state.v, state.parameters, state.signs)
    kinetic, potential = (
        [float(np.sum(one.node(node))) for one in (state.values, later)]
        for node in (system.kinetic, system.potential)
    )
    change = (kinetic[1] - potential[1]) - (kinetic[0] - potential[0])
    return not abs(change) <= SAME * (abs(kinetic[0]) + abs(potential[0]))
