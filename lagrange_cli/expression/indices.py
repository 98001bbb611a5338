"""Whole numbers: what indices, ranges and conditions of indexed families come to."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from operator import add, eq, floordiv, ge, gt, le, lt, mod, mul, ne, sub
from typing import Any

from lagrange_cli.expression.near import known_hint, near_hint
from lagrange_cli.expression.syntax import (
    Axis,
    Binary,
    Call,
    Comparison,
    ExpressionError,
    Logic,
    Lookup,
    Loop,
    Name,
    Negative,
    Number,
    Sum,
    Tree,
    plain_names,
)
from lagrange_cli.expression.vocabulary import member_name

Indices = Mapping[str, int]
"""The values of the indices and sizes at hand."""

LARGEST = 2**53
"""Whole numbers up to here are exact as floats too."""

OPERATIONS: dict[str, Callable[[int, int], int]] = {
    "+": add, "-": sub, "*": mul, "//": floordiv, "%": mod, "**": lambda a, b: power(a, b),
}  # fmt: skip
COMPARISONS: dict[str, Callable[[int, int], bool]] = {
    "==": eq, "!=": ne, "<": lt, "<=": le, ">": gt, ">=": ge,
}  # fmt: skip
FUNCTIONS: dict[str, Callable[..., int]] = {"abs": abs, "min": min, "max": max}
EXTREMES: dict[str, Callable[[Any, Any], Any]] = {
    "min": lambda a, b: a + (b - a) * (b < a), "max": lambda a, b: a + (b - a) * (b > a),
}  # fmt: skip
"""Of two, which may be arrays."""
_MADE_OF = "use whole numbers, sizes and indices with + - * // % ** and abs, min, max"


def power(base: int, exponent: int) -> int:
    """``base**exponent``, or a number of that sign that is too large, too. Raises ``ValueError`` for a
    negative exponent."""
    if exponent < 0:
        raise ValueError
    found: int = base ** min(exponent, 54 + exponent % 2)
    return found


class Unsuited(Exception):
    """The question has no common answer for all members of a family. Where that is known, its arguments are
    what the members are written out for, and a way to do without."""


def integer(tree: Tree, indices: Indices) -> int:
    """The whole number that ``tree`` is.

    Raises:
        ExpressionError: where it is none.
    """
    spine: list[Binary] = []
    while isinstance(tree, Binary):
        spine.append(tree)
        tree = tree.left
    value = _operand(tree, indices)
    for binary in reversed(spine):
        value = _bounded(binary, _combined(binary, value, integer(binary.right, indices), indices))
    return value


def holds(condition: Tree, indices: Indices) -> bool:
    """Whether a condition holds; a whole number does unless it is 0."""
    if isinstance(condition, Logic):
        if condition.operator == "not":
            return not holds(condition.operands[0], indices)
        test = all if condition.operator == "and" else any
        return test(holds(operand, indices) for operand in condition.operands)
    if isinstance(condition, Comparison):
        values = [integer(operand, indices) for operand in condition.operands]
        return all(
            COMPARISONS[operator](left, right)
            for operator, left, right in zip(condition.operators, values, values[1:])
        )
    return integer(condition, indices) != 0


def counted(loop: Sum | Axis | Loop, indices: Indices) -> range:
    """The values that the index of a sum, of a key or of a loop runs through."""
    bounds = [integer(bound, indices) for bound in loop.bounds]
    if len(bounds) == 3 and bounds[2] == 0:
        raise ExpressionError(
            loop.bounds[2].span, "the step of a range must not be 0", "leave it out, or write 1"
        )
    return range(*bounds)


def known_indices(tree: Tree, indices: Indices) -> str:
    """``, for i = 2``: what the whole numbers in ``tree`` are at the moment, for a message; or nothing."""
    shown = [f"{name} = {value}" for name, value in indices.items() if name in plain_names(tree)]
    return f", for {', '.join(shown)}" if shown else ""


def _operand(tree: Tree, indices: Indices) -> int:
    if isinstance(tree, Number):
        if not tree.text.replace("_", "").isdecimal():
            value = float(tree.text)
            hint = f"write {value:.0f}" if value.is_integer() and value <= LARGEST else _MADE_OF
            raise ExpressionError(tree.span, f"{tree.text} is not a whole number", hint)
        if len(tree.text) > 16:
            raise ExpressionError(tree.span, "whole number too large", f"the largest is {LARGEST}")
        return _bounded(tree, int(tree.text))
    if isinstance(tree, Name):
        if not tree.indices and tree.identifier in indices:
            return indices[tree.identifier]
        known = sorted(indices)
        hint = near_hint(tree.identifier, known)
        if not hint and known and len(tree.identifier) == 1:
            ranges = f"{tree.identifier} in range(N)"
            hint = f"{known_hint(known)}; sum(... for {ranges}), or a key such as u[{ranges}], makes it one"
        hint = hint or known_hint(known) or _MADE_OF
        if tree.indices:
            hint = "lists of whole numbers are parameters; write where(condition, a, b) for other conditions"
        raise ExpressionError(tree.span, f"'{tree.identifier}' is neither an index nor a size here", hint)
    if isinstance(tree, Lookup):
        return _looked_up(tree, indices)
    if isinstance(tree, Negative):
        return -integer(tree.operand, indices)
    if isinstance(tree, Call) and tree.function in FUNCTIONS:
        return FUNCTIONS[tree.function](*(integer(one, indices) for one in tree.arguments))
    if isinstance(tree, Comparison | Logic):
        raise ExpressionError(tree.span, "expected a whole number, found a condition", "write it after 'if'")
    raise ExpressionError(tree.span, "expected a whole number", _MADE_OF)


def _looked_up(tree: Lookup, indices: Indices) -> int:
    place = [integer(index, indices) for index in tree.indices]
    found = tree.table.number(place)
    if found is None:
        message = f"there is no {member_name(tree.table.name, place)}{known_indices(tree, indices)}"
        raise ExpressionError(tree.span, message, f"members are {tree.table.extent}")
    return found


def _combined(tree: Binary, left: int, right: int, indices: Indices) -> int:
    operation = OPERATIONS.get(tree.operator)
    if operation is None:
        hint = "write // for the quotient without remainder" if tree.operator == "/" else _MADE_OF
        raise ExpressionError(tree.span, f"'{tree.operator}' is not allowed between whole numbers", hint)
    try:
        return operation(left, right)
    except ZeroDivisionError as error:
        raise ExpressionError(
            tree.span, f"division by zero{known_indices(tree, indices)}", "the divisor must not be 0"
        ) from error
    except ValueError as error:
        raise ExpressionError(
            tree.span, f"negative exponent{known_indices(tree, indices)}", "the power is no whole number"
        ) from error


def _bounded(tree: Tree, value: int) -> int:
    if abs(value) > LARGEST:
        raise ExpressionError(tree.span, "whole number too large", f"the largest is {LARGEST}")
    return value
