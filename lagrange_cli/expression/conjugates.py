"""Differences that cancel except for a number: sqrt(1 + u^4) - u^2 is 1/(sqrt(1 + u^4) + u^2).

Where u is large, the difference has no digits left; and a difference of disks (``native.stepping.proof``)
does not make use of what these have in common.
"""

from __future__ import annotations

from typing import Any

from lagrange_cli.expression.node import Kind, Node
from lagrange_cli.expression.signs import Sign, signs

LEFT_OVER = 2.0**-48
"""Coefficients that would cancel except for rounding are at most this fraction of their former size."""
CERTAIN = 2.0**-20
"""A remaining number is at least this fraction of those whose difference it is."""


def conjugate(node: Node) -> tuple[Node, Node] | None:
    """k sqrt(P) - B as a fraction, if k B is never negative and k^2 P - B^2 is a number."""
    if node.kind is not Kind.SUM:
        return None
    for term, scale in zip(node.arguments, node.data[1]):
        if term.kind is Kind.PRODUCT and term.data == (0.5,):
            if scale - scale != 0:  # it is infinite, or nan: no difference is without this term
                return None
            rest = node - term * scale
            if signs(rest if scale < 0 else -rest, {}) is Sign.ANY:
                return None
            above = term.arguments[0] * (scale * scale) - rest * rest
            number = left_over(above, term.arguments[0] * (scale * scale))
            return None if number is None else (node.graph.lift(number), term * scale - rest)
    return None


def left_over(node: Node, beside: Node) -> Any:
    """The number that a node is, up to the rounding of coefficients ``beside`` it; None if it is none."""
    if node.kind is Kind.NUMBER:
        number, rest = node.data, []
    elif node.kind is Kind.SUM and beside.kind is Kind.SUM:
        number, rest = node.data[0], node.data[1]
    else:
        return None
    constant, coefficients = beside.data if beside.kind is Kind.SUM else (0.0, [1.0])
    largest = max(map(abs, coefficients))
    known = abs(number) >= abs(constant) * CERTAIN
    return number if known and all(abs(one) <= largest * LEFT_OVER for one in rest) else None
