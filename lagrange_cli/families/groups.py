"""Families as the file has them: whose members are side by side in an array, and how others are written."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from math import prod
from typing import Any, TypeVar

import numpy as np

from lagrange_cli.expression.array_builder import Members
from lagrange_cli.expression.index_arrays import FARTHEST, Differ, Places, distinct, one_if_equal
from lagrange_cli.expression.indices import Unsuited
from lagrange_cli.expression.syntax import Axis, Name, Tree, components
from lagrange_cli.families.arrays import Array, Domain
from lagrange_cli.records import dataclass, field
from lagrange_cli.spec.content import groups_by_name
from lagrange_cli.spec.family import Family, MemberNames
from lagrange_cli.spec.members import flat_places, indices_of, numbers_of
from lagrange_cli.spec.spec import Expression, Spec
from lagrange_cli.spec.whole import Part, Template, WrittenFamily

T = TypeVar("T", bound=Template)

MOST = 10_000_000
"""Places in the table of a family."""


@dataclass(frozen=True, eq=False)
class Rows:
    """A family whose members are side by side in an array."""

    array: Array
    first: int
    family: Family


@dataclass(frozen=True, eq=False)
class Group:
    """A family whose members are written: the ``trees`` that occur, or what else is written, which of them
    each member has, and the values of its indices. ``places`` has the members' places in ascending order,
    the last index fastest; None where there is one everywhere. ``keyed`` says by which ranges and conditions
    the file gives the members of a tree."""

    family: Family
    places: Places | None
    trees: tuple[Any, ...]
    labels: Places
    indices: Mapping[str, Places]
    keyed: Mapping[int, Sequence[Axis]] = field(default_factory=dict)

    @property
    def count(self) -> int:
        return len(self.labels)

    def numbers_at(self, places: Places) -> Places:
        """Which members are at these places, -1 where there is none."""
        if self.places is None:
            return places
        if not len(self.places):
            return np.full_like(places, -1)
        found = np.searchsorted(self.places, places)
        found[found == len(self.places)] = 0
        return np.where(self.places[found] == places, found, -1)

    def members(self, which: Places, sizes: Mapping[str, int], domain: Domain) -> tuple[Any, Members]:
        """The tree of some members, and their indices. Raises ``Differ`` where they have several."""
        labels = self.labels[which]
        if len(labels) and np.any(labels != labels[0]):
            raise Differ(labels)
        values = {name: one_if_equal(one[which]) for name, one in self.indices.items()}
        found = Members(domain, domain.count, {**sizes, **values})
        found.alike = {**sizes, **{name: one[self.labels == labels[0]] for name, one in self.indices.items()}}
        return self.trees[labels[0]], found


def group_of(family: Family, written: Mapping[str, Expression]) -> Group:
    """The members of a family as they are written."""
    return placed_parts(family, parts_of(family, written))


def placed_parts(
    family: Family, given: Sequence[Part[Any]], of: Callable[[Any], Any] = lambda item: item.tree
) -> Group:
    """The members of a family in parts; those in none have the label -1. What is written is ``of`` the items
    of the parts: their trees."""
    parts = [(numbers_of(family, part), part) for part in given]
    parts.sort(key=lambda one: int(one[0].min()))
    seen: dict[int, int] = {}
    labels = np.full(len(family.members), -1, dtype=np.int64)
    names = dict.fromkeys(name for _, part in parts for name in part.indices if name)
    indices = {name: np.zeros(len(family.members), dtype=np.int64) for name in names}
    for numbers, part in parts:
        labels[numbers] = seen.setdefault(id(of(part.item)), len(seen))
        for name, values in indices_of(part).items():
            indices[name][numbers] = values
    trees = {seen[id(of(part.item))]: of(part.item) for _, part in parts}
    keyed = {seen[id(of(part.item))]: part.keyed for _, part in parts if part.keyed}
    whole = tuple(trees[i] for i in range(len(trees)))
    return Group(family, known_places(family), whole, labels, indices, keyed)


def parts_of(family: Family, written: Mapping[str, T]) -> Sequence[Part[T]]:
    """The members of a family by what they have in common. Raises ``Unsuited`` where others are written."""
    found = groups_by_name(written).get(family.name)
    if isinstance(found, WrittenFamily):
        if found.family.members != family.members:
            raise Unsuited
        return found.parts
    if found is None or family.shape:
        raise Unsuited
    return [Part(found, (), ())]


def known_places(family: Family) -> Places | None:
    """The places of a family's members, the last index fastest; None where there is one everywhere. Raises
    ``Unsuited`` where places are too far apart to be numbered."""
    if family.complete:
        return None
    if prod(family.shape) >= FARTHEST:
        raise Unsuited
    assert isinstance(family.members, MemberNames)
    return flat_places(family.members.places, family.shape)


def places_of(family: Family) -> Places:
    """The members' numbers by place, the last index fastest. Raises ``Unsuited`` where members are too far
    apart for a table."""
    size = prod(family.shape)
    if size == len(family.members):
        return np.arange(size)
    if size > MOST:
        raise Unsuited
    found = np.full(size, -1, dtype=np.int64)
    assert isinstance(family.members, MemberNames)
    found[flat_places(family.members.places, family.shape)] = np.arange(len(family.members))
    return found


def among(family: Family, other: Family) -> Places:
    """Which members of another family the members of a family are, (members,)."""
    if family.members == other.members:
        return np.arange(len(family.members))
    return np.array([other.number(name) for name in family.members], dtype=np.int64)


def particle_families(spec: Spec) -> Mapping[str, Family]:
    """The families of particles."""
    return {**spec.families.get("masses", {}), **spec.families.get("embedding", {})}


def alike(one: Group, other: Group, own: Places | None = None) -> Iterator[Places]:
    """The members of a group in parts that are alike in it and in another group, of which they are members,
    too: all, or those of the numbers ``own``."""
    labels = one.labels * (int(other.labels.max()) + 1) + (other.labels if own is None else other.labels[own])
    for label in distinct(labels):
        yield np.flatnonzero(labels == label)


def components_in(tree: Tree, groups: Mapping[str, Group], *within: Group) -> int:
    """How many components an expression has, as far as its form shows; members of groups that it is
    ``within`` say nothing."""

    def of_name(name: Name) -> int:
        group = groups.get(name.identifier)
        if group is None or group in within:
            return 1
        return max(components_in(one, groups, group, *within) for one in group.trees)

    return components(tree, of_name)
