"""Values of graph nodes at many states at once, with numpy: nan or inf where there is no real value."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

from lagrange_cli.expression.node import Kind, Node, reachable

Array = npt.NDArray[np.float64]
FUNCTIONS = {"asin": np.arcsin, "acos": np.arccos, "atan": np.arctan, "atan2": np.arctan2}
"""Functions with another name in numpy."""


def evaluate(nodes: Sequence[Node], values: Mapping[str, Array | float]) -> list[Array]:
    """Values of ``nodes``, given those of the symbols by name: numbers, or arrays of one shape."""
    found: dict[Node, Any] = {}
    with np.errstate(all="ignore"):
        for node in reachable(nodes):
            found[node] = _value(node, [found[one] for one in node.arguments], values)
    return [np.asarray(found[node], dtype=float) for node in nodes]


def sizes(nodes: Sequence[Node], values: Mapping[str, Array | float]) -> list[Array]:
    """How large the terms of ``nodes`` are: the same, with absolute values in all sums."""
    found, known = dict[Node, Any](), dict[Node, Any]()
    with np.errstate(all="ignore"):
        for node in reachable(nodes):
            known[node] = _value(node, [known[one] for one in node.arguments], values)
            found[node] = np.abs(known[node])
            if node.kind is Kind.SUM:
                constant, coefficients = node.data
                terms = zip(coefficients, node.arguments)
                found[node] = abs(float(constant)) + sum(abs(float(c)) * found[one] for c, one in terms)
            elif node.kind is Kind.PRODUCT:
                found[node] = 1.0
                for one, exponent in zip(node.arguments, node.data):
                    base = found[one] if exponent > 0 else np.abs(known[one])
                    found[node] = found[node] * np.power(base, float(exponent))
            elif node.kind is Kind.SWITCH:
                u, above, below = node.arguments
                found[node] = np.where(known[u] > 0, found[above], found[below])
    return [np.asarray(found[node], dtype=float) for node in nodes]


def _value(node: Node, a: Sequence[Any], values: Mapping[str, Array | float]) -> Any:
    """The value of one node, from those of its arguments."""
    kind = node.kind
    if kind is Kind.NUMBER:
        return float(node.data)
    if kind is Kind.SYMBOL:
        return values[node.data]
    if kind is Kind.SUM:
        constant, coefficients = node.data
        return float(constant) + sum(float(c) * x for c, x in zip(coefficients, a))
    if kind is Kind.PRODUCT:
        product: Any = 1.0
        for base, exponent in zip(a, node.data):
            product = product * (base if exponent == 1 else np.power(base, float(exponent)))
        return product
    if kind is Kind.POWER:
        return np.power(a[0], a[1])
    if kind is Kind.FUNCTION:
        function = FUNCTIONS.get(node.data) or getattr(np, node.data)
        return function(*a)
    if kind is Kind.SWITCH:
        u, above, below = a
        middle = above if node.data > 0 else below if node.data < 0 else (above + below) / 2
        return np.where(u > 0, above, np.where(u < 0, below, np.where(np.isnan(u), np.nan, middle)))
    raise ValueError("a time derivative has no value without a motion")
