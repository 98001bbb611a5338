"""The values that constraints allow for coordinates without initial values: all that are found.

Newton's method is started from many places, the same ones in every run.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from itertools import islice
from random import Random
from typing import Any

import numpy as np

from lagrange_cli.model.start.folds import meeting_place
from lagrange_cli.model.start.linear import damped, independent, least_squares, scattered
from lagrange_cli.model.start.nearest import NEAR, ROUND, Surface, Values
from lagrange_cli.records import dataclass

STARTS, MOST_ENTRIES = 96, 400_000
"""Places to start from, and entries of matrices in all of them together."""
MOST_CLOSURES = 8
SAME = 1e-6
"""Closures that differ by less, relative to their size, are one."""
ALMOST = 1e-5
"""The largest residual of constraints, relative to their terms, if given values may still be moved."""
ROUNDINGS = 8
"""Roundings by which constraints are off where two closures meet."""
TURN = 2 * math.pi
STEPS = 50
FEW = 8
"""Places from which a near miss is looked for."""


@dataclass(frozen=True)
class Closures:
    """What was found: ``states`` as a whole, or coordinates that are ``left`` open, by number.

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
    unknown = list(surface.unknown)
    for begin in starts(x, unknown, sizes, len(surface.kept), found):
        state, off = solve(surface, begin)
        if state is None:
            continue
        if off > ALMOST:
            if off < 0.999 * least:
                best, least = state, off
            continue
        left = undetermined(surface, state)
        if left:
            return Closures([], left)
        if any(alike(surface, state, other) for other in found):
            continue
        state = tidied(surface, state)
        if not any(alike(surface, state, other) for other in found):
            found.append(tidied(surface, where_two_meet(surface, state, ROUNDINGS * ROUND) or state))
        if len(found) >= MOST_CLOSURES:
            break
    if not found and best is None:
        begins = islice(starts(x, unknown, sizes, len(surface.kept), []), FEW)
        best = next((state for begin in begins if (state := near_miss(surface, begin))), None)
    return Closures(sorted(found), [], best)


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


def starts(
    x: Sequence[float], unknown: Sequence[int], sizes: Sequence[float], rows: int, found: list[list[float]]
) -> Iterator[list[float]]:
    """Places to start from: some are small, some large, all are spread over both signs.

    Every other one keeps some of the values of a closure that has been ``found``: of several loops, each may
    close in more than one way, whatever the others do.
    """
    inner = {*unknown}
    known = [abs(one) for k, one in enumerate(x) if k not in inner and one]
    lengths = list(dict.fromkeys([*known, *(abs(one) for one in sizes if one), 1.0, math.pi]))[:12]
    count = max(4, min(STARTS, MOST_ENTRIES // max(1, rows * len(unknown))))
    numbers = Random(0)  # from which every run draws the same
    for i in range(count):
        kept = found[i // 2 % len(found)] if found and i % 2 else None
        size = lengths[i // 2 % len(lengths)] if kept is None else max(abs(kept[k]) for k in unknown)
        begin = list(x)
        for k in unknown:
            place = 1.5 * size * numbers.uniform(-1.0, 1.0)
            begin[k] = place if kept is None or numbers.random() < 0.5 else kept[k]
        yield begin


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
            matrix, f = matrix_of(surface, surface.at(x))
            step = least_squares(matrix, -f)
        except (ArithmeticError, np.linalg.LinAlgError):
            return None, math.inf
        if not np.isfinite(step).all():
            return None, math.inf
        length = float(np.abs(step).max(initial=0.0)) / size
        halved = halved + 1 if 0.4 < length / last < 0.6 else 0
        factor = 2.0 if halved > 2 else min(1.0, 0.7 / length) if length else 1.0
        for k, dx in zip(surface.unknown, step.tolist()):
            x[k] += factor * dx
        if length <= ROUND or (length >= last / 2 and last <= NEAR):
            bound = sum(np.abs(matrix) @ np.array([abs(x[k]) for k in surface.unknown]))
            terms = max(float(bound), float(np.abs(matrix).max(initial=0.0)) * size)
            return x, float(np.abs(f).max(initial=0.0)) / (terms or size)
        last = length
    return None, math.inf


def undetermined(surface: Surface, state: Sequence[float]) -> list[int]:
    """The unknown coordinates that could change with the constraints still satisfied."""
    matrix, _ = matrix_of(surface, surface.at(state))
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
    rows = surface.at(state)[1]
    norms = np.array([math.hypot(*map(float, rows[i].values())) or 1.0 for i in surface.kept])
    found = meeting_place(values, np.array([state[k] for k in surface.unknown]), size)
    return placed(found) if found is not None and satisfied(surface, placed(found), unit) else None


def tidied(surface: Surface, state: list[float]) -> list[float]:
    """0 in place of rounding errors, and angles from -pi to pi."""
    for k in surface.unknown:
        if abs(state[k]) <= NEAR * surface.scale[k] and satisfied(
            surface, [*state[:k], 0.0, *state[k + 1 :]]
        ):
            state[k] = 0.0
        turns = round(state[k] / TURN)
        turned = [*state[:k], state[k] - TURN * turns, *state[k + 1 :]]
        if turns and satisfied(surface, turned):
            state = turned
    return state


def satisfied(surface: Surface, state: Sequence[float], unit: float = NEAR) -> bool:
    """Whether a state is a solution, with errors of ``unit`` of the terms."""
    try:
        values, rows = surface.at(state)
    except ArithmeticError:
        return False
    return all(
        abs(float(values[i])) <= unit * sum(abs(float(a)) * surface.scale[k] for k, a in rows[i].items())
        for i in surface.kept
    )


def alike(surface: Surface, one: Sequence[float], other: Sequence[float]) -> bool:
    """Whether two closures are the same."""
    return all(abs(one[k] - other[k]) <= SAME * max(surface.scale[k], abs(one[k])) for k in surface.unknown)


def determined(rows: Sequence[Any], unknown: Sequence[int], scale: Sequence[float]) -> list[int]:
    """The rows that are independent as functions of the unknown coordinates alone."""
    inner = set(unknown)
    return independent([{k: a for k, a in row.items() if k in inner} for row in rows], scale)
