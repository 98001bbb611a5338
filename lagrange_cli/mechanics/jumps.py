"""Energies that jump: the force there is infinite, and no motion is defined.

L, U and Rayleigh's function may have kinks, where the forces jump. Whether they are continuous where a switch
changes may depend on the values of parameters; here is refused what jumps with any.
"""

from __future__ import annotations

import math

from lagrange_cli.errors import InfiniteForce
from lagrange_cli.expression.graph import Graph
from lagrange_cli.expression.node import Kind, Node, reachable
from lagrange_cli.mechanics.substitution import substituted
from lagrange_cli.mechanics.variables import graph_of, variables
from lagrange_cli.model.model import Model

ROUNDING = 1e-9
"""A jump this small beside the terms that it is the difference of is rounding."""


def refuse_jumps(model: Model[Node]) -> None:
    """Raises ``InfiniteForce`` where an energy has a jump of constant size."""
    graph = graph_of(model)
    by_place = [*model.q, *model.v]
    energy = ("potential", model.potential) if model.lagrangian is None else ("lagrangian", model.lagrangian)
    for key, node, symbols in ((*energy, by_place), ("dissipation", model.dissipation, model.v)):
        for u in arguments(node):
            if any(u.symbols & symbol.symbols for symbol in symbols):
                jump = difference(graph, node, u)
                if is_certain(graph, jump, u, variables(model)):
                    raise InfiniteForce(key)


def arguments(node: Node) -> list[Node]:
    """What decides in the switches below a node."""
    return list(dict.fromkeys(one.arguments[0] for one in reachable([node]) if one.kind is Kind.SWITCH))


def difference(graph: Graph, node: Node, u: Node) -> Node:
    """What ``node`` is more on the side u > 0 than on the other."""
    switches = [one for one in reachable([node]) if one.kind is Kind.SWITCH and one.arguments[0] is u]
    above, below = (
        substituted(graph, [node], {one: one.arguments[side] for one in switches})[0] for side in (1, 2)
    )
    return above - below


def is_certain(graph: Graph, jump: Node, u: Node, moving: int) -> bool:
    """Whether a difference is not 0 where u is 0, unless a parameter is."""
    if not jump.symbols & moving:
        return not jump.is_zero
    terms = terms_of(graph, u)
    for term, coefficient in terms:
        rest = graph.sum([*terms, (term, -coefficient)])
        if term.kind is Kind.SYMBOL and not rest.symbols & term.symbols:
            (left,) = substituted(graph, [jump], {term: -1.0 / coefficient * rest})
            return stays(graph, left, max(abs(c) for _, c in terms_of(graph, jump)), moving)
    return False


def stays(graph: Graph, left: Node, scale: float, moving: int) -> bool:
    """Whether a sum is more than rounding, whatever its parameters are: a product of what moves has one term,
    which no other cancels."""
    found: dict[Node, int] = {}
    for term, coefficient in terms_of(graph, left):
        if not math.isfinite(coefficient):
            return False  # a pole
        if abs(coefficient) > ROUNDING * scale:
            _, factor = graph.split_parameters(term, moving)
            found[factor] = found.get(factor, 0) + 1
    return 1 in found.values()


def terms_of(graph: Graph, node: Node) -> list[tuple[Node, float]]:
    """The terms of a sum with their coefficients; its constant is one."""
    if node.kind is Kind.NUMBER:
        return [(graph.one, node.data)]
    if node.kind is not Kind.SUM:
        return [(node, 1.0)]
    constant, coefficients = node.data
    return [*zip(node.arguments, coefficients), *([(graph.one, constant)] if constant else [])]
