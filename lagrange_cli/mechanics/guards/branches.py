"""Roots in the branches of switches: where the argument is 0, these have no series."""

from __future__ import annotations

import math

from lagrange_cli.expression.node import Kind, Node, reachable
from lagrange_cli.records import dataclass


@dataclass(frozen=True)
class Rooted:
    """Branches that contain roots of the argument: whether they are ``steep`` there, infinitely; and the
    ``side``, the sign of the argument, that alone has some, or 0."""

    steep: bool
    side: int

    def joined(self, other: Rooted | None) -> Rooted:
        """The roots of these branches and of others with the same argument."""
        if other is None:
            return self
        return Rooted(self.steep or other.steep, self.side if self.side == other.side else 0)


def rooted(argument: Node, above: Node, below: Node) -> Rooted | None:
    """The roots in the branches of a switch, if there are any: of what its argument contains."""
    first, second = (_least_exponent(argument, one) for one in (above, below))
    if first == second == math.inf:
        return None
    side = 0 if max(first, second) < math.inf else 1 if first < math.inf else -1
    return Rooted(min(first, second) < 1.0, side)


def _least_exponent(argument: Node, branch: Node) -> float:
    """The least fractional exponent of what the argument contains; 0 where it is not known, and infinity
    where there is none."""
    least = math.inf
    for node in reachable([branch]):
        if node.kind is Kind.PRODUCT:
            for base, exponent in zip(node.arguments, node.data):
                if base.symbols & argument.symbols and exponent != int(exponent):
                    least = min(least, exponent)
        elif node.kind is Kind.POWER and node.arguments[0].symbols & argument.symbols:
            least = min(least, 0.0)
    return least
