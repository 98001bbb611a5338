"""The bounds of names whose indices are known for all terms of a sum at once."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, Protocol

import numpy as np

from lagrange_cli.expression.index_arrays import Places, Whole, flat
from lagrange_cli.expression.indices import Unsuited
from lagrange_cli.expression.many_bounds import Many
from lagrange_cli.expression.vocabulary import COMPONENTS, VELOCITY_COMPONENTS
from lagrange_cli.spec.family import Family, Grid, MemberNames
from lagrange_cli.spec.kinds import Meaning
from lagrange_cli.spec.meanings import Settled
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
        if not family.complete:
            raise Unsuited
        which = flat(places, family.shape, count)
        value = names.alike(name)
        if value is None:
            value = numbers_at(names.values.of_family(family), which)
    return component_of(value, component) if component else value


def component_of(value: Any, component: str) -> Any:
    """The bounds of a component. Raises ``Unsuited`` where there is none of this name."""
    known = COMPONENTS + VELOCITY_COMPONENTS
    if component not in known or not isinstance(value, tuple) or known.index(component) % 3 >= len(value):
        raise Unsuited
    return value[known.index(component) % 3]


def numbers_at(found: list[Any] | None, which: Places) -> Any:
    """The bounds of some members of a family whose numbers are known, and are written alike."""
    if found is None or len(found) != 1 or found[0] is None:
        raise Unsuited

    def chosen(one: Any) -> Any:
        return Many(one.numbers[which], one) if isinstance(one, Many) else one

    return tuple(map(chosen, found[0])) if isinstance(found[0], tuple) else chosen(found[0])


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
    assert isinstance(family.members, MemberNames)
    places = family.members.places
    if not isinstance(places, Grid):
        return np.array([*map(places.number, part.places)], dtype=np.int64)
    found = np.zeros(1, dtype=np.int64)
    for own, values in zip(part.ranges, places.ranges):
        ranks = (np.arange(own.start, own.stop, own.step) - values.start) // values.step
        found = (found[:, None] * len(values) + ranks).ravel()
    return found
