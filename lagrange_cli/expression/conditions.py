"""Conditions of ``where``: comparisons of numbers, joined by ``and``, ``or``, ``not``.

A comparison is the sign of a difference, and what is joined is one choice inside another. Where all that is
compared are whole numbers, indices and sizes, conditions are those of sums.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from lagrange_cli.expression.algebra import Algebra, Value
from lagrange_cli.expression.indices import Indices, holds
from lagrange_cli.expression.syntax import Comparison, ExpressionError, Logic, Name, Tree, is_whole
from lagrange_cli.records import dataclass


@dataclass(frozen=True)
class Positive:
    """Whether u > 0 (``at`` is -1) or u >= 0 (1)."""

    u: Any
    at: int

    def select(self, algebra: Algebra[Any], yes: Any, no: Any) -> Any:
        """``yes`` where it holds, ``no`` elsewhere."""
        return algebra.switch(self.u, yes, no, self.at)


@dataclass(frozen=True)
class Joined:
    """A condition that holds where all of its ``parts`` do, or any of them; if ``turned``, its opposite."""

    parts: tuple[Condition, ...]
    every: bool
    turned: bool = False

    def select(self, algebra: Algebra[Any], yes: Any, no: Any) -> Any:
        """``yes`` where it holds, ``no`` elsewhere."""
        if self.turned:
            yes, no = no, yes
        made = yes if self.every else no
        for part in reversed(self.parts):
            made = part.select(algebra, made, no) if self.every else part.select(algebra, yes, made)
        return made


Condition = Positive | Joined


def met(
    condition: Tree,
    indices: Indices,
    value: Callable[[Tree], Value],
    algebra: Algebra[Any],
    decided: Callable[[Tree, Indices], bool] = holds,
) -> bool | Condition:
    """Whether a condition holds, where that is known; ``value`` gives those of what is compared, and
    ``decided`` whether whole numbers do as they should."""
    if isinstance(condition, Logic):
        if condition.operator == "not":
            inner = met(condition.operands[0], indices, value, algebra, decided)
            return not inner if isinstance(inner, bool) else Joined((inner,), True, True)
        every, open_ones = condition.operator == "and", []
        for operand in condition.operands:
            inner = met(operand, indices, value, algebra, decided)
            if isinstance(inner, bool):
                if inner is not every:
                    return inner
            else:
                open_ones.append(inner)
        return Joined(tuple(open_ones), every) if open_ones else every
    if not isinstance(condition, Comparison):
        raise ExpressionError(
            condition.span, "expected a condition, found a value", "compare it with another, as in x > 0"
        )
    if all(is_whole(operand, lambda name: is_index(name, indices)) for operand in condition.operands):
        return decided(condition, indices)
    values = [scalar(operand, value(operand)) for operand in condition.operands]
    found: list[Condition] = []
    for operator, left, right in zip(condition.operators, values, values[1:]):
        if operator in ("==", "!="):
            u = left - right
            side = algebra.side(u, 0)
            if side is None:
                found.append(Joined((Positive(u, 1), Positive(-u, 1)), True, operator == "!="))
            elif (side == 0) != (operator == "=="):
                return False
            continue
        at = 1 if operator in ("<=", ">=") else -1
        u = left - right if operator in (">", ">=") else right - left
        side = algebra.side(u, at)
        if side == -1:
            return False
        if side is None:
            found.append(Positive(u, at))
    if not found:
        return True
    return found[0] if len(found) == 1 else Joined(tuple(found), True)


def is_index(name: Name, indices: Indices) -> bool:
    """Whether it is an index or a size."""
    return not name.indices and name.identifier in indices


def scalar(tree: Tree, value: Value) -> Any:
    """What is compared, if it is no vector."""
    if isinstance(value, tuple):
        raise ExpressionError(tree.span, "vectors cannot be compared", "take components, or their norm()")
    return value
