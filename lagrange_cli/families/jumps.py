"""Which expressions of families may jump, or have no value or series somewhere."""

from __future__ import annotations

from collections.abc import Iterable

from lagrange_cli.expression.graph import Graph
from lagrange_cli.expression.indices import Unsuited
from lagrange_cli.expression.node import Kind, Node, reachable
from lagrange_cli.families.arrays import Array, Slots, Total
from lagrange_cli.mechanics.substitution import substituted
from lagrange_cli.mechanics.switching.switches import MOST, Merging, switches, vanishes_with

PARTIAL = "log", "asin", "acos", "acosh", "atanh"
"""Functions that do not have a value everywhere."""


def refuse_jumps(slots: Slots, node: Node, *arrays: Array) -> None:
    """Raise ``Unsuited`` where an expression, or a sum in it, may jump as numbers of these arrays change."""
    moving = slots.symbols_of(*arrays, totals=True)
    for one in switches(Merging(slots.graph, moving).merged([node]), moving):
        if jumps(slots.graph, one):
            raise Unsuited
    for _, slot in slots.inside(node):
        if isinstance(slot.array, Total):
            for term in slot.array.terms:
                refuse_jumps(slots, term.node, *arrays)


def refuse_angles(slots: Slots, nodes: Iterable[Node]) -> None:
    """Raise ``Unsuited`` where expressions, or sums in them, have angles, which jump."""
    if any(one.kind is Kind.FUNCTION and one.data == "atan2" for one in reachable(slots.made_of(nodes))):
        raise Unsuited


def jumps(graph: Graph, switch: Node) -> bool:
    """Whether a switch may have two values where its argument is 0, on some side of the switches in it.
    Where both are infinite there, no motion passes."""
    argument, above, below = switch.arguments
    if all(_has_pole(graph, one, argument) for one in (above, below)):
        return False
    return _differ(graph, above - below, argument, most=MOST)


def _has_pole(graph: Graph, node: Node, argument: Node) -> bool:
    """Whether a term of an expression is infinite where the argument is 0."""
    if node.kind is Kind.SUM:
        return any(_has_pole(graph, one, argument) for one in node.arguments)
    if node.kind is not Kind.PRODUCT:
        return False
    own = graph.split_coefficient(argument)[1]
    factors = [(graph.split_coefficient(a)[1], e) for a, e in zip(node.arguments, node.data)]
    poles = [a for a, e in factors if e < 0 and a is own]
    return bool(poles) and not any(e > 0 and vanishes_with(graph, a, argument) for a, e in factors)


def _differ(graph: Graph, *both: Node, most: int) -> bool:
    """Whether the first of ``both`` may be other than 0 where the second is, on some side of so many
    switches."""
    node, argument = both
    if vanishes_with(graph, node, argument):
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


def is_root(node: Node) -> bool:
    """Whether it has no series where what it is of is 0."""
    return node.kind is Kind.POWER or (node.kind is Kind.PRODUCT and any(e != int(e) for e in node.data))


def partial(node: Node) -> bool:
    """Whether it may have no value somewhere."""
    inside = reachable([node])
    return any(is_root(one) or (one.kind is Kind.FUNCTION and one.data in PARTIAL) for one in inside)
