"""Sections of a file as sequences and mappings of their members, in which families are whole."""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Callable, ItemsView, Iterable, Iterator, Mapping, Sequence, ValuesView
from itertools import chain
from typing import Any, TypeVar

from lagrange_cli.spec.family import LikeTuple, Made
from lagrange_cli.spec.whole import Template, WrittenFamily

T = TypeVar("T", bound=Template)


class Items(LikeTuple[T]):
    """A section in its order: ``groups`` are items of their own and families."""

    def __init__(self, groups: Sequence[T | WrittenFamily[T]]) -> None:
        self.groups = tuple(groups)
        self._starts: list[int] = [0]
        for one in self.groups:
            self._starts.append(self._starts[-1] + (len(one) if isinstance(one, WrittenFamily) else 1))

    def __len__(self) -> int:
        return self._starts[-1]

    def nth(self, number: int) -> T:
        group = bisect_right(self._starts, number) - 1
        one = self.groups[group]
        return one[number - self._starts[group]] if isinstance(one, WrittenFamily) else one

    def __iter__(self) -> Iterator[T]:
        for one in self.groups:
            if isinstance(one, WrittenFamily):
                yield from one
            else:
                yield one


class ByName(Mapping[str, T]):
    """What a section gives by name: ``groups`` has items of their own, and families by theirs."""

    def __init__(self, groups: Mapping[str, T | WrittenFamily[T]]) -> None:
        self.groups = groups

    def __len__(self) -> int:
        return sum(len(one) if isinstance(one, WrittenFamily) else 1 for one in self.groups.values())

    def __getitem__(self, name: str) -> T:
        group = self.groups.get(name.partition("[")[0])
        if isinstance(group, WrittenFamily):
            group = group.named(name)
        elif group is None or "[" in name:
            group = self.groups.get(name)
        if group is None or isinstance(group, WrittenFamily):
            raise KeyError(name)
        return group

    def __contains__(self, name: object) -> bool:
        return isinstance(name, str) and self.get(name) is not None

    def __iter__(self) -> Iterator[str]:
        for name, one in self.groups.items():
            if isinstance(one, WrittenFamily):
                yield from one.names
            else:
                yield name

    def values(self) -> ValuesView[T]:
        return _Values(self)

    def items(self) -> ItemsView[str, T]:
        return _Pairs(self)

    def __repr__(self) -> str:
        return repr(dict(self.items()))


class _Values(ValuesView[T]):
    _mapping: ByName[T]

    def __iter__(self) -> Iterator[T]:
        return iter(Items([*self._mapping.groups.values()]))


class _Pairs(ItemsView[str, T]):
    _mapping: ByName[T]

    def __iter__(self) -> Iterator[tuple[str, T]]:
        return zip(self._mapping, self._mapping.values())


class SectionNames(Made[str]):
    """The names of the items of a section, in which families are whole."""

    def __init__(self, section: Sequence[Any]) -> None:
        self._section = section
        self.bases = {one.name: one for one in groups_of(section)}

    @property
    def starts(self) -> dict[str, int]:
        """The numbers of the items, of families those of their first members."""
        found, first = {}, 0
        for name, one in self.bases.items():
            found[name] = first
            first += len(one) if isinstance(one, WrittenFamily) else 1
        return found

    def __len__(self) -> int:
        return len(self._section)

    def nth(self, number: int) -> str:
        name: str = self._section[number].name
        return name

    def __iter__(self) -> Iterator[str]:
        groups = groups_of(self._section)
        return chain.from_iterable(
            one.names if isinstance(one, WrittenFamily) else (one.name,) for one in groups
        )

    def __contains__(self, name: object) -> bool:
        return isinstance(name, str) and self.item(name) is not None

    def item(self, name: str) -> Any:
        """The item of this name, or None."""
        group = self.bases.get(name.partition("[")[0])
        return group.named(name) if isinstance(group, WrittenFamily) else self.bases.get(name)


def names_of(section: Sequence[Any]) -> SectionNames:
    """The names of its items."""
    return SectionNames(section)


def named_alike(section: Sequence[Any]) -> Iterator[tuple[Any, list[str]]]:
    """Its items with their names; of members of a family that are written alike, one with all names."""
    for one in groups_of(section):
        if isinstance(one, WrittenFamily):
            for part in one.parts:
                yield part.item, [*one.names_of_part(part)]
        else:
            yield one, [one.name]


def bases_of(names: Iterable[str]) -> Iterable[str]:
    """The names, each family once where they are those of a whole section."""
    if isinstance(names, SectionNames):
        return names.bases
    return names.groups if isinstance(names, ByName) else names


def written(section: Mapping[str, T]) -> Iterator[T]:
    """What a section gives; of members of a family that are written alike the first."""
    for one in groups_by_name(section).values():
        yield from firsts(one)


def written_by_family(section: Mapping[str, T]) -> dict[str, list[T]]:
    """The same by the names of families, and of what is none."""
    found: dict[str, list[T]] = {}
    for name, one in groups_by_name(section).items():
        found.setdefault(name.partition("[")[0], []).extend(firsts(one))
    return found


def firsts_of(section: Sequence[T]) -> Iterator[T]:
    """The same of a section that is a sequence."""
    for one in groups_of(section):
        yield from firsts(one)


def firsts(group: T | WrittenFamily[T]) -> Iterator[T]:
    """An item of its own; of a family the first of the members that are written alike."""
    if not isinstance(group, WrittenFamily):
        yield group
    else:
        yield from map(group.at, sorted(next(part.places) for part in group.parts))


def statements(group: T | WrittenFamily[T]) -> list[T]:
    """What is written: an item of its own, or those of a family."""
    return [part.item for part in group.parts] if isinstance(group, WrittenFamily) else [group]


def groups_of(section: Sequence[T]) -> Sequence[T | WrittenFamily[T]]:
    """The items of a section, in which families are whole."""
    return section.groups if isinstance(section, Items) else section


def groups_by_name(section: Mapping[str, T]) -> Mapping[str, T | WrittenFamily[T]]:
    """What a section gives by name, in which families are whole."""
    return section.groups if isinstance(section, ByName) else section


def parts_by_name(groups: Iterable[Any], of: Callable[[Any], Any]) -> dict[str, Any]:
    """What each item has by its name, and each family whole; without those that have none."""
    found: dict[str, Any] = {}
    for one in groups:
        if not isinstance(one, WrittenFamily):
            made = of(one)
            found |= {} if made is None else {one.name: made}
        elif all(of(part.item) is not None for part in one.parts):
            found[one.name] = one.mapped(of)
    return found


def in_order(groups: Sequence[Any]) -> Sequence[Any]:
    """The section that has these groups."""
    return Items(groups) if any(isinstance(one, WrittenFamily) for one in groups) else tuple(groups)


def by_name(groups: Mapping[str, Any]) -> Mapping[str, Any]:
    """The same of what is given by name."""
    whole = any(isinstance(one, WrittenFamily) for one in groups.values())
    return ByName(groups) if whole else dict(groups)


def parted(section: Mapping[str, T], names: Iterable[str]) -> tuple[Mapping[str, T], Mapping[str, T]]:
    """What has one of these ``names``, of families without indices, and all else of a section."""
    chosen, groups = set(names), groups_by_name(section)
    inside = {name: one for name, one in groups.items() if name in chosen}
    outside = {name: one for name, one in groups.items() if name not in chosen}
    return by_name(inside), by_name(outside)
