"""Families: quantities of one name, told apart by indices. Members are named where they are asked for."""

from __future__ import annotations

from abc import abstractmethod
from bisect import bisect_right
from collections.abc import Iterator, Sequence
from itertools import accumulate, chain, pairwise, product
from math import prod
from typing import Any, TypeAlias, TypeVar, overload

from lagrange_cli.expression.vocabulary import member_name
from lagrange_cli.records import dataclass, replace

Place: TypeAlias = "tuple[int, ...]"
"""The values of a member's indices."""


T_co = TypeVar("T_co", covariant=True)


class Made(Sequence[T_co]):
    """A sequence whose items are made where they are asked for."""

    __slots__ = ()

    @abstractmethod
    def nth(self, number: int) -> T_co:
        """The item of this number, from 0 on."""

    @overload
    def __getitem__(self, number: int) -> T_co: ...
    @overload
    def __getitem__(self, number: slice) -> Sequence[T_co]: ...
    def __getitem__(self, number: Any) -> Any:
        wanted = range(len(self))[number]
        return [self.nth(k) for k in wanted] if isinstance(wanted, range) else self.nth(wanted)


class LikeTuple(Made[T_co]):
    """One that is equal to tuples of the same items, and to others of its kind."""

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, (tuple, type(self))):
            return NotImplemented
        return len(self) == len(other) and all(one == two for one, two in zip(self, other))

    def __hash__(self) -> int:
        return hash(tuple(self))

    def __repr__(self) -> str:
        return repr(tuple(self))


class Grid(Made[Place]):
    """All combinations of the values of some indices in order, the last index fastest. The ``ranges``
    ascend."""

    __slots__ = ("_count", "ranges")

    def __init__(self, ranges: tuple[range, ...]) -> None:
        self.ranges, self._count = ranges, prod(map(len, ranges))

    def __len__(self) -> int:
        return self._count

    def nth(self, number: int) -> Place:
        rest = number
        place: list[int] = []
        for values in reversed(self.ranges):
            rest, own = divmod(rest, len(values))
            place.append(values[own])
        return tuple(reversed(place))

    def __iter__(self) -> Iterator[Place]:
        return product(*self.ranges)

    def number(self, place: Place) -> int | None:
        """Which one it is, counted from 0; None where it is none of them."""
        if len(place) != len(self.ranges):
            return None
        found = 0
        for value, values in zip(place, self.ranges):
            if value not in values:
                return None
            found = found * len(values) + (value - values.start) // values.step
        return found


class Listed(Made[Place]):
    """Places one by one, where they are no grid."""

    def __init__(self, places: Sequence[Place]) -> None:
        self._places = tuple(places)
        self._numbers = {place: number for number, place in enumerate(self._places)}

    def __len__(self) -> int:
        return len(self._places)

    def nth(self, number: int) -> Place:
        return self._places[number]

    def number(self, place: Place) -> int | None:
        """Which one it is, counted from 0; None where it is none of them."""
        return self._numbers.get(place)


class Blocks(Made[Place]):
    """The places of several grids, each of which ends before the next one begins."""

    def __init__(self, parts: Sequence[Grid]) -> None:
        self.parts = parts
        self._first = [part[0] for part in parts]
        self._before = [0, *accumulate(map(len, parts))]

    def __len__(self) -> int:
        return self._before[-1]

    def nth(self, number: int) -> Place:
        k = bisect_right(self._before, number) - 1
        return self.parts[k].nth(number - self._before[k])

    def __iter__(self) -> Iterator[Place]:
        return chain.from_iterable(self.parts)

    def number(self, place: Place) -> int | None:
        """Which one it is, counted from 0; None where it is none of them."""
        k = bisect_right(self._first, place) - 1
        found = self.parts[k].number(place) if k >= 0 else None
        return None if found is None else self._before[k] + found


Places: TypeAlias = "Grid | Blocks | Listed"


def places_of(parts: Sequence[tuple[range, ...]]) -> Places:
    """The places of several grids in ascending order; none is in two of them."""
    made = sorted(map(Grid, parts), key=lambda one: one[0])
    if len(made) == 1:
        return made[0]
    if all(one[-1] < other[0] for one, other in pairwise(made)):
        return Blocks(made)
    return Listed(sorted(chain.from_iterable(made)))


