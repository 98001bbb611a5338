"""The values that constraints allow for coordinates without initial values: all that are found.

Newton's method is started from many places, the same ones in every run.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import islice
from typing import Any

import numpy as np

from lagrange_cli.model.start.beginnings import beginnings, starts
from lagrange_cli.model.start.dependence import independent
from lagrange_cli.model.start.folds import FLAT, meeting_place
from lagrange_cli.model.start.linear import DENSE, damped, scattered, smallest, steep
from lagrange_cli.model.start.nearest import NEAR, ROUND, Surface, Values
from lagrange_cli.records import dataclass

MOST_CLOSURES = 8
SAME = 1e-6
"""Closures that differ by less, relative to their size, are one."""
ALMOST = 1e-5
"""The largest residual of constraints, relative to their terms, if given values may still be moved."""
ROUNDINGS = 8
"""Roundings by which constraints are off where two closures meet."""
TURN = 2 * math.pi
STEPS = 50
CLEARLY = 1e-5
"""Slopes along each direction, relative to their size, with which all coordinates are determined."""
FEW = 8
"""Places from which a near miss is looked for, and states that leave coordinates open before others are not
looked for: a linkage may fold so that some of it turns freely."""


@dataclass(frozen=True)
class Closures:
    """What was found: ``states`` as a whole, or coordinates that are ``left`` open, by number, if no state
    determines them.

    Where there is no closure, ``best`` is where the constraints are satisfied best.
    """

    states: list[list[float]]
    left: list[int]
    best: list[float] | None = None


def closures(surface: Surface, x: Sequence[float], sizes: Sequence[float]) -> Closures:
    """All values of the surface's unknown coordinates; ``x`` has the others, ``sizes`` are numbers of the
    system, among which the lengths of its parts may be."""
    found: list[list[float]] = []
    best, least = None, math.inf
    loose: list[list[int]] = []
    unknown = list(surface.unknown)
    for begin in beginnings(surface, x, sizes, found):
        state, off = solve(surface, begin)
        if state is None:
            continue
        if off > ALMOST:
            if off < 0.999 * least:
                best, least = state, off
            continue
        left = undetermined(surface, state)
        if left:
            loose.append(left)
            if len(loose) < FEW or found:
                continue
            return Closures([], loose[0])
        if any(alike(surface, state, other) for other in found):
            continue
        state = tidied(surface, state)
        if not any(alike(surface, state, other) for other in found):
            found.append(tidied(surface, where_two_meet(surface, state, ROUNDINGS * ROUND) or state))
        if len(found) >= MOST_CLOSURES:
            break
    if loose and not found:
        return Closures([], loose[0])
    if not found and best is None:
        begins = islice(starts(x, unknown, sizes, len(surface.kept), []), FEW)
        best = next((state for begin in begins if (state := near_miss(surface, begin))), None)
    return Closures(sorted(found), [], best and tidied(surface, best, surface.at(best)[0]))


def near_miss(surface: Surface, begin: Sequence[float]) -> list[float] | None:
    """A place where two closures would meet if given values were slightly different, as of a stretched
    chain whose ends are too far apart by rounding: Newton's method does not converge there."""
    x, unknown = list(begin), {*surface.unknown}
    try:
        for _ in range(STEPS):
            f, rows = surface.at(x)
            mine = [{k: a for k, a in rows[i].items() if k in unknown} for i in surface.kept]
            for k, dx in damped(mine, [float(f[i]) for i in surface.kept], surface.scale).items():
                x[k] += dx
        return where_two_meet(surface, x, ALMOST)
    except (ArithmeticError, np.linalg.LinAlgError):
        return None


def slopes_of(surface: Surface, values: Values) -> list[dict[int, float]]:
    """The slopes of the functions by the unknown coordinates."""
    places = {*surface.unknown}
    return [{k: float(a) for k, a in values[1][i].items() if k in places} for i in surface.kept]


def matrix_of(surface: Surface, values: Values) -> tuple[Any, Any]:
    """The functions and their slopes by the unknown coordinates, as arrays."""
    f, rows = values
    places = {k: place for place, k in enumerate(surface.unknown)}
    matrix = np.zeros((len(surface.kept), len(places)))
    for i, number in enumerate(surface.kept):
        for k, a in rows[number].items():
            if k in places:
                matrix[i, places[k]] = a
    return matrix, np.array([float(f[i]) for i in surface.kept])


def solve(surface: Surface, begin: Sequence[float]) -> tuple[list[float] | None, float]:
    """A place near the one to start from where the constraints are satisfied best, by Gauss and Newton's
    method, and how far they are off, relative to their terms; None where it does not converge."""
    x, last, halved = list(begin), math.inf, 0
    size = max(map(abs, begin), default=1.0) or 1.0
    for _ in range(STEPS):
        try:
            values, all_rows = surface.at(x)
            rows = slopes_of(surface, (values, all_rows))
            f = [float(values[i]) for i in surface.kept]
            step = smallest(rows, [-one for one in f], surface.unknown)
        except (ArithmeticError, np.linalg.LinAlgError):
            return None, math.inf
        if not all(map(math.isfinite, step)):
            return None, math.inf
        length = max(map(abs, step), default=0.0) / size
        halved = halved + 1 if 0.4 < length / last < 0.6 else 0
        factor = 2.0 if halved > 2 else min(1.0, 0.7 / length) if length else 1.0
        for k, dx in zip(surface.unknown, step):
            x[k] += factor * dx
        size = max(size, *map(abs, x))  # values to be found may be much larger than those they depend on
        if length <= ROUND or (length >= last / 2 and last <= NEAR):
            largest = max((abs(a) for row in rows for a in row.values()), default=0.0)
            bound = max((sum(abs(a * x[k]) for k, a in row.items()) for row in rows), default=0.0)
            return x, max(map(abs, f), default=0.0) / (max(bound, largest * size) or size)
        last = length
    return None, math.inf


