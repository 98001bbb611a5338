"""The expressions of a system file over sympy, with their indices: a sum stays a sum.

Where members differ in kind, a sum becomes several (``kinds``).
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np
import sympy

from lagrange_cli.expression.algebra import Value
from lagrange_cli.expression.index_arrays import holding, integers
from lagrange_cli.expression.index_loops import inner
from lagrange_cli.expression.indices import Unsuited
from lagrange_cli.expression.syntax import Name, Sum, Tree
from lagrange_cli.expression.vocabulary import BODY_COMPONENTS, COMPONENTS, TIME, VELOCITY_COMPONENTS
from lagrange_cli.families.builder import recursion
from lagrange_cli.families.groups import Group, group_of
from lagrange_cli.model.orientation import Turning, turning
from lagrange_cli.model.rigid_body import second_moments
from lagrange_cli.records import dataclass
from lagrange_cli.spec.spec import Expression
from lagrange_cli.symbolic.families.frames import Frame, Kind, Split
from lagrange_cli.symbolic.families.kinds import MemberKinds, loop_of
from lagrange_cli.symbolic.families.labels import axes_of
from lagrange_cli.symbolic.indexed.conditions import Condition, Joined, Loop, Relation, condition_of, relation
from lagrange_cli.symbolic.indexed.members import (
    KNOWN,
    Loops,
    Summed,
    expression_of,
    member,
    rate_of,
    renamed,
)
from lagrange_cli.symbolic.indexed.whole import Whole, named, number, operation, reduced, whole_of


@dataclass(frozen=True)
class Oriented:
    """How rigid bodies of a family turn, and the second moments and products of their mass; ``form`` is how
    the orientation is given."""

    form: str
    turning: Turning[sympy.Expr]
    moments: Sequence[sympy.Expr]
    products: Mapping[tuple[int, int], sympy.Expr]


class WrittenBuilder(MemberKinds):
    """Raises ``Unsuited`` for what it does not know."""

    def value(self, tree: Tree, frame: Frame) -> Any:
        """The value of a tree: an expression, or several for a vector."""
        return self._value(tree, frame)

    def building(self, tree: Tree) -> Callable[[Frame], Any]:
        """What builds a tree."""
        return lambda frame: self.value(tree, frame)

    def among(self, group: Group, kind: Kind) -> Callable[[Frame], Any]:
        """What builds the members of a group that have the places of those of a kind."""

        def build(frame: Frame) -> Any:
            known = {**self.spec.sizes, **frame.arrays}
            return self.of_group(group, kind.indices, [one.value(known) for one in kind.indices], frame)

        return build

    def scalar(self, written: Expression) -> sympy.Expr:
        """The value of an expression that belongs to no family."""
        values = {**self.root, **written.indices}
        names = {**self.names, **{name: number(one) for name, one in written.indices.items()}}
        made = self.value(written.tree, Frame(values, 1, names, {}))
        if isinstance(made, tuple):
            raise Unsuited
        return made

    # names

    def _name(self, tree: Name, indices: Any) -> Value:
        frame: Frame = indices
        if not tree.indices and tree.identifier in frame.names:
            return expression_of(frame.names[tree.identifier])
        if tree.identifier == "pi":
            return self.algebra.pi()
        if tree.identifier == TIME:
            return self.algebra.symbol(TIME)
        wholes = tuple(self.settled(whole_of(one, frame.names)) for one in tree.indices)
        name, _, component = tree.identifier.partition(".")
        if name in self.bases:
            if component or len(wholes) != len(self.bases[name].shape):
                raise Unsuited
            return member(name, wholes) if wholes else self.algebra.symbol(name)
        if name not in self.groups:
            raise Unsuited
        values = [integers(one, frame) for one in tree.indices]
        if component in BODY_COMPONENTS:
            return self.oriented(name, wholes, values, frame).turning.component(component)
        value = self.of_group(self.groups[name], wholes, values, frame)
        if not component:
            return value
        parts = value if isinstance(value, tuple) else (value,)
        if component in VELOCITY_COMPONENTS:
            return self.rate(parts[VELOCITY_COMPONENTS.index(component)])
        return parts[COMPONENTS.index(component)]

    def settled(self, index: Whole) -> Whole:
        """An index without remainders, where it is made of sizes alone: N - 1 for -1 % N."""
        if not index.names <= self.spec.sizes.keys():
            return index
        return reduced(index, {name: (size, size) for name, size in self.spec.sizes.items()})

    def _whole(self, tree: Tree, indices: Any) -> Value:
        return expression_of(whole_of(tree, indices.names))

    def of_group(self, group: Group, wholes: Sequence[Whole], values: Sequence[Any], frame: Frame) -> Value:
        """What members of a group are, with their places."""
        tree, inside = self.chosen(group, wholes, values, frame)
        with recursion(group, self.within):
            return self.value(tree, inside)

    def chosen(
        self, group: Group, wholes: Sequence[Whole], values: Sequence[Any], frame: Frame
    ) -> tuple[Any, Frame]:
        """How members of a group are written, and where that stands. Raises ``Split`` where they differ."""
        shape = group.family.shape
        places: Any = 0
        for value, size in zip(values, shape):
            places = places * size + value
        which = group.numbers_at(np.broadcast_to(np.asarray(places, dtype=np.int64), frame.count))
        labels = group.labels[which]
        if len(labels) and np.any(labels != labels[0]):
            label = int(labels[0])
            raise Split(self._where_label(group, label, wholes))
        label = int(labels[0]) if len(labels) else 0
        own = {name: np.broadcast_to(one, group.count)[which] for name, one in group.indices.items()}
        names = {**self.names, **{name: wholes[axis] for name, axis in axes_of(group, label).items()}}
        return group.trees[label], Frame({**self.sizes, **own}, frame.count, names, frame.arrays)

    def oriented(self, name: str, wholes: Sequence[Whole], values: Sequence[Any], frame: Frame) -> Oriented:
        """How members of a family of rigid bodies turn."""
        if name not in self.bodies:
            raise Unsuited
        body, inside = self.chosen(self.bodies[name], wholes, values, frame)

        def value(one: Expression) -> Any:
            return self.value(one.tree, inside)

        def mass() -> Any:
            masses = group_of(self.bodies[name].family, self.spec.masses)
            return self.of_group(masses, wholes, values, frame)

        how = body.orientation
        turns = turning(self.algebra, how.form, how.sequence, [*map(value, how.entries)], self.rate)
        return Oriented(how.form, turns, *second_moments(self.algebra, body.inertia, value, mass))

    def _where_label(self, group: Group, label: int, wholes: Sequence[Whole]) -> Condition:
        """Where members have a label: the ranges and conditions of its key."""
        names, parts = dict(self.names), list[Condition]()
        for axis, whole, size in zip(group.keyed[label], wholes, group.family.shape):
            if not axis.index:
                parts.append(relation(whole, "==", whole_of(axis.bounds[0], names)))
                continue
            loop = loop_of("", axis, names)
            names[axis.index] = whole
            low = loop.start != number(0)
            high = loop.stop.names > self.sizes.keys() or loop.stop.value(self.sizes) != size
            if low and high:
                parts.append(Relation(("<=", "<"), (loop.start, whole, loop.stop)))
            elif low or high:
                bound = (">=", loop.start) if low else ("<", loop.stop)
                parts.append(relation(whole, *bound))
            if loop.step != 1:
                parts.append(relation(operation("%", whole - loop.start, number(loop.step)), "==", number(0)))
            parts += [condition_of(one, names) for one in axis.conditions]
        return parts[0] if len(parts) == 1 else Joined("and", tuple(parts))

    # loops

    def _holds(self, condition: Tree, indices: Any) -> bool:
        """The same for all members. Raises ``Split`` where they differ."""
        known = np.broadcast_to(holding(condition, indices), indices.count)
        if len(known) and np.any(known != known[0]):
            raise Split(condition_of(condition, indices.names))
        return not len(known) or bool(known[0])

    def _sum(self, tree: Sum, indices: Any) -> Value:
        frame: Frame = indices
        index = self.fresh(tree.index, frame)
        names = {**frame.names, tree.index: named(index)}
        loop = loop_of(index, tree, frame.names)
        inside = self.rounds(tree, frame, index, names)
        kinds = self.kinds([loop], inside, lambda one: self._value(tree.body, one))
        parts: list[list[sympy.Expr]] = []
        vector = False
        for (loop,), value in kinds:
            vector = isinstance(value, tuple)
            listed = value if isinstance(value, tuple) else (value,)
            parts += [[] for _ in range(len(listed) - len(parts))]
            for k, one in enumerate(listed):
                parts[k].append(self._over(loop, one))
        made = tuple(sympy.Add(*one) for one in parts)
        return made if vector else made[0] if made else sympy.S.Zero

    def rounds(self, tree: Sum, frame: Frame, index: str, names: Mapping[str, Whole]) -> Frame:
        """Where the terms of a sum stand, all of those of all members."""
        values, owners = inner(tree, frame, frame.count)
        arrays = {name: np.broadcast_to(one, frame.count)[owners] for name, one in frame.arrays.items()}
        return Frame(values, len(owners), names, {**arrays, index: values[tree.index]})

    def _over(self, loop: Loop, value: sympy.Expr) -> sympy.Expr:
        """The sum of a value over a loop."""
        if loop.step == 1 and not loop.conditions and loop.stop - loop.start == number(1):
            return renamed(value, {loop.index: loop.start}, {})
        return Summed(value, Loops([loop]))

    # velocities

    def rate(self, expression: sympy.Expr) -> sympy.Expr:
        """The time derivative of what depends on coordinates, velocities and t."""

        def rate(symbol: sympy.Symbol) -> sympy.Expr | None:
            base, indices = KNOWN.get(symbol.name, (symbol.name, ()))
            found = self.rates.get(base)
            if found is None:
                return None
            return member(found, indices) if indices else sympy.Symbol(found)

        return rate_of(expression, rate)
