"""What the structure of an expression says of its sign."""

from __future__ import annotations

import math
from collections.abc import Mapping
from enum import IntEnum
from typing import Any

from lagrange_cli.expression.node import Kind, Node, reachable


class Sign(IntEnum):
    """The known properties of a real value, if it has one."""

    ANY = 0
    NEVER_NEGATIVE = 1
    POSITIVE = 2


FUNCTIONS = {"exp": Sign.POSITIVE, "cosh": Sign.POSITIVE, "acos": Sign.NEVER_NEGATIVE}
BOUNDED = "sin", "cos", "tanh"
"""Functions that never exceed 1 in size."""
BROKEN = "atan2", "tan"
"""Functions that jump, or have poles from whose sides they have opposite signs."""


def signs(node: Node, known: dict[Node, Sign]) -> Sign:
    """The sign of ``node``; ``known`` holds and takes that of what is below it."""
    for one in reachable([node], lambda inner: inner not in known):
        known[one] = _sign(one, known)
    return known[node]


def _sign(node: Node, known: Mapping[Node, Sign]) -> Sign:
    if node.kind is Kind.NUMBER:
        return of_number(node.data)
    if node.kind is Kind.SUM:
        constant, coefficients = node.data
        terms = [_sign_of_multiple(a, c, known) for a, c in zip(node.arguments, coefficients)]
        pairs = zip(node.arguments, coefficients, terms)
        unknown = [abs(c) * most for a, c, sign in pairs if sign is Sign.ANY and (most := bound(a))]
        if len(unknown) < terms.count(Sign.ANY) or not (least := constant - sum(unknown)) >= 0:
            return Sign.ANY
        return max(*terms, of_number(least))
    if node.kind is Kind.PRODUCT:
        return min(_sign_of_power(known[a], e) for a, e in zip(node.arguments, node.data))
    if node.kind is Kind.POWER:
        return Sign.NEVER_NEGATIVE if known[node.arguments[0]] is not Sign.ANY else Sign.ANY
    if node.kind is Kind.FUNCTION:
        return FUNCTIONS.get(node.data, Sign.ANY)
    if node.kind is Kind.SWITCH:
        return _sign_of_multiple(node, 1.0, known)
    return Sign.ANY


def bound(node: Node) -> int:
    """What the size of an expression does not exceed: 1, or 0 if that is not seen."""
    if node.kind is Kind.PRODUCT:
        return int(all(bound(a) and isinstance(e, int) and e > 0 for a, e in zip(node.arguments, node.data)))
    return int(node.kind is Kind.FUNCTION and node.data in BOUNDED)


def _sign_of_multiple(node: Node, factor: Any, known: Mapping[Node, Sign]) -> Sign:
    """That of a number times an expression. The branches of a switch count where its argument has their side:
    neither max(0, u) nor -min(0, u) is negative."""
    if node.kind is not Kind.SWITCH:
        return known[node] if factor > 0 else Sign.ANY
    u, *branches = node.arguments
    found = Sign.POSITIVE
    for branch, side in zip(branches, (1, -1)):
        ratio, rest = in_terms_of(u, branch)
        own = known[branch] if factor > 0 else Sign.ANY
        if factor * ratio * side >= 0:
            own = max(own, of_number(factor * rest))
        found = min(found, own)
    return found


def in_terms_of(u: Node, node: Node) -> tuple[Any, Any]:
    """The numbers a and b of ``node`` = a u + b; not numbers where none are seen."""
    (constant, own), (other, terms) = _terms(node), _terms(u)
    ratios = {own[one] / factor for one, factor in terms.items()} if own.keys() == terms.keys() else {0.0}
    if len(ratios) > 1 or (own and ratios == {0.0}):
        return math.nan, math.nan
    (ratio,) = ratios
    return ratio, constant - ratio * other


def _terms(node: Node) -> tuple[Any, dict[Node, Any]]:
    """The constant and the coefficients of a sum."""
    if node.kind is Kind.NUMBER:
        return node.data, {}
    if node.kind is not Kind.SUM:
        return 0.0, {node: 1.0}
    constant, coefficients = node.data
    return constant, dict(zip(node.arguments, coefficients))


def of_number(number: Any) -> Sign:
    """The sign of a number; that of nan is unknown."""
    return Sign.POSITIVE if number > 0 else Sign.NEVER_NEGATIVE if number == 0 else Sign.ANY


def _sign_of_power(base: Sign, exponent: Any) -> Sign:
    if base is Sign.ANY and (not math.isfinite(exponent) or exponent % 2 == 1):
        return Sign.ANY
    return Sign.POSITIVE if base is Sign.POSITIVE else Sign.NEVER_NEGATIVE


def is_absolute(node: Node) -> bool:
    """Whether it is the absolute value of its first argument."""
    if node.kind is not Kind.SWITCH or node.arguments[0] is not node.arguments[1]:
        return False
    u, _, below = node.arguments
    return below is -u


def is_sign(node: Node) -> bool:
    """Whether it is the sign of its first argument."""
    if node.kind is not Kind.SWITCH or node.data != 0:
        return False
    above, below = node.arguments[1:]
    return above.kind is below.kind is Kind.NUMBER and (above.data, below.data) == (1, -1)


def proportional(one: Node, other: Node) -> bool:
    """Whether one expression is visibly a number times the other."""
    if one is other:
        return True
    if one.kind is not Kind.SUM or other.kind is not Kind.SUM or one.arguments != other.arguments:
        return False
    first, second = ((node.data[0], *node.data[1]) for node in (one, other))
    return all(a * second[1] == b * first[1] for a, b in zip(first, second))


def unbroken(node: Node, known: int, moving: int) -> bool:
    """Whether an expression visibly changes its sign along a motion only where it is 0: it has no jump, and
    no pole of that kind. Symbols are ``known`` not to jump, and constant but for what is ``moving``."""
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
