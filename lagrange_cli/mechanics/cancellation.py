"""Forms in which nothing cancels, which disks enclose closely (``native.stepping.proof``).

A difference of disks does not make use of what they have in common.
"""

from __future__ import annotations

from lagrange_cli.expression.node import Kind, Node


def squared_tanh(node: Node) -> Node | None:
    """u, if it is c (1 - tanh(u)^2)."""
    if node.kind is not Kind.SUM or len(node.arguments) != 1 or node.data[1] != (-node.data[0],):
        return None
    square = node.arguments[0]
    if square.kind is not Kind.PRODUCT or square.data != (2,):
        return None
    inner = square.arguments[0]
    return inner.arguments[0] if inner.kind is Kind.FUNCTION and inner.data == "tanh" else None
