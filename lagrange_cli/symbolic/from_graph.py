"""Expressions of the graph as expressions of sympy."""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction
from math import pi

import sympy

from lagrange_cli.expression.node import Kind, Node, reachable
from lagrange_cli.expression.symbolic import FUNCTIONS
from lagrange_cli.expression.symbolic_switches import OfExpressions

LARGEST = 2000
"""Nodes of the largest expression that is written out."""
TWELFTHS = 12
"""Parts of pi, or of its reciprocal, that are recognized."""
LARGEST_DENOMINATOR = 1 << 40
"""The largest denominator of a fraction that is written as it is."""
DENOMINATOR = 5000
"""The largest denominator of the square of a root that is recognized."""


def from_graph(node: Node) -> sympy.Expr | None:
    """A node as an expression of sympy, None where it is too large; symbols keep their names."""
    made: dict[Node, sympy.Expr] = {}
    below = reachable([node])
    if len(below) > LARGEST:
        return None
    for one in below:
        made[one] = _expression(one, [made[argument] for argument in one.arguments])
    return made[node]


def _expression(node: Node, arguments: Sequence[sympy.Expr]) -> sympy.Expr:
    if node.kind is Kind.NUMBER:
        return number(node.data)
    if node.kind is Kind.SYMBOL:
        return sympy.Symbol(str(node.data))
    if node.kind is Kind.SUM:
        constant, coefficients = node.data
        return sympy.Add(number(constant), *(number(c) * x for c, x in zip(coefficients, arguments)))
    if node.kind is Kind.PRODUCT:
        return sympy.Mul(*(_power(x, number(e)) for x, e in zip(arguments, node.data)))
    if node.kind is Kind.POWER:
        return sympy.Pow(*arguments)
    if node.kind is Kind.SWITCH:
        from lagrange_cli.symbolic.switches import recognized

        u, above, below = arguments
        return recognized(u, above, below, node.data)
    return FUNCTIONS[str(node.data)](*arguments)


def _power(base: sympy.Expr, exponent: sympy.Expr) -> sympy.Expr:
    if not base.has(OfExpressions):
        return sympy.Pow(base, exponent)
    from lagrange_cli.symbolic.switches import to_power

    return to_power(base, exponent)


def number(value: float | Fraction) -> sympy.Expr:
    """The exact rational, or a simple multiple of pi or 1/pi, or the root of a simple fraction."""
    for factor, multiple in ((sympy.pi, float(value) / pi), (1 / sympy.pi, float(value) * pi)):
        parts = round(multiple * TWELFTHS)
        if parts and abs(multiple * TWELFTHS - parts) < 1e-12 * abs(parts):
            return sympy.Rational(parts, TWELFTHS) * factor
    if isinstance(value, float) or value.denominator > LARGEST_DENOMINATOR:
        square = Fraction(float(value) ** 2).limit_denominator(DENOMINATOR)
        if square and abs(float(value) ** 2 - square) < 1e-15 * square:
            root = sympy.sqrt(sympy.Rational(square.numerator, square.denominator))
            return root if value > 0 else -root
    if isinstance(value, float):
        return sympy.Rational(repr(value))
    return sympy.Rational(value.numerator, value.denominator)
