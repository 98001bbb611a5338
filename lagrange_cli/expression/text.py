"""Nodes of the graph as text in the language of system files, to be read."""

from __future__ import annotations

import math
from collections.abc import Mapping

from lagrange_cli.expression.node import Kind, Node, reachable

SUM, PRODUCT, POWER = 0, 1, 2
"""How tightly operators bind."""
TWELFTHS = 12
"""Parts of pi that are recognized."""
THIRDS = frozenset({3, 6, 7, 9, 11, 12})
"""Denominators of exponents that are no decimals."""


def text_of(node: Node, names: Mapping[Node, str] | None = None, moving: int = 0) -> str:
    """``node`` in the words of a system file; ``names`` are those of nodes that have one. In products,
    factors with symbols that are ``moving`` come last."""
    made: dict[Node, tuple[str, int]] = {}
    for one in reachable([node]):
        made[one] = _text(one, made, moving) if one not in (names or {}) else ((names or {})[one], POWER)
    return made[node][0]


def number_text(value: float) -> str:
    """A number in few digits, or in terms of pi."""
    value = float(value)
    for sign, multiple in (("*", value / math.pi), ("/", value * math.pi)):
        if value and abs(multiple * TWELFTHS - round(multiple * TWELFTHS)) < 1e-12 * abs(multiple):
            return "pi" if multiple == 1 and sign == "*" else f"{multiple:.12g}{sign}pi"
    return f"{value:.12g}"


def _text(node: Node, made: Mapping[Node, tuple[str, int]], moving: int) -> tuple[str, int]:
    arguments = [made[a] for a in node.arguments]
    if node.kind is Kind.NUMBER:
        return number_text(node.data), POWER if node.data >= 0 else SUM
    if node.kind is Kind.SYMBOL:
        return str(node.data), POWER
    if node.kind is Kind.SUM:
        constant, coefficients = node.data
        terms = [_term(float(c), argument) for c, argument in zip(coefficients, arguments)]
        if constant != 0:
            terms.append(number_text(constant))
        return joined(terms), SUM if len(terms) > 1 or terms[0].startswith("-") else PRODUCT
    if node.kind is Kind.PRODUCT:
        return _product(node, made, moving)
    if node.kind is Kind.POWER:
        return f"{bracketed(arguments[0], POWER)}**{bracketed(arguments[1], POWER)}", PRODUCT
    name = node.data if node.kind is Kind.FUNCTION else "where" if node.kind is Kind.SWITCH else "ddt"
    inside = [text for text, _ in arguments]
    if node.kind is Kind.SWITCH:
        inside[0] += " > 0"
    return f"{name}({', '.join(inside)})", POWER


def _product(node: Node, made: Mapping[Node, tuple[str, int]], moving: int) -> tuple[str, int]:
    factors = sorted(zip(node.arguments, node.data), key=lambda one: bool(one[0].symbols & moving))
    above = [_power(made[a], e) for a, e in factors if e > 0]
    below = [_power(made[a], -e) for a, e in factors if e < 0]
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


def _term(coefficient: float, argument: tuple[str, int]) -> str:
    if abs(coefficient) == 1:
        return "-" * (coefficient < 0) + bracketed(argument, PRODUCT)
    text = bracketed(argument, PRODUCT)
    return number_text(coefficient) + (text[1:] if text.startswith("1/") else f"*{text}")


def joined(terms: list[str]) -> str:
    """A sum of terms, each of which may begin with its sign."""
    first, *rest = terms
    return first + "".join(f" - {one[1:]}" if one.startswith("-") else f" + {one}" for one in rest)


def bracketed(argument: tuple[str, int], least: int) -> str:
    """An operand, in brackets where it binds less tightly."""
    text, binds = argument
    return text if binds >= least else f"({text})"
