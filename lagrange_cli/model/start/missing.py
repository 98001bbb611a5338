"""Coordinates without initial values: those that the constraints require; or else the places from which the
nearest states are searched for that satisfy the constraints with other values than the given ones.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from contextlib import suppress
from itertools import islice
from typing import Any

from lagrange_cli.errors import SpecError
from lagrange_cli.model.start.beginnings import starts
from lagrange_cli.model.start.closing import Closing
from lagrange_cli.model.start.closures import MOST_CLOSURES
from lagrange_cli.model.start.equations import Equations, Row
from lagrange_cli.model.start.linear import DENSE, damped
from lagrange_cli.model.start.search import Search, away

FEW, STEPS = 8, 30
"""Places from which values are searched for with which the constraints are satisfied best, and steps."""
MOST = 32
"""Places from which the nearest states are searched for."""


def closure(search: Search, q: list[Any], unknown: Sequence[int]) -> tuple[list[Any], bool]:
    """The coordinates, with the only values that the ``unknown`` ones can have, and whether there are any;
    without these, those with which the constraints are satisfied best.

    Raises:
        SpecError: there are several; a coordinate is left free.
    """
    plain = [float(x) for x in q]
    doubles = search.equations
    if search.exact is not None:
        doubles = Equations(search.spec, {name: float(x) for name, x in search.parameters.items()})
    time = float(search.given.t)

    def at(x: Sequence[float], chosen: Sequence[int]) -> tuple[Mapping[int, Any], Mapping[int, Row]]:
        try:
            return doubles.part(time, x, chosen)
        except SpecError as error:
            raise ArithmeticError(error.problems[0].message) from error

    scale = max(map(abs, plain), default=0.0) or 1.0
    found = Closing(at, range(search.count), unknown, plain, scale, sizes(search)).closures()
    if found.left:
        raise search.refusal.open_coordinate(found.left[0])
    if len(found.states) > 1:
        more = len(found.states) >= MOST_CLOSURES
        listed = [{k: state[k] for k in unknown} for state in found.states]
        raise search.refusal.several(listed, more=more)
    chosen = found.states[0] if found.states else found.best or satisfying_best(search, plain, unknown)
    if chosen is None:
        raise search.refusal.no_closure(sorted({*range(len(q))}.difference(unknown)), unknown)
    return [0 * x + chosen[k] if k in unknown else x for k, x in enumerate(q)], bool(found.states)


def sizes(search: Search) -> list[float]:
    """Numbers of the system, among which the lengths of its parts may be."""
    return [float(x) for x in search.parameters.values()]


def satisfying_best(search: Search, x: Sequence[float], unknown: Sequence[int]) -> list[float] | None:
    """The state with other values of the ``unknown`` coordinates in which the constraints are off by the
    least part of their terms, of those that are seen on the way from a few places; None where they have no
    values at any of these."""
    best, least = None, math.inf
    inner = {*unknown}
    for begin in islice(starts(x, unknown, sizes(search), search.count, []), FEW):
        state = list(begin)
        with suppress(ArithmeticError):
            scale, _ = search.metric(state)
            for _ in range(STEPS):
                values, rows = search.position_values(state)
                off = search.worst(values, rows, scale)
                if off < least:
                    best, least = list(state), off
                mine = [{k: float(a) for k, a in row.items() if k in inner} for row in rows]
                for k, dx in damped(mine, [float(f) for f in values], scale).items():
                    state[k] += dx
    return best


def begins(
    search: Search, x: Sequence[Any], scale: Sequence[float], aside: float, found: list[list[Any]]
) -> Iterator[list[Any]]:
    """Places from which the nearest states are searched for: all kinds of values of coordinates that are not
    given, and the given ones, every other time with ``aside`` of their scale added."""
    unknown = sorted(search.given.open_q)
    plain = [float(one) for one in x]
    count = MOST if len(x) <= DENSE else 1
    for number, place in enumerate(islice(starts(plain, unknown, sizes(search), search.count, found), count)):
        near = away(x, scale, number, aside * (-1) ** (number // 2)) if number % 2 else list(x)
        yield [place[k] if k in search.given.open_q else one for k, one in enumerate(near)]
