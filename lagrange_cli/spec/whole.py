"""Families of a section as the file has them: what is written once stands for all members, each of which is
made where it is asked for."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping
from itertools import product
from math import prod
from typing import Any, Generic, Protocol, TypeVar

from lagrange_cli.expression.syntax import Axis
from lagrange_cli.records import dataclass
from lagrange_cli.spec.family import Family, Grid, Made, MemberNames, Place


class Template(Protocol):
    """What members of a family can be made of."""

    def member(self, name: str, indices: Mapping[str, int]) -> Any:
        """The one of this name, for these values of the indices."""


T = TypeVar("T", bound=Template)
U = TypeVar("U", bound=Template)
V = TypeVar("V", bound=Any)


@dataclass(frozen=True)
class Part(Generic[T]):
    """Members that are written alike: the ``item``, for all values of its ``indices`` in the ``ranges``. An
    index without a name is a number. ``keyed`` is how the file writes these; where members are missing
    between the ends of the ranges, a key has several parts. Members of lists have no key."""

    item: T
    indices: tuple[str, ...]
    ranges: tuple[range, ...]
    keyed: tuple[Axis, ...] = ()

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

    def of(self, item: V) -> Part[V]:
        """The same members of another item."""
        return Part(item, self.indices, self.ranges, self.keyed)


class WrittenFamily(Made[T]):
    """The members of a family of a section, in the ``order`` of these places if that is not that of their
    names."""

    def __init__(
        self, family: Family, parts: tuple[Part[T], ...], order: tuple[Place, ...] | None = None
    ) -> None:
        assert isinstance(family.members, MemberNames)
        self.family, self.parts, self.order = family, parts, order
        self._names = family.members
        self._made: dict[Place, T] = {}
        """The members that have been asked for."""
        wide = [part for part in parts if part.count > 1]
        self._wide = [part for part in wide if len(part.ranges[0]) > 1]
        self._rows: dict[int, list[Part[T]]] = {}
        """Those that have one first index, by this."""
        for part in wide:
            if len(part.ranges[0]) == 1:
                self._rows.setdefault(part.ranges[0][0], []).append(part)
        self._single = {next(part.places): part for part in parts if part.count == 1}

    @property
    def name(self) -> str:
        """That of the family."""
        return self.family.name

    def __len__(self) -> int:
        return len(self._names)

    def nth(self, number: int) -> T:
        return self.at((self.order or self._names.places)[number])

    def __iter__(self) -> Iterator[T]:
        if self.order is not None or len(self.parts) > 1:
            return map(self.at, self.order or self._names.places)
        return self.of_part(self.parts[0])

    def of_part(self, part: Part[T]) -> Iterator[T]:
        """The members of one part."""
        for place in part.places:
            yield self._made.get(place) or self._make(part, place)

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
        if len(self.parts) == 1:
            return self.parts[0]
        wide = (*self._rows.get(place[0], ()), *self._wide)
        return self._single.get(place) or next(part for part in wide if part.has(place))

    def at(self, place: Place) -> T:
        """The member at a place."""
        return self._made.get(place) or self._make(self.part_at(place), place)

    def _make(self, part: Part[T], place: Place) -> T:
        made: T = part.item.member(f"{self.family.name}[{','.join(map(str, place))}]", part.values(place))
        self._made[place] = made
        return made

    def named(self, name: str) -> T | None:
        """The member of this name; None where there is none."""
        place = self._names.place(name)
        return None if place is None else self.at(place)

    def mapped(self, function: Callable[[T], U]) -> WrittenFamily[U]:
        """What ``function`` makes of every statement."""
        parts = tuple(part.of(function(part.item)) for part in self.parts)
        return WrittenFamily(self.family, parts, self.order)

    def ordered(self, order: tuple[Place, ...]) -> WrittenFamily[T]:
        """The same in another order."""
        return WrittenFamily(self.family, self.parts, None if order == tuple(self._names.places) else order)
