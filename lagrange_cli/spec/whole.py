"""Families of a section as the file has them: what is written once stands for all members, each of which is
made where it is asked for."""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Callable, ItemsView, Iterable, Iterator, Mapping, Sequence, ValuesView
from itertools import chain, product
from math import prod
from typing import Any, Generic, Protocol, TypeVar, overload

from lagrange_cli.records import dataclass
from lagrange_cli.spec.family import Family, Grid, MemberNames, Place


class Template(Protocol):
    """What members of a family can be made of."""

    def member(self, name: str, indices: Mapping[str, int]) -> Any:
        """The one of this name, for these values of the indices."""


T = TypeVar("T", bound=Template)
U = TypeVar("U", bound=Template)


@dataclass(frozen=True)
class Part(Generic[T]):
    """Members that are written alike: the ``item``, for all values of its ``indices`` in the ``ranges``. An
    index without a name is a number."""

    item: T
    indices: tuple[str, ...]
    ranges: tuple[range, ...]

    @property
    def count(self) -> int:
        """The number of its members."""
        return prod(map(len, self.ranges))

    @property
    def axes(self) -> dict[str, range]:
        """The ranges of the indices that have names."""
        return {name: values for name, values in zip(self.indices, self.ranges) if name}

    @property
    def places(self) -> Iterator[Place]:
        """Those of its members, in ascending order."""
        return product(*self.ranges)

    def within(self, other: Part[Any]) -> bool:
        """Whether all of its members are also in another part, as far as the ends and steps show."""
        return all(
            own[0] in values and own[-1] in values and own.step % values.step == 0
            for own, values in zip(self.ranges, other.ranges)
        )

    def has(self, place: Place) -> bool:
        """Whether a member at this place is one of them."""
        return all(value in values for value, values in zip(place, self.ranges))

    def values(self, place: Place) -> dict[str, int]:
        """The values of the indices at a place."""
        return {name: value for name, value in zip(self.indices, place) if name}


class WrittenFamily(Sequence[T]):
    """The members of a family of a section, in the ``order`` of these places if that is not that of their
    names."""

    def __init__(
        self, family: Family, parts: tuple[Part[T], ...], order: tuple[Place, ...] | None = None
    ) -> None:
        assert isinstance(family.members, MemberNames)
        self.family, self.parts, self.order = family, parts, order
        self._names = family.members
        self._wide = [part for part in parts if part.count > 1]
        self._single = {next(part.places): part for part in parts if part.count == 1}

    @property
    def name(self) -> str:
        """That of the family."""
        return self.family.name

    def __len__(self) -> int:
        return len(self._names)

    @overload
    def __getitem__(self, number: int) -> T: ...
    @overload
    def __getitem__(self, number: slice) -> Sequence[T]: ...
    def __getitem__(self, number: Any) -> Any:
        if isinstance(number, slice):
            return [self[k] for k in range(len(self))[number]]
        return self.at((self.order or self._names.places)[number])

    def __iter__(self) -> Iterator[T]:
        if self.order is not None or len(self.parts) > 1:
            return map(self.at, self.order or self._names.places)
        return self.of_part(self.parts[0])

    def of_part(self, part: Part[T]) -> Iterator[T]:
        """The members of one part."""
        base, item = self.family.name, part.item
        for place in part.places:
            yield item.member(f"{base}[{','.join(map(str, place))}]", part.values(place))

    def names_of_part(self, part: Part[T]) -> Iterator[str]:
        """The names of the members of one part."""
        return iter(self._names if len(self.parts) == 1 else MemberNames(self.name, Grid(part.ranges)))

    def numbers_of_part(self, part: Part[T]) -> Iterable[int]:
        """Which members of the family they are."""
        if len(self.parts) == 1:
            return range(len(self))
        return (number for place in part.places if (number := self._names.places.number(place)) is not None)

    @property
    def names(self) -> Iterable[str]:
        """Their names in this order."""
        if self.order is None:
            return self._names
        return (f"{self.family.name}[{','.join(map(str, place))}]" for place in self.order)

    def part_at(self, place: Place) -> Part[T]:
        """The part that the member at a place belongs to."""
        return self._single.get(place) or next(part for part in self._wide if part.has(place))

    def at(self, place: Place) -> T:
        """The member at a place."""
        part = self.part_at(place)
        made: T = part.item.member(f"{self.family.name}[{','.join(map(str, place))}]", part.values(place))
        return made

    def named(self, name: str) -> T | None:
        """The member of this name; None where there is none."""
        place = self._names.place(name)
        return None if place is None else self.at(place)

    def mapped(self, function: Callable[[T], U]) -> WrittenFamily[U]:
        """What ``function`` makes of every statement."""
        parts = tuple(Part(function(part.item), part.indices, part.ranges) for part in self.parts)
        return WrittenFamily(self.family, parts, self.order)

    def ordered(self, order: tuple[Place, ...]) -> WrittenFamily[T]:
        """The same in another order."""
        return WrittenFamily(self.family, self.parts, None if order == tuple(self._names.places) else order)


class Items(Sequence[T]):
    """A section in its order: ``groups`` are items of their own and families."""

    def __init__(self, groups: Sequence[T | WrittenFamily[T]]) -> None:
        self.groups = tuple(groups)
        self._starts: list[int] = [0]
        for one in self.groups:
            self._starts.append(self._starts[-1] + (len(one) if isinstance(one, WrittenFamily) else 1))

    def __len__(self) -> int:
        return self._starts[-1]

    @overload
    def __getitem__(self, number: int) -> T: ...
    @overload
    def __getitem__(self, number: slice) -> Sequence[T]: ...
    def __getitem__(self, number: Any) -> Any:
        if isinstance(number, slice):
            return [self[k] for k in range(len(self))[number]]
        number = range(len(self))[number]
        group = bisect_right(self._starts, number) - 1
        one = self.groups[group]
        return one[number - self._starts[group]] if isinstance(one, WrittenFamily) else one

    def __iter__(self) -> Iterator[T]:
        for one in self.groups:
            if isinstance(one, WrittenFamily):
                yield from one
            else:
                yield one

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, (tuple, Items)):
            return NotImplemented
        return len(self) == len(other) and all(one == two for one, two in zip(self, other))

    def __hash__(self) -> int:
        return hash(tuple(self))

    def __repr__(self) -> str:
        return repr(tuple(self))


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


class SectionNames(Sequence[str]):
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

    @overload
    def __getitem__(self, number: int) -> str: ...
    @overload
    def __getitem__(self, number: slice) -> Sequence[str]: ...
    def __getitem__(self, number: Any) -> Any:
        found = self._section[number]
        return [one.name for one in found] if isinstance(number, slice) else found.name

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


def in_order(groups: Sequence[Any]) -> Sequence[Any]:
    """The section that has these groups."""
    return Items(groups) if any(isinstance(one, WrittenFamily) for one in groups) else tuple(groups)


def by_name(groups: Mapping[str, Any]) -> Mapping[str, Any]:
    """The same of what is given by name."""
    whole = any(isinstance(one, WrittenFamily) for one in groups.values())
    return ByName(groups) if whole else dict(groups)
