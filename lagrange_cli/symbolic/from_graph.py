"""Expressions of the graph as expressions of sympy."""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction
from math import pi

import sympy

from lagrange_cli.expression.node import Kind, Node, reachable
from lagrange_cli.expression.symbolic import FUNCTIONS, SympyAlgebra

LARGEST = 2000
"""Nodes of the largest expression that is written out."""
TWELFTHS = 12
"""Parts of pi, or of its reciprocal, that are recognized."""


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
        return sympy.Mul(*(sympy.Pow(x, number(e)) for x, e in zip(arguments, node.data)))
    if node.kind is Kind.POWER:
        return sympy.Pow(*arguments)
    if node.kind is Kind.SWITCH:
        u, above, below = arguments
        return SympyAlgebra().switch(u, above, below, node.data)
    return FUNCTIONS[str(node.data)](*arguments)


def number(value: float | Fraction) -> sympy.Expr:
    """The exact rational, or a simple multiple of pi or 1/pi."""
    for factor, multiple in ((sympy.pi, float(value) / pi), (1 / sympy.pi, float(value) * pi)):
        parts = round(multiple * TWELFTHS)
        if parts and abs(multiple * TWELFTHS - parts) < 1e-12 * abs(parts):
            return sympy.Rational(parts, TWELFTHS) * factor
    if isinstance(value, float):
        return sympy.Rational(repr(value))
    fraction = Fraction(value)
    return sympy.Rational(fraction.numerator, fraction.denominator)
