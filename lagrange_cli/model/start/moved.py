"""Given values are moved to the nearest ones that satisfy the constraints, if these are near enough.

That is: by little beside the size of the system, a mean over its coordinates, and beside the lengths within
which the slopes of constraints change.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Iterable, Sequence
from contextlib import suppress
from functools import partial
from typing import Any

from lagrange_cli.expression.vocabulary import velocity_name
from lagrange_cli.model.start.closures import ROUNDINGS, SAME, tidied
from lagrange_cli.model.start.dependence import independent
from lagrange_cli.model.start.given_masses import GivenMasses
from lagrange_cli.model.start.linear import DENSE, steepness
from lagrange_cli.model.start.missing import MOST, begins
from lagrange_cli.model.start.nearest import NEAR, ROUND, Surface
from lagrange_cli.model.start.search import SLIGHTLY, Search, away
from lagrange_cli.portions import portion
from lagrange_cli.records import replace

FEW = 10
PATIENCE = 20
"""Rounds of Newton's method without progress after which it ends, of many coordinates."""
IDLE = 20
"""Searches in a row without another state, after which there are no others."""
FLAT = 1e-12
"""The part of its scale that is left of a coordinate that is 0, where the distance hardly changes with it."""
CRAWLS = 3
"""Searches that end before they arrive, and are more by this than others, after which there are no more. A
linkage that is stretched as far as it goes is singular: it is approached slowly from everywhere."""
TURNS = 3
"""Searches in the masses at the place that was found."""
ASIDE, SIDES = 0.5, 4
"""How far aside of a state other searches begin, as a part of the way to the point that was found, and in how
many directions and their opposites; in one, of more coordinates than a ``FEW``."""


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
    free = search.given.open_v if speeds else search.given.open_q
    if len(x) > DENSE:
        surface = replace(surface, patience=PATIENCE)
        if not search.given.forced:
            surface = replace(surface, descents=0)  # what is not slightly off is refused
    begin = None
    if search.known is not None:
        begin = [0 * one + other for one, other in zip(x, search.known.v if speeds else search.known.q)]
    with portion(1 + 2 * sides(x) * search.given.forced):
        near = tried(partial(surface.nearest, begin=begin), x)
    if near is not None and off(near) > NEAR:
        near = None
    if near is not None:
        by = math.sqrt(len(x)) * far(x, near, scale, free)
        if begin is not None or max(by, bent(surface, x, near, search.typical(scale))) <= SLIGHTLY:
            return near
    if not speeds:
        refusal.check_directions(surface.at(x)[0])
    found = [] if near is None else [near]
    if not speeds and (len(x) <= DENSE or search.given.forced):  # speeds are linear
        found = equally_near(search, surface, x, near, off)
    if not found:
        steep = steepness(surface.at(x)[1], scale)
        flat = [i for i, (one, usual) in enumerate(zip(steep, search.typical(scale))) if one <= NEAR * usual]
        raise refusal.contradiction(*surface.at(x), scale, flat, speeds=speeds)
    if search.given.forced and len(found) == 1:
        return found[0]
    if search.given.forced:
        raise refusal.equally_near([dict(enumerate(map(float, one))) for one in found])
    names = [*map(velocity_name, search.coordinates)] if speeds else search.coordinates
    moves = [told(names, x, one, scale) for one in found] if surface.descents else []
    unknown = [] if speeds else sorted(free)
    raise refusal.far_off(*surface.at(x), scale, moves, x, unknown, speeds=speeds)


