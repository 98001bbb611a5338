"""Some members of a family in blocks: side by side, or at equal distances."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Sequence
from itertools import groupby, product
from math import prod

from lagrange_cli.expression.loops import Ranges, grids_of
from lagrange_cli.spec.family import Family, Place

FEWEST = 4
"""Members of a block that are named together."""


def blocks(family: Family, present: Collection[str]) -> Iterator[tuple[Ranges, Sequence[str]]]:
    """Members of a family that are ``present``, each block with the ranges of its indices; those that are in
    a block of few are left out."""
    if not family.shape:
        return
    kept = {place: name for place, name in zip(family.places, family.members) if name in present}
    for ranges in _grids(sorted(kept)):
        if prod(map(len, ranges)) >= FEWEST:
            yield ranges, [kept[place] for place in product(*ranges)]


def _grids(places: list[Place]) -> Iterator[Ranges]:
    """Places in ascending order in grids; of those with one index, those side by side first."""
    if places and len(places[0]) == 1:
        for _, own in groupby(enumerate([*places]), lambda one: one[1][0] - one[0]):
            row = [place for _, place in own]
            if len(row) >= FEWEST:
                yield (range(row[0][0], row[-1][0] + 1),)
                places = [one for one in places if one not in {*row}]
    if places:
        yield from grids_of([*map(list, places)])


def several(values: range) -> str:
    """``151, ..., 299``, or ``0, 3, ..., 27``."""
    first = values[:1] if values.step == 1 else values[:2]
    return f"{', '.join(map(str, first))}, ..., {values[-1]}"
