"""What the structure of an expression says of its curvature: whether it is convex in its variables.

The rules are those of disciplined convex programming (M. Grant, S. Boyd, Y. Ye, in: Global Optimization,
2006): sums of convex expressions, even powers of linear ones, and lengths of vectors of these.
"""

from __future__ import annotations

from enum import IntFlag

from lagrange_cli.expression.node import Kind, Node, reachable
from lagrange_cli.expression.signs import Sign, signs


class Curvature(IntFlag):
    """Whether an expression is known to be convex, concave, or both, that is linear."""

    ANY = 0
    CONVEX = 1
    CONCAVE = 2
    LINEAR = 3

    def times(self, positive: bool) -> Curvature:
        """That of a positive or a negative multiple."""
        both = {Curvature.CONVEX: Curvature.CONCAVE, Curvature.CONCAVE: Curvature.CONVEX}
        return self if positive else both.get(self, self)


def curvature(node: Node, variables: int) -> Curvature:
    """The curvature of ``node`` in its ``variables`` (symbols) together, where it has a value."""
    known: dict[Node, Curvature] = {}
    for one in reachable([node]):
        if one.kind is Kind.SYMBOL or not one.symbols & variables:
            known[one] = Curvature.LINEAR
        elif one.kind is Kind.SUM:
            known[one] = Curvature.LINEAR
            for inner, coefficient in zip(one.arguments, one.data[1]):
                known[one] &= known[inner].times(coefficient > 0)
        elif one.kind is Kind.PRODUCT:
            known[one] = _of_product(one, variables, known)
        else:
            known[one] = Curvature.ANY
    return known[node]


def _of_product(node: Node, variables: int, known: dict[Node, Curvature]) -> Curvature:
    """That of a power of one expression, times constants."""
    factors = [*zip(node.arguments, node.data)]
    moving = [(base, e) for base, e in factors if base.symbols & variables]
    if len(moving) > 1:
        return Curvature.ANY
    ((base, exponent),) = moving
    found = Curvature.ANY
    if exponent == 1:
        found = known[base]
    elif (exponent > 0 and exponent % 2 == 0 and known[base] is Curvature.LINEAR) or (
        exponent == 0.5 and _is_square(base, variables, known)
    ):
        found = Curvature.CONVEX
    fixed = [(base, e) for base, e in factors if not base.symbols & variables]
    scaled = all(signs(base, {}) is not Sign.ANY or e % 2 == 0 for base, e in fixed)
    return found if scaled or found is Curvature.LINEAR else Curvature.ANY


def _is_square(node: Node, variables: int, known: dict[Node, Curvature]) -> bool:
    """Whether it is the square of the length of a vector whose components are linear."""
    if node.kind is Kind.SUM:
        constant, coefficients = node.data
        parts = [c > 0 and _is_square(a, variables, known) for a, c in zip(node.arguments, coefficients)]
        return constant >= 0 and all(parts)
    if not node.symbols & variables:
        return signs(node, {}) is not Sign.ANY
    return (
        node.kind is Kind.PRODUCT
        and all(e == 2 and known[base] is Curvature.LINEAR for base, e in zip(node.arguments, node.data))
        and sum(bool(base.symbols & variables) for base in node.arguments) == 1
    )
