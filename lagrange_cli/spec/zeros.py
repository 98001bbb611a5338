"""Which expressions are 0 in every state because of how positions and orientations are written.

Parameters are numbers of a run and count as any number.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from functools import cached_property
from math import pi
from typing import Any, TypeAlias

from lagrange_cli.expression.numbers import evaluate
from lagrange_cli.expression.syntax import Binary, ExpressionError, Name, Negative, Number, Sum, Tree, names
from lagrange_cli.expression.vocabulary import AXES_COMPONENTS, COMPONENTS, VELOCITY_COMPONENTS
from lagrange_cli.spec.content import groups_of, statements
from lagrange_cli.spec.draft import Draft, WrittenBody
from lagrange_cli.spec.spec import Orientation

Pattern: TypeAlias = "tuple[tuple[bool, ...], ...]"
"""Three rows of three: whether the entries of a matrix are other than 0."""


class Zeros:
    """The positions, orientations and definitions of a file; ``spread`` gives the components of a vector."""

    def __init__(self, draft: Draft, spread: Callable[[Tree], Tree | tuple[Tree, ...]]) -> None:
        self._draft, self._spread = draft, spread

    def is_zero(self, tree: Tree) -> bool:
        """Whether a scalar is 0 in every state; no is the answer where that takes more than a look."""
        if isinstance(tree, Number):
            return float(tree.text) == 0
        if isinstance(tree, Negative):
            return self.is_zero(tree.operand)
        if isinstance(tree, Sum):
            return self.is_zero(tree.body)
        if isinstance(tree, Name):
            return self._is_zero(tree)
        if not isinstance(tree, Binary):
            return False
        left, right = tree.left, tree.right
        if tree.operator in "+-":
            return self.is_zero(left) and self.is_zero(right)
        factors = {"*": (left, right), "/": (left,)}.get(tree.operator, ())
        return any(map(self.is_zero, factors))

    def _is_zero(self, name: Name) -> bool:
        """The same of a name: in a family, of all members."""
        base, _, component = name.identifier.partition(".")
        if component in AXES_COMPONENTS:
            i, j = divmod(AXES_COMPONENTS.index(component), 3)
            return not any(pattern[i][j] for pattern in self._turned(base))
        axes = COMPONENTS + VELOCITY_COMPONENTS
        if component and component not in axes:
            return False
        k = axes.index(component) % 3 if component else 0
        given = self._written.get(base)
        return given is not None and all(self.is_zero(self._spread_of(one)[k]) for one in given)

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
        """Which entries of R are other than 0."""
        trees = [one.tree for one in how.entries]
        if how.form == "matrix":
            there = [not self.is_zero(tree) for tree in trees]
            return tuple(tuple(there[3 * i : 3 * i + 3]) for i in range(3))
        if how.form == "quaternion":
            w, x, y, z = (not self.is_zero(tree) for tree in trees)
            xy, xz, yz = (x and y) or (w and z), (x and z) or (w and y), (y and z) or (w and x)
            return (True, xy, xz), (xy, True, yz), (xz, yz, True)
        a, b, c = (elementary("xyz".index(axis), tree) for axis, tree in zip(how.sequence, trees))
        return product(product(a, b), c)


def elementary(axis: int, angle: Tree) -> Pattern:
    """The pattern of a rotation about an axis; angles that are multiples of pi/2 have one of their own."""
    turns = quarters(angle)
    even, odd = turns is None or turns % 2 == 0, turns is None or turns % 2 == 1

    def there(i: int, j: int) -> bool:
        if axis in (i, j):
            return i == j
        return even if i == j else odd

    return tuple(tuple(there(i, j) for j in range(3)) for i in range(3))


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
    middle: Any = [*zip(*right)]
    return tuple(tuple(any(a and b for a, b in zip(row, column)) for column in middle) for row in left)
