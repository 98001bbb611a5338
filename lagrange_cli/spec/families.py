"""Families: the statements of a section become families that know their members, such as ``theta[3]``."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import product
from math import prod
from typing import Any, TypeVar

from lagrange_cli.expression.indices import counted, integer
from lagrange_cli.expression.near import known_hint, near_hint
from lagrange_cli.expression.quantities import is_unit
from lagrange_cli.expression.syntax import Axis, ExpressionError, Name, Tree, parts, plain_names
from lagrange_cli.expression.vocabulary import member_name
from lagrange_cli.limits import way_out, whole
from lagrange_cli.records import dataclass, field, replace
from lagrange_cli.spec.content import in_order
from lagrange_cli.spec.draft import Declared, Draft, Entry, WrittenBody, WrittenEvent
from lagrange_cli.spec.family import Family, Grid, MemberNames, Places, places_of
from lagrange_cli.spec.problems import Problems
from lagrange_cli.spec.sections import SECTIONS
from lagrange_cli.spec.source import Place as FilePlace
from lagrange_cli.spec.whole import Part, WrittenFamily

MAX_MEMBERS = whole("members")
"""Members of all the families of a file but definitions."""
MAX_DEFINED = max(whole("pairs"), MAX_MEMBERS)
"""Members of all families of definitions: ranges, until they are used."""

One = TypeVar("One", Entry, Declared, WrittenEvent, WrittenBody)


def expand(draft: Draft, sizes: Mapping[str, int], problems: Problems) -> Draft:
    """The draft with the members of families, in the order of their indices."""
    expander = _Expander(draft, sizes, problems)
    expanded: dict[str, Any] = {}
    families: dict[str, dict[str, Family]] = {}
    for row in SECTIONS.rows:
        if row.family:
            pieces: Sequence[Any] = draft.sections.get(row.key, ())
            expander.defining = row.key == "definitions"
            expanded[row.key], families[row.key] = expander.section(pieces, row.family == "all")
    transformations = []
    for one in draft.transformations:
        coordinates, own = expander.section(one.coordinates, True)
        entries, _ = expander.section(one.entries, False)
        transformations.append(replace(one, coordinates=coordinates, entries=entries, families=own))
    expanded["transformations"] = tuple(transformations)
    sections = {**draft.sections, **expanded}
    return replace(draft, sections=sections, families=families, indices=tuple(expander.indices))


@dataclass
class _Expander:
    draft: Draft
    """As it is written, for what a name is that is taken for a size."""
    sizes: Mapping[str, int]
    problems: Problems
    indices: list[tuple[str, FilePlace]] = field(default_factory=list)
    """Every index of a key, with its place."""
    members: dict[str, int] = field(default_factory=dict)
    """How many there are so far, of definitions and of all others."""
    defining: bool = False
    """Whether the section at hand is that of definitions."""

    @property
    def most(self) -> int:
        """How many members there may be."""
        return MAX_DEFINED if self.defining else MAX_MEMBERS

    def section(self, entries: Sequence[One], complete: bool) -> tuple[Sequence[One], dict[str, Family]]:
        """The section with members, and what families it has."""
        grouped: dict[str, list[One]] = {}
        for entry in entries:
            grouped.setdefault(entry.name, []).append(entry)
        found: list[One | WrittenFamily[One]] = []
        families: dict[str, Family] = {}
        for name, pieces in grouped.items():
            if not any(piece.key.axes or piece.is_list for piece in pieces):
                found += pieces
                continue
            parts = self._parts(pieces)
            family = None if parts is None else self._family(name, pieces, parts, complete)
            if family is None:
                self.problems.broken.add(name)
                continue
            families[name] = family
            if parts:
                found.append(WrittenFamily(family, tuple(parts)))
        return in_order(found), families

    def _parts(self, pieces: list[One]) -> list[Part[One]] | None:
        """What the pieces give of a family; None where something is wrong."""
        from lagrange_cli.spec.repeated import Taken

        found: list[Part[One]] = []
        taken = Taken[One]()
        axes = len(pieces[0].key.axes)
        for piece in pieces:
            if len(piece.key.axes) != axes or (len(pieces) > 1 and not axes):
                self.problems.add(
                    piece.place,
                    f"'{piece.key.label}' and '{pieces[0].key.label}' have different numbers of indices",
                    "give all members of a family the same number of indices",
                )
                return None
            given = self._piece(piece)
            if given is None:
                return None
            for part, order in given:
                again = taken.again(part, order) if pieces[1:] else None
                if again is not None:
                    place, other = again
                    self.problems.add(
                        piece.place,
                        f"'{member_name(piece.name, place)}' is given twice",
                        f"it is already given in line {other.item.place.line}",
                    )
                    return None
                found.append(part)
        return found

    def _empty(self, piece: One) -> None:
        """Say that a family has no members, at the range of its first piece that is empty."""
        if not piece.key.is_grid:
            self._report(piece, ExpressionError(piece.key.axes[-1].span, "no members", "make a range longer"))
            return
        axis = next(axis for axis in piece.key.axes if axis.index and not counted(axis, self.sizes))
        message = f"empty range{self._shown(axis)}"
        self._report(piece, ExpressionError(axis.span, message, "a family has at least one member"))

    def _piece(self, piece: One) -> list[tuple[Part[One], tuple[range, ...]]] | None:
        """The members that one entry gives, and its ranges as they are written; None where it is wrong. There
        are none where a range is empty, as that of all links but the first in a chain of one."""
        if isinstance(piece, Declared) and piece.is_list:
            return self._list(piece)
        if not piece.key.is_grid:
            return self._some(piece)
        ranges = [self._range(piece, axis) for axis in piece.key.axes]
        known = tuple(one for one in ranges if one is not None)
        if len(known) < len(ranges) or not self._count(piece, prod(map(len, known))):
            return None
        self._note(piece)
        if not all(known):
            return []
        indices = tuple(axis.index for axis in piece.key.axes)
        return [(Part(piece, indices, tuple(map(ascending, known)), piece.key.axes), known)]

    def _note(self, piece: One) -> None:
        self.indices += [(axis.index, piece.at(axis.span)) for axis in piece.key.axes if axis.index]

    def _some(self, piece: One) -> list[tuple[Part[One], tuple[range, ...]]] | None:
        """Members whose indices depend on one another, as ``range(i)`` does, or satisfy conditions."""
        from lagrange_cli.expression.loops import grids

        if any(plain_names(tree) & self.problems.broken for axis in piece.key.axes for tree in axis.trees):
            return None
        try:
            found = grids(piece.key.axes, self.sizes, self.most)
            smallest = min((values[0] for ranges in found for values in ranges), default=0)
            if smallest < 0:
                span = piece.key.axes[0].span
                raise ExpressionError(span, f"negative index {smallest}", "indices count from 0")
        except ExpressionError as error:
            self._report(piece, error)
            return None
        if not self._count(piece, sum(prod(map(len, ranges)) for ranges in found)):
            return None
        self._note(piece)
        indices = tuple(axis.index for axis in piece.key.axes)
        return [(Part(piece, indices, ranges, piece.key.axes), ranges) for ranges in found]

    def _list(self, piece: Declared) -> list[tuple[Part[Declared], tuple[range, ...]]] | None:
        values = piece.fields["value"]
        if piece.key.axes:
            self.problems.add(
                piece.place,
                f"lists as members of the family '{piece.key.label}'",
                f"write '{piece.name}: [...]' for a list, or one expression for each member",
            )
            return None
        if not self._count(piece, len(values)):
            return None
        items = (replace(piece, fields={**piece.fields, "value": value}) for value in values)
        ranges = ((range(i, i + 1),) for i in range(len(values)))
        return [(Part(item, ("",), own), own) for item, own in zip(items, ranges)]

    def _range(self, piece: One, axis: Axis) -> range | None:
        """The values of one index of a key."""
        if any(plain_names(bound) & self.problems.broken for bound in axis.bounds):
            return None
        try:
            if axis.index:
                values = counted(axis, self.sizes)
            else:
                value = integer(axis.bounds[0], self.sizes)
                values = range(value, value + 1)
            smallest = min(values[0], values[-1]) if values else 0  # min would walk through the whole range
            if smallest < 0:
                raise ExpressionError(
                    axis.span, f"negative index {smallest}{self._shown(axis)}", "indices count from 0"
                )
        except ExpressionError as error:
            self._report(piece, error)
            return None
        return values

    def _report(self, piece: One, error: ExpressionError) -> None:
        axes, start = piece.key.axes, error.span.start
        axis = next((one for one in axes if one.span.start <= start < one.span.stop), axes[0])
        before = {one.index for one in axes if one.span.stop < axis.span.start}
        used = frozenset[str]().union(*map(plain_names, axis.trees))
        unknown = sorted(used - self.sizes.keys() - before - ({axis.index} if axis.conditions else set()))
        message, hint = error.message, error.hint
        later = [one.index for one in axes if one.index in unknown]
        if later:
            message, hint = f"the index '{later[0]}' is used before its range", "write its range first"
        elif misplaced := self._misplaced(axis, start):
            message, hint = misplaced
        elif unknown:
            name = unknown[0]
            self.problems.broken.add(name)  # said once
            message = f"unknown size '{name}'"
            hint = near_hint(name, self.sizes) or known_hint(self.sizes) or f"add 'sizes: {{{name}: 10}}'"
            if name.islower() and piece.key.axes == (axis,) and not axis.index:
                size = next(iter(self.sizes), "N")
                hint = f"write {piece.key.name}[{name} in range({size})] for all members"
            elif self._is_parameter(name):
                hint = f"'{name}' is a parameter: declare it under 'sizes' instead"
            if is_unit(name) and not axis.index and not self._is_parameter(name):
                hint += f"; a unit is written '{piece.name}: {{value: 1.0, unit: {name}}}'"
        self.problems.add(piece.at(error.span), f"{message} in '{piece.key.label}'", hint)

    def _misplaced(self, axis: Axis, start: int) -> tuple[str, str] | None:
        """What is wrong with the name that begins at ``start`` in a range or a condition, where the file
        gives it to something else than a size."""
        for tree in axis.trees if axis.index else ():
            for one in parts(tree):
                if not isinstance(one, Name) or one.span.start != start or one.base in self.sizes:
                    continue
                made = "conditions of families compare" if tree in axis.conditions else "ranges are made of"
                hint, role = f"{made} indices and sizes", self._role(one.base)
                if self._is_parameter(one.base) and not one.indices:
                    self.problems.broken.add(one.base)  # said once
                    hint += f": declare '{one.base}' under 'sizes' instead"
                return (f"'{one.base}' is {role}", hint) if role else None
        return None

    def _role(self, name: str) -> str:
        """What a name stands for."""
        from lagrange_cli.spec.roles import role_in_draft  # for mistakes only

        return role_in_draft(self.draft, name)

    def _is_parameter(self, name: str) -> bool:
        return any(one.name == name for one in self.draft.declared("parameters"))

    def _shown(self, axis: Axis) -> str:
        used = frozenset[str]().union(*map(plain_names, axis.bounds))
        shown = [f"{name} = {value}" for name, value in self.sizes.items() if name in used]
        return f" for {', '.join(shown)}" if shown else ""

    def _count(self, piece: One, members: int) -> bool:
        """Add members of the section at hand; whether they are not too many."""
        of, name = ("definitions", "pairs") if self.defining else ("families", "members")
        before = self.members.get(of, 0)
        self.members[of] = before + members
        if before + members > self.most >= before:
            self.problems.add(
                piece.place,
                f"more than {self.most} members in all {of} together",
                f"make the sizes smaller, {way_out(name)}",
            )
        return before + members <= self.most

    def _family(self, name: str, pieces: list[One], parts: list[Part[One]], complete: bool) -> Family | None:
        if not parts and complete:
            self._empty(pieces[0])
            return None
        axes = len(pieces[0].key.axes) or 1
        shape = tuple(max((part.ranges[k][-1] + 1 for part in parts), default=0) for k in range(axes))
        count = sum(part.count for part in parts)
        if count == prod(shape):
            members: Places = Grid(tuple(map(range, shape)))
        else:
            members = places_of([part.ranges for part in parts])
        if complete and count != prod(shape):
            missing = next(place for place in product(*map(range, shape)) if members.number(place) is None)
            self.problems.add(
                pieces[0].place,
                f"the family '{name}' has no member '{member_name(name, missing)}'",
                f"declare all members from 0 on, as in {name}[i in range(N)]",
            )
            return None
        return Family(name, shape, MemberNames(name, members), self._labels(pieces, shape))

    def _labels(self, pieces: list[One], shape: tuple[int, ...]) -> tuple[str, ...]:
        """The axes' names in the output: that of the size they run through, where there is one."""
        labels: list[str] = []
        for k, length in enumerate(shape):
            label = f"index_{length}"
            for piece in pieces:
                bounds: tuple[Tree, ...] = piece.key.axes[k].bounds if piece.key.axes else ()
                bound = bounds[0] if len(bounds) == 1 and piece.key.axes[k].index else None
                if isinstance(bound, Name) and self.sizes.get(bound.identifier) == length:
                    label = bound.identifier
            again = labels.count(label)
            labels.append(f"{label}_{again + 1}" if again else label)
        return tuple(labels)


def ascending(values: range) -> range:
    """The same numbers in ascending order."""
    return values if values.step > 0 else values[::-1]
