"""The constraints of a system and its masses as functions of the state, for doubles and for many digits."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from functools import cached_property
from itertools import chain
from typing import TYPE_CHECKING, Any, Protocol

from lagrange_cli.errors import NotLinear, SpecError, TooLarge
from lagrange_cli.expression.sloped import Sloped, SlopedAlgebra
from lagrange_cli.expression.syntax import Tree, names
from lagrange_cli.expression.vocabulary import MOVING_COMPONENTS, family_name, velocity_name
from lagrange_cli.limits import Work
from lagrange_cli.model.build import build_model
from lagrange_cli.model.constraints import built_constraints
from lagrange_cli.model.model import Model
from lagrange_cli.model.scope import Scope
from lagrange_cli.model.start.parts import Parts
from lagrange_cli.records import dataclass, replace
from lagrange_cli.spec.content import by_name, groups_by_name, statements
from lagrange_cli.spec.source import Source
from lagrange_cli.spec.spec import Expression, Spec

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from lagrange_cli.model.start.differentiated import Differentiated

Row = Mapping[int, Any]
"""The coefficients of the velocities in the rate of a constraint, by coordinate."""
Part = tuple[Mapping[int, Any], Mapping[int, Row]]
"""Some of the constraints, by number: their values and these coefficients."""
KEPT = 4
"""States at which values are remembered."""
BENT = 1e-9
"""A constraint on velocities is not linear in them if its slopes change by more, relative to their size."""


@dataclass(frozen=True)
class Rates:
    """sum_k ``rows[i][k]`` q_dot_k + ``drifts[i]`` = 0 for each constraint; the holonomic ones come first.

    ``values`` are those of the constraints themselves: f(q, t), or g(q, q_dot, t).
    """

    values: list[Any]
    rows: list[Row]
    drifts: list[Any]


Solver = Callable[["NDArray[np.float64]"], "NDArray[np.float64]"]
"""Solves M x = b for some coordinates: b (coordinates, columns) to x."""


class Matter(Protocol):
    """The mass matrix M at a place."""

    @property
    def rows(self) -> Mapping[int, Mapping[int, Any]]:
        """M as far as it is not 0."""

    @property
    def extent(self) -> float:
        """sum m r^2 of the particles."""

    def diagonal(self, count: int) -> list[Any]:
        """M_kk of so many coordinates."""

    def times(self, way: Sequence[Any], chosen: Iterable[int]) -> dict[int, Any]:
        """The ``chosen`` rows of M times a vector."""

    def solver(self, chosen: Sequence[int]) -> Solver | None:
        """How M x = b is solved for the ``chosen`` coordinates; None where only the rows are known."""


@dataclass(frozen=True)
class Masses:
    """``Matter`` whose ``rows`` are known."""

    rows: Mapping[int, Mapping[int, Any]]
    extent: float = 0.0

    def diagonal(self, count: int) -> list[Any]:
        return [self.rows.get(k, {}).get(k, 0.0) for k in range(count)]

    def times(self, way: Sequence[Any], chosen: Iterable[int]) -> dict[int, Any]:
        found: dict[int, Any] = dict.fromkeys(chosen, 0.0)
        for j in found:
            for k, m in self.rows.get(j, {}).items():
                found[j] += m * way[k]
        return found

    def solver(self, chosen: Sequence[int]) -> Solver | None:
        return None


class Equations:
    """The constraints of ``spec`` and its masses with these values of the ``parameters``.

    With an ``exact`` module, mpmath's context, numbers have many digits.
    """

    def __init__(self, spec: Spec, parameters: Mapping[str, Any], exact: Any = None) -> None:
        self.spec, self.parameters, self.exact = spec, parameters, exact
        self.coordinates = [one.name for one in spec.coordinates]
        self.size, self.work = len(self.coordinates), Work()
        self.bound = with_what_is_used(spec, spec.all_constraints.values())
        moving = {velocity_name(family_name(name)) for name in self.coordinates}
        energies = {name: one for name, one in spec.potential.items() if depends(spec, one, moving)}
        matter = [*energies.values(), *spec.masses.values(), *spec.embedding.values()]
        matter += [one for body in spec.bodies.values() for one in body.expressions]
        matter += [] if spec.lagrangian is None else [spec.lagrangian]
        bare = with_what_is_used(spec, matter)
        self.moving = replace(
            bare, embedding=spec.embedding, potential=energies, constraints={}, nonholonomic={}
        )
        self._known: dict[Any, Rates] = {}

    def at(self, t: Any, q: Sequence[Any], v: Sequence[Any]) -> Rates:
        """The constraints at a state.

        Raises:
            SpecError: where one of them has no value.
            NotLinear: where one on velocities is not linear in them.
        """
        place = t, *q, *v
        if place not in self._known:
            while len(self._known) >= KEPT:
                del self._known[next(iter(self._known))]
            self._known[place] = self._at(t, q, v)
        return self._known[place]

    def part(self, t: Any, q: Sequence[Any], chosen: Sequence[int]) -> Part:
        """The ``chosen`` ones of the holonomic constraints at a place, in doubles. Raises ``SpecError`` where
        one of them has no value."""
        if not self.spec.bodies and not self.spec.replaced:
            return self._parts.at(t, q, chosen)
        known = None if self._differentiated is None else self._differentiated.at(t, q, chosen)
        if known is not None:
            return known
        found = self.at(t, q, [0.0] * len(q))
        return {i: found.values[i] for i in chosen}, {i: found.rows[i] for i in chosen}

    @cached_property
    def _parts(self) -> Parts:
        return Parts(self.spec, self.parameters, self.coordinates)

    @cached_property
    def _differentiated(self) -> Differentiated | None:
        from lagrange_cli.model.start.differentiated import Differentiated

        try:
            return Differentiated(self.bound, self.parameters, self.coordinates)
        except (SpecError, TooLarge):  # which is explained at a place
            return None

    def _at(self, t: Any, q: Sequence[Any], v: Sequence[Any]) -> Rates:
        found = built_constraints(Scope(self.bound, self.algebra(t, q, v)))
        values, drifts, rows = list[Any](), list[Any](), list[Row]()
        for one in found:
            f: Sloped = one.expression
            values.append(f.value)
            if one.holonomic:
                rows.append({slot - 1: slope for slot, slope in f.slopes.items() if slot > 0})
                if not all(math.isfinite(float(slope)) for slope in f.slopes.values()):
                    raise self._without_derivative(one.name)
                drifts.append(f.slopes.get(0, 0.0))
                continue
            row = {-slot - 1: slope for slot, slope in f.slopes.items() if slot < 0}
            largest = max(map(abs, row.values()), default=0.0)
            bent = any(abs(curve) > BENT * largest for curve in f.curves.values())
            if bent or not all(math.isfinite(float(slope)) for slope in row.values()):
                raise NotLinear(one.name)
            rows.append(row)
            drifts.append(f.value - sum(slope * v[k] for k, slope in row.items()))
        return Rates(values, rows, drifts)

    def _without_derivative(self, name: str) -> SpecError:
        source = Source(self.spec.filename, self.spec.text)
        message = f"constraint '{name}' has no finite derivative at the initial state"
        place = self.spec.all_constraints[name].place
        return source.error(place, message, "start from another state, or write the constraint another way")

    def masses(self, t: Any, q: Sequence[Any], v: Sequence[Any]) -> Masses:
        """d2L/dq_dot dq_dot at a state; nothing where it has no value."""
        try:
            model = build_model(self.moving, self.algebra(t, q, v))
            curves = inertia(model).curves
        except SpecError:
            return Masses({})
        found: dict[int, dict[int, Any]] = {}
        for (i, j), curve in curves.items():
            if curve != 0:
                j, k = -i - 1, -j - 1
                found.setdefault(j, {})[k] = found.setdefault(k, {})[j] = curve
        squares = (float(p.mass.value) * float(x.value) ** 2 for p in model.particles for x in p.position)
        return Masses(found, sum(squares))

    def algebra(self, t: Any, q: Sequence[Any], v: Sequence[Any]) -> SlopedAlgebra:
        """Numbers with slopes, at a state."""
        state = t, q, v
        if self.exact is None:
            return SlopedAlgebra(self.parameters, self.coordinates, state, self.work)
        number = self.exact.mpf

        def read(text: str) -> Any:
            return number(text.replace("_", ""))

        return SlopedAlgebra(self.parameters, self.coordinates, state, self.work, self.exact, read)


def inertia(model: Model[Sloped]) -> Sloped:
    """L, or the terms of T that depend on velocities: they determine the masses."""
    if model.lagrangian is not None:
        return model.lagrangian
    half = model.algebra.number("0.5")
    terms = [half * p.mass * u * u for p in model.particles for u in p.velocity]
    return model.algebra.total([*terms, -model.potential])


def with_what_is_used(spec: Spec, expressions: Iterable[Expression]) -> Spec:
    """The system without definitions and positions that the expressions do not use, and without potential,
    forces, observables and events."""
    needed = used(spec, expressions)
    kept: dict[str, Any] = {
        section: by_name({k: one for k, one in groups_by_name(given).items() if family_name(k) in needed})
        for section, given in (("definitions", spec.definitions), ("embedding", spec.embedding))
    }
    return replace(spec, **kept, potential={}, forces={}, observables={}, events={})


def used(spec: Spec, expressions: Iterable[Expression]) -> set[str]:
    """The names, of families without indices, that expressions and what they are made of contain."""
    made: dict[str, list[Tree]] = {}
    for name, group in chain(*(groups_by_name(one).items() for one in (spec.definitions, spec.embedding))):
        made.setdefault(family_name(name), []).extend(one.tree for one in statements(group))
    for name, body in spec.bodies.items():
        made.setdefault(family_name(name), []).extend(one.tree for one in body.expressions)
    found: set[str] = set()
    pending, seen = [one.tree for one in expressions], set[int]()
    while pending:
        tree = pending.pop()
        if id(tree) in seen:
            continue
        seen.add(id(tree))
        for symbol in names(tree):
            base = family_name(symbol.base)
            if symbol.identifier.partition(".")[2] in MOVING_COMPONENTS:
                found.add(velocity_name(base))
            if base not in found:
                found.add(base)
                pending += made.get(base, ())
    return found


def depends(spec: Spec, expression: Expression, moving: set[str]) -> bool:
    """Whether velocities occur in an expression: those of coordinates, or of places."""
    found = used(spec, [expression])
    return not found.isdisjoint(moving | {*map(velocity_name, spec.order)})
