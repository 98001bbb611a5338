"""Given values are moved to the nearest ones that satisfy the constraints, if these are near enough."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

from lagrange_cli.expression.vocabulary import velocity_name
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
    if far(x, found, scale) > SLIGHTLY and not search.given.forced:
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


def far(before: Sequence[Any], after: Sequence[Any], scale: Sequence[float]) -> float:
    """The largest part of its scale that a value is moved by."""
    return max((abs(float(b - a)) / size for a, b, size in zip(before, after, scale)), default=0.0)
