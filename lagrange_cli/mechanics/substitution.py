"""Expressions in other symbols."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping

from lagrange_cli.expression.graph import Graph
from lagrange_cli.expression.node import Kind, Node, reachable, union


def substituted(graph: Graph, nodes: Iterable[Node], values: Mapping[Node, Node]) -> tuple[Node, ...]:
    """``nodes`` with expressions in place of symbols, or of other nodes. What holds none of them stays."""
    nodes, gone = tuple(nodes), union(values)
    made = dict(values)
    for node in reachable(nodes, lambda node: bool(node.symbols & gone)):
        if node not in made and any(argument in made for argument in node.arguments):
            made[node] = rebuilt(graph, node, [made.get(argument, argument) for argument in node.arguments])
    return tuple(made.get(node, node) for node in nodes)


def root_of(graph: Graph, node: Node, x: Node) -> Node | None:
    """An x at which ``node`` is 0, if it is a polynomial of the first or second degree in x."""
    slope = graph.diff(node, x)
    second = graph.diff(slope, x)
    if second.symbols & x.symbols:
        return None
    b, c = substituted(graph, [slope, node], {x: graph.zero})
    if second.is_zero:
        return None if b.is_zero else -(c / b)
    return (graph.product([(b * b - 2.0 * second * c, 0.5)]) - b) / second


def rewritten(
    graph: Graph,
    nodes: Iterable[Node],
    change: Callable[[Node, list[Node]], Node | None],
    made: dict[Node, Node] | None = None,
) -> tuple[Node, ...]:
    """``nodes`` from their symbols on: ``change`` gives what is in place of a node whose arguments have
    become others, or None where it is the same of these. What is ``made`` before stays."""
    nodes, made = tuple(nodes), {} if made is None else made
    for node in reachable(nodes, lambda node: node not in made):
        arguments = [made[argument] for argument in node.arguments]
        new = change(node, arguments)
        if new is None:
            same = all(a is b for a, b in zip(arguments, node.arguments))
            new = node if same else rebuilt(graph, node, arguments)
        made[node] = new
    return tuple(made[node] for node in nodes)


def rebuilt(graph: Graph, node: Node, arguments: list[Node]) -> Node:
    """``node`` with other arguments."""
    if node.kind is Kind.SUM:
        constant, coefficients = node.data
        return graph.sum([*zip(arguments, coefficients), (graph.constant(constant), 1.0)])
    if node.kind is Kind.PRODUCT:
        return graph.product(zip(arguments, node.data))
    if node.kind is Kind.POWER:
        return graph.power(*arguments)
    if node.kind is Kind.FUNCTION:
        return graph.function(node.data, arguments)
    if node.kind is Kind.SWITCH:
        u, above, below = arguments
        return graph.switch(u, above, below, node.data)
    return node
