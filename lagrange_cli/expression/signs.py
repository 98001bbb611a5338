"""What the structure of an expression says of its sign, and which sums are squares of others."""

from __future__ import annotations

import math
from collections.abc import Mapping
from enum import IntEnum
from fractions import Fraction
from typing import Any

from lagrange_cli.expression.node import Kind, Node, Table, reachable

LAST_BIT = 2.0**-52
"""Coefficients of a square that was multiplied out by hand are off by a rounding."""


class Sign(IntEnum):
    """What is known of a real value, where it has one."""

    ANY = 0
    NEVER_NEGATIVE = 1
    POSITIVE = 2


FUNCTIONS = {"exp": Sign.POSITIVE, "cosh": Sign.POSITIVE, "acos": Sign.NEVER_NEGATIVE}


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
        terms = [known[a] if c > 0 else Sign.ANY for a, c in zip(node.arguments, coefficients)]
        if min(terms) is Sign.ANY or not constant >= 0:
            return Sign.ANY
        return max(*terms, of_number(constant))
    if node.kind is Kind.PRODUCT:
        return min(_sign_of_power(known[a], e) for a, e in zip(node.arguments, node.data))
    if node.kind is Kind.POWER:
        return Sign.NEVER_NEGATIVE if known[node.arguments[0]] is not Sign.ANY else Sign.ANY
    if node.kind is Kind.FUNCTION:
        return FUNCTIONS.get(node.data, Sign.ANY)
    if node.kind is Kind.SWITCH:
        return Sign.NEVER_NEGATIVE if is_absolute(node) else min(known[a] for a in node.arguments[1:])
    return Sign.ANY


def of_number(number: Any) -> Sign:
    """That of a number; of nan, nothing is known."""
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


def root_of_square(graph: Table, node: Node) -> Node | None:
    """A sum whose square ``node`` is, multiplied out: x - y of x**2 - 2*x*y + y**2.

    n terms have n squares and n (n - 1)/2 products of two.
    """
    constant, coefficients = node.data
    given = dict(zip(node.arguments, coefficients))
    if constant:
        given[graph.one] = constant
    squares = sum(c > 0 and (term is graph.one or _is_even(term)) for term, c in given.items())
    if squares < 2 or len(given) > squares * (squares + 1) // 2:
        return None
    if squares == len(given) and not any(isinstance(c, Fraction) for c in given.values()):
        return None  # all of them have roots
    parts: dict[Node, Any] = {}
    for term, coefficient in given.items():
        half = _half(graph, term)
        root = exact_root(coefficient) if half is not None else None
        if half is not None and root is not None:
            parts[half] = root
    count = len(parts)
    if count < 2 or len(given) != count * (count + 1) // 2:
        return None
    graph.work.charge(count * count)
    first, *others = parts
    for other in others:
        cross = given.get(graph.product([(first, 1), (other, 1)]), 0.0)
        if cross < 0:
            parts[other] = -parts[other]
    listed = list(parts.items())
    for place, (one, a) in enumerate(listed):
        for other, b in listed[place + 1 :]:
            cross = given.get(graph.product([(one, 1), (other, 1)]), 0.0)
            slack = 0 if isinstance(cross, Fraction) else LAST_BIT
            if not abs(cross - 2 * a * b) <= slack * abs(2 * a * b):
                return None
    return graph.sum(listed)


SQUARES: Mapping[tuple[str, int, int], tuple[str, float, float]] = {
    ("cos", 1, -1): ("sin", 0.5, 2.0),
    ("cos", 1, 1): ("cos", 0.5, 2.0),
    ("cosh", 1, -1): ("sinh", 0.5, -2.0),
    ("cos", 2, -1): ("sin", 1.0, 1.0),
    ("sin", 2, -1): ("cos", 1.0, 1.0),
    ("cosh", 2, -1): ("sinh", 1.0, -1.0),
}
"""1 + s f(u)^e as c g(k u)^2: of f, e and s the g, k and c."""


def square_of_function(graph: Table, node: Node) -> tuple[Node, Node] | None:
    """a and b with ``node`` = a b^2 where b is a function, such as 2 and sin(u/2) of 1 - cos(u)."""
    constant, coefficients = node.data
    given = [*zip(node.arguments, coefficients), *([(graph.one, constant)] if constant else [])]
    if len(given) != 2:
        return None
    for (one, first), (other, second) in (given, given[::-1]):
        if abs(first) != abs(second):
            return None
        parts = zip(other.arguments, other.data) if other.kind is Kind.PRODUCT else [(other, 1)]
        for f, exponent in parts:
            square = SQUARES.get((str(f.data), exponent, 1 if first == second else -1))
            if square and f.kind is Kind.FUNCTION and graph.product([(other, 1), (f, -exponent)]) is one:
                name, inner, outer = square
                return one * (first * outer), graph.function(name, [f.arguments[0] * inner])
    return None


def _half(graph: Table, term: Node) -> Node | None:
    """The square root of a product of even powers that are positive."""
    if term is graph.one:
        return term
    if not _is_even(term):
        return None
    return graph.product([(a, e // 2) for a, e in zip(term.arguments, term.data)])


def _is_even(term: Node) -> bool:
    """Whether it is a product of even powers that are positive."""
    if term.kind is not Kind.PRODUCT:
        return False
    return all(isinstance(e, int) and e > 0 and e % 2 == 0 for e in term.data)


def exact_root(number: Any) -> Any:
    """The square root of a positive number: of a fraction one that is exact, of a double the nearest one."""
    if not (number > 0 and math.isfinite(number)):
        return None
    if not isinstance(number, Fraction):
        return math.sqrt(number)
    above, below = math.isqrt(number.numerator), math.isqrt(number.denominator)
    exact = above * above == number.numerator and below * below == number.denominator
    return type(number)(above, below) if exact else None
