"""Members of a family that are given twice, found without a list of all."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import chain
from typing import Generic, TypeVar

from lagrange_cli.spec.draft import Written
from lagrange_cli.spec.family import Place
from lagrange_cli.spec.whole import Part

One = TypeVar("One", bound=Written)


class Taken(Generic[One]):
    """The places of a family that have a member."""

    def __init__(self) -> None:
        self._wide: list[Part[One]] = []
        self._rows: dict[int, list[Part[One]]] = {}
        """Those whose members have one first index, by this."""

    def again(self, part: Part[One], order: tuple[range, ...]) -> tuple[Place, Part[One]] | None:
        """Add the places of a part. The first of them in this ``order`` that was taken before, and what has
        it."""
        first = part.ranges[0]
        rows = first if len(first) < len(self._rows) else [i for i in self._rows if i in first]
        near = chain(self._wide, *(self._rows.get(i, ()) for i in rows))
        others = (other for other in near if other.item is not part.item)  # which gives none twice
        twice = [(place, one) for one in others if (place := first_common(order, one.ranges)) is not None]
        (self._wide if len(first) > 1 else self._rows.setdefault(first[0], [])).append(part)
        ranks = (
            ([values.index(x) for x, values in zip(place, order)], place, other) for place, other in twice
        )
        found = min(ranks, key=lambda one: one[0], default=None)
        return None if found is None else found[1:]


def first_common(order: tuple[range, ...], others: tuple[range, ...]) -> Place | None:
    """The first place, in this order, that some places have in common with others; None if there is none."""
    found = [next(common(one, two), None) for one, two in zip(order, others)]
    return None if None in found else tuple(one for one in found if one is not None)


def common(one: range, other: range) -> Iterator[int]:
    """The numbers in a range that are also in another, which ascends: from where both have begun, the
    differences to the steps of the other come again after as many numbers as its step."""
    if one.step < 0:
        return (-value for value in common(negative(one), negative(other[::-1])))
    first = max(0, -((one.start - other.start) // one.step))
    return (value for value in one[first : first + other.step] if value in other)


def negative(values: range) -> range:
    """The numbers with the other sign."""
    return range(-values.start, -values.stop, -values.step)
