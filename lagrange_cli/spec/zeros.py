"""Which expressions are 0, or constant, in every state because of how positions and orientations are written.

Parameters are numbers of a run, and count as any number.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from functools import cached_property, reduce
from math import pi
from typing import Any, TypeAlias

from lagrange_cli.expression.numbers import evaluate
from lagrange_cli.expression.syntax import (
    Binary,
    ExpressionError,
    Name,
    Negative,
    Number,
    Sum,
    Tree,
    children,
    names,
)
from lagrange_cli.expression.vocabulary import (
    AXES_COMPONENTS,
    AXES_RATES,
    BODY_SPIN,
    COMPONENTS,
    SPACE_SPIN,
    VELOCITY_COMPONENTS,
)
from lagrange_cli.spec.body import Orientation
from lagrange_cli.spec.content import groups_of, statements
from lagrange_cli.spec.draft import Draft, WrittenBody
from lagrange_cli.spec.kinds import Kind
from lagrange_cli.spec.names import Names

ZERO, CONSTANT, VARYING = range(3)
"""What is known of a value: it is 0 in every state, the same in every state, or neither."""
Pattern: TypeAlias = "tuple[tuple[int, ...], ...]"
"""Three rows of three: what is known of the entries of a matrix."""


class Zeros:
    """The positions, orientations and definitions of a file; ``spread`` gives the components of a vector."""

    def __init__(self, draft: Draft, known: Names, spread: Callable[[Tree], Tree | tuple[Tree, ...]]) -> None:
        self._draft, self._names, self._spread = draft, known, spread
        self._supposed: dict[tuple[str, int], int] = {}
        """What is supposed of components that are being looked at: members may follow from one another."""

    def is_zero(self, tree: Tree) -> bool:
        """Whether a scalar is 0 in every state; no is the answer where that takes more than a look."""
        return self.level(tree) == ZERO

    def level(self, tree: Tree) -> int:
        """What is known of a scalar."""
        if isinstance(tree, Number):
            return CONSTANT if float(tree.text) else ZERO
        if isinstance(tree, Negative):
            return self.level(tree.operand)
        if isinstance(tree, Sum):
            return self.level(tree.body)
        if isinstance(tree, Name):
            return self._of_name(tree)
        parts = [self.level(one) for one in children(tree)]
        if isinstance(tree, Binary) and tree.operator in ("+", "-"):
            return max(parts)
        if isinstance(tree, Binary) and tree.operator in ("*", "/"):
            return both(parts[0], parts[1] if tree.operator == "*" else max(CONSTANT, parts[1]))
        return max(CONSTANT, *parts)

    def _of_name(self, name: Name) -> int:
        """The same of a name: in a family, of all members."""
        base, _, component = name.identifier.partition(".")
        if component in COMPONENTS:
            return self._of_place(base, COMPONENTS.index(component))
        if component in VELOCITY_COMPONENTS:
            return rate(self._of_place(base, VELOCITY_COMPONENTS.index(component)))
        if component in AXES_COMPONENTS:
            return self._of_axes(base, *divmod(AXES_COMPONENTS.index(component), 3))
        if component in AXES_RATES:
            return rate(self._of_axes(base, *divmod(AXES_RATES.index(component), 3)))
        if component in SPACE_SPIN + BODY_SPIN:
            axis = (SPACE_SPIN + BODY_SPIN).index(component) % 3
            return ZERO if all(keeps(pattern, axis) for pattern in self._turned(base)) else VARYING
        meaning = self._names.table.get(base)
        if component or meaning is None or meaning.what in (Kind.PARAMETER, Kind.SIZE):
            return VARYING if component else CONSTANT
        return self._of_place(base, 0) if meaning.what is Kind.DEFINITION else VARYING

    def _of_place(self, base: str, k: int) -> int:
        """What is known of a component of a position, or of a definition: the least that agrees with itself
        where it follows from other members."""
        given, key = self._written.get(base, ()), (base, k)
        if key in self._supposed:
            return self._supposed[key]
        found, supposed = ZERO, None
        while found != supposed:
            supposed = self._supposed[key] = found
            found = max((self.level(self._spread_of(one)[k]) for one in given), default=VARYING)
        del self._supposed[key]
        return found

    def _of_axes(self, base: str, i: int, j: int) -> int:
        """What is known of an entry of R."""
        return max((pattern[i][j] for pattern in self._turned(base)), default=VARYING)

    def _spread_of(self, tree: Tree) -> tuple[Tree, ...]:
        found = self._spread(tree)
        return found if isinstance(found, tuple) else (found,)

    @cached_property
    def _written(self) -> dict[str, list[Tree]]:
        """The positions and definitions of each name, as they are written."""
        found: dict[str, list[Tree]] = {}
        for section in ("definitions", "embedding"):
            for group in groups_of(self._draft.entries(section)):
                given = [one.value.tree for one in statements(group) if one.value is not None]
                found.setdefault(group.name.partition("[")[0], []).extend(given)
        for bodies in groups_of(self._draft.bodies):
            places = [one.position.tree for one in statements(bodies) if one.position is not None]
            found.setdefault(bodies.name.partition("[")[0], []).extend(places)
        return found

    def _turned(self, base: str) -> Iterator[Pattern]:
        """The patterns of R of a body, or of each statement of a family of bodies."""
        for group in groups_of(self._draft.bodies):
            if group.name.partition("[")[0] == base:
                bodies: list[WrittenBody] = statements(group)
                yield from (self.pattern(one.orientation) for one in bodies if one.orientation is not None)

    def pattern(self, how: Orientation) -> Pattern:
        """What is known of the entries of R."""
        trees = [one.tree for one in how.entries]
        levels = [self.level(tree) for tree in trees]
        if how.form == "matrix":
            return tuple(tuple(levels[3 * i : 3 * i + 3]) for i in range(3))
        if how.form == "quaternion":
            return by_quaternion(*levels)
        turns = [
            elementary("xyz".index(axis), tree, level)
            for axis, tree, level in zip(how.sequence, trees, levels)
        ]
        return reduce(product, turns)


def rate(level: int) -> int:
    """What is known of the rate of change."""
    return VARYING if level == VARYING else ZERO


def both(one: int, other: int) -> int:
    """What is known of a product."""
    return ZERO if ZERO in (one, other) else max(one, other)


def by_quaternion(w: int, x: int, y: int, z: int) -> Pattern:
    """The pattern of R of a quaternion of length 1: R_11 = 1 - 2 (y^2 + z^2) = 2 (w^2 + x^2) - 1 etc."""
    xy, xz, yz = max(both(x, y), both(w, z)), max(both(x, z), both(w, y)), max(both(y, z), both(w, x))
    halves = ((w, x), (y, z)), ((w, y), (x, z)), ((w, z), (x, y))
    one, two, three = (max(CONSTANT, min(map(max, half))) for half in halves)
    return (one, xy, xz), (xy, two, yz), (xz, yz, three)


def elementary(axis: int, angle: Tree, level: int) -> Pattern:
    """The pattern of a rotation about an axis; multiples of pi/2 have one of their own."""
    turns = quarters(angle)

    def entry(i: int, j: int) -> int:
        if axis in (i, j):
            return CONSTANT if i == j else ZERO
        if turns is None:
            return max(CONSTANT, level)
        return CONSTANT if (turns % 2 == 0) == (i == j) else ZERO

    return tuple(tuple(entry(i, j) for j in range(3)) for i in range(3))


def quarters(angle: Tree) -> int | None:
    """How many right angles a number is; None where it is none, or no number."""
    if any(name.identifier != "pi" for name in names(angle)):
        return None
    try:
        turns = evaluate(angle) / (pi / 2)
    except (ExpressionError, ArithmeticError):
        return None
    return round(turns) if abs(turns - round(turns)) < 1e-12 else None


def product(left: Pattern, right: Pattern) -> Pattern:
    """The pattern of a product of matrices."""
    columns: Any = [*zip(*right)]
    return tuple(tuple(max(map(both, row, column)) for column in columns) for row in left)


def keeps(pattern: Pattern, axis: int) -> bool:
    """Whether a body of this pattern does not turn about an axis: it does not turn, or about another one."""
    if all(one <= CONSTANT for row in pattern for one in row):
        return True
    return any(
        pattern[m][m] == CONSTANT and not any(pattern[m][k] or pattern[k][m] for k in range(3) if k != m)
        for m in range(3)
        if m != axis
    )
