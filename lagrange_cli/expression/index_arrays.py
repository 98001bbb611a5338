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

from lagrange_cli.expression.indices import (
    COMPARISONS,
    EXTREMES,
    FUNCTIONS,
    LARGEST,
    OPERATIONS,
    Unsuited,
    counted,
)
from lagrange_cli.expression.syntax import (
    Axis,
    Binary,
    Call,
    Comparison,
    ExpressionError,
    Logic,
    Name,
    Negative,
    Number,
    Sum,
    Tree,
)
from lagrange_cli.limits import whole

if TYPE_CHECKING:
    from numpy.typing import NDArray

T = TypeVar("T")
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


def integers(tree: Tree, indices: Indices) -> Whole:
    """The whole number that ``tree`` is, or those of all members."""
    if isinstance(tree, Number) and tree.text.isdecimal() and len(tree.text) < 16:
        return int(tree.text)
    if isinstance(tree, Name) and not tree.indices and tree.identifier in indices:
        return indices[tree.identifier]
    if isinstance(tree, Negative):
        return -integers(tree.operand, indices)
    if isinstance(tree, Binary) and tree.operator in OPERATIONS:
        left, right = integers(tree.left, indices), integers(tree.right, indices)
        if tree.operator in ("//", "%") and np.any(np.equal(right, 0)):
            raise Unsuited
        value: Whole = OPERATIONS[tree.operator](left, right)  # type: ignore[arg-type]
        if np.any(np.abs(value) > LARGEST // 2**20):  # so that a further product does not overflow
            raise Unsuited
        return value
    if isinstance(tree, Call) and tree.function in FUNCTIONS:
        values = [integers(one, indices) for one in tree.arguments]
        if all(isinstance(one, int) for one in values):
            return FUNCTIONS[tree.function](*values)
        return np.abs(values[0]) if tree.function == "abs" else reduce(EXTREMES[tree.function], values)
    raise Unsuited


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


def rounds(loop: Sum, indices: Indices, count: int) -> tuple[Places, Places]:
    """Every round of a sum for each of ``count`` members, member after member: whose it is, and its index."""
    bounds = [integers(bound, indices) for bound in loop.bounds]
    if all(isinstance(bound, int) for bound in bounds):
        try:
            values = counted(loop, {k: v for k, v in indices.items() if isinstance(v, int)})
        except ExpressionError as error:
            raise Unsuited from error
        limited(count * len(values))
        own = np.arange(values.start, values.stop, values.step, dtype=np.int64)
        return np.repeat(np.arange(count), len(own)), np.tile(own, count)
    start, stop, step = (0, bounds[0], 1) if len(bounds) == 1 else (*bounds, 1)[:3]
    if not isinstance(step, int) or step == 0:
        raise Unsuited
    sizes = np.broadcast_to(np.maximum(0, -((start - stop) // step)), count)
    total = limited(int(sizes.sum()))
    members = np.repeat(np.arange(count), sizes)
    before = np.repeat(np.cumsum(sizes) - sizes, sizes)
    return members, np.broadcast_to(start, count)[members] + step * (np.arange(total) - before)


def visited(loop: Sum, indices: Indices, count: int) -> Places:
    """The values that the index of a loop takes for any of ``count`` members, each once, in ascending
    order."""
    bounds = [integers(bound, indices) for bound in loop.bounds]
    if all(isinstance(bound, int) for bound in bounds):
        values = rounds(loop, indices, 1)[1]
        return values if len(values) < 2 or values[0] < values[1] else values[::-1]
    if len(bounds) > 2:
        return np.unique(rounds(loop, indices, count)[1])
    start, stop = (np.broadcast_to(one, count) for one in (0, *bounds)[-2:])
    runs = np.flatnonzero(start < stop)
    if not len(runs):
        return np.zeros(0, dtype=np.int64)
    first = int(start[runs].min())
    begun = np.zeros(limited(int(stop[runs].max()) - first) + 1, dtype=np.int64)
    np.add.at(begun, start[runs] - first, 1)
    np.add.at(begun, stop[runs] - first, -1)
    return first + np.flatnonzero(np.cumsum(begun))


def satisfied(axis: Axis, values: range, known: Indices) -> list[int]:
    """The values of an index that satisfy the conditions of its axis."""
    found = np.arange(values.start, values.stop, values.step, dtype=np.int64)
    for condition in axis.conditions:
        found = found[np.broadcast_to(holding(condition, {**known, axis.index: found}), len(found))]
    return [*map(int, found)]


def limited(terms: int) -> int:
    """So many terms, if they are not too many."""
    if terms > MOST:
        raise TooMany
    return terms


def taken(indices: Indices, members: Places) -> dict[str, Whole]:
    """The indices of some members."""
    return {name: one if isinstance(one, int) else one[members] for name, one in indices.items()}


def inner(loop: Sum, indices: Indices, count: int) -> tuple[dict[str, Whole], Places]:
    """The indices of all terms of a sum, and to which of ``count`` members each term belongs."""
    members, own = rounds(loop, indices, count)
    found = {**taken(indices, members), loop.index: own}
    for condition in loop.conditions:
        chosen = np.flatnonzero(np.broadcast_to(holding(condition, found), len(members)))
        members, found = members[chosen], taken(found, chosen)
    return found, members


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
    return int(values[0]) if len(values) and np.all(values == values[0]) else values


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
    found = [which[labels == label] for label in np.unique(labels)]
    if len(found) < 2:
        raise Unsuited
    return found
