"""Bounds of whole numbers over stretches of indices: interval arithmetic, over arrays of numpy.

An index is known as its least and its greatest value, which may be arrays: one for each stretch.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from functools import reduce
from typing import TYPE_CHECKING, TypeAlias

import numpy as np

from lagrange_cli.expression.index_arrays import Mask, Whole, integers, modest, multiplied, raised
from lagrange_cli.expression.indices import Unsuited
from lagrange_cli.expression.syntax import Binary, Call, Comparison, Logic, Lookup, Name, Negative, Tree

if TYPE_CHECKING:
    from lagrange_cli.expression.number_table import NumberTable

    Bounds: TypeAlias = "tuple[Whole, Whole]"
    Known: TypeAlias = "Mapping[str, Bounds]"
    Answer: TypeAlias = "tuple[bool | Mask, bool | Mask]"
    """Whether a condition may hold for some indices of a stretch, and whether it certainly does for all."""


def bounds_of(tree: Tree, known: Known) -> Bounds:
    """The least and the greatest value of a tree, or wider bounds. Raises ``Unsuited`` where it is no whole
    number, or too large."""
    if isinstance(tree, Name) and not tree.indices and tree.identifier in known:
        return known[tree.identifier]
    if isinstance(tree, Negative):
        low, high = bounds_of(tree.operand, known)
        return -high, -low
    if isinstance(tree, Binary) and tree.operator in _ARITHMETIC:
        low, high = _ARITHMETIC[tree.operator](bounds_of(tree.left, known), bounds_of(tree.right, known))
        return modest(low), modest(high)
    if isinstance(tree, Call) and tree.function in _EXTREMES:
        return reduce(_EXTREMES[tree.function], [bounds_of(one, known) for one in tree.arguments])
    if isinstance(tree, Call) and tree.function == "abs":
        return _absolute(bounds_of(tree.arguments[0], known))
    if isinstance(tree, Lookup):
        return _looked_up(tree.table, [bounds_of(one, known) for one in tree.indices])
    value = integers(tree, {})
    return value, value


def answer(condition: Tree, known: Known) -> Answer:
    """Whether a condition may hold, and whether it certainly does."""
    if isinstance(condition, Logic):
        return _joined(condition.operator, [answer(one, known) for one in condition.operands])
    if isinstance(condition, Comparison):
        values = [bounds_of(one, known) for one in condition.operands]
        pairs = zip(condition.operators, values, values[1:])
        return _joined("and", [_compared(operator, a, b) for operator, a, b in pairs])
    return _compared("!=", bounds_of(condition, known), (0, 0))


def bounds_of_loop(written: Sequence[Tree], known: Known) -> tuple[Bounds, bool | Mask]:
    """The least and the greatest value of a loop's index, or wider bounds, and whether there may be any: its
    range is ``written`` so."""
    found = [bounds_of(one, known) for one in written]
    if len(found) < 3:
        start, stop = ((0, 0), *found)[-2:]
        return (start[0], stop[1] - 1), np.less(start[0], stop[1])
    start, stop, step = found
    upwards, downwards = (start[0], stop[1] - 1), (stop[0] + 1, start[1])
    if np.all(np.greater(step[0], 0)):
        return upwards, np.less(start[0], stop[1])
    if np.all(np.less(step[1], 0)):
        return downwards, np.greater(start[1], stop[0])
    return (np.minimum(upwards[0], downwards[0]), np.maximum(upwards[1], downwards[1])), True


def _joined(operator: str, parts: list[Answer]) -> Answer:
    if operator == "not":
        may, must = parts[0]
        return np.logical_not(must), np.logical_not(may)
    join = np.logical_and if operator == "and" else np.logical_or
    return reduce(join, [may for may, _ in parts]), reduce(join, [must for _, must in parts])


def _compared(operator: str, left: Bounds, right: Bounds) -> Answer:
    (a, b), (c, d) = left, right
    if operator in (">", ">="):
        return _compared("<" if operator == ">" else "<=", right, left)
    if operator == "<":
        return np.less(a, d), np.less(b, c)
    if operator == "<=":
        return np.less_equal(a, d), np.less_equal(b, c)
    meet = np.logical_and(np.less_equal(a, d), np.less_equal(c, b))
    equal = np.logical_and(np.equal(a, d), np.equal(c, b))
    equal = np.logical_and(equal, np.equal(a, b))
    return (meet, equal) if operator == "==" else (np.logical_not(equal), np.logical_not(meet))


def _corners(operation: Callable[[Whole, Whole], Whole], left: Bounds, right: Bounds) -> Bounds:
    """Bounds of what is least and greatest at the ends of both."""
    ends = [operation(a, b) for a in left for b in right]
    return reduce(np.minimum, ends), reduce(np.maximum, ends)


def _added(left: Bounds, right: Bounds) -> Bounds:
    return left[0] + right[0], left[1] + right[1]


def _subtracted(left: Bounds, right: Bounds) -> Bounds:
    return left[0] - right[1], left[1] - right[0]


def _multiplied(left: Bounds, right: Bounds) -> Bounds:
    return _corners(multiplied, left, right)


def _raised(left: Bounds, right: Bounds) -> Bounds:
    """Of the power; wider ones where bases may be negative."""
    if np.any(np.less(left[0], 0)):
        most = raised(np.maximum(1, np.maximum(np.abs(left[0]), np.abs(left[1]))), right[1])
        return -most, most
    return _corners(raised, left, right)


def _divided(left: Bounds, right: Bounds) -> Bounds:
    """Of the quotient without remainder; all that it may be where divisors have both signs."""
    if np.any(np.less_equal(right[0], 0) & np.greater_equal(right[1], 0)):
        most = np.maximum(np.abs(left[0]), np.abs(left[1]))
        return -most, most
    return _corners(lambda a, b: a // b, left, right)


def _remainder(left: Bounds, right: Bounds) -> Bounds:
    """Of the remainder, whose sign is that of the divisor: exact between two multiples of a divisor."""
    low, high = np.minimum(0, np.add(right[0], 1)), np.maximum(0, np.subtract(right[1], 1))
    if np.any(np.not_equal(*right) | np.equal(right[0], 0)):
        return low, high
    between = np.equal(left[0] // right[0], left[1] // right[0])
    return np.where(between, left[0] % right[0], low), np.where(between, left[1] % right[0], high)


def _looked_up(table: NumberTable, places: Sequence[Bounds]) -> Bounds:
    """Exact where there is one place in a stretch, else those of the whole table."""
    for (low, high), size in zip(places, table.shape):
        if np.any(np.less(low, 0)) or np.any(np.greater_equal(high, size)):
            raise Unsuited
    numbers = table.numbers[tuple(low for low, _ in places)]
    single = reduce(np.logical_and, [np.equal(low, high) for low, high in places])
    return tuple(np.where(single, numbers, end) for end in (table.numbers.min(), table.numbers.max()))


def _absolute(values: Bounds) -> Bounds:
    low, high = values
    return np.maximum(0, np.maximum(low, -high)), np.maximum(np.abs(low), np.abs(high))


_ARITHMETIC: dict[str, Callable[[Bounds, Bounds], Bounds]] = {
    "+": _added, "-": _subtracted, "*": _multiplied, "//": _divided, "%": _remainder,
    "**": _raised,
}  # fmt: skip
_EXTREMES: dict[str, Callable[..., Bounds]] = {
    "min": lambda a, b: (np.minimum(a[0], b[0]), np.minimum(a[1], b[1])),
    "max": lambda a, b: (np.maximum(a[0], b[0]), np.maximum(a[1], b[1])),
}
