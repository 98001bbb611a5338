"""Exponentials that overflow although nothing else would: 1/cosh(u)^2, 1/(1 + e^u).

Their arguments are held where the expression no longer changes by them: where e^u has become e^80."""

from __future__ import annotations

from collections.abc import Sequence

from lagrange_cli.expression.graph import Graph
from lagrange_cli.expression.node import Kind, Node, reachable
from lagrange_cli.mechanics.substitution import substituted
from lagrange_cli.mechanics.variables import graph_of, variables
from lagrange_cli.model.model import Model
from lagrange_cli.records import replace

LARGE = 80.0
"""e^-80 is beyond the digits of double-double; and some powers of e^80 are numbers still."""
GROWING = frozenset({"exp", "sinh", "cosh"})


def saturated(model: Model[Node]) -> Model[Node]:
    """``model`` with such an energy: what is made of its values, but no derivative, is the same."""
    energies = [model.potential, *([] if model.lagrangian is None else [model.lagrangian])]
    held = held_in(graph_of(model), energies, variables(model))
    if not held:
        return model
    potential, *lagrangian = substituted(graph_of(model), energies, held)
    return replace(model, potential=potential, lagrangian=lagrangian[0] if lagrangian else None)


def saturated_rows(graph: Graph, rows: Sequence[Node], moving: int) -> tuple[Node, ...]:
    """Equations with bounded arguments of the exponentials that nothing grows with."""
    return substituted(graph, rows, held_in(graph, rows, moving))


def held_in(graph: Graph, roots: Sequence[Node], moving: int) -> dict[Node, Node]:
    """The exponentials that none of ``roots`` grows with, and what takes their places."""
    growing = [node for node in reachable(roots) if is_growing(node) and node.symbols & moving]
    return {node: bounded(graph, node) for node in growing if all(is_bounded(root, node) for root in roots)}


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


def is_bounded(root: Node, growing: Node) -> bool:
    """Whether ``root`` does not grow with one of its nodes, nor with others of that one's argument; by the
    degree of every node in these."""
    degrees: dict[Node, float | None] = {}
    for node in reachable([root]):
        each = [degrees[argument] for argument in node.arguments]
        known = [one for one in each if one is not None]
        if is_growing(node) and node.arguments == growing.arguments:
            degrees[node] = 1.0
        elif len(known) < len(each):
            degrees[node] = None
        elif node.kind is Kind.SUM:
            degrees[node] = max([*known, *([0.0] if node.data[0] != 0 else [])])
        elif node.kind is Kind.PRODUCT:
            degrees[node] = float(sum(exponent * one for exponent, one in zip(node.data, known)))
        else:
            degrees[node] = None if max(known, default=0.0) > 0 else 0.0
    found = degrees[root]
    return found is not None and found <= 0
