"""The bounds of names whose indices are known for all terms of a sum at once."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, Protocol

import numpy as np

from lagrange_cli.expression.index_arrays import Places, Whole, flat
from lagrange_cli.expression.indices import Unsuited
from lagrange_cli.expression.vocabulary import COMPONENTS, VELOCITY_COMPONENTS
from lagrange_cli.spec.kinds import Meaning
from lagrange_cli.spec.spec import Expression


class Table(Protocol):
    """The interface of the table of names (``spec.names``)."""

    table: dict[str, Meaning]
    values: dict[str, Any]

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
        if np.prod(family.shape, dtype=np.int64) != len(family.members):
            raise Unsuited
        flat(places, family.shape, count)
        value = names.alike(name)
        if value is None:
            raise Unsuited
    if not component:
        return value
    known = COMPONENTS + VELOCITY_COMPONENTS
    if component not in known or not isinstance(value, tuple) or known.index(component) % 3 >= len(value):
        raise Unsuited
    return value[known.index(component) % 3]


def indices_of(members: Sequence[Expression]) -> dict[str, Places]:
    """The values that each index has for the members of a family, which are written alike."""
    return {
        name: np.array([one.indices[name] for one in members], dtype=np.int64) for name in members[0].indices
    }
