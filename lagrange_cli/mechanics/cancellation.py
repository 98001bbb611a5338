"""What cancels in terms of the equations, which disks enclose loosely (``native.stepping.cancelling``).

A difference of disks does not make use of what they have in common.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator

from lagrange_cli.expression.node import Kind, Node, reachable
from lagrange_cli.mechanics.approach import core, is_linear
from lagrange_cli.mechanics.defect import SINGULAR


def singular_sums(roots: Iterable[Node], variables: int, unknown: int) -> list[Node]:
    """The sums and products in which the expressions ``roots`` are singular, or steep: denominators, bases of
    roots, and arguments of functions such as tanh. Left out are linear ones, and those with ``unknown``
    symbols or accelerations."""
    found = singular_in(roots, variables)
    return [one for one in found if is_compound(one, variables) and is_known(one, unknown)]


def singular_in(roots: Iterable[Node], variables: int) -> list[Node]:
    """What the expressions ``roots`` are singular or steep in."""
    nodes = reachable(roots)
    return [*dict.fromkeys(moving_core(one, variables) for node in nodes for one in arguments(node))]


def arguments(node: Node) -> Iterator[Node]:
    """What a node may be singular or steep in."""
    if node.kind is Kind.PRODUCT:
        powers = zip(node.arguments, node.data)
        yield from (one for one, exponent in powers if exponent < 0 or exponent != int(exponent))
    elif node.kind is Kind.POWER or (node.kind is Kind.FUNCTION and node.data in SINGULAR):
        yield from node.arguments


def is_known(node: Node, unknown: int) -> bool:
    """Whether it contains neither ``unknown`` symbols nor rates such as accelerations."""
    return not node.symbols & unknown and all(one.kind is not Kind.DDT for one in reachable([node]))


def moving_core(node: Node, variables: int) -> Node:
    """What it is made of by powers, constant factors and constants that are added: w of sqrt(1 - 2*w**2)."""
    inner: Node | None = node
    while inner is not None:
        node = core(inner, variables)
        moving = [one for one in node.arguments if one.symbols & variables]
        inner = moving[0] if node.kind is Kind.SUM and len(moving) == 1 else None
    return node


def is_compound(node: Node, variables: int) -> bool:
    """Whether it is a sum or a product of several parts that move, and not linear."""
    moving = [one for one in node.arguments if one.symbols & variables]
    return node.kind in (Kind.SUM, Kind.PRODUCT) and len(moving) > 1 and not is_linear(node, variables)


def squared_tanh(node: Node) -> Node | None:
    """u, if it is c (1 - tanh(u)^2)."""
    if node.kind is not Kind.SUM or len(node.arguments) != 1 or node.data[1] != (-node.data[0],):
        return None
    square = node.arguments[0]
    if square.kind is not Kind.PRODUCT or square.data != (2,):
        return None
    inner = square.arguments[0]
    return inner.arguments[0] if inner.kind is Kind.FUNCTION and inner.data == "tanh" else None
