"""The bounds of names whose indices are known for all terms of a sum at once."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from functools import lru_cache
from math import prod
from typing import Any, Protocol

import numpy as np

from lagrange_cli.expression.bounds import Bounds
from lagrange_cli.expression.index_arrays import FARTHEST, Differ, Places, Whole, flat
from lagrange_cli.expression.indices import Unsuited
from lagrange_cli.expression.many_bounds import Many, Various, chosen, various
from lagrange_cli.expression.vocabulary import BODY_COMPONENTS, COMPONENTS, VELOCITY_COMPONENTS
from lagrange_cli.spec import family as families
from lagrange_cli.spec.family import Blocks, Family, Grid, Listed, MemberNames
from lagrange_cli.spec.kinds import Meaning
from lagrange_cli.spec.meanings import Settled, has_some, largest, scalar
from lagrange_cli.spec.whole import Part


class Table(Protocol):
    """The interface of the table of names (``spec.names``)."""

    table: dict[str, Meaning]
    values: Settled

    def alike(self, name: str) -> Any: ...


def bounds_of(names: Table, identifier: str, places: list[Whole], count: int) -> Any:
    """The bounds of a (dotted) name, with the ``places`` of its indices in each of ``count`` terms.

    Raises ``Unsuited`` where a member does not exist, or more has to be known of each.
    """
    name, _, component = identifier.partition(".")
    if name not in names.table:
        raise Unsuited
    family = names.table[name].family
    if family is None:
        if places or name not in names.values or names.values[name] is None:
            raise Unsuited
        value = names.values[name]
    else:
        which = members_at(family, flat(places, family.shape, count))
        value = names.alike(name)
        if value is None:
            value = numbers_at(names.values, family, which)
    return component_of(value, component) if component else value


def component_of(value: Any, component: str) -> Any:
    """The bounds of a component. Raises ``Unsuited`` where there is none of this name."""
    if component in BODY_COMPONENTS:
        return scalar()
    known = COMPONENTS + VELOCITY_COMPONENTS
    if component not in known or not isinstance(value, tuple) or known.index(component) % 3 >= len(value):
        raise Unsuited
    return value[known.index(component) % 3]


def numbers_at(values: Settled, family: Family, which: Places) -> Any:
    """The bounds of some members of a family whose numbers are known, and are written alike."""
    found = values.of_family(family)
    if found is None or any(one is None for one in found):
        raise Unsuited
    value = chosen(found[0] if len(found) == 1 else gathered([*map(values.get, family.members)]), which)
    for one in value if isinstance(value, tuple) else (value,):
        if isinstance(one, Various):
            raise Differ(one.labels)
    return value


def gathered(bounds: Sequence[Any]) -> Any:
    """The bounds of members together that have been found one by one. Raises ``Unsuited`` where a number is
    known of some of them only, or they differ in kind."""
    if any(isinstance(one, tuple) for one in bounds):
        if len({len(one) if isinstance(one, tuple) else 0 for one in bounds}) > 1:
            raise Unsuited
        return tuple(map(gathered, zip(*bounds)))
    numbers = [one.value for one in bounds]
    found = largest([Bounds(None, one.size, one.depth, one.kind) for one in bounds])
    if None not in numbers:
        return Many(np.array(numbers), found)
    if any(number is not None for number in numbers) or any(map(has_some, bounds)):
        raise Unsuited
    return found


def shares(
    family: Family, settled: Sequence[tuple[Sequence[Part[Any]], Any]]
) -> Iterator[tuple[Part[Any] | None, Any]]:
    """The bounds that have been found together for members of these parts, one part after the other, as those
    of each part, or of the whole family (None) in the order of its members."""
    count = sum(part.count for parts, _ in settled for part in parts)
    if count == len(family.members) and prod(family.shape) < FARTHEST:
        numbers = [np.concatenate([numbers_of(family, part) for part in parts]) for parts, _ in settled]
        if len(settled) == 1:
            yield None, chosen(settled[0][1], np.argsort(numbers[0]))
            return
        value = various([(one, own) for (_, one), own in zip(settled, numbers)], count)
        if value is not None:
            yield None, value
            return
    for parts, value in settled:
        ends = np.cumsum([part.count for part in parts])
        for part, end in zip(parts, ends):
            yield part, chosen(value, np.arange(end - part.count, end))


def indices_of(part: Part[Any]) -> dict[str, Places]:
    """The values that each index has for the members of a part of a family, (members,)."""
    axes = [np.arange(one.start, one.stop, one.step, dtype=np.int64) for one in part.ranges]
    values = np.meshgrid(*axes, indexing="ij")
    return {name: one.ravel() for name, one in zip(part.indices, values) if name}


def indices_of_all(parts: Sequence[Part[Any]]) -> dict[str, Places]:
    """The same for the members of parts that have the same indices, one part after the other."""
    found = [*map(indices_of, parts)]
    return {name: np.concatenate([one[name] for one in found]) for name in found[0]}


def numbers_of(family: Family, part: Part[Any]) -> Places:
    """Which members of a family those of a part are, in the order of their places (members,)."""
    if part.count == len(family.members):
        return np.arange(part.count)
    return members_at(family, grid_places(Grid(part.ranges), family.shape))


def members_at(family: Family, which: Places) -> Places:
    """Which members of a family are at flat places. Raises ``Unsuited`` where there is none, or where places
    are too far apart to be numbered."""
    if family.complete:
        return which
    if prod(family.shape) >= FARTHEST:
        raise Unsuited
    assert isinstance(family.members, MemberNames)
    known = flat_places(family.members.places, family.shape)
    found = np.minimum(np.searchsorted(known, which), len(known) - 1)
    if np.any(known[found] != which):
        raise Unsuited
    return found


@lru_cache(maxsize=64)
def flat_places(places: families.Places, shape: tuple[int, ...]) -> Places:
    """Places as one number each, the last index fastest (places,)."""
    if isinstance(places, Listed):
        return np.array(np.ravel_multi_index(tuple(np.array([*places]).T), shape), dtype=np.int64)
    if isinstance(places, Blocks):
        return np.concatenate([grid_places(one, shape) for one in places.parts])
    return grid_places(places, shape)


def grid_places(places: Grid, shape: tuple[int, ...]) -> Places:
    """The same of a grid."""
    found = np.zeros(1, dtype=np.int64)
    for values, size in zip(places.ranges, shape):
        found = (found[:, None] * size + np.arange(values.start, values.stop, values.step)).ravel()
    return found
