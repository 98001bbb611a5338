"""Which expressions of families may jump, or have no value or series somewhere."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator

from lagrange_cli.expression.graph import Graph
from lagrange_cli.expression.indices import Unsuited
from lagrange_cli.expression.node import Kind, Node, factors_of, reachable
from lagrange_cli.families.arrays import Array, Slots, Total
from lagrange_cli.mechanics.substitution import substituted
from lagrange_cli.mechanics.switching.switches import (
    MOST,
    Merging,
    on_a_sphere,
    switches,
    vanishes_with,
    where_it_vanishes,
)

PARTIAL = "log", "asin", "acos", "acosh", "atanh"
"""Functions that do not have a value everywhere."""


def may_jump(slots: Slots, node: Node, *arrays: Array) -> bool:
    """Whether an expression, or a sum in it, may jump as numbers of these arrays change."""
    moving = slots.symbols_of(*arrays, totals=True)
    if any(jumps(slots.graph, one) for one in switches(Merging(slots.graph, moving).merged([node]), moving)):
        return True
    inner = (slot.array for _, slot in slots.inside(node) if isinstance(slot.array, Total))
    return any(may_jump(slots, term.node, *arrays) for total in inner for term in total.terms)


def refuse_angles(slots: Slots, nodes: Iterable[Node]) -> None:
    """Raise ``Unsuited`` where expressions, or sums in them, have angles, which jump."""
    if any(one.kind is Kind.FUNCTION and one.data == "atan2" for one in reachable(slots.made_of(nodes))):
        raise Unsuited


def jumps(graph: Graph, switch: Node) -> bool:
    """Whether a switch may have two values where its argument is 0, on some side of the switches in it.
    Where both are infinite there, no motion passes."""
    argument, above, below = switch.arguments
    if all(max(_poles(graph, one, argument)) >= 0 for one in (above, below)):
        return False
    return _differ(graph, above - below, argument, most=MOST)


def depends_on_parameters(graph: Graph, switch: Node, moving: int) -> bool:
    """Whether parameters alone say whether a switch has two values where its argument is 0, by their signs:
    that of the force of a play, k*max(0, abs(u) - b), has where b is negative."""
    return any(_may_vanish(graph, one, MOST) for one in _constants(graph, switch, moving))


def jumps_by_a_constant(graph: Graph, switch: Node, moving: int) -> bool:
    """Whether parameters alone say by how much a switch jumps where its argument is 0. Energies that do jump
    with the values of a run are refused before (``run.jumps``)."""
    return any(True for _ in _constants(graph, switch, moving))


def _constants(graph: Graph, switch: Node, moving: int) -> Iterator[Node]:
    """By how much a switch jumps where its argument is 0, if nothing ``moving`` is in it."""
    argument, above, below = switch.arguments
    jump = above - below
    found = (*where_it_vanishes(graph, jump, argument), *on_a_sphere(graph, jump, argument))
    return (one for one in found if not one.symbols & moving)


def _may_vanish(graph: Graph, node: Node, most: int) -> bool:
    """Whether an expression is 0 on some side of so many switches."""
    if node.is_zero:
        return True
    inside = [one for one in reachable([node]) if one.kind is Kind.SWITCH]
    if not inside or not most:
        return False
    decides = inside[0].arguments[0]
    for side in (1, 2):
        given = {one: one.arguments[side] for one in inside if one.arguments[0] is decides}
        if _may_vanish(graph, substituted(graph, [node], given)[0], most - 1):
            return True
    return False


def pole(graph: Graph, switch: Node) -> float:
    """The order of the pole that all terms on both sides of a switch have at least where its argument is 0: 2
    for k/u^2, 0 for a logarithm; -inf if a term is finite there."""
    argument, *sides = switch.arguments
    return min(order for one in sides for order in _poles(graph, one, argument))


def _poles(graph: Graph, node: Node, argument: Node) -> list[float]:
    """The orders of the poles of the terms of an expression where the argument is 0."""
    if node.kind is Kind.SUM:
        constant = [-math.inf] if node.data[0] else []
        return constant + [order for one in node.arguments for order in _poles(graph, one, argument)]
    own = graph.split_coefficient(argument)[1]
    factors = [(graph.split_coefficient(a)[1], e) for a, e in factors_of(node)]
    if any(e > 0 and vanishes_with(graph, a, argument) for a, e in factors):
        return [-math.inf]
    orders = [-e if e < 0 else -math.inf for a, e in factors if a is own]
    inner = [graph.split_coefficient(a.arguments[0])[1] for a, e in factors if a.data == "log" and e > 0]
    orders += [0.0 for one in inner if any(a is own for a, _ in factors_of(one))]
    return [max(orders, default=-math.inf)]


def _differ(graph: Graph, *both: Node, most: int) -> bool:
    """Whether the first of ``both`` may be other than 0 where the second is, on some side of so many
    switches."""
    node, argument = both
    if vanishes_with(graph, node, argument):
        return False
    if any(left.is_zero for left in on_a_sphere(graph, node, argument)):
        return False
    inside = [one for one in reachable([node, argument]) if one.kind is Kind.SWITCH]
    if not inside or not most:
        return True
    decides = inside[0].arguments[0]
    for side in (1, 2):
        given = {one: one.arguments[side] for one in inside if one.arguments[0] is decides}
        if _differ(graph, *substituted(graph, [node, argument], given), most=most - 1):
            return True
    return False


def is_root(node: Node, moving: int = -1) -> bool:
    """Whether it has no series where what it is of is 0, and that is ``moving``: roots of parameters are
    numbers."""
    if node.kind is Kind.POWER:
        return bool(node.symbols & moving)
    factors = factors_of(node) if node.kind is Kind.PRODUCT else ()
    return any(exponent != int(exponent) and base.symbols & moving for base, exponent in factors)


def partial(node: Node, moving: int = -1) -> bool:
    """Whether it may have no value somewhere as what is ``moving`` changes."""
    inside = reachable([node])
    return any(
        is_root(one, moving)
        or (one.kind is Kind.FUNCTION and one.data in PARTIAL and bool(one.symbols & moving))
        for one in inside
    )