def equally_near(
    search: Search,
    surface: Surface,
    x: Sequence[Any],
    near: list[Any] | None,
    off: Callable[[Sequence[Any]], float],
) -> list[list[Any]]:
    """The nearest points of a surface, of which there may be several; how far constraints are ``off`` tells
    others from these.

    The point ``near``, or none, is where the search from ``x`` itself ended. By symmetry this may be one
    where the distance is not the least, such as (0, 0) for x y = 0 from (1, 1). Searches from all sides of
    ``x``, and with all kinds of values that are not given, leave it.
    """
    scale, typical = surface.scale, search.typical(surface.scale)
    free = search.given.open_q
    part = ASIDE * (1.0 if near is None else far(x, near, scale, free)) / math.sqrt(len(x))
    found = [] if near is None else [plain(surface, near, free)]
    places: Iterable[list[Any]] = (
        away(x, scale, number, side) for number in range(sides(x)) for side in (part, -part)
    )
    if free:
        places = begins(search, x, scale, part or ASIDE, found)
    idle, crawls = 0, 0
    with portion(MOST if free else 2 * sides(x)) as work:
        for done, begin in enumerate(places):
            if idle > IDLE or crawls >= CRAWLS:
                break
            work.reach(done)
            idle += 1
            with suppress(ArithmeticError):
                kept = independent(surface.at(begin)[1], scale, typical)
                aside = replace(surface, kept=kept)
                one = aside.nearest(x, begin)
                if one is not None:
                    crawls += 1 if aside.slide(x, one)[1] > SAME else -1
                one = one and plain(aside, one, free)
                new = one is not None and all(far(one, other, scale) > SAME for other in found)
                if one is not None and new and off(one) <= NEAR:
                    found.append(one)
                    idle = 0
    gaps = [surface.gap(x, one) for one in found]
    if free and crawls < CRAWLS:
        own = [in_own_metric(search, surface, x, one) for one in found]
        gaps, found = [gap for gap, _ in own], [one for _, one in own]
    metric = surface.metric or surface.masses
    whole = max(float(m) * size**2 for m, size in zip(metric.diagonal(len(x)), scale))
    least = min(gaps, default=0.0) * (1 + SAME) + NEAR**2 * whole
    best: list[list[Any]] = []
    for gap, one in zip(gaps, found):
        if gap <= least and all(far(one, other, scale) > SAME for other in best):
            best.append(one)
    for k, values in enumerate(zip(*best)):
        if max(values) - min(values) <= SAME * scale[k]:
            for one in best:
                one[k] = 0.0 if abs(values[0]) <= ROUND * scale[k] else values[0]
    return sorted(best)


def in_own_metric(
    search: Search, surface: Surface, x: Sequence[Any], near: list[Any]
) -> tuple[float, list[Any]]:
    """The nearest point next to another one with the masses that the system has there, and the square of its
    distance: masses may depend on the coordinates that are not given."""
    for _ in range(TURNS):
        before = near
        place = [near[k] if k in search.given.open_q else one for k, one in enumerate(x)]
        _, masses = search.metric(place)
        kept = independent(surface.at(near)[1], surface.scale, search.typical(surface.scale))
        metric = GivenMasses(masses, search.given.open_q, surface.scale)
        surface = replace(surface, kept=kept, masses=masses, metric=metric)
        near = tried(partial(surface.nearest, begin=before), place) or before
        if far(before, near, surface.scale) <= NEAR:
            break
    return surface.gap(x, near), plain(surface, near, search.given.open_q)


def plain(surface: Surface, x: list[Any], free: Collection[int]) -> list[Any]:
    """The same state, without full turns of ``free`` coordinates, and 0 in place of rounding errors."""
    return tidied(replace(surface, unknown=sorted(free)), x, flat=FLAT, unit=ROUNDINGS * ROUND)


def sides(x: Sequence[Any]) -> int:
    """In how many directions, and their opposites, searches begin aside of a state."""
    return SIDES if len(x) <= FEW else 1


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


def far(
    before: Sequence[Any], after: Sequence[Any], scale: Sequence[float], free: Collection[int] = ()
) -> float:
    """The largest part of its scale that a value is moved by, without those that are ``free``."""
    parts = (abs(float(b - a)) / size for a, b, size in zip(before, after, scale))
    return max((part for k, part in enumerate(parts) if k not in free), default=0.0)
