"""Nodes of the graph as text in the language of system files, to be read."""

from __future__ import annotations

import math
from collections.abc import Mapping

from lagrange_cli.decimals import decimal
from lagrange_cli.expression.node import Kind, Node, reachable

SUM, PRODUCT, POWER = 0, 1, 2
"""How tightly operators bind."""
TWELFTHS = 12
"""Parts of pi that are recognized."""
MOST = 17
"""Less than this are the denominators of coefficients in sums that are multiplied by a number."""
THIRDS = frozenset({3, 6, 7, 9, 11, 12})
"""Denominators of exponents that are no decimals."""
SIMPLE = (1, 2, 3, 4, 5, 6, 7, 8, 9, 11, 12, 16, 24, 32)
"""Denominators of coefficients that are not written as decimals."""


def text_of(node: Node, moving: int = 0) -> str:
    """``node`` in the words of a system file. In products, factors with symbols that are ``moving`` come
    last."""
    made: dict[Node, tuple[str, int]] = {}
    for one in reachable([node]):
        made[one] = _text(one, made, moving)
    return made[node][0]


def number_text(value: float) -> str:
    """A number in few digits, or in terms of pi."""
    value = float(value)
    for sign, multiple in (("*", value / math.pi), ("/", value * math.pi)):
        if value and abs(multiple * TWELFTHS - round(multiple * TWELFTHS)) < 1e-12 * abs(multiple):
            return "pi" if multiple == 1 and sign == "*" else f"{decimal(multiple, 12)}{sign}pi"
    return decimal(value, 12)


def _text(node: Node, made: Mapping[Node, tuple[str, int]], moving: int) -> tuple[str, int]:
    arguments = [made[a] for a in node.arguments]
    if node.kind is Kind.NUMBER:
        return number_text(node.data), POWER if node.data >= 0 else SUM
    if node.kind is Kind.SYMBOL:
        return str(node.data), POWER
    if node.kind is Kind.SUM:
        return _sum(node, made, moving)
    if node.kind is Kind.PRODUCT:
        return _product(node, made, moving)
    if node.kind is Kind.POWER:
        return f"{bracketed(arguments[0], POWER)}**{bracketed(arguments[1], POWER)}", PRODUCT
    name = node.data if node.kind is Kind.FUNCTION else "where" if node.kind is Kind.SWITCH else "ddt"
    inside = [text for text, _ in arguments]
    if node.kind is Kind.SWITCH:
        inside[0] += " > 0"
    return f"{name}({', '.join(inside)})", POWER


def _sum(node: Node, made: Mapping[Node, tuple[str, int]], moving: int, times: int = 1) -> tuple[str, int]:
    """A sum so many times."""
    constant, coefficients = node.data
    terms = [_term(times * float(c), one, made, moving) for c, one in zip(coefficients, node.arguments)]
    if constant != 0:
        terms.append(number_text(times * constant))
    return joined(terms), SUM if len(terms) > 1 or terms[0].startswith("-") else PRODUCT


def _product(
    node: Node, made: Mapping[Node, tuple[str, int]], moving: int, times: str = "1", over: str = "1"
) -> tuple[str, int]:
    """A product, multiplied by a number and divided by another."""
    powers = zip(node.arguments, node.data) if node.kind is Kind.PRODUCT else [(node, 1)]
    factors = sorted(powers, key=lambda one: bool(one[0].symbols & moving))
    above = [times] * (times != "1") + [_power(made[a], e) for a, e in factors if e > 0]
    below = [over] * (over != "1") + [_power(made[a], -e) for a, e in factors if e < 0]
    text = "*".join(above) or "1"
    if below:
        text += f"/{below[0]}" if len(below) == 1 else f"/({'*'.join(below)})"
    return text, PRODUCT


def _power(argument: tuple[str, int], exponent: float) -> str:
    if exponent == 0.5:
        return f"sqrt({argument[0]})"
    if exponent == 1:
        return bracketed(argument, PRODUCT)
    return f"{bracketed(argument, POWER)}**{exponent_text(exponent)}"


def exponent_text(exponent: float) -> str:
    """An exponent (not negative) as a short decimal, or as a fraction."""
    from fractions import Fraction  # for what is rare

    near = Fraction(exponent).limit_denominator(TWELFTHS)
    simple = near.denominator in THIRDS and math.isclose(near, exponent, rel_tol=1e-14)
    return f"({near})" if simple else number_text(exponent)


def _term(coefficient: float, node: Node, made: Mapping[Node, tuple[str, int]], moving: int) -> str:
    """A number of times ``node``. Sums in it get whole coefficients where the number stays whole:
    4*x*(a - b/4) becomes x*(4*a - b)."""
    whole = dict[Node, tuple[str, int]]()
    for one, exponent in zip(node.arguments, node.data) if node.kind is Kind.PRODUCT else ():
        times = _denominator(one)
        left = coefficient / times**exponent
        if times > 1 and left.is_integer():
            coefficient, whole[one] = left, _sum(one, made, moving, times)
    size, sign = abs(coefficient), "-" * (coefficient < 0)
    over = next((n for n in SIMPLE if (n * size).is_integer() and n * size / n == size), 1)
    text, _ = _product(node, {**made, **whole}, moving, number_text(over * size), str(over))
    return sign + text


def _denominator(node: Node) -> int:
    """The least number of times that a sum has whole coefficients; 1 where it is no sum, or has none."""
    numbers = [float(c) for c in (node.data[0], *node.data[1])] if node.kind is Kind.SUM else []
    return next((n for n in range(1, MOST) if all((n * c).is_integer() for c in numbers)), 1)


def joined(terms: list[str]) -> str:
    """A sum of terms, each of which may begin with its sign."""
    first, *rest = terms
    return first + "".join(f" - {one[1:]}" if one.startswith("-") else f" + {one}" for one in rest)


def bracketed(argument: tuple[str, int], least: int) -> str:
    """An operand, in brackets where it binds less tightly."""
    text, binds = argument
    return text if binds >= least else f"({text})"
