"""A consistent start: initial values that satisfy the constraints, with those that the file leaves out.

First the coordinates, then the velocities. Values that are not given are found, given ones being kept; if the
constraints are not satisfied then, given values are moved to the nearest state in the metric of the masses.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping, Sequence
from functools import cached_property
from typing import Any

from lagrange_cli.errors import NotLinear, SpecError
from lagrange_cli.expression.vocabulary import velocity_name
from lagrange_cli.model.start.closures import MOST_CLOSURES, closures, determined
from lagrange_cli.model.start.equations import Equations, Masses, Rates
from lagrange_cli.model.start.linear import APART, coupled, damped, independent, scales, scattered, steepness
from lagrange_cli.model.start.nearest import LONG_ROUND, NEAR, ROUND, ROUNDS, Surface, Values
from lagrange_cli.model.start.report import Refusal
from lagrange_cli.model.start.unit_quaternions import normalized
from lagrange_cli.records import dataclass, replace
from lagrange_cli.spec.spec import Spec

SLIGHTLY = 1e-6
"""Given values are moved by this part of their scale."""
NEARBY = 0.03
"""How far away states are, as a part of the scale, that tell what is true in general."""
TRIES = 3
AGREE = 1e-7
"""Constraints that depend on others agree with them if they are off by no more nearby."""
EXACTLY = 1e-12
"""States nearby are consistent if constraints are off by no more."""


@dataclass(frozen=True)
class Change:
    """The initial ``value`` of a coordinate or velocity where it is not as ``given`` (None: not given), and
    by how much it is larger."""

    name: str
    given: float | None
    value: float
    by: float


@dataclass(frozen=True)
class Generic:
    """What constraints do in general: the numbers of those that are ``independent``, the steepness of each
    that is ``typical``, and the numbers of those that are ``coupled`` by depending on each other."""

    independent: tuple[int, ...]
    typical: tuple[float, ...]
    coupled: tuple[int, ...] = ()


@dataclass(frozen=True)
class Start:
    """A consistent state ``q`` and ``v``, what was ``changed`` to get there, and what constraints do there.

    ``redundant`` are the names of constraints that depend on the others at all states nearby; the multipliers
    of those that depend on each other are ``undetermined``. Where
    constraints are ``singular``, they depend on others at the start, and not nearby. ``generic`` is what
    holds there. ``normalized`` has the lengths that quaternions had, by body, where they were not 1.
    """

    q: tuple[Any, ...]
    v: tuple[Any, ...]
    changed: tuple[Change, ...]
    redundant: tuple[str, ...]
    undetermined: tuple[str, ...]
    singular: tuple[str, ...]
    generic: Generic
    normalized: Mapping[str, float]


@dataclass(frozen=True)
class Given:
    """The initial values of a run: ``q`` and ``v`` by coordinate, at time ``t``; those of the coordinates
    with numbers ``open_q`` and ``open_v`` are not given. They may be moved however far if ``forced``."""

    t: Any
    q: Sequence[Any]
    v: Sequence[Any]
    open_q: Collection[int] = ()
    open_v: Collection[int] = ()
    forced: bool = False


def consistent(
    spec: Spec, parameters: Mapping[str, Any], given: Given, exact: Any = None, generic: Generic | None = None
) -> Start:
    """The consistent start. With an ``exact`` module of mpmath numbers have many digits.

    ``generic`` is what is known already, from a search in doubles, whose values the coordinates that are not
    given have.

    Raises:
        SpecError: the constraints contradict each other, or values that are too far off; several closures
            are left; a coordinate is left without a value.
    """
    return Search(spec, parameters, given, exact, generic).start()


class Search:
    """One search for a consistent start."""

    def __init__(
        self, spec: Spec, parameters: Mapping[str, Any], given: Given, exact: Any, generic: Generic | None
    ) -> None:
        self.spec, self.written, self.exact = spec, given, exact
        q, v, self.normalized = normalized(spec, given.q, given.v, given.open_q, SLIGHTLY)
        self.given = replace(given, q=q, v=v)
        self.equations = Equations(spec, parameters, exact)
        self.parameters, self._generic = parameters, generic
        self.names = [*spec.all_constraints]
        self.coordinates = [one.name for one in spec.coordinates]
        self.unit = ROUND if exact is None else LONG_ROUND
        self.refusal = Refusal(spec)
        self._measured: tuple[tuple[Any, ...], list[float], Masses] = ((), [], Masses({}))

    def start(self) -> Start:
        """See ``consistent``."""
        self.refuse_constants()
        q = self.places()
        scale, masses = self.metric(q)
        singular: tuple[str, ...] = ()
        here = independent(self.rates(q, self.given.v).rows, scale, self.typical(scale))
        v = self.speeds(q, scale, masses, here)
        generic = self.generic(q, scale)
        if len(here) < len(generic.independent):
            singular = tuple(name for i, name in enumerate(self.names) if i not in here)
        changed = [*self.changes(self.coordinates, self.written.q, q, self.given.open_q)]
        speeds = [*map(velocity_name, self.coordinates)]
        changed += self.changes(speeds, self.written.v, v, self.given.open_v)
        redundant = tuple(one for i, one in enumerate(self.names) if i not in generic.independent)
        singular = tuple(one for one in singular if one not in redundant)
        undetermined = tuple(one for i, one in enumerate(self.names) if i in generic.coupled)
        found = tuple(q), tuple(v), tuple(changed), redundant, undetermined, singular, generic
        return Start(*found, self.normalized)

    def refuse_constants(self) -> None:
        """Refuse what has no slopes wherever one looks, and constraints on velocities whose slopes depend on
        these."""
        q, v = self.given.q, self.given.v
        scale = self.metric(q)[0]
        rows = self.rates(q, v).rows
        here = steepness(rows, scale)
        if self.spec.nonholonomic:
            faster = [a + size * b for a, size, b in zip(v, scale, scattered(0, len(v)))]
            others = self.rates(q, faster).rows
            for name, row, other in zip(self.names, rows, others):
                sizes = {k: abs(a) + abs(row.get(k, 0.0)) for k, a in other.items()}
                if any(abs(a - row.get(k, 0.0)) > NEAR * sizes[k] for k, a in other.items()):
                    raise NotLinear(name)
        for name, steep, usual in zip(self.names, here, self.typical(scale)):
            if steep == usual == 0.0:
                raise self.refusal.constant(name)

    @staticmethod
    def changes(
        names: Sequence[str], before: Sequence[Any], after: Sequence[Any], free: Collection[int]
    ) -> list[Change]:
        """What is not as it was."""
        return [
            Change(name, None if k in free else float(old), float(new), float(new - old))
            for k, (name, old, new) in enumerate(zip(names, before, after))
            if new != old or (k in free and new != 0)
        ]

    @cached_property
    def count(self) -> int:
        """Of the holonomic constraints, which come first."""
        found = self.rates(self.given.q, self.given.v)
        return len(found.values) - len(self.spec.nonholonomic)

    def rates(self, q: Sequence[Any], v: Sequence[Any], t: Any = None) -> Rates:
        """The constraints at a state; ArithmeticError becomes ``SpecError``."""
        return self.equations.at(self.given.t if t is None else t, q, v)

    def position_values(self, q: Sequence[Any], t: Any = None) -> Values:
        """The holonomic constraints at a place."""
        try:
            found = self.rates(q, self.given.v, t)
        except SpecError as error:
            raise ArithmeticError(error.problems[0].message) from error
        return found.values[: self.count], found.rows[: self.count]

    def metric(self, q: Sequence[Any]) -> tuple[list[float], Masses]:
        """The scale of each coordinate, and the masses."""
        place = tuple(q)
        if self._measured[0] != place:
            masses = self.equations.masses(self.given.t, q, [0.0 * x for x in q])
            self._measured = place, scales(masses, q, masses.extent), masses
        return self._measured[1:]

    def places(self) -> list[Any]:
        """Consistent coordinates."""
        given, q = self.given, list(self.given.q)
        if not self.count:
            return q
        unknown = sorted(given.open_q)
        if unknown and self._generic is None:
            q = self.closure(q, unknown)
        scale, masses = self.metric(q)
        rows = self.position_values(q)[1]
        at = self.position_values
        if unknown:
            kept = determined(rows, unknown, scale)
            found = self.tried(Surface(at, kept, unknown, masses, scale, self.unit).nearest, q)
            q = q if found is None else found
        everything = [*range(len(q))]
        kept = independent(rows, scale, self.typical(scale))
        if self.off(q, scale) > 2 * self.unit:
            found = self.tried(Surface(at, kept, everything, masses, scale, self.unit).nearest, q)
            if found is None or self.off(found, scale) > NEAR:
                raise self.refusal.contradiction(*self.position_values(q), scale)
            far = self.far(q, found, scale)
            if far > SLIGHTLY and not given.forced:
                raise self.refusal.far_off(*self.position_values(q), scale, self.told(q, found, scale))
            q = found
        return q

    def tried(self, nearest: Any, q: Sequence[Any]) -> Any:
        """What ``nearest`` finds; None where it comes to a place where something has no value."""
        try:
            return nearest(q)
        except ArithmeticError:
            return None

    def told(
        self, before: Sequence[Any], after: Sequence[Any], scale: Sequence[float], speeds: bool = False
    ) -> list[tuple[str, float]]:
        """The names of values that are moved, and where to."""
        names = [*map(velocity_name, self.coordinates)] if speeds else self.coordinates
        return [
            (name, float(new))
            for name, old, new, size in zip(names, before, after, scale)
            if abs(float(new - old)) > NEAR * size
        ]

    def far(self, before: Sequence[Any], after: Sequence[Any], scale: Sequence[float]) -> float:
        """The largest part of its scale that a value is moved by."""
        return max((abs(float(b - a)) / size for a, b, size in zip(before, after, scale)), default=0.0)

    def off(self, q: Sequence[Any], scale: Sequence[float]) -> float:
        """How far from 0 the worst constraint is, relative to the sizes of its terms."""
        values, rows = self.position_values(q)
        return self.worst(values, rows, scale)

    def worst(self, values: Sequence[Any], rows: Sequence[Any], scale: Sequence[float]) -> float:
        """The largest of values relative to their terms."""
        found = 0.0
        for i, (value, steep) in enumerate(zip(values, steepness(rows, scale))):
            size = max(steep, NEAR * self.typical(scale)[i])
            off = abs(float(value))
            found = max(found, off / size if size else (math.inf if off > NEAR else 0.0))
        return found

    def typical(self, scale: Sequence[float]) -> Sequence[float]:
        """The steepness of constraints away from places where their slopes may vanish."""
        if self._generic is not None:
            return self._generic.typical
        if not hasattr(self, "_typical"):
            self._typical = [0.0] * len(self.names)
            for number in range(TRIES):
                near = self.away(self.given.q, scale, number)
                speeds = [
                    float(v) + size * one
                    for v, size, one in zip(self.given.v, scale, scattered(number, len(near)))
                ]
                try:
                    self._typical = steepness(self.rates(near, speeds).rows, scale)
                    break
                except SpecError:
                    continue
        return self._typical

    def away(self, q: Sequence[Any], scale: Sequence[float], number: int) -> list[float]:
        """A place nearby, the same in every run."""
        moves = zip(q, scale, scattered(number, len(q)))
        return [float(x) + NEARBY * size * move for x, size, move in moves]

    def closure(self, q: list[Any], unknown: Sequence[int]) -> list[Any]:
        """The coordinates, with the only values that the open ones can have."""
        plain = [float(x) for x in q]
        doubles = Equations(self.spec, {name: float(x) for name, x in self.parameters.items()})
        time = float(self.given.t)

        def at(x: Sequence[Any]) -> Values:
            try:
                found = doubles.at(time, x, [0.0] * len(x))
            except SpecError as error:
                raise ArithmeticError(error.problems[0].message) from error
            return found.values[: self.count], found.rows[: self.count]

        sizes = [float(x) for x in self.parameters.values()]
        scale = [max(map(abs, plain), default=0.0) or 1.0] * len(plain)
        everything = Surface(at, range(self.count), unknown, Masses({}), scale, ROUND)
        found = closures(everything, plain, sizes)
        if found.left:
            raise self.refusal.open_coordinate(found.left[0])
        chosen = found.states[0] if found.states else found.best
        if chosen is None:
            raise self.refusal.no_closure([k for k in range(len(q)) if k not in set(unknown)], unknown)
        if len(found.states) > 1:
            more = len(found.states) >= MOST_CLOSURES
            listed = [{k: state[k] for k in unknown} for state in found.states]
            raise self.refusal.several(listed, more=more)
        for k in unknown:
            q[k] = 0 * q[k] + chosen[k]
        return q

    def generic(self, q: Sequence[Any], scale: Sequence[float]) -> Generic:
        """Which constraints are independent at consistent states nearby, where most of them are."""
        if self._generic is not None:
            return self._generic
        rows = self.rates(q, self.given.v).rows
        typical = self.typical(scale)
        best = independent(rows, scale, typical)
        if len(best) == len(self.names):
            return Generic(tuple(best), tuple(typical))
        seen, places = [best], [rows]
        for number in range(TRIES):
            near = self.nearby(q, scale, [*range(self.count)], number)
            if near is not None:
                there = self.rates(near, self.given.v).rows
                seen.append(independent(there, scale, typical, sine=APART))
                places.append(there)
        if len(seen) == 1:  # a place that stands alone: nothing is known beyond it
            return Generic(tuple(range(len(self.names))), tuple(typical))
        best = max(seen, key=len)
        self.refuse_restricting(q, scale, best)
        return Generic(tuple(best), tuple(typical), coupled(places[seen.index(best)], best, scale))

    def nearby(
        self, q: Sequence[Any], scale: Sequence[float], kept: Sequence[int], number: int, t: Any = None
    ) -> list[Any] | None:
        """A consistent place nearby, as far as the constraints ``kept`` go."""
        place = self.away(q, scale, number)
        for _ in range(ROUNDS):
            try:
                values, rows = self.position_values(place, t)
                mine = [rows[i] for i in kept]
                step = damped(mine, [float(values[i]) for i in kept], scale)
            except ArithmeticError:
                return None
            place = [x + step.get(k, 0.0) for k, x in enumerate(place)]
            if max((abs(dx) / scale[k] for k, dx in step.items()), default=0.0) <= EXACTLY:
                return place if self.worst([values[i] for i in kept], mine, scale) <= EXACTLY else None
        return None

    def refuse_restricting(self, q: Sequence[Any], scale: Sequence[float], best: Sequence[int]) -> None:
        """Refuse constraints that depend on others, and contradict them nearby or later."""
        rest = [i for i in range(len(self.names)) if i not in best]
        times = self.given.t, self.given.t + NEARBY
        moving = any(float(one) for t in times for one in self.rates(q, self.given.v, t).drifts)
        bound = [i for i in best if i < self.count]
        for number in range(TRIES if rest else 0):
            for later in (0.0, NEARBY * (number + 1))[: 1 + moving]:
                t = self.given.t + later
                near = self.nearby(q, scale, bound, number, t)
                if near is None:
                    continue
                rates = self.rates(near, [0.0 * x for x in near], t)
                drifts = [float(rates.drifts[i]) for i in best]
                v = damped([rates.rows[i] for i in best], drifts, scale, damping=0.0)
                for i in rest:
                    size = max(steepness([rates.rows[i]], scale)[0], self.typical(scale)[i])
                    off = float(rates.values[i]) if i < self.count else 0.0
                    if abs(off) > AGREE * size:
                        raise self.refusal.restricting(self.names[i], later=bool(later))
                    rate = sum(float(a) * v.get(k, 0.0) for k, a in rates.rows[i].items())
                    rate += float(rates.drifts[i])
                    speed = max((abs(dx) / scale[k] for k, dx in v.items()), default=0.0)
                    if abs(rate) > AGREE * max(size * speed, abs(float(rates.drifts[i]))):
                        raise self.refusal.restricting(self.names[i], later=True)

    def speeds(
        self, q: Sequence[Any], scale: Sequence[float], masses: Masses, kept: Sequence[int]
    ) -> list[Any]:
        """Consistent velocities."""
        given, v = self.given, list(self.given.v)
        rates = self.rates(q, v)

        def at(x: Sequence[Any]) -> Values:
            values = [
                drift + sum((a * x[k] for k, a in row.items()), 0 * drift)
                for row, drift in zip(rates.rows, rates.drifts)
            ]
            return values, rates.rows

        def surface(kept: Sequence[int], unknown: Sequence[int], size: Sequence[float]) -> Surface:
            return Surface(at, kept, unknown, masses, size, self.unit)

        everything = [*range(len(v))]
        whole = self.tried(surface(kept, everything, scale).reach, v) or v
        size = scales(masses, [max(abs(float(a)), abs(float(b))) for a, b in zip(v, whole)])
        unknown = sorted(given.open_v)
        if unknown and self.off_by(at(v), size, rates) > 0.0:
            some = determined([rates.rows[i] for i in kept], unknown, scale)
            alone = Masses({k: {k: 1.0 / scale[k] ** 2} for k in unknown})  # none moves because others do
            free = Surface(at, [kept[i] for i in some], unknown, alone, size, self.unit)
            found = self.tried(free.nearest, v)
            v = v if found is None else found
        if self.off_by(at(v), size, rates) > 2 * self.unit:
            found = self.tried(surface(kept, everything, size).nearest, v)
            if found is None or self.off_by(at(found), size, rates) > NEAR:
                raise self.refusal.contradiction(*at(v), size, speeds=True)
            if self.far(v, found, size) > SLIGHTLY and not given.forced:
                raise self.refusal.far_off(*at(v), size, self.told(v, found, size, True), speeds=True)
            v = found
        return v

    def off_by(self, values: Values, size: Sequence[float], rates: Rates) -> float:
        """How far from 0 the worst rate of a constraint is, relative to its terms."""
        found = 0.0
        for value, steep, drift in zip(values[0], steepness(values[1], size), rates.drifts):
            whole = max(steep, abs(float(drift)))
            if value:
                found = max(found, abs(float(value)) / whole if whole else math.inf)
        return found