def undetermined(surface: Surface, state: Sequence[float]) -> list[int]:
    """The unknown coordinates that could change with the constraints still satisfied."""
    here = surface.at(state)
    rows = slopes_of(surface, here)
    largest = max((abs(a) for row in rows for a in row.values()), default=0.0)
    if steep(rows, len(surface.unknown), CLEARLY * largest):
        return []
    matrix, _ = matrix_of(surface, here)
    rank = np.linalg.matrix_rank(matrix, tol=NEAR * max(1e-300, float(np.abs(matrix).max(initial=0.0))))
    if rank == len(surface.unknown):
        return []
    near = list(state)
    for k, one in zip(surface.unknown, scattered(0, len(surface.unknown))):
        near[k] += 0.05 * surface.scale[k] * one  # the slopes may vanish at this place only
    try:
        matrix, _ = matrix_of(surface, surface.at(near))
    except ArithmeticError:
        return []
    _, values, directions = np.linalg.svd(matrix)
    least = NEAR * max(1e-300, float(values.max(initial=0.0)))
    free = directions[int((values > least).sum()) :]
    return [k for k, moves in zip(surface.unknown, np.abs(free).max(axis=0, initial=0.0)) if moves > NEAR]


def where_two_meet(surface: Surface, state: list[float], unit: float) -> list[float] | None:
    """The place near a closure at which it meets another one, to all digits, if the constraints are
    satisfied there with errors of ``unit`` of their terms."""

    def values(x: Any) -> tuple[Any, Any]:
        matrix, f = matrix_of(surface, surface.at(placed(x)))
        return matrix / norms[:, None], f / norms

    def placed(x: Any) -> list[float]:
        moved = dict(zip(surface.unknown, x.tolist()))
        return [moved.get(k, one) for k, one in enumerate(state)]

    size = max(map(abs, state), default=1.0) or 1.0
    here = surface.at(state)
    lengths = [math.hypot(*map(float, here[1][i].values())) or 1.0 for i in surface.kept]
    rows = [{k: a / x for k, a in row.items()} for row, x in zip(slopes_of(surface, here), lengths)]
    if steep(rows, len(surface.unknown), FLAT):
        return None
    norms = np.array(lengths)
    found = meeting_place(values, np.array([state[k] for k in surface.unknown]), size)
    return placed(found) if found is not None and satisfied(surface, placed(found), unit) else None


def tidied(
    surface: Surface, state: list[float], off: Any = (), flat: float = NEAR, unit: float = NEAR
) -> list[float]:
    """0 in place of rounding errors, parts of the scale that are as ``flat``, and angles from -pi to pi: all
    at once, or else one by one of a few. The constraints are ``off`` by these values, or satisfied, with
    errors of ``unit`` of their terms."""
    tidy: dict[int, float] = {}
    for k in surface.unknown:
        turns = round(state[k] / TURN)
        if abs(state[k]) <= flat * surface.scale[k]:
            tidy[k] = 0.0
        elif turns:
            tidy[k] = state[k] - TURN * turns
    many = [tidy.get(k, x) for k, x in enumerate(state)]
    if not tidy or satisfied(surface, many, unit, off):
        return many
    for k, one in tidy.items() if len(surface.unknown) <= DENSE else ():
        changed = [*state[:k], one, *state[k + 1 :]]
        if satisfied(surface, changed, unit, off):
            state = changed
    return state


def satisfied(surface: Surface, state: Sequence[float], unit: float = NEAR, off: Any = ()) -> bool:
    """Whether a state is a solution, with errors of ``unit`` of the terms, or is ``off`` by these values."""
    try:
        values, rows = surface.at(state)
    except ArithmeticError:
        return False
    return all(
        abs(float(values[i] - off[i] if len(off) else values[i]))
        <= unit * sum(abs(float(a)) * surface.scale[k] for k, a in rows[i].items())
        for i in surface.kept
    )


def alike(surface: Surface, one: Sequence[float], other: Sequence[float]) -> bool:
    """Whether two closures are the same."""
    return all(abs(one[k] - other[k]) <= SAME * max(surface.scale[k], abs(one[k])) for k in surface.unknown)


def determined(rows: Sequence[Any], unknown: Sequence[int], scale: Sequence[float]) -> list[int]:
    """The rows that are independent as functions of the unknown coordinates alone."""
    inner = set(unknown)
    return independent([{k: a for k, a in row.items() if k in inner} for row in rows], scale)
