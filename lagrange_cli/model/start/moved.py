"""Given values are moved to the nearest ones that satisfy the constraints, if these are near enough.

That is: by little beside the size of the system, a mean over its coordinates, and beside the lengths within
which the slopes of constraints change.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import Any

from lagrange_cli.expression.vocabulary import velocity_name
from lagrange_cli.model.start.linear import steepness
from lagrange_cli.model.start.nearest import NEAR, ROUND, Surface
from lagrange_cli.model.start.search import SLIGHTLY, Search


def moved(
    search: Search,
    surface: Surface,
    x: list[Any],
    off: Callable[[Sequence[Any]], float],
    speeds: bool = False,
) -> list[Any]:
    """Coordinates, or ``speeds``, on the ``surface``: ``x`` itself where it is ``off`` by rounding only.

    Raises:
        SpecError: there is no such point, or it is too far off.
    """
    if off(x) <= 2 * search.unit:
        return x
    scale, refusal = surface.scale, search.refusal
    found = tried(surface.nearest, x)
    if found is None or off(found) > NEAR:
        raise refusal.contradiction(*surface.at(x), scale, speeds=speeds)
    parts = math.sqrt(len(x)) * far(x, found, scale), bent(surface, x, found, search.typical(scale))
    if max(parts) > SLIGHTLY and not search.given.forced:
        names = [*map(velocity_name, search.coordinates)] if speeds else search.coordinates
        raise refusal.far_off(*surface.at(x), scale, told(names, x, found, scale), speeds=speeds)
    return found


def tried(nearest: Callable[[Sequence[Any]], list[Any] | None], x: Sequence[Any]) -> list[Any] | None:
    """The result of ``nearest``; None if it reaches a place where something has no value."""
    try:
        return nearest(x)
    except ArithmeticError:
        return None


def told(
    names: Sequence[str], before: Sequence[Any], after: Sequence[Any], scale: Sequence[float]
) -> list[tuple[str, float]]:
    """The names of values that are moved, and where to."""
    return [
        (name, float(new) if abs(new) > ROUND * size else 0.0)
        for name, old, new, size in zip(names, before, after, scale)
        if abs(float(new - old)) > NEAR * size
    ]


def bent(surface: Surface, before: Sequence[Any], after: Sequence[Any], typical: Sequence[float]) -> float:
    """The largest part of itself by which the slopes of a constraint change: a rod is moved by this part of
    its length, wherever it is and however long a chain it belongs to."""
    rows, others = surface.at(before)[1], surface.at(after)[1]
    changes = [{k: row.get(k, 0.0) - a for k, a in other.items()} for row, other in zip(rows, others)]
    steep = [steepness(some, surface.scale) for some in (changes, rows, others)]
    return max((x / max(sizes) for x, *sizes in zip(*steep, typical) if x), default=0.0)


def far(before: Sequence[Any], after: Sequence[Any], scale: Sequence[float]) -> float:
    """The largest part of its scale that a value is moved by."""
    return max((abs(float(b - a)) / size for a, b, size in zip(before, after, scale)), default=0.0)
