"""A consistent start: initial values that satisfy the constraints, with those that the file leaves out.

First the coordinates, then the velocities. Values that are not given are found, given ones being kept; if the
constraints are not satisfied then, given values are moved to the nearest state in the metric of the masses.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from typing import Any

from lagrange_cli.expression.vocabulary import velocity_name
from lagrange_cli.model.start.generic import faint, in_general, refuse_constants
from lagrange_cli.model.start.linear import independent
from lagrange_cli.model.start.nearest import ROUND
from lagrange_cli.model.start.places import places
from lagrange_cli.model.start.search import Evaluated, Generic, Given, Search
from lagrange_cli.model.start.speeds import speeds
from lagrange_cli.records import dataclass
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
    generic: Generic | None = None,
    equations: Evaluated | None = None,
) -> Start:
    """The consistent start. With an ``exact`` module of mpmath numbers have many digits.

    ``generic`` is what is known already, from a search in doubles, whose values the coordinates that are not
    given have. ``equations`` give the constraints and masses; by default, they are evaluated one by one.

    Raises:
        SpecError: the constraints contradict each other, or values that are too far off; several closures
            are left; a coordinate is left without a value.
    """
    search = Search(spec, parameters, given, exact, generic, equations)
    refuse_constants(search)
    q = places(search)
    scale, masses = search.metric(q)
    singular: tuple[str, ...] = ()
    here = independent(search.rates(q, search.given.v).rows, scale, search.typical(scale))
    v = speeds(search, q, scale, masses, here)
    known = in_general(search, q, scale)
    if len(here) < len(known.independent):
        singular = tuple(name for i, name in enumerate(search.names) if i not in here)
    changed = [*changes(search.coordinates, search.written.q, q, search.given.open_q, scale)]
    names = [*map(velocity_name, search.coordinates)]
    fastest = max((abs(float(u)) / size for u, size in zip(v, scale)), default=0.0)
    usual = [size * fastest for size in scale]
    changed += changes(names, search.written.v, v, search.given.open_v, usual)
    redundant = tuple(one for i, one in enumerate(search.names) if i not in known.independent)
    singular = tuple(one for one in singular if one not in redundant)
    undetermined = tuple(one for i, one in enumerate(search.names) if i in known.coupled)
    found = tuple(q), tuple(v), tuple(changed), redundant, undetermined, singular, known
    return Start(*found, faint(search, q, scale), search.normalized)


def changes(
    names: Sequence[str],
    before: Sequence[Any],
    after: Sequence[Any],
    free: Collection[int],
    scale: Sequence[float],
) -> list[Change]:
    """The values that have changed by more than doubles are rounded, as parts of their ``scale``."""
    return [
        Change(name, None if k in free else float(old), float(new), float(new - old))
        for k, (name, old, new, size) in enumerate(zip(names, before, after, scale))
        if abs(new if k in free else new - old) > 2 * ROUND * size
    ]
