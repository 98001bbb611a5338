"""Expressions that stay 0, and equations written in their place."""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence

from lagrange_cli.expression.parse import read
from lagrange_cli.expression.syntax import Binary, Comparison, Span
from lagrange_cli.spec.fields import read_scalar, read_vector
from lagrange_cli.spec.nodes import Node, Scalar
from lagrange_cli.spec.problems import Problems
from lagrange_cli.spec.spec import Expression

EQUALS = re.compile(r"(?<![=<>!])==?(?!=)")
LONGEST = 60
"""Characters of an expression that a hint repeats."""
WALL = "a wall is a potential such as k*max(0, x - l)**2/2, or an event that sets velocities"


def read_vanishing(node: Node, where: str, problems: Problems) -> Expression | None:
    """A scalar or a vector that stays 0. An equation is a mistake, but shows which one was meant."""
    sides = EQUALS.split(node.text) if isinstance(node, Scalar) else []
    if not isinstance(node, Scalar):
        return read_vector(node, where, problems)
    if not all(map(is_side, sides)):
        return read_scalar(node, where, problems)
    kind, hint = "equation", "write one constraint for each equation"
    parts = [read(side, start) for side, start in zip(sides, starts(sides, node.text))]
    tree = parts[0][0]
    if len(sides) == 1:
        if not isinstance(tree, Comparison):
            return read_scalar(node, where, problems)
        kind, hint, tree, parts = "inequality", WALL, tree.operands[0], []
    elif len(sides) == 2:
        hint = f"write {difference(*(side.strip() for side in sides))}"
    for further, _ in parts[1:]:  # names are looked up on all sides
        tree = Binary("-", tree, further, Span(0, len(node.text)))
    problems.add(node.place, f"{where} is an expression that stays 0, not an {kind}", hint)
    expression = Expression(node.text, tree, node.place, ((0, node.passage),))
    problems.distrust(tree)
    for _, errors in parts:
        for error in errors:
            problems.add_expression(expression, error, where)
    return expression


def is_side(text: str) -> bool:
    """Whether it may be one side of an equation, and not of a condition within parentheses."""
    return bool(text.strip()) and all(text.count(a) == text.count(b) for a, b in ("()", "[]"))


def starts(sides: Sequence[str], text: str) -> Iterator[int]:
    """Where each side of an equation begins in its text."""
    start = 0
    for side in sides:
        start = text.index(side, start)
        yield start
        start += len(side)


def difference(left: str, right: str) -> str:
    """``left - right`` as it is written; one side alone where the other is 0."""
    if is_zero(left) and not is_zero(right):
        return difference(right, left)
    if right and not is_zero(right):
        tree = read(right)[0]
        is_sum = isinstance(tree, Binary) and tree.operator in "+-"
        left = f"{left} - ({right})" if is_sum or right[0] in "+-" else f"{left} - {right}"
    return left.replace("^", "**") if len(left) <= LONGEST else "the difference of both sides"


def is_zero(text: str) -> bool:
    """Whether it is the number 0."""
    return bool(re.fullmatch(r"[-+]?0+(\.0*)?", text))
