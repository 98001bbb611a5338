"""The kinds of members of families, which are written alike: the loops through them, and names for indices.

Members differ in kind as a chain's ends do from its middle. Which kinds there are is decided for all members
at once, by arrays of numpy.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import Any

import numpy as np
import sympy

from lagrange_cli.expression.algebra import Value
from lagrange_cli.expression.build import Builder
from lagrange_cli.expression.indices import Unsuited
from lagrange_cli.expression.symbolic import SympyAlgebra
from lagrange_cli.expression.syntax import Axis, Sum, Tree
from lagrange_cli.expression.vocabulary import TIME, acceleration_name, velocity_name
from lagrange_cli.families.groups import Group, group_of, particle_families
from lagrange_cli.families.turning import body_groups
from lagrange_cli.spec.spec import Family, Spec, grouped
from lagrange_cli.symbolic.families.frames import Frame, Kind, Split
from lagrange_cli.symbolic.families.labels import places_of
from lagrange_cli.symbolic.indexed.conditions import Loop, condition_of, holds, names_of, negation
from lagrange_cli.symbolic.indexed.members import Loops
from lagrange_cli.symbolic.indexed.whole import Whole, named, number, operation, whole_of

LETTERS = "ijklmnabcdefgh"
MOST_PIECES = 30
"""Into which a sum is split."""


class MemberKinds(Builder):
    """A builder that knows the families of a file, and splits them into kinds."""

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
        self.coordinates = grouped([one.name for one in spec.coordinates], spec.coordinate_families)
        self.groups: dict[str, Group] = {}
        self.within: list[Group] = []
        """The groups whose members are being built."""
        for family in grouped(spec.definitions, spec.families.get("definitions", {})):
            self.groups[family.name] = group_of(family, spec.definitions)
        for family in grouped(spec.embedding, particle_families(spec)):
            self.groups[family.name] = group_of(family, spec.embedding)
        self.bodies = {name: one.group for name, one in body_groups(spec).items()} if spec.bodies else {}
        self.names = {name: named(name) for name in spec.sizes}
        self.taken = {*spec.sizes, *self.bases, *self.groups, TIME}
        """Names that no index may get."""
        self.root = Frame(spec.sizes, 1, self.names, {})

    def _unknown(self, identifier: str) -> Value:
        raise Unsuited

    def fresh(self, wanted: str, frame: Frame, *inside: sympy.Expr) -> str:
        """An index's name, if no loop around has it, and no loop in what stands ``inside``."""
        used = self.taken.union(frame.arrays, *(one.names for one in frame.names.values()))
        used.update(loop.index for one in inside for loops in one.atoms(Loops) for loop in loops.loops)
        candidates = [wanted, *LETTERS, *(f"i{k}" for k in range(99))]
        found: str = next(name for name in candidates if name not in used)
        return found

    def of_family(self, group: Group) -> Iterator[Kind]:
        """The members of a family, of each kind by itself; those that differ further raise ``Split``."""
        for label, tree in enumerate(group.trees):
            yield self.keyed(group.keyed.get(label, ()), places_of(group, label), tree)

    def keyed(self, axes: Sequence[Axis], places: Sequence[Any], tree: Tree) -> Kind:
        """Members that are written with the ``axes`` of a key: the loops are those of the key. Their
        ``places`` are axis by axis."""
        loops: list[Loop] = []
        indices: list[Whole] = []
        names, arrays = dict(self.names), dict[str, Any]()
        for one, own in zip(axes, places):
            if not one.index:
                indices.append(whole_of(one.bounds[0], names))
                continue
            index = self.fresh(one.index, Frame({}, 1, names, arrays))
            loop = loop_of(index, one, names)
            if self.has_one(loop):
                names[one.index] = loop.start
            else:
                loops.append(loop)
                names[one.index], arrays[index] = named(index), own
            indices.append(names[one.index])
        values = {one.index: own for one, own in zip(axes, places) if one.index}
        frame = Frame({**self.sizes, **values}, len(places[0]) if axes else 1, names, arrays)
        return Kind(tuple(loops), tuple(indices), tree, frame)

    def has_one(self, loop: Loop) -> bool:
        """Whether a loop without conditions has one member, of a number that sizes determine."""
        if loop.conditions or not loop.names <= self.sizes.keys():
            return False
        return int((loop.stop - loop.start).value(self.sizes)) == 1

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


def loop_of(index: str, written: Axis | Sum, names: Mapping[str, Whole]) -> Loop:
    """The loop that is called ``index``, as it is written; others around it are called by ``names``. It runs
    upward: what is done does not depend on the order."""
    start, stop, step = number(0), number(0), 1
    bounds = [whole_of(one, names) for one in written.bounds]
    if len(bounds) == 1:
        stop = bounds[0]
    else:
        start, stop = bounds[:2]
    if len(bounds) == 3:
        if bounds[2].terms:
            raise Unsuited
        step = bounds[2].constant
    if step < 0:
        count = start - stop - number(1)
        first = start - (count if step == -1 else operation("//", count, number(-step)) * -step)
        start, stop, step = first, start + number(1), -step
    inside = {**names, written.index: named(index)}
    conditions = tuple(condition_of(one, inside) for one in written.conditions)
    return Loop(index, start, stop, step, conditions)
