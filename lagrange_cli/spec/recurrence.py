"""Members of a family that follow from one another, as in ``x[i]: x[i - 1] + l*sin(theta[i])``: what is
written once for them is checked once, and sums that go on from member to member are added up at once."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import partial
from typing import Any

import numpy as np

from lagrange_cli.expression.algebra import Value
from lagrange_cli.expression.array_builder import Members
from lagrange_cli.expression.bounds import MAX_DEPTH, Bounds
from lagrange_cli.expression.index_arrays import Differ, Mask, Places, Whole, distinct, flat, integers
from lagrange_cli.expression.indices import Indices, Unsuited
from lagrange_cli.expression.many_bounds import BoundsBuilder
from lagrange_cli.expression.syntax import Binary, ExpressionError, Name, Sum, Tree, names
from lagrange_cli.expression.vocabulary import member_name
from lagrange_cli.spec.family import Place
from lagrange_cli.spec.meanings import has_some, largest, scalar
from lagrange_cli.spec.members import Table, bounds_of, component_of, indices_of
from lagrange_cli.spec.order import Needs
from lagrange_cli.spec.whole import Part, WrittenFamily

FEW = 8
"""Members beside a part that its members may begin from."""


class Recurrence(BoundsBuilder):
    """The bounds of the members of a ``part`` of a family, each of which follows from earlier ones, or each
    from later ones.

    Sizes that grow by as much from member to member are those of a sum, which is written once.
    """

    def __init__(self, table: Table, sizes: Indices, group: WrittenFamily[Any], part: Part[Any]) -> None:
        super().__init__(partial(bounds_of, table), sizes)
        self.table, self.family, self.part = table, group.family, part
        self._others = [one for one in group.parts if one is not part and one.count > 1]
        self.ascending: bool | None = None
        """Whether members of the part follow from those before them; None as long as none does from any."""
        self.natural = True
        """Whether all that members follow from comes before them in the order of their indices."""
        self._beside: dict[int, Value] = {}
        """The bounds of members beside the part, by their numbers."""
        self._previous: Value = None
        """Those of the members that others follow from."""

    @property
    def places(self) -> list[Place]:
        """Those of the members, in the order in which they can be computed."""
        return [*self.part.places][:: -1 if self.ascending is False else 1]

    def settled(self, tree: Tree) -> Value:
        """The bounds of all members; None where members have to be checked one by one.

        Raises:
            Needs: for a member beside the part that is not settled yet.
        """
        try:
            self._all(tree)
            found = [self._all(tree, start) for start in [*self._beside.values()] or [scalar()]]
            before, value = None, joint(found)
            for _ in range(3 * MAX_DEPTH):
                before, value, earlier = value, self._all(tree, value), before
                if earlier is not None and steady(earlier, before, value):
                    return value
        except (Unsuited, Differ, ExpressionError, ArithmeticError):
            pass
        return None

    def _all(self, tree: Tree, previous: Value = None) -> Value:
        """The bounds of all members where those that they follow from have the bounds ``previous``."""
        self._previous, self.used = previous, 0
        count = self.part.count
        found = joint(
            [value for _, value, _ in self.each(tree, {**self._sizes, **indices_of(self.part)}, count)]
        )
        if any(one.value is not None or has_some(one) for one in parts_of(found)):
            raise Unsuited  # numbers are looked at one by one
        return found

    def named(self, identifier: str, places: list[Whole], members: Members) -> Value:
        name, _, component = identifier.partition(".")
        if name != self.family.name:
            return super().named(identifier, places, members)
        which = flat(places, self.family.shape, members.count)
        value = self._of_own(which, places, members)
        return component_of(value, component) if component else value

    def shared(self, tree: Sum, members: Members) -> None:
        """Terms differ from member to member: each knows which member it belongs to."""

    def _of_own(self, which: Places, places: list[Whole], members: Members) -> Value:
        """The bounds of members of the family itself."""
        inside = within(self.part, places, members.count)
        at = [members[name] if name else one[0] for name, one in zip(self.part.indices, self.part.ranges)]
        ahead = flat(at, self.family.shape, members.count) - which
        self.natural = self.natural and bool(np.all(ahead > 0))
        beside, rest = [], ~inside
        for other in self._others:
            if np.any(chosen := rest & within(other, places, members.count)):
                beside.append(self._member(int(which[chosen][0]), alone=False))
                rest &= ~chosen
        beside += [self._member(number) for number in distinct(which[rest]).tolist()[: FEW + 1]]
        if len(beside) > FEW:
            raise Unsuited
        if not np.any(inside):
            return joint(beside)
        ahead = ahead[inside]
        ascending = bool(ahead[0] > 0)
        if np.any(ahead == 0) or np.any((ahead > 0) != ascending) or self.ascending is (not ascending):
            raise Unsuited
        self.ascending = ascending
        if self._previous is None:
            self._previous = beside[0] if beside else scalar()
        return self._previous

    def _member(self, number: int, *, alone: bool = True) -> Value:
        """The bounds of a member beside the part, which it may have in common with others."""
        if number not in self._beside:
            name = member_name(self.family.name, self.family.at(number))
            if name not in self.table.values:
                raise Needs(name) if name in self.family.members else Unsuited
            if self.table.values[name] is None:
                raise Unsuited
            value = self.table.values[name]
            if not alone and any(one.value is not None for one in parts_of(value)):
                raise Unsuited
            self._beside[number] = value
        return self._beside[number]


def within(part: Part[Any], places: Sequence[Whole], count: int) -> Mask:
    """Which of so many members, at these places, are some of a part."""
    inside = np.ones(count, dtype=bool)
    for place, values in zip(places, part.ranges):
        inside &= np.less_equal(values[0], place) & np.less_equal(place, values[-1])
        inside &= np.equal((place - values[0]) % values.step, 0)
    return inside


def parts_of(value: Value) -> Sequence[Bounds]:
    """The components of a vector, or a scalar alone."""
    return value if isinstance(value, tuple) else (value,)


def joint(found: Sequence[Value]) -> Value:
    """Bounds of them all. Raises ``Unsuited`` where they differ in kind."""
    value = found[0] if len(found) == 1 else largest(found) if found else None
    if value is None:
        raise Unsuited
    return value


def steady(one: Value, two: Value, three: Value) -> bool:
    """Whether bounds go on as they do here: just as deep, and larger by as much."""
    return all(
        (b.depth, b.kind) == (c.depth, c.kind) and c.size - b.size == b.size - a.size
        for a, b, c in zip(*map(parts_of, (one, two, three)))
    )


def addends(tree: Tree, base: str) -> tuple[Name, list[tuple[Tree, bool]]]:
    """Of ``x[i - 1] + a - b``, the member of the family ``base`` and what is added to it, in order, and
    whether it is subtracted. Raises ``Unsuited`` where ``tree`` is no such sum."""
    rest: list[tuple[Tree, bool]] = []
    while isinstance(tree, Binary) and tree.operator in ("+", "-"):
        if isinstance(tree.right, Name) and tree.right.identifier == base and tree.operator == "+":
            found = tree.right, [(tree.left, False), *reversed(rest)]
            break
        rest.append((tree.right, tree.operator == "-"))
        tree = tree.left
    else:
        if not isinstance(tree, Name) or tree.identifier != base:
            raise Unsuited
        found = tree, [*reversed(rest)]
    if not found[1] or any(name.base == base for one, _ in found[1] for name in names(one)):
        raise Unsuited
    return found


def direction(used: Name, part: Part[Any], indices: Mapping[str, Whole]) -> tuple[int, int]:
    """Along which axis members follow from their neighbours, and in which direction. Raises ``Unsuited``
    where it is otherwise."""
    found = []
    for axis, (tree, name, values) in enumerate(zip(used.indices, part.indices, part.ranges)):
        shift = integers(tree, indices) - (indices[name] if name else values[0])
        least, most = int(np.min(shift)), int(np.max(shift))
        if least != most or abs(least) not in (0, values.step):
            raise Unsuited
        if least:
            found.append((axis, -1 if least > 0 else 1))
    if len(found) != 1 or len(used.indices) != len(part.ranges):
        raise Unsuited
    return found[0]
