"""Where a force may hide: functions that may vanish, or be constant to the last bit, at both ends of a step
and in its series, but not between.

Their arguments have convergent series, which ``native.stepping.detection`` follows."""

from __future__ import annotations

import math
from collections.abc import Sequence

from lagrange_cli.expression.node import Kind, Node, reachable
from lagrange_cli.mechanics.residual import Residual

HIDING = frozenset({"exp", "tanh", "sinh", "cosh"})
"""These change by orders of magnitude, or from one constant to another, when their argument changes."""
STEEP, HIGH = -4, 16
"""Powers up to the one and from the other on change so fast that a series may not show them. They show most
where their base is nearest to 0, or greatest."""


def hidden_forces(residual: Residual) -> dict[Node, float]:
    """What is to be followed in the equations: arguments of functions that hide something, with 0, and
    bases, with the power that they are raised to."""
    graph, found = residual.graph, {}
    nodes = reachable(residual.residual)
    degrees = growth(nodes)
    for node in nodes:
        if node.kind is Kind.FUNCTION and node.data in HIDING:
            found[node.arguments[0]] = 0.0
        elif node.kind is Kind.POWER:
            found[node.arguments[1] * graph.function("log", node.arguments[:1])] = 0.0
        elif node.kind is Kind.PRODUCT:
            for base, exponent in zip(node.arguments, node.data):
                if found.get(base) != 0.0 and not STEEP < exponent * degrees[base] < HIGH:
                    found[base] = min(float(exponent), found.get(base, math.inf))
    return {node: power for node, power in found.items() if node.symbols & residual.variables}


def growth(nodes: Sequence[Node]) -> dict[Node, float]:
    """Of each node the power of large coordinates that it grows with, at most; arguments come first."""
    found: dict[Node, float] = {}
    for node in nodes:
        each = [found[argument] for argument in node.arguments]
        if node.kind is Kind.SUM:
            found[node] = max(each, default=0.0)
        elif node.kind is Kind.PRODUCT:
            found[node] = sum(abs(exponent) * degree for exponent, degree in zip(node.data, each))
        else:
            found[node] = 0.0 if node.kind is Kind.NUMBER else 1.0
    return found
