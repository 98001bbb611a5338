"""Tables of whole numbers that indices are looked up in: of an irregular network, the ends of its bonds."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property
from typing import TYPE_CHECKING, Any

from lagrange_cli.expression.vocabulary import member_name
from lagrange_cli.records import dataclass

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray


@dataclass(frozen=True, eq=False)
class NumberTable:
    """The family ``name`` with all of its ``numbers``, an array with an axis for each index. ``given`` says
    which members there are."""

    name: str
    numbers: NDArray[np.int64]
    given: NDArray[np.bool_]

    @property
    def shape(self) -> tuple[int, ...]:
        """How many values each index has."""
        return self.numbers.shape

    @property
    def extent(self) -> str:
        """The first and the last member, for a message."""
        first, last = (0,) * len(self.shape), [size - 1 for size in self.shape]
        return f"{member_name(self.name, first)} to {member_name(self.name, last)}"

    @property
    def listed(self) -> list[Any]:
        """The numbers as lists, with None where there is none."""
        found = self.numbers.astype(object)
        found[~self.given] = None
        listed: list[Any] = found.tolist()
        return listed

    @property
    def by_place(self) -> dict[int | tuple[int, ...], int]:
        """The numbers by their indices."""
        places = zip(*(one.tolist() for one in self.given.nonzero()))
        return {place if len(place) > 1 else place[0]: int(self.numbers[place]) for place in places}

    @cached_property
    def in_structure(self) -> tuple[str, tuple[int, ...], str]:
        """What identifies it: equations depend on its numbers."""
        from hashlib import sha256

        content = sha256(self.numbers.astype("<i8").tobytes() + self.given.tobytes())
        return self.name, self.shape, content.hexdigest()

    def number(self, place: Sequence[int]) -> int | None:
        """The number at a place; None where there is none."""
        if len(place) != len(self.shape) or not all(0 <= i < n for i, n in zip(place, self.shape)):
            return None
        return int(self.numbers[tuple(place)]) if self.given[tuple(place)] else None
