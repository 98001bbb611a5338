"""Forms in which nothing cancels: what disks enclose closely (``native.stepping.proof``).

The difference of disks knows nothing of what they have in common.
"""

from __future__ import annotations

from lagrange_cli.expression.node import Kind, Node
from lagrange_cli.expression.signs import Sign, signs
from lagrange_cli.records import dataclass

LEFT_OVER = 2.0**-48
"""Coefficients that would cancel but for their rounding are at most so large a part of what they were."""


@dataclass(frozen=True)
class Rooted:
    """A fraction that does not cancel."""

    above: Node
    below: Node


def rooted(node: Node) -> Rooted | None:
    """k sqrt(P) - B as a fraction, if k B is never negative and k^2 P - B^2 does not move."""
    if node.kind is not Kind.SUM:
        return None
    for term, scale in zip(node.arguments, node.data[1]):
        if term.kind is Kind.PRODUCT and term.data == (0.5,):
            rest = node - term * scale
            if signs(rest if scale < 0 else -rest, {}) is Sign.ANY:
                return None
            above = term.arguments[0] * (scale * scale) - rest * rest
            return Rooted(above, term * scale - rest) if still(above, term.arguments[0]) else None
    return None


def still(node: Node, beside: Node) -> bool:
    """Whether a node is a number, but for what rounding of coefficients has left of those ``beside`` it."""
    if node.kind is not Kind.SUM or beside.kind is not Kind.SUM:
        return node.kind is Kind.NUMBER
    largest = max(map(abs, beside.data[1]))
    return all(abs(one) <= largest * LEFT_OVER for one in node.data[1])


def squared_tanh(node: Node) -> Node | None:
    """u, if it is c (1 - tanh(u)^2)."""
    if node.kind is not Kind.SUM or len(node.arguments) != 1 or node.data[1] != (-node.data[0],):
        return None
    square = node.arguments[0]
    if square.kind is not Kind.PRODUCT or square.data != (2,):
        return None
    inner = square.arguments[0]
    return inner.arguments[0] if inner.kind is Kind.FUNCTION and inner.data == "tanh" else None
