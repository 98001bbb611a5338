"""A consistent start: initial values that satisfy the constraints, with those that the file leaves out.

First the coordinates, then the velocities. Values that are not given are found, given ones being kept; if the
constraints are not satisfied then, given values are moved to the nearest state in the metric of the masses.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Iterator, Mapping, Sequence
from typing import Any

from lagrange_cli.expression.vocabulary import velocity_name
from lagrange_cli.model.start.closures import determined
from lagrange_cli.model.start.dependence import independent
from lagrange_cli.model.start.equations import Masses, Matter, Rates
from lagrange_cli.model.start.generic import faint, in_general, refuse_constants
from lagrange_cli.model.start.given_masses import GivenMasses
from lagrange_cli.model.start.linear import scales, steepness
from lagrange_cli.model.start.missing import closure
from lagrange_cli.model.start.moved import far, moved, tried
from lagrange_cli.model.start.nearest import ROUND, Surface, Values
from lagrange_cli.model.start.search import SLIGHTLY, Evaluated, Generic, Given, Known, Search
from lagrange_cli.records import dataclass, replace
from lagrange_cli.spec.spec import Spec


@dataclass(frozen=True)
class Change:
    """The initial ``value`` of a coordinate or velocity where it is not as ``given`` (None: not given), and
    by how much it is larger."""

    name: str
    given: float | None
    value: float
    by: float


@dataclass(frozen=True)
class Start:
    """A consistent state ``q`` and ``v``, what was ``changed`` to get there, and what constraints do there.

    ``redundant`` are the names of constraints that depend on the others at all states nearby; the multipliers
    of those that depend on each other are ``undetermined``. Where
    constraints are ``singular``, they depend on others at the start, and not nearby. ``generic`` is what
    holds there. ``faint`` are constraints with a coefficient that is all but 0 beside others, at the start
    and nearby. ``normalized`` has the lengths that quaternions had, by body, where they were not 1.
    """

    q: tuple[Any, ...]
    v: tuple[Any, ...]
    changed: tuple[Change, ...]
    redundant: tuple[str, ...]
    undetermined: tuple[str, ...]
    singular: tuple[str, ...]
    generic: Generic
    faint: tuple[str, ...]
    normalized: Mapping[str, float]


def consistent(
    spec: Spec,
    parameters: Mapping[str, Any],
    given: Given,
    exact: Any = None,
    near: Start | None = None,
    equations: Evaluated | None = None,
) -> Start:
    """The consistent start. With an ``exact`` module of mpmath numbers have many digits.

    ``near`` is that of a search in doubles, whose values the coordinates that are not given have.
    ``equations`` give the constraints and masses; by default, they are evaluated one by one.

    Raises:
        SpecError: the constraints contradict each other, or values that are too far off; several closures
            are left; a coordinate is left without a value.
    """
    known = None if near is None else Known(near.q, near.v, near.generic)
    search = Search(spec, parameters, given, exact, known, equations)
    refuse_constants(search)
    q = places(search)
    scale, masses = search.metric(q)
    singular: tuple[str, ...] = ()
    here = independent(search.rates(q, search.given.v).rows, scale, search.typical(scale))
    v = speeds(search, q, scale, masses, here)
    general = in_general(search, q, scale)
    if len(here) < len(general.independent):
        singular = tuple(name for i, name in enumerate(search.names) if i not in here)
    changed = changes(search.coordinates, search.written.q, q, search.given.open_q, scale, places=True)
    names = [*map(velocity_name, search.coordinates)]
    fastest = max((abs(float(u)) / size for u, size in zip(v, scale)), default=0.0)
    usual = [size * fastest for size in scale]
    changed += changes(names, search.written.v, v, search.given.open_v, usual)
    redundant = tuple(one for i, one in enumerate(search.names) if i not in general.independent)
    singular = tuple(one for one in singular if one not in redundant)
    tied = {i for group in general.tied for i in group}
    undetermined = tuple(one for i, one in enumerate(search.names) if i in tied)
    found = tuple(q), tuple(v), tuple(changed), redundant, undetermined, singular, general
    return Start(*found, faint(search, q, scale), search.normalized)


def changes(
    names: Sequence[str],
    before: Sequence[Any],
    after: Sequence[Any],
    free: Collection[int],
    scale: Sequence[float],
    *,
    places: bool = False,
) -> list[Change]:
    """The values that have changed by more than doubles are rounded, as parts of their ``scale``, and those
    that are not given: ``places``, or velocities that are not 0, as they would be without constraints."""
    return [
        Change(name, None if k in free else float(old), float(new), float(new - old))
        for k, (name, old, new, size) in enumerate(zip(names, before, after, scale))
        if (places and k in free) or abs(new if k in free else new - old) > 2 * ROUND * size
    ]


def speeds(
    search: Search, q: Sequence[Any], scale: Sequence[float], masses: Matter, kept: Sequence[int]
) -> list[Any]:
    """Consistent velocities."""
    given, v = search.given, list(search.given.v)
    rates = search.rates(q, v)
    metric = GivenMasses(masses, given.open_v, scale) if given.open_v else None

    def at(x: Sequence[Any]) -> Values:
        values = [
            drift + sum((a * x[k] for k, a in row.items()), 0 * drift)
            for row, drift in zip(rates.rows, rates.drifts)
        ]
        return values, rates.rows

    def surface(kept: Sequence[int], unknown: Sequence[int], size: Sequence[float]) -> Surface:
        """They are linear functions: however long, the first step leads there."""
        return Surface(at, kept, unknown, masses, size, search.unit, far=math.inf, metric=metric)

    everything = [*range(len(v))]
    whole = tried(surface(kept, everything, scale).reach, v) or v
    size = scales(masses, [max(abs(float(a)), abs(float(b))) for a, b in zip(v, whole)])
    for binding, unknown in stages(search, kept):
        if not unknown or off_by(at(v), size, rates) == 0.0:
            continue
        some = determined([rates.rows[i] for i in binding], unknown, scale)
        own = masses.diagonal(len(v))  # none moves because others do
        if not all(own[k] > 0 for k in unknown):
            own = [1.0 / size**2 for size in scale]
        alone = Masses({k: {k: own[k]} for k in unknown})
        free = replace(surface([binding[i] for i in some], unknown, size), masses=alone, metric=None)
        found = tried(free.nearest, v)
        if found is not None:
            v = found
            size = scales(masses, [max(abs(float(a)), abs(float(b))) for a, b in zip(v, whole)])
    return moved(
        search, surface(kept, everything, size), v, lambda x: off_by(at(x), size, rates), speeds=True
    )


def stages(search: Search, kept: Sequence[int]) -> Iterator[tuple[Sequence[int], Sequence[int]]]:
    """Constraints, and the velocities that are found from them: those of coordinates without mass come last,
    from their own equations. These do not move what has a mass."""
    unknown, massless = sorted(search.given.open_v), search.spec.massless
    if not massless:
        yield kept, unknown
        return
    names = {*massless.values()}
    light = {k for k, one in enumerate(search.spec.coordinates) if one.name in names}
    for last in (False, True):
        own = [i for i in kept if (search.names[i] in massless) == last]
        yield own, [k for k in unknown if (k in light) == last]


def off_by(values: Values, size: Sequence[float], rates: Rates) -> float:
    """The largest rate of a constraint, relative to its terms."""
    found = 0.0
    for value, steep, drift in zip(values[0], steepness(values[1], size), rates.drifts):
        whole = max(steep, abs(float(drift)))
        if value:
            found = max(found, abs(float(value)) / whole if whole else math.inf)
    return found


def places(search: Search) -> list[Any]:
    """Consistent coordinates."""
    given, q = search.given, list(search.given.q)
    if not search.count:
        return q
    unknown = sorted(given.open_q)
    closed = True
    if unknown and search.known is None:
        q, closed = closure(search, q, unknown)
    scale, masses = search.metric(q)
    if search.known is not None:
        closed = far(search.known.q, q, scale) <= SLIGHTLY
    rows = search.position_values(q)[1]
    at = search.position_values
    if unknown and closed:
        kept = determined(rows, unknown, scale)
        found = tried(Surface(at, kept, unknown, masses, scale, search.unit).nearest, q)
        q = q if found is None else found
    kept = independent(rows, scale, search.typical(scale))
    metric = GivenMasses(masses, unknown, scale) if unknown else None
    everything = Surface(at, kept, [*range(len(q))], masses, scale, search.unit, metric=metric)
    return moved(search, everything, q, lambda x: search.worst(*at(x), scale))
