"""The input of a search for a consistent start: the constraints and masses of a system at any state."""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping, Sequence
from typing import Any, Protocol

from lagrange_cli.errors import SpecError
from lagrange_cli.model.start.equations import Equations, Masses, Matter, Part, Rates
from lagrange_cli.model.start.linear import scales, scattered, steepness
from lagrange_cli.model.start.nearest import LONG_ROUND, NEAR, ROUND, Values
from lagrange_cli.model.start.report import Refusal
from lagrange_cli.model.start.unit_quaternions import normalized
from lagrange_cli.records import dataclass, replace
from lagrange_cli.spec.content import names_of
from lagrange_cli.spec.spec import Spec

SLIGHTLY = 1e-6
"""Given values are moved by this part of their scale."""
NEARBY = 0.03
"""The distance, as a part of the scale, of the nearby states at which constraints are examined."""
TRIES = 3


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


@dataclass(frozen=True)
class Generic:
    """What constraints do in general: the numbers of those that are ``independent``, the steepness of each
    that is ``typical``, and groups of those that are ``tied``: some of a group depend on the others. These
    agree up to ``rest``, a part of their size, where that is more than rounding. Those ``in_turn`` depend on
    others by factors that change."""

    independent: tuple[int, ...]
    typical: tuple[float, ...]
    tied: tuple[tuple[int, ...], ...] = ()
    rest: float = 0.0
    in_turn: tuple[int, ...] = ()


@dataclass(frozen=True)
class Known:
    """What a search in doubles has found: the state, and what constraints do in general."""

    q: Sequence[Any]
    v: Sequence[Any]
    generic: Generic


class Evaluated(Protocol):
    """The constraints and the masses of a system, at any state (see ``Equations``)."""

    def at(self, t: Any, q: Sequence[Any], v: Sequence[Any]) -> Rates: ...
    def part(self, t: Any, q: Sequence[Any], chosen: Sequence[int]) -> Part: ...
    def masses(self, t: Any, q: Sequence[Any], v: Sequence[Any]) -> Matter: ...


class Search:
    """One search for a consistent start: numbers of the constraints, and how large each is in general."""

    def __init__(
        self,
        spec: Spec,
        parameters: Mapping[str, Any],
        given: Given,
        exact: Any,
        known: Known | None,
        equations: Evaluated | None = None,
    ) -> None:
        self.spec, self.written, self.exact = spec, given, exact
        q, v, self.normalized = normalized(spec, given.q, given.v, given.open_q, SLIGHTLY)
        self.given = replace(given, q=q, v=v)
        self.equations = equations or Equations(spec, parameters, exact)
        self.parameters, self.known = parameters, known
        self.names = [*spec.all_constraints]
        self.coordinates = [*names_of(spec.coordinates)]
        self.unit = ROUND if exact is None else LONG_ROUND
        self.refusal = Refusal(spec)
        self._measured: tuple[tuple[Any, ...], list[float], Matter] = ((), [], Masses({}))

    @property
    def count(self) -> int:
        """The number of holonomic constraints, which come first."""
        return len(self.names) - len(self.spec.nonholonomic)

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

    def metric(self, q: Sequence[Any]) -> tuple[list[float], Matter]:
        """The scale of each coordinate, and the masses."""
        place = tuple(q)
        if self._measured[0] != place:
            masses = self.equations.masses(self.given.t, q, [0.0 * x for x in q])
            self._measured = place, scales(masses, q, masses.extent), masses
        return self._measured[1:]

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
        if self.known is not None:
            return self.known.generic.typical
        if not hasattr(self, "_typical"):
            self._typical = [0.0] * len(self.names)
            for number in range(TRIES):
                near = away(self.given.q, scale, number, NEARBY / math.sqrt(len(scale)))
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

    def first(self, scale: Sequence[float]) -> list[Any]:
        """The given coordinates; those that are open have values at which nothing vanishes by chance."""
        near = self.away(self.given.q, scale, 0)
        return [near[k] if k in self.given.open_q else x for k, x in enumerate(self.given.q)]

    def away(self, q: Sequence[Any], scale: Sequence[float], number: int, part: float = 1.0) -> list[float]:
        """A place nearby, at a ``part`` of the usual distance, the same in every run."""
        return away(q, scale, number, part * NEARBY)


def away(q: Sequence[Any], scale: Sequence[float], number: int, near: float) -> list[float]:
    """A place where coordinates have moved by at most a part of their scale, the same in every run."""
    moves = zip(q, scale, scattered(number, len(q)))
    return [float(x) + near * size * move for x, size, move in moves]
