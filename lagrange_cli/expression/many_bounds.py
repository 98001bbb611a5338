"""Bounds of the terms of a long sum, all at once: what ``bounds`` finds term by term.

Numbers that depend on indices are known for all terms. A possible mistake in any of them raises
``Unsuited``: the terms are then checked one by one, and the mistake is reported at its place.
"""

from __future__ import annotations

import math
import operator
from collections.abc import Callable, Iterator, Mapping, Sequence
from functools import reduce
from typing import TYPE_CHECKING, Any

import numpy as np

from lagrange_cli.expression.algebra import Value
from lagrange_cli.expression.array_builder import ArrayBuilder, Members
from lagrange_cli.expression.bounds import MAX_EXPONENT, Bounds, BoundsAlgebra
from lagrange_cli.expression.index_arrays import (
    MOST,
    Differ,
    Indices,
    Places,
    TooMany,
    Whole,
    of_each_kind,
    taken,
)
from lagrange_cli.expression.indices import Unsuited
from lagrange_cli.expression.syntax import ExpressionError, Sum, Tree
from lagrange_cli.limits import way_out, whole

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Numbers = NDArray[np.float64]

FUNCTIONS: dict[str, Callable[..., Any]] = {
    "sin": np.sin, "cos": np.cos, "tan": np.tan, "asin": np.arcsin, "acos": np.arccos, "atan": np.arctan,
    "sinh": np.sinh, "cosh": np.cosh, "tanh": np.tanh, "exp": np.exp, "log": np.log, "sqrt": np.sqrt,
    "abs": np.abs, "sign": np.sign, "atan2": np.arctan2,
    "min": lambda *values: reduce(np.minimum, values), "max": lambda *values: reduce(np.maximum, values),
}  # fmt: skip


class Many(Bounds):
    """A number of each term: ``numbers`` (terms,). To others it is unknown."""

    __slots__ = ("numbers",)

    def __init__(self, numbers: Numbers, like: Bounds | None = None) -> None:
        like = like or Bounds()
        super().__init__(None, like.size, like.depth, like.kind)
        if not np.all(np.isfinite(numbers)):
            raise Unsuited
        self.numbers = numbers

    def _with(self, word: str, left: Bounds, right: Bounds) -> Bounds:
        operation: Callable[[Any, Any], Any] = getattr(operator, word)
        made: Bounds = operation(*(Bounds(one.value, one.size, one.depth, one.kind) for one in (left, right)))
        numbers = [numbers_of(one) for one in (left, right)]
        if numbers[0] is None or numbers[1] is None:
            return made
        with np.errstate(all="ignore"):
            return Many(operation(*numbers), made)

    def __add__(self, other: Bounds) -> Bounds:
        return self._with("add", self, other)

    def __radd__(self, other: Bounds) -> Bounds:
        return self._with("add", other, self)

    def __sub__(self, other: Bounds) -> Bounds:
        return self._with("sub", self, other)

    def __rsub__(self, other: Bounds) -> Bounds:
        return self._with("sub", other, self)

    def __mul__(self, other: Bounds) -> Bounds:
        return self._with("mul", self, other)

    def __rmul__(self, other: Bounds) -> Bounds:
        return self._with("mul", other, self)

    def __truediv__(self, other: Bounds) -> Bounds:
        if isinstance(other, Many):
            return other.__rtruediv__(self)
        return self._with("truediv", self, other)

    def __rtruediv__(self, other: Bounds) -> Bounds:
        if np.any(self.numbers == 0):
            raise Unsuited
        return self._with("truediv", other, self)

    def __pow__(self, other: Bounds) -> Bounds:
        if isinstance(other, Many):
            return other.__rpow__(self)
        return self._with("pow", self, other)

    def __rpow__(self, other: Bounds) -> Bounds:
        largest = float(np.max(np.abs(self.numbers)))
        if largest > MAX_EXPONENT and numbers_of(other) is None:
            raise Unsuited
        made = self._with("pow", other, self)
        if isinstance(made, Many):
            if not np.all(np.isfinite(made.numbers)):
                raise Unsuited
            return made
        return Bounds(None, made.size * max(1, math.ceil(largest)), made.depth, made.kind)

    def __neg__(self) -> Bounds:
        return Many(-self.numbers, self)


class Various(Bounds):
    """Bounds of members that differ in kind: ``labels`` say which of the ``kinds`` each has."""

    __slots__ = ("kinds", "labels")

    def __init__(self, labels: Places, kinds: Sequence[Bounds]) -> None:
        deepest = max(kinds, key=lambda one: one.depth)
        super().__init__(None, max(one.size for one in kinds), deepest.depth, deepest.kind)
        self.labels, self.kinds = labels, kinds


def various(found: Sequence[tuple[Value, Places]], count: int) -> Value | None:
    """The bounds of ``count`` members from those of each kind, with their numbers; None where not all have
    as many components."""
    values = [value if isinstance(value, tuple) else (value,) for value, _ in found]
    if len({isinstance(value, tuple) for value, _ in found}) > 1 or len({*map(len, values)}) > 1:
        return None
    labels = np.zeros(count, dtype=np.int64)
    for k, (_, which) in enumerate(found):
        labels[which] = k
    made = tuple(
        joined(labels, [placed(one, which, count) for one, (_, which) in zip(parts, found)])
        for parts in zip(*values)
    )
    return made if isinstance(found[0][0], tuple) else made[0]


