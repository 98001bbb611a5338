"""Coordinates that satisfy the constraints: the only values of those that are not given, then all of them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from lagrange_cli.errors import SpecError
from lagrange_cli.model.start.closing import Closing
from lagrange_cli.model.start.closures import MOST_CLOSURES, determined
from lagrange_cli.model.start.equations import Equations, Row
from lagrange_cli.model.start.linear import independent
from lagrange_cli.model.start.moved import moved, tried
from lagrange_cli.model.start.nearest import Surface
from lagrange_cli.model.start.search import Search


def places(search: Search) -> list[Any]:
    """Consistent coordinates."""
    given, q = search.given, list(search.given.q)
    if not search.count:
        return q
    unknown = sorted(given.open_q)
    if unknown and search.known is None:
        q = closure(search, q, unknown)
    scale, masses = search.metric(q)
    rows = search.position_values(q)[1]
    at = search.position_values
    if unknown:
        kept = determined(rows, unknown, scale)
        found = tried(Surface(at, kept, unknown, masses, scale, search.unit).nearest, q)
        q = q if found is None else found
    kept = independent(rows, scale, search.typical(scale))
    everything = Surface(at, kept, [*range(len(q))], masses, scale, search.unit)
    return moved(search, everything, q, lambda x: search.worst(*at(x), scale))


def closure(search: Search, q: list[Any], unknown: Sequence[int]) -> list[Any]:
    """The coordinates, with the only values that the open ones can have."""
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

    sizes = [float(x) for x in search.parameters.values()]
    scale = max(map(abs, plain), default=0.0) or 1.0
    found = Closing(at, range(search.count), unknown, plain, scale, sizes).closures()
    if found.left:
        raise search.refusal.open_coordinate(found.left[0])
    chosen = found.states[0] if found.states else found.best
    if chosen is None:
        raise search.refusal.no_closure(sorted({*range(len(q))}.difference(unknown)), unknown)
    if len(found.states) > 1:
        more = len(found.states) >= MOST_CLOSURES
        listed = [{k: state[k] for k in unknown} for state in found.states]
        raise search.refusal.several(listed, more=more)
    for k in unknown:
        q[k] = 0 * q[k] + chosen[k]
    return q
