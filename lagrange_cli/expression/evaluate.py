"""Values of graph nodes in floating point, with the size of the terms that they are sums of."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence

from lagrange_cli.expression.node import Kind, Node, reachable
from lagrange_cli.expression.reals import real_function, real_power

SATURATING = frozenset({"exp", "tanh", "sinh", "cosh"})
FARTHEST = 10.0
"""Beyond this, sums with such functions hold less than their rounding: tanh is 1, exp(-x) is nothing beside
1."""


def evaluate(
    nodes: Sequence[Node],
    values: Mapping[str, float],
    power: Callable[[float, float], float] = real_power,
    function: Callable[[str, Sequence[float]], float] = real_function,
) -> tuple[dict[Node, float], dict[Node, float]]:
    """Values of ``nodes`` and all below them, and for each the size of the terms it was summed from.

    The second number is what a value must be compared with before it is called zero: the value computed
    with every subtraction turned into an addition (a running bound of the cancellation). Not a number are
    values that say nothing about it, where one of ``SATURATING`` is too far from 0. ``power`` and
    ``function`` are those of the numbers given.
    """
    value: dict[Node, float] = {}
    size: dict[Node, float] = {}
    for node in reachable(nodes):
        a = node.arguments
        if node.kind is Kind.NUMBER:
            value[node], size[node] = node.data, abs(node.data)
        elif node.kind is Kind.SYMBOL:
            value[node] = values[node.data]
            size[node] = abs(value[node])
        elif node.kind is Kind.SUM:
            constant, coefficients = node.data
            value[node] = constant + sum(c * value[x] for c, x in zip(coefficients, a))
            size[node] = abs(constant) + sum(abs(c) * size[x] for c, x in zip(coefficients, a))
        elif node.kind is Kind.PRODUCT:
            result, bound = 1.0, 1.0
            for x, e in zip(a, node.data):
                factor = power(value[x], e)
                result *= factor
                bound *= power(size[x], e) if e > 0 else abs(factor)
            value[node], size[node] = result, bound
        elif node.kind is Kind.POWER:
            value[node] = power(value[a[0]], value[a[1]])
            size[node] = abs(value[node])
        elif node.kind is Kind.FUNCTION:
            far = node.data in SATURATING and abs(value[a[0]]) > FARTHEST
            value[node] = math.nan if far else function(node.data, [value[x] for x in a])
            size[node] = max(abs(value[node]), 1.0)
            if node.data == "exp":
                size[node] = abs(value[node]) * max(size[a[0]], 1.0)
        elif node.kind is Kind.SWITCH:
            value[node] = switched(node.data, *(value[x] for x in a))
            size[node] = switched(node.data, value[a[0]], size[a[1]], size[a[2]])
        else:
            raise ValueError("a time derivative has no value without a motion")
    return value, size


def switched(at: int, u: float, above: float, below: float) -> float:
    """A switch's value; what it does not choose may be anything."""
    side = 1 if u > 0 else -1 if u < 0 else at
    if u != u:
        return math.nan
    return above if side > 0 else below if side < 0 else (above + below) / 2