class MemberNames(LikeTuple[str]):
    """The names of the members of the family ``base``, at these ``places``: ``u[0,0]``, ``u[0,1]`` and so
    on."""

    def __init__(self, base: str, places: Places) -> None:
        self.base, self.places = base, places
        self._all: list[str] | None = None

    def __len__(self) -> int:
        return len(self.places)

    def nth(self, number: int) -> str:
        return member_name(self.base, self.places[number])

    def __iter__(self) -> Iterator[str]:
        if self._all is None:
            self._all = self._listed()
        return iter(self._all)

    def _listed(self) -> list[str]:
        if not isinstance(self.places, Grid):
            return [member_name(self.base, place) for place in self.places]
        *outer, last = self.places.ranges
        ends = [f"{i}]" for i in last]
        begins = ["".join(map("{},".format, place)) for place in product(*outer)]
        return [f"{self.base}[{begin}{end}" for begin in begins for end in ends]

    def __contains__(self, name: object) -> bool:
        return isinstance(name, str) and self.number(name) is not None

    def __eq__(self, other: object) -> bool:
        if isinstance(other, MemberNames) and self.places is other.places:
            return self.base == other.base
        if (
            isinstance(other, MemberNames)
            and isinstance(self.places, Grid)
            and isinstance(other.places, Grid)
        ):
            return self.base == other.base and self.places.ranges == other.places.ranges
        return super().__eq__(other)

    __hash__ = LikeTuple.__hash__

    def place(self, name: str) -> Place | None:
        """The indices in a member's name; None where it is none."""
        inner = name[len(self.base) + 1 : -1]
        if not name.startswith(self.base + "[") or not name.endswith("]"):
            return None
        try:
            place = tuple(map(int, inner.split(",")))
        except ValueError:
            return None
        return place if ",".join(map(str, place)) == inner and self.places.number(place) is not None else None

    def number(self, name: str) -> int | None:
        """Which member has this name; None where none has."""
        place = self.place(name)
        return None if place is None else self.places.number(place)


@dataclass(frozen=True)
class Family:
    """Quantities of one name: ``members`` are called ``u[0,0]``, ``u[0,1]`` and so on, the last index
    fastest, and ``shape`` says how far each index runs. ``axes`` are the indices' names in the output."""

    name: str
    shape: tuple[int, ...]
    members: Sequence[str]
    axes: tuple[str, ...]

    @property
    def label(self) -> str:
        """The family as it is called in texts: ``u[i,j]``."""
        return member_name(self.name, "ijklmn"[: len(self.shape)]) if self.shape else self.name

    def hint(self, name: str) -> str:
        """The range of its members, as a hint where another was used."""
        if "-" in name:
            return "indices count from 0; write u[(i - 1) % N] for a ring"
        if not self.members:
            return f"'{self.label}' has no members for these sizes"
        first, last = self.members[0], self.members[-1]
        return f"the only member is {first}" if first == last else f"the members are {first} to {last}"

    def renamed(self, name: str) -> Family:
        """A family with the same indices."""
        assert isinstance(self.members, MemberNames)
        return replace(self, name=name, members=MemberNames(name, self.members.places))

    def number(self, name: str) -> int | None:
        """Which member has this name; None where none has."""
        assert isinstance(self.members, MemberNames)
        return self.members.number(name)

    def place(self, name: str) -> Place | None:
        """The indices of the member of this name; None where none has it."""
        assert isinstance(self.members, MemberNames)
        return self.members.place(name)

    @property
    def places(self) -> Sequence[Place]:
        """The indices of all members, in their order."""
        assert isinstance(self.members, MemberNames)
        return self.members.places

    def at(self, number: int) -> Place:
        """The indices that come to this number, the last index fastest, whether or not there is a member."""
        return Grid(tuple(map(range, self.shape)))[number]

    @property
    def complete(self) -> bool:
        """Whether every index from 0 on has a member."""
        return len(self.members) == prod(self.shape)
