"""Expressions that change their sign only where they are 0: they do not jump, and have no pole from whose
sides they have opposite signs."""

from __future__ import annotations

from lagrange_cli.expression.node import Kind, Node, reachable
from lagrange_cli.expression.signs import Sign, is_absolute, signs

BROKEN = "atan2", "tan"
"""Functions that jump, or have poles of that kind."""


def unbroken(node: Node, known: int, moving: int) -> bool:
    """Whether an expression of a motion is visibly one: what it is made of is ``known`` not to jump, and
    constant but for what is ``moving`` (bit sets of symbols)."""
    own: dict[Node, Sign] = {}

    def breaks(one: Node) -> bool:
        if one.kind is Kind.SYMBOL:
            return not one.symbols & known
        if one.kind is Kind.PRODUCT:
            below = [
                a for a, e in zip(one.arguments, one.data) if e < 0 and e % 2 == 1 and a.symbols & moving
            ]
            return any(signs(a, own) is Sign.ANY for a in below)
        if one.kind is Kind.SWITCH:
            return not is_absolute(one)
        return one.kind is Kind.DDT or (one.kind is Kind.FUNCTION and one.data in BROKEN)

    return not any(map(breaks, reachable([node])))
