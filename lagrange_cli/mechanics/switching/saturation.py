"""Exponentials that overflow although nothing else would: 1/cosh(u)^2, 1/(1 + e^u).

Their arguments are bounded where the expression no longer changes with them: where e^u reaches e^80."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping, Sequence

from lagrange_cli.expression.graph import Graph
from lagrange_cli.expression.node import Kind, Node, in_order, reachable
from lagrange_cli.mechanics.substitution import substituted
from lagrange_cli.mechanics.variables import graph_of, variables
from lagrange_cli.model.model import Model
from lagrange_cli.records import replace

LARGE = 80.0
"""e^-80 is beyond the digits of double-double; and some powers of e^80 are numbers still."""
GROWING = frozenset({"exp", "sinh", "cosh"})


def saturated(model: Model[Node]) -> Model[Node]:
    """``model`` with such energies and events: what is made of their values, but no derivative, is the
    same."""
    graph, moving = graph_of(model), variables(model)
    arguments = saturated_each(graph, [event.argument for event in model.events], moving)
    events = tuple(replace(event, argument=u) for event, u in zip(model.events, arguments))
    model = replace(model, events=events)
    energies = [model.potential, *([] if model.lagrangian is None else [model.lagrangian])]
    held = held_in(graph, energies, moving)
    if not held:
        return model
    potential, *lagrangian = substituted(graph, energies, held)
    return replace(model, potential=potential, lagrangian=lagrangian[0] if lagrangian else None)


def released(model: Model[Node]) -> Model[Node]:
    """``model`` with the energies that it had before they were ``saturated``."""
    graph = graph_of(model)
    energies = [model.potential, *([] if model.lagrangian is None else [model.lagrangian])]
    free = {}
    for node in reachable(energies):
        if is_growing(node) and node.arguments[0].kind is Kind.SWITCH:
            u = node.arguments[0]
            while u.kind is Kind.SWITCH:
                u = next((one for one in u.arguments[1:] if one.kind is not Kind.NUMBER), graph.zero)
            before = graph.function(node.data, (u,))
            if bounded(graph, before) is node:
                free[node] = before
    if not free:
        return model
    potential, *lagrangian = substituted(graph, energies, free)
    return replace(model, potential=potential, lagrangian=lagrangian[0] if lagrangian else None)


def saturated_rows(graph: Graph, rows: Sequence[Node], moving: int) -> tuple[Node, ...]:
    """Equations with bounded arguments of the exponentials that nothing grows with."""
    return substituted(graph, rows, held_in(graph, rows, moving))


def saturated_each(graph: Graph, nodes: Sequence[Node], moving: int) -> tuple[Node, ...]:
    """The same for expressions that have nothing to do with one another, such as integrands."""
    if not any(map(is_growing, reachable(nodes))):
        return tuple(nodes)
    return tuple(saturated_rows(graph, [node], moving)[0] for node in nodes)


def held_in(graph: Graph, roots: Sequence[Node], moving: int) -> dict[Node, Node]:
    """The exponentials that none of ``roots`` grows with, and what takes their places."""
    users: dict[Node, list[Node]] = {}
    growing: dict[Node, list[Node]] = {}
    for node in reachable(roots):
        for argument in node.arguments:
            users.setdefault(argument, []).append(node)
        if is_growing(node):
            growing.setdefault(node.arguments[0], []).append(node)
    found = [
        node
        for u, nodes in growing.items()
        if u.symbols & moving and all(one <= 0 for one in degrees_of(roots, nodes, users))
        for node in nodes
    ]
    return {node: bounded(graph, node) for node in in_order(found)}


def bounded(graph: Graph, node: Node) -> Node:
    """An exponential whose argument ends at ``LARGE``, and that of cosh and sinh at -``LARGE``, too."""
    (u,) = node.arguments
    held = graph.switch(u - LARGE, graph.constant(LARGE), u, -1)
    if node.data != "exp":
        held = graph.switch(u + LARGE, held, graph.constant(-LARGE), 1)
    return graph.function(node.data, (held,))


def is_growing(node: Node) -> bool:
    """Whether it grows exponentially with its argument."""
    return node.kind is Kind.FUNCTION and node.data in GROWING


def degrees_of(
    roots: Sequence[Node], growing: Sequence[Node], users: Mapping[Node, Sequence[Node]]
) -> Iterator[float]:
    """How ``roots`` grow with exponentials of one argument, as powers of these; infinity where there is no
    such power. Only nodes that use
    them, directly or not, are examined."""
    degrees = dict.fromkeys(growing, 1.0)
    for node in above(growing, users):
        if node not in degrees:
            each = [degrees.get(argument, 0.0) for argument in node.arguments]
            if math.inf in each:
                degrees[node] = math.inf
            elif node.kind is Kind.SUM:
                degrees[node] = max([*each, *([0.0] if node.data[0] != 0 else [])])
            elif node.kind is Kind.PRODUCT:
                degrees[node] = float(sum(exponent * one for exponent, one in zip(node.data, each)))
            else:
                degrees[node] = math.inf if max(each) > 0 else 0.0
    return (degrees.get(root, 0.0) for root in roots)


def above(nodes: Iterable[Node], users: Mapping[Node, Sequence[Node]]) -> list[Node]:
    """The nodes and all that use them, arguments before their users."""
    seen: set[Node] = set()
    pending = [*nodes]
    while pending:
        node = pending.pop()
        if node not in seen:
            seen.add(node)
            using = users.get(node, ())
            node.graph.work.charge(1 + len(using))
            pending.extend(using)
    return in_order(seen)
