"""Families that follow from one another in turn, as in ``knee[i]: foot[i - 1] + ..`` and
``foot[i]: knee[i] + ..``: all but one are eliminated from this one, which follows from itself then."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from itertools import chain, groupby
from typing import Any

import numpy as np

from lagrange_cli.expression.index_arrays import Whole, integers
from lagrange_cli.expression.indices import Indices
from lagrange_cli.expression.indices import Unsuited as NotWhole
from lagrange_cli.expression.rebuilding import rebuilt, size_of, with_children
from lagrange_cli.expression.syntax import (
    Binary,
    Call,
    ExpressionError,
    Name,
    Negative,
    Span,
    Sum,
    Tree,
    Vector,
    calls,
    children,
    components,
    names,
    plain_names,
    sums,
)
from lagrange_cli.expression.vocabulary import COMPONENTS
from lagrange_cli.records import replace
from lagrange_cli.spec.circles import Group, Groups, Missing, Unsuited, Uses, are_sound, written_in
from lagrange_cli.spec.content import groups_of, in_order, statements
from lagrange_cli.spec.draft import Declared, Draft, Written, WrittenBody
from lagrange_cli.spec.members import indices_of
from lagrange_cli.spec.order import bases_in, dependency_order, uses_of
from lagrange_cli.spec.problems import Problems
from lagrange_cli.spec.recurrence import within
from lagrange_cli.spec.whole import Part, WrittenFamily

LONGEST = 500
"""The most parts of a tree that is put into another, or of one with others in it."""
MOST = 50
"""The most names that may follow from one another."""


def with_turns(
    draft: Draft, sections: tuple[str, ...], sizes: Indices, problems: Problems
) -> tuple[Draft, dict[str, Group]]:
    """The draft without families of these sections that follow from one another in turn, and what these
    are as the file has them, by name. Where that is not possible, or they have mistakes, they remain."""
    section_of, groups = dict[str, str](), dict[str, Group]()
    for key in sections:
        for one in groups_of(draft.sections.get(key, ())):
            if one.name in groups:
                return draft, {}
            section_of[one.name], groups[one.name] = key, one
    found, as_written = dict(draft.sections), dict[str, Group]()
    for circle in circles_of(uses_of(groups)):
        if not groups.keys() >= {*circle} or not are_sound(map(groups.__getitem__, circle), problems):
            return draft, {}
        changed = reduced(circle, groups, sizes)
        if changed is None:
            return draft, {}
        key = section_of[changed.name]
        found[key] = in_order([changed if one.name == changed.name else one for one in groups_of(found[key])])
        as_written |= {name: groups[name] for name in circle}
    return replace(draft, sections=found), as_written


def reduced(circle: list[str], groups: Groups, sizes: Indices) -> Group | None:
    """One of the groups that follow from one another, as it follows from itself alone: the others, which must
    not follow from themselves without it, are eliminated. None where there is none."""
    uses = {one: bases_in(*statements(groups[one])).intersection(circle) for one in circle}
    for one in sorted(circle, key=lambda name: -len(parts_of(groups[name]))):
        others = {name: used - {one} for name, used in uses.items() if name != one}
        order, cycles = dependency_order(others)
        if cycles:
            continue
        found = groups[one]
        try:
            for eliminated in reversed(order):
                found = Substitution(groups, eliminated, sizes).of(found)
        except Missing:
            return None
        except (Unsuited, ExpressionError):
            continue
        return found
    return None


def circles_of(uses: Mapping[str, set[str]]) -> list[list[str]]:
    """The names that follow from one another, two or more at a time; nothing where they are too many."""
    stuck = set(uses) - set(dependency_order(uses)[0])
    users = {name: set[str]() for name in stuck}
    for name in stuck:
        for other in uses[name] & stuck:
            users[other].add(name)
    stuck -= set(dependency_order(users)[0])  # what nothing follows from that is in a circle
    if len(stuck) > MOST:
        return []
    reached, found = {name: reachable(uses, name) for name in uses if name in stuck}, list[list[str]]()
    while reached:
        first = next(iter(reached))
        circle = [one for one in reached if one == first or (one in reached[first] and first in reached[one])]
        for one in circle:
            del reached[one]
        found += [circle] if len(circle) > 1 else []
    return found


def reachable(uses: Mapping[str, set[str]], name: str) -> set[str]:
    """All that something uses, and what that uses."""
    seen, pending = set[str](), [name]
    while pending:
        new = uses.get(pending.pop(), set()) - seen
        seen |= new
        pending += new
    return seen


def parts_of(group: Group) -> tuple[Part[Any], ...]:
    """The parts of a family, or of one that is none."""
    return group.parts if isinstance(group, WrittenFamily) else (Part(group, (), ()),)


class Substitution:
    """Puts what one of the ``groups`` is in place of its name, which is ``eliminated``."""

    def __init__(self, groups: Groups, eliminated: str, sizes: Indices) -> None:
        self.groups, self.eliminated = groups, eliminated
        self.parts = parts_of(groups[eliminated])
        self._uses = Uses({eliminated: groups[eliminated]}, sizes)
        self._counts: dict[str, int] = {}

    def of(self, group: Group) -> Group:
        """A group without the name.

        Raises:
            Unsuited: where that is not possible.
            ExpressionError, Missing: where an index is wrong.
        """
        if not isinstance(group, WrittenFamily):
            found: Written = self._item(group, self._used(group, {}))
            return found
        made = chain.from_iterable(map(self._parts, group.parts))
        return WrittenFamily(group.family, tuple(made), group.order)

    def _parts(self, part: Part[Any]) -> Iterator[Part[Any]]:
        """A part, divided where its members use different parts of the one that is eliminated."""
        alike = self._used_alike(part)
        if alike is not None:
            yield replace(part, item=self._item(part.item, alike))
            return
        used = {place: self._used(part.item, part.values(place)) for place in part.places}
        items = dict[tuple[tuple[int, int], ...], Any]()
        for ranges in boxes(used, part.ranges):
            which = used[tuple(values[0] for values in ranges)]
            key = tuple(sorted(which.items()))
            if key not in items:
                items[key] = self._item(part.item, which)
            yield Part(items[key], part.indices, ranges, part.keyed)

    def _used_alike(self, part: Part[Any]) -> dict[int, int] | None:
        """Which part each use of the name stands for, by their ids, for all members of a part at once; None
        where they have to be looked at one by one."""
        tree, found = written_in(part.item).tree, dict[int, int]()
        if any(True for _ in sums(tree)) or calls(tree, ("where",)):
            return None
        indices: dict[str, Whole] = {**self._uses.sizes, **indices_of(part)}
        for name in names(tree):
            if name.base != self.eliminated:
                continue
            try:
                places = [integers(one, indices) for one in name.indices]
            except NotWhole:
                return None
            fit = [k for k, one in enumerate(self.parts) if has_all(one, places, part.count)]
            if not fit:
                return None
            found[id(name)] = fit[0]
        return found

    def _used(self, item: Written, indices: Indices) -> dict[int, int]:
        """The same for one member."""
        found = dict[int, int]()
        for name, place in self._uses.of(item, indices):
            which = next((k for k, part in enumerate(self.parts) if fits(part, place)), None)
            if which is None or found.setdefault(id(name), which) != which:
                raise Unsuited
        return found

    def _item(self, item: Written, which: Mapping[int, int]) -> Any:
        """An item without the name, which may be any of its parts where no member uses it: in a branch that
        is not taken."""

        value, offsets = written_in(item), dict[int, int]()

        def change(one: Tree, made: tuple[Tree, ...]) -> Tree:
            nonlocal value
            if isinstance(one, Name) and one.base == self.eliminated:
                number = which.get(id(one), 0)
                if number not in offsets:
                    offsets[number] = len(value.whole)
                    value = value.followed_by(written_in(self.parts[number].item))
                return self._meaning(one, self.parts[number], offsets[number])
            return with_children(one, made)

        tree = limited(rebuilt(value.tree, change))
        value = replace(value, tree=tree)
        if isinstance(item, Declared):
            return replace(item, fields={**item.fields, "value": value})
        return replace(item, **{"position" if isinstance(item, WrittenBody) else "value": value})

    def _meaning(self, name: Name, part: Part[Any], offset: int) -> Tree:
        """What the name stands for, of which the text is at this ``offset`` of that where the name is."""
        tree, component = limited(written_in(part.item).tree), name.identifier.partition(".")[2]
        if component:
            if component not in COMPONENTS:
                raise Unsuited
            tree = self._component(tree, COMPONENTS.index(component))
        given = {index: one for index, one in zip(part.indices, name.indices) if index}
        taken = given.keys() | {one for index in name.indices for one in plain_names(index)}
        if any(one.index in taken for one, _ in sums(tree)):
            raise Unsuited  # an index would be taken for another
        return placed(tree, given, offset)

    def _component(self, tree: Tree, axis: int) -> Tree:
        """A component of a vector."""
        if isinstance(tree, Vector) and axis < len(tree.items):
            return tree.items[axis]
        if isinstance(tree, Name) and self._count(tree) > axis:
            return replace(tree, identifier=f"{tree.identifier}.{COMPONENTS[axis]}")
        if isinstance(tree, Negative | Sum | Binary) or (isinstance(tree, Call) and tree.function == "where"):
            given = [(one, components(one, self._count) > 1) for one in children(tree)]
            if any(several for _, several in given):
                made = (self._component(one, axis) if several else one for one, several in given)
                return with_children(tree, tuple(made))
        raise Unsuited

    def _count(self, name: Name) -> int:
        """How many components a name has, as far as its form shows."""
        if "." in name.identifier or name.identifier not in self.groups:
            return 1
        if name.identifier not in self._counts:
            self._counts[name.identifier] = 0
            trees = [limited(written_in(one.item).tree) for one in parts_of(self.groups[name.identifier])]
            self._counts[name.identifier] = max(components(one, self._count) for one in trees)
        return self._counts[name.identifier]


def limited(tree: Tree) -> Tree:
    """A tree that is not too large. Raises ``Unsuited`` for another."""
    if size_of(tree) > LONGEST:
        raise Unsuited
    return tree


def fits(part: Part[Any], place: tuple[int, ...]) -> bool:
    """Whether a part has a member at a place."""
    return len(place) == len(part.ranges) and part.has(place)


def has_all(part: Part[Any], places: Sequence[Whole], count: int) -> bool:
    """Whether it has members at all of so many places."""
    return len(places) == len(part.ranges) and bool(np.all(within(part, places, count)))


def placed(tree: Tree, given: Mapping[str, Tree], offset: int) -> Tree:
    """A tree whose text is moved to this ``offset``, with others in place of indices."""

    def moved(span: Span) -> Span:
        return Span(span.start + offset, span.stop + offset)

    def change(one: Tree, made: tuple[Tree, ...]) -> Tree:
        if isinstance(one, Name) and not one.indices and one.identifier in given:
            return given[one.identifier]
        found = replace(with_children(one, made), span=moved(one.span))
        return replace(found, index_span=moved(found.index_span)) if isinstance(found, Sum) else found

    return rebuilt(tree, change)


def boxes(labels: Mapping[tuple[int, ...], Any], ranges: tuple[range, ...]) -> Iterator[tuple[range, ...]]:
    """Ranges within these, in each of which all places have equal labels."""
    if not ranges:
        yield ()
        return
    rows: dict[int, dict[tuple[int, ...], Any]] = {value: {} for value in ranges[0]}
    for place, label in labels.items():
        rows[place[0]][place[1:]] = label
    start = 0
    for _, alike in groupby(ranges[0], key=lambda value: [*rows[value].values()]):
        own = ranges[0][start : start + len([*alike])]
        start += len(own)
        yield from ((own, *inner) for inner in boxes(rows[own[0]], ranges[1:]))