def joined(labels: Places, kinds: Sequence[Bounds]) -> Bounds:
    """Bounds of members of several kinds; where no number is known of any, they are those of all."""
    made = Various(labels, kinds)
    known = any(numbers_of(one) is not None or isinstance(one, Various) for one in kinds)
    return made if known else Bounds(None, made.size, made.depth, made.kind)


def placed(one: Bounds, which: Places, count: int) -> Bounds:
    """Bounds of some members, with their numbers at their places among all."""
    if isinstance(one, Various):
        labels = np.zeros(count, dtype=np.int64)
        labels[which] = one.labels
        return Various(labels, [placed(kind, which, count) for kind in one.kinds])
    if not isinstance(one, Many) or not one.numbers.ndim:
        return one
    numbers = np.zeros(count)
    numbers[which] = one.numbers
    return Many(numbers, one)


def chosen(value: Any, which: Places) -> Any:
    """The bounds of some of the members whose bounds are ``value``."""
    if isinstance(value, tuple):
        return tuple(chosen(one, which) for one in value)
    if isinstance(value, Various):
        labels = value.labels[which]
        kinds = [chosen(one, which) for one in value.kinds]
        return kinds[labels[0]] if len(labels) and np.all(labels == labels[0]) else Various(labels, kinds)
    known = isinstance(value, Many) and value.numbers.ndim > 0
    return Many(value.numbers[which], value) if known else value


def numbers_of(one: Bounds) -> Numbers | float | None:
    """What is known of it."""
    return one.numbers if isinstance(one, Many) else one.value


class ManyBoundsAlgebra(BoundsAlgebra):
    """``Algebra[Bounds]`` with numbers of all terms."""

    def switch(self, u: Bounds, above: Bounds, below: Bounds, at: int) -> Bounds:
        if not isinstance(u, Many):
            return super().switch(u, above, below, at)
        sides = np.where(u.numbers == 0, at, np.sign(u.numbers)).astype(np.int64)
        if np.any(sides != sides[:1]):
            raise Differ(sides)
        return above if sides[0] == 1 else below

    def function(self, name: str, arguments: Sequence[Bounds]) -> Bounds:
        known = [numbers_of(one) for one in arguments]
        made = super().function(name, arguments)
        if not any(isinstance(one, Many) for one in arguments):
            return made
        if any(one is None for one in known):
            return made
        if name not in FUNCTIONS:
            raise Unsuited
        with np.errstate(all="ignore"):
            return Many(FUNCTIONS[name](*known), made)


class BoundsBuilder(ArrayBuilder):
    """Builds the terms of sums. ``members`` gives the bounds of a name's members at the places of its
    indices, and raises ``Unsuited`` where there is no such member."""

    def __init__(self, members: Callable[[str, list[Whole], int], Value], sizes: Indices) -> None:
        super().__init__(lambda name: None, ManyBoundsAlgebra(), {})
        self._members, self._sizes = members, sizes

    def bounds(self, tree: Sum, indices: Indices) -> Value | None:
        """The bounds of a sum; None where they cannot be found at once."""
        if self.used > self.most:
            return None
        try:
            return self.summed(tree, Members(None, 1, {**self._sizes, **indices}))
        except TooMany as error:
            if whole("terms") > MOST:  # they may be written out
                return None
            message, hint = f"more than {MOST} terms in all sums together", "make the sizes smaller, "
            raise ExpressionError(tree.span, message, hint + way_out("pairs")) from error
        except (Unsuited, Differ, ExpressionError, ArithmeticError):
            return None

    def of_members(self, tree: Tree, indices: Mapping[str, Whole], count: int) -> Value | None:
        """The bounds of an expression that ``count`` members of a family share; None where they cannot be
        found at once."""

        def alike(which: Places) -> tuple[Value, Places]:
            here = taken(indices, which) if len(which) < count else indices
            return self._value(tree, Members(None, len(which), {**self._sizes, **here})), which

        try:
            found = [*of_each_kind(np.arange(count), alike)]
        except (Unsuited, ExpressionError, ArithmeticError):
            return None
        return found[0][0] if len(found) == 1 else various(found, count)

    def number(self, value: Whole, members: Members) -> Bounds:
        return Bounds(float(value)) if isinstance(value, int) else Many(value.astype(float))

    def named(self, identifier: str, places: list[Whole], members: Members) -> Value:
        return self._members(identifier, places, members.count)

    def summed(self, tree: Sum, members: Members) -> Value:
        total: Value = None
        for value in self.different(tree, members):
            found: Value = tuple(map(of_sum, value)) if isinstance(value, tuple) else of_sum(value)
            if total is None:
                total = found
            elif isinstance(total, tuple) != isinstance(found, tuple):
                raise Unsuited
            elif isinstance(total, tuple):
                total = tuple(map(operator.add, total, found))
            else:
                total = total + found
        if total is None:
            raise Unsuited
        return total

    def different(self, tree: Sum, members: Members) -> Iterator[Value]:
        """The bounds of the terms of a sum, of each kind. Terms that members have in common are looked at
        once."""
        shared = self.shared(tree, members)
        if shared is None:
            yield from (value for _, value, _ in self.terms(tree, members))
        else:
            yield from (value for _, value, _ in self.each(tree.body, shared[0], len(shared[1])))


def of_sum(term: Bounds) -> Bounds:
    """The bounds of a sum of such terms, which are written once."""
    if numbers_of(term) is not None:
        raise Unsuited
    return Bounds(None, term.size + 1, term.depth + (term.kind != "sum"), "sum")
