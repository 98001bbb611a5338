"""Expressions of the graph as expressions of sympy."""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction

import sympy

from lagrange_cli.expression.node import Kind, Node, reachable
from lagrange_cli.expression.symbolic import FUNCTIONS
from lagrange_cli.expression.symbolic_switches import OfExpressions

PLAIN = 1000
"""Fractions with lesser denominators are written as they are."""
LARGEST = 2000
"""Nodes of the largest expression that is written out."""


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
    """As people write it: an exact fraction or the root of one, or one of these times pi or 1/pi."""
    if not isinstance(value, float) and value.denominator < PLAIN:
        return sympy.Rational(value.numerator, value.denominator)
    from lagrange_cli.expression.written import as_written

    found, root, turns = as_written(abs(value))
    size = sympy.Rational(found.numerator, found.denominator)
    whole = (sympy.sqrt(size) if root else size) * sympy.pi**turns
    return whole if value >= 0 else -whole
