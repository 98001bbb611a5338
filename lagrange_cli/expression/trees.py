"""Nodes of the graph as trees, as if they had been written in a file."""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction

from lagrange_cli.decimals import as_decimal, exact
from lagrange_cli.expression.node import Kind, Node, reachable
from lagrange_cli.expression.syntax import Binary, Call, Comparison, Name, Negative, Number, Span, Tree

NOWHERE = Span(0, 0)
DIGITS = 70
"""Those of fractions that are no finite decimals."""


def tree_of(node: Node) -> Tree:
    """The tree of an expression; it must contain no total time derivative."""
    made: dict[Node, Tree] = {}
    for one in reachable([node]):
        made[one] = _tree(one, [made[each] for each in one.arguments])
    return made[node]


def _tree(node: Node, arguments: Sequence[Tree]) -> Tree:
    if node.kind is Kind.NUMBER:
        return number(node.data)
    if node.kind is Kind.SYMBOL:
        return named(node.data)
    if node.kind is Kind.SUM:
        constant, coefficients = node.data
        terms = [scaled(c, one) for c, one in zip(coefficients, arguments)]
        return joined("+", [*terms, *([number(constant)] if constant else [])])
    if node.kind is Kind.PRODUCT:
        return joined("*", [raised(one, exponent) for one, exponent in zip(arguments, node.data)])
    if node.kind is Kind.POWER:
        return joined("**", arguments)
    if node.kind is Kind.SWITCH:
        return chosen(node.data, *arguments)
    assert node.kind is Kind.FUNCTION, node.kind
    return Call(node.data, tuple(arguments), NOWHERE)


def number(value: float | Fraction) -> Tree:
    """A number, which may be negative; a fraction with so many digits as are needed, or ``DIGITS``."""
    if isinstance(value, Fraction):
        size = Number(as_decimal(abs(value), DIGITS), NOWHERE)
    else:
        size = Number(exact(abs(value)).removesuffix(".0"), NOWHERE)
    return Negative(size, NOWHERE) if value < 0 else size


def named(name: str) -> Tree:
    """A name: ``x_dot[2,3]`` is a member of a family."""
    base, _, indices = name.rstrip("]").partition("[")
    return Name(base, NOWHERE, tuple(Number(one, NOWHERE) for one in indices.split(",") if one))


def scaled(coefficient: float, tree: Tree) -> Tree:
    """A number of times a tree."""
    return tree if coefficient == 1 else Binary("*", number(coefficient), tree, NOWHERE)


def raised(base: Tree, exponent: float) -> Tree:
    """A power with a number as its exponent."""
    return base if exponent == 1 else Binary("**", base, number(exponent), NOWHERE)


def joined(operator: str, operands: Sequence[Tree]) -> Tree:
    """Operands with an operator between them. Of many ones both halves are joined first, so that a tree is
    not as deep as it has terms."""
    half = len(operands) // 2
    if not half:
        return operands[0]
    return Binary(operator, joined(operator, operands[:half]), joined(operator, operands[half:]), NOWHERE)


def chosen(at: int, u: Tree, above: Tree, below: Tree) -> Tree:
    """One of two sides by the sign of u; where u is 0, that on the side ``at``, or their mean."""
    if at == 0:
        both = [chosen(side, u, above, below) for side in (1, -1)]
        return Binary("/", joined("+", both), Number("2", NOWHERE), NOWHERE)
    condition = Comparison((">=" if at > 0 else ">",), (u, Number("0", NOWHERE)), NOWHERE)
    return Call("where", (condition, above, below), NOWHERE)
