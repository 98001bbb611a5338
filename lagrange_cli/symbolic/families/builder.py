"""The expressions of a system file over sympy, with their indices: a sum stays a sum.

Where members differ in kind, as a chain's ends do from its middle, a sum becomes several. Which kinds there
are is decided for all members at once, by arrays of numpy.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import Any

import numpy as np
import sympy

from lagrange_cli.expression.algebra import Value
from lagrange_cli.expression.build import Builder
from lagrange_cli.expression.index_arrays import holding, inner, integers
from lagrange_cli.expression.indices import Unsuited
from lagrange_cli.expression.symbolic import SympyAlgebra
from lagrange_cli.expression.syntax import Call, Name, Sum, Tree
from lagrange_cli.expression.vocabulary import (
    COMPONENTS,
    TIME,
    VELOCITY_COMPONENTS,
    acceleration_name,
    velocity_name,
)
from lagrange_cli.families.builder import recursion
from lagrange_cli.families.groups import Group, group_of, particle_families
from lagrange_cli.spec.spec import Expression, Family, Spec, grouped
from lagrange_cli.symbolic.families.frames import Frame, Kind, Split
from lagrange_cli.symbolic.families.labels import axes_of, places_of, ranges
from lagrange_cli.symbolic.indexed.conditions import (
    Condition,
    Joined,
    Loop,
    Relation,
    condition_of,
    holds,
    names_of,
    negation,
    relation,
)
from lagrange_cli.symbolic.indexed.members import (
    KNOWN,
    Loops,
    Summed,
    expression_of,
    member,
    opened,
    renamed,
)
from lagrange_cli.symbolic.indexed.whole import Whole, named, number, operation, reduced, whole_of

LETTERS = "ijklmnabcdefgh"
MOST_PIECES = 30
"""Into which a sum is split."""


class WrittenBuilder(Builder):
    """Raises ``Unsuited`` for what it does not know."""

    def __init__(self, spec: Spec) -> None:
        super().__init__(self._unknown, SympyAlgebra(), spec.sizes)
        self.spec = spec
        self.bases: dict[str, Family] = {}
        self.rates: dict[str, str] = {}
        """The names of velocities and accelerations."""
        for section, items in (("coordinates", spec.coordinates), ("parameters", spec.parameters)):
            for family in grouped([one.name for one in items], spec.families.get(section, {})):
                self.bases[family.name] = family
                if section == "coordinates":
                    speed = velocity_name(family.name)
                    self.bases[speed] = family
                    self.rates |= {family.name: speed, speed: acceleration_name(family.name)}
        self.coordinates = grouped(
            [one.name for one in spec.coordinates], spec.families.get("coordinates", {})
        )
        self.groups: dict[str, Group] = {}
        self.within: list[Group] = []
        """The groups whose members are being built."""
        for family in grouped(spec.definitions, spec.families.get("definitions", {})):
            self.groups[family.name] = group_of(family, spec.definitions)
        for family in grouped(spec.embedding, particle_families(spec)):
            self.groups[family.name] = group_of(family, spec.embedding)
        self.names = {name: named(name) for name in spec.sizes}
        self.taken = {*spec.sizes, *self.bases, *self.groups, TIME}
        """Names that no index may get."""
        self.root = Frame(spec.sizes, 1, self.names, {})

    def _unknown(self, identifier: str) -> Value:
        raise Unsuited

    def value(self, tree: Tree, frame: Frame) -> Any:
        """The value of a tree: an expression, or several for a vector."""
        return self._value(tree, frame)

    def building(self, tree: Tree) -> Callable[[Frame], Any]:
        """What builds a tree."""
        return lambda frame: self.value(tree, frame)

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
        value = self.of_group(
            self.groups[name], wholes, [integers(one, frame) for one in tree.indices], frame
        )
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
        shape = group.family.shape
        places: Any = 0
        for value, size in zip(values, shape):
            places = places * size + value
        which = np.broadcast_to(group.place_of[places], frame.count)
        labels = group.labels[which]
        if len(labels) and np.any(labels != labels[0]):
            label = int(labels[0])
            raise Split(self._where_label(group, label, wholes))
        label = int(labels[0]) if len(labels) else 0
        own = {name: np.broadcast_to(one, group.count)[which] for name, one in group.indices.items()}
        names = {**self.names, **{name: wholes[axis] for name, axis in axes_of(group, label).items()}}
        inside = Frame({**self.sizes, **own}, frame.count, names, frame.arrays)
        with recursion(group, self.within):
            return self.value(group.trees[label], inside)

    def _where_label(self, group: Group, label: int, wholes: Sequence[Whole]) -> Condition:
        """Where members have a label."""
        parts: list[Condition] = []
        for (low, high), size, whole, axis in zip(
            ranges(group, label), group.family.shape, wholes, range(len(wholes))
        ):
            if low == high:
                parts.append(relation(whole, "==", self.bound(group.family, axis, low)))
            elif (low, high) != (0, size - 1):
                top = self.bound(group.family, axis, high + 1)
                parts.append(Relation(("<=", "<"), (number(low), whole, top)))
        return parts[0] if len(parts) == 1 else Joined("and", tuple(parts))

    def bound(self, family: Family, axis: int, value: int) -> Whole:
        """A number near the end of an axis in terms of the size that the axis has."""
        return self.near(value, family.axes[axis].partition("_")[0])

    def near(self, value: int, *sizes: str) -> Whole:
        """A number that is near a size in terms of it."""
        axes = [one.partition("_")[0] for family in self.coordinates for one in family.axes]
        for name in (*sizes, *axes):
            size = self.sizes.get(name, 0)
            if value > 2 and 0 <= abs(size - value) <= 2 < size:
                return named(name) + number(value - size)
        return number(value)

    # loops

    def _where(self, tree: Call, indices: Any) -> Value:
        condition, *branches = tree.arguments
        known = np.broadcast_to(holding(condition, indices), indices.count)
        if len(known) and np.any(known != known[0]):
            raise Split(condition_of(condition, indices.names))
        return self._value(branches[0 if not len(known) or known[0] else 1], indices)

    def _sum(self, tree: Sum, indices: Any) -> Value:
        frame: Frame = indices
        index = self.fresh(tree.index, frame)
        names = {**frame.names, tree.index: named(index)}
        start, stop, step = number(0), number(0), 1
        bounds = [whole_of(one, frame.names) for one in tree.bounds]
        if len(bounds) == 1:
            stop = bounds[0]
        else:
            start, stop = bounds[:2]
        if len(bounds) == 3:
            if bounds[2].terms:
                raise Unsuited
            step = bounds[2].constant
        if step < 0:  # a sum does not depend on the order of its terms
            count = start - stop - number(1)
            first = start - (count if step == -1 else operation("//", count, number(-step)) * -step)
            start, stop, step = first, start + number(1), -step
        conditions = tuple(condition_of(one, names) for one in tree.conditions)
        loop = Loop(index, start, stop, step, conditions)
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

    def kinds(
        self, loops: Sequence[Loop], frame: Frame, build: Callable[[Frame], Any]
    ) -> Iterator[tuple[tuple[Loop, ...], Any]]:
        """The values of the members that loops run through, for each kind separately."""
        alone = len(frame.arrays) == 1 == len(loops) and not loops[0].conditions
        alone = alone and loops[0].names <= self.sizes.keys()
        pending = [(tuple(loops), np.arange(frame.count))] if frame.count else []
        pieces = 0
        while pending:
            loops, which = pending.pop(0)
            part, pieces = frame.part(which), pieces + 1
            try:
                yield loops, build(part)
            except Split as split:
                within = [one for one in loops if one.index in names_of(split.condition)]
                if not within or pieces > MOST_PIECES:
                    raise
                chosen = np.broadcast_to(holds(split.condition, {**self.sizes, **part.arrays}), part.count)
                for condition, own in ((split.condition, chosen), (negation(split.condition), ~chosen)):
                    last = within[-1]
                    more = Loop(last.index, last.start, last.stop, last.step, (*last.conditions, condition))
                    if alone:
                        more = self._plain(more, part.arrays[last.index][own])
                    pending.append((tuple(more if one is last else one for one in loops), which[own]))

    def _plain(self, loop: Loop, values: Any) -> Loop:
        """The loop without conditions, if it runs through a range of these values all the same."""
        low, high = int(values[0]), int(values[-1])
        if loop.step != 1 or not np.array_equal(values, np.arange(low, high + 1)):
            return loop
        start, stop = (one.value(self.sizes) for one in (loop.start, loop.stop))
        start = loop.start if low == start else self.near(low)
        stop = loop.stop if high + 1 == stop else self.near(high + 1)
        return Loop(loop.index, start, start + number(1) if low == high else stop)

    def _over(self, loop: Loop, value: sympy.Expr) -> sympy.Expr:
        """The sum of a value over a loop."""
        if loop.step == 1 and not loop.conditions and loop.stop - loop.start == number(1):
            return renamed(value, {loop.index: loop.start}, {})
        return Summed(value, Loops([loop]))

    def fresh(self, wanted: str, frame: Frame, *inside: sympy.Expr) -> str:
        """An index's name, if no loop around has it, and no loop in what stands ``inside``."""
        used = self.taken.union(frame.arrays, *(one.names for one in frame.names.values()))
        used.update(loop.index for one in inside for loops in one.atoms(Loops) for loop in loops.loops)
        candidates = [wanted, *LETTERS, *(f"i{k}" for k in range(99))]
        found: str = next(name for name in candidates if name not in used)
        return found

    def of_family(self, group: Group) -> Iterator[Kind]:
        """The members of a family, of each kind by itself; those that differ further raise ``Split``."""
        family = group.family
        for label in range(len(group.trees)):
            if not family.shape:
                values = {name: int(one[0]) for name, one in group.indices.items()}
                yield Kind((), (), group.trees[label], Frame({**self.sizes, **values}, 1, self.names, {}))
                continue
            axes = {axis: name for name, axis in axes_of(group, label).items()}
            loops: list[Loop] = []
            indices: list[Whole] = []
            axes_names: list[str] = []
            names = dict(self.names)
            for axis, (low, high) in enumerate(ranges(group, label)):
                wanted = axes.get(axis, LETTERS[axis])
                index = self.fresh(wanted, Frame({}, 1, {one.index: named(one.index) for one in loops}, {}))
                whole = named(index)
                axes_names.append(index)
                if low == high:
                    whole = self.bound(family, axis, low)
                else:
                    start, stop = self.bound(family, axis, low), self.bound(family, axis, high + 1)
                    loops.append(Loop(index, start if low > 2 else number(low), stop))
                indices.append(whole)
                if axis in axes:
                    names[axes[axis]] = whole
            chosen = group.labels == label
            values = {name: one[chosen] for name, one in group.indices.items()}
            places = dict(zip(axes_names, places_of(group, label)))
            arrays = {loop.index: places[loop.index] for loop in loops}
            frame = Frame({**self.sizes, **values}, int(chosen.sum()), names, arrays)
            yield Kind(tuple(loops), tuple(indices), group.trees[label], frame)

    # velocities

    def rate(self, expression: sympy.Expr) -> sympy.Expr:
        """The time derivative of what depends on coordinates, velocities and t."""
        plain, sums = opened(expression)
        made = plain.diff(sympy.Symbol(TIME))
        for symbol in sorted(plain.free_symbols, key=str):
            if symbol in sums:
                one = sums[symbol]
                made += plain.diff(symbol) * Summed(self.rate(one.body), one.args[1])
                continue
            base, indices = KNOWN.get(symbol.name, (symbol.name, ()))
            if base in self.rates:
                rate = self.rates[base]
                made += plain.diff(symbol) * (member(rate, indices) if indices else sympy.Symbol(rate))
        return made.xreplace(sums)
