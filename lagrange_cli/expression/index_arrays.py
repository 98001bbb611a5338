"""Whole numbers of many members at once: what indices, sizes and conditions are for all terms of a sum.

As ``indices``, over arrays of numpy. A mistake in any member raises ``Unsuited``: the caller
then goes through the members one by one, and reports each mistake.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from functools import reduce
from math import prod
from typing import TYPE_CHECKING, TypeAlias, TypeVar

import numpy as np

from lagrange_cli.expression.indices import COMPARISONS, EXTREMES, FUNCTIONS, LARGEST, OPERATIONS, Unsuited
from lagrange_cli.expression.syntax import (
    Binary,
    Call,
    Comparison,
    Logic,
    Lookup,
    Name,
    Negative,
    Number,
    Tree,
)
from lagrange_cli.limits import whole

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from lagrange_cli.expression.number_table import NumberTable

T = TypeVar("T")
S = TypeVar("S", bound=np.generic)
Places: TypeAlias = "NDArray[np.int64]"
Mask: TypeAlias = "NDArray[np.bool_]"
Whole: TypeAlias = "int | Places"
Indices: TypeAlias = "Mapping[str, Whole]"

MOST = whole("pairs")
"""Terms of all sums that are not written out."""
FARTHEST = 2**62
"""Places of a family that have numbers: those of wider ones do not fit."""


class TooMany(Unsuited):
    """Raised where sums have more terms than may be computed together."""


class Differ(Exception):
    """Members differ in kind: those with equal ``labels`` (members,) may be alike."""

    def __init__(self, labels: Places) -> None:
        super().__init__()
        self.labels = labels


def distinct(values: NDArray[S]) -> NDArray[S]:
    """The different ones of some values, in ascending order. (``np.unique`` loads masked arrays, which takes
    10 ms.)"""
    found = np.sort(values, axis=None)
    first = np.ones(len(found), dtype=bool)
    first[1:] = found[1:] != found[:-1]
    return found[first]


def integers(tree: Tree, indices: Indices) -> Whole:
    """The whole number that ``tree`` is, or those of all members."""
    if isinstance(tree, Number) and tree.text.isdecimal() and len(tree.text) < 16:
        return int(tree.text)
    if isinstance(tree, Name) and not tree.indices and tree.identifier in indices:
        return indices[tree.identifier]
    if isinstance(tree, Lookup):
        return looked_up(tree.table, [integers(one, indices) for one in tree.indices])
    if isinstance(tree, Negative):
        return -integers(tree.operand, indices)
    if isinstance(tree, Binary) and tree.operator in OPERATIONS:
        left, right = integers(tree.left, indices), integers(tree.right, indices)
        if tree.operator in ("//", "%") and np.any(np.equal(right, 0)):
            raise Unsuited
        if tree.operator == "*":
            return multiplied(left, right)
        if tree.operator == "**":
            return raised(left, right)
        return modest(OPERATIONS[tree.operator](left, right))  # type: ignore[arg-type]
    if isinstance(tree, Call) and tree.function in FUNCTIONS:
        values = [integers(one, indices) for one in tree.arguments]
        if all(isinstance(one, int) for one in values):
            return FUNCTIONS[tree.function](*values)
        return np.abs(values[0]) if tree.function == "abs" else reduce(EXTREMES[tree.function], values)
    raise Unsuited


def looked_up(table: NumberTable, places: Sequence[Whole]) -> Whole:
    """The numbers at some places of a table. Raises ``Unsuited`` where some are missing."""
    if len(places) != len(table.shape):
        raise Unsuited
    for place, size in zip(places, table.shape):
        if np.size(place) and (np.min(place) < 0 or np.max(place) >= size):
            raise Unsuited
    if not np.all(table.given[tuple(places)]):
        raise Unsuited
    found = table.numbers[tuple(places)]
    return int(found) if np.ndim(found) == 0 else found


def modest(value: Whole) -> Whole:
    """The same numbers. Raises ``Unsuited`` where some are too large."""
    if np.any(np.abs(value) > LARGEST):
        raise Unsuited
    return value


def multiplied(left: Whole, right: Whole) -> Whole:
    """The product. Raises ``Unsuited`` where it is too large."""
    if np.any(np.abs(np.multiply(left, right, dtype=np.float64)) > LARGEST):
        raise Unsuited
    return left * right


def raised(base: Whole, exponent: Whole) -> Whole:
    """The power. Raises ``Unsuited`` where it is no whole number, or too large."""
    if np.any(np.less(exponent, 0)):
        raise Unsuited
    with np.errstate(over="ignore"):
        if np.any(np.power(np.abs(base), exponent, dtype=np.float64) > LARGEST):
            raise Unsuited
    return base**exponent


def holding(condition: Tree, indices: Indices) -> bool | Mask:
    """Whether a condition holds, or for which members."""
    if isinstance(condition, Logic):
        return joined(condition.operator, [holding(one, indices) for one in condition.operands])
    if isinstance(condition, Comparison):
        return compared(condition.operators, [integers(one, indices) for one in condition.operands])
    return np.not_equal(integers(condition, indices), 0)


def joined(operator: str, parts: Sequence[bool | Mask]) -> bool | Mask:
    """Conditions joined by ``not``, ``and`` or ``or``."""
    if operator == "not":
        return np.logical_not(parts[0])
    return reduce(np.logical_and if operator == "and" else np.logical_or, parts)


def compared(operators: Sequence[str], values: Sequence[Whole]) -> bool | Mask:
    """Whether each number compares to the next one as the operators say."""
    pairs = zip(operators, values, values[1:])
    return reduce(np.logical_and, (COMPARISONS[one](a, b) for one, a, b in pairs), True)  # type: ignore[arg-type]


def limited(terms: int) -> int:
    """So many terms, if they are not too many."""
    if terms > MOST:
        raise TooMany
    return terms


def taken(indices: Indices, members: Places) -> dict[str, Whole]:
    """The indices of some members."""
    return {name: one if isinstance(one, int) else one[members] for name, one in indices.items()}


def flat(places: Sequence[Whole], shape: Sequence[int], count: int) -> Places:
    """Places in a family of this ``shape``, the last index fastest."""
    if len(places) != len(shape) or prod(shape) >= FARTHEST:
        raise Unsuited
    made: Whole = 0
    for i, (place, size) in enumerate(zip(places, shape)):
        if np.size(place) and (np.min(place) < 0 or np.max(place) >= size):
            raise Unsuited
        made = made * size + place if i else place
    return np.broadcast_to(np.asarray(made, dtype=np.int64), count)


def one_if_equal(values: Places) -> Whole:
    """One number for all if they are equal."""
    same = len(values) and values[0] == values[-1] and np.all(values == values[0])
    return int(values[0]) if same else values


def of_each_kind(which: Places, make: Callable[[Places], T]) -> Iterator[T]:
    """What ``make`` gives for the members of each kind by themselves: those that ``Differ`` are split.

    Raises ``Unsuited`` where they cannot be.
    """
    pending = [which]
    while pending:
        some = pending.pop()
        try:
            made = make(some)
        except Differ as differ:
            pending += split(some, differ)
        else:
            yield made


def split(which: Places, differ: Differ) -> list[Places]:
    """Members by their labels."""
    labels = np.broadcast_to(differ.labels, len(which))
    found = [which[labels == label] for label in distinct(labels)]
    if len(found) < 2:
        raise Unsuited
    return found
