"""The structure of a system, from which its equations follow: everything except the numbers of a run."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from lagrange_cli.spec.content import groups_by_name, groups_of
from lagrange_cli.spec.spec import Expression, Family, Spec
from lagrange_cli.spec.whole import WrittenFamily

NUMBERS = frozenset({"parameters", "coordinates"})
"""Only the names of these count: their values are passed to compiled code as it runs."""
OUTSIDE = frozenset(
    {"filename", "text", "name", "description", "solve", "time_unit", "draw", "transformations"}
)
"""These have no part in the equations."""


def structure(spec: Spec) -> dict[str, Any]:
    """The system in terms of JSON, the same for every run that differs in numbers only.

    Whatever field a ``Spec`` has is part of it unless it is known to have no part in the equations.
    """
    return {
        name: [listed(one) for one in groups_of(value)] if name in NUMBERS else plain(value)
        for name, value in vars(spec).items()
        if name not in OUTSIDE
    }


def listed(group: Any) -> Any:
    """Something that only the name of counts of: of a family, the range of each index besides."""
    if not isinstance(group, WrittenFamily):
        return group.name
    return [group.name, *([ends(one) for one in part.ranges] for part in group.parts), group.order]


def ends(values: range) -> list[int]:
    """What a range is made of."""
    return [values.start, values.stop, values.step]


def plain(value: object) -> Any:
    """A field of a ``Spec`` in terms of JSON; an expression is its text, with the values of the indices that
    stand in it: all else follows from these."""
    if isinstance(value, Expression):
        return [value.text, *value.indices.items()] if value.indices else value.text
    if isinstance(value, Family):
        return [value.shape, value.axes]
    parts = getattr(value, "in_structure", None)
    if parts is not None:
        return plain(parts)
    if isinstance(value, WrittenFamily):
        parts = [[plain(one.item), one.indices, [ends(x) for x in one.ranges]] for one in value.parts]
        return [parts, value.order]
    if isinstance(value, Mapping):
        return [[key, plain(inner)] for key, inner in groups_by_name(value).items()]
    if isinstance(value, tuple):
        return [plain(inner) for inner in value]
    if value is None or isinstance(value, (str, int, float)):
        return value
    raise TypeError(f"a {type(value).__name__} has no place in a structure")
