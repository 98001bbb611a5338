"""The constraints of families at a start: the numbers of all members at once (see ``model.start``)."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from contextlib import suppress
from functools import cached_property
from itertools import combinations
from typing import TYPE_CHECKING, Any

import numpy as np

from lagrange_cli.errors import TooLarge
from lagrange_cli.expression.index_arrays import Differ
from lagrange_cli.expression.indices import Unsuited
from lagrange_cli.expression.node import Kind, reachable
from lagrange_cli.expression.syntax import ExpressionError
from lagrange_cli.expression.vocabulary import family_name, velocity_name
from lagrange_cli.families.arrays import Source, Term, Total, total_of
from lagrange_cli.families.bonds import Bonds, bonds
from lagrange_cli.families.builder import FamilyBuilder
from lagrange_cli.families.chains import ChainBuilder
from lagrange_cli.families.masses import components, particles
from lagrange_cli.families.values import FamilyValues
from lagrange_cli.model import sparse
from lagrange_cli.model.start.consistent import Start
from lagrange_cli.model.start.equations import Equations, Masses, Part, Rates, depends
from lagrange_cli.model.start.generic import FAINT
from lagrange_cli.model.start.linear import CLEAR, DENSE, FILLED
from lagrange_cli.model.start.nearest import ROUND
from lagrange_cli.model.start.search import NEARBY, Generic, Given, away
from lagrange_cli.records import dataclass
from lagrange_cli.spec.content import bases_of, names_of
from lagrange_cli.spec.spec import Spec, grouped

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Values = NDArray[np.float64]

UNKNOWN = "nonholonomic", "bodies", "replaced", "left_out"
"""Parts of a system with which constraints are looked at member by member."""


@dataclass(frozen=True, eq=False)
class Whole:
    """The constraints of a system of families, in the order of their ``names``; its masses, which are
    constant, and sum m r^2."""

    names: Sequence[str]
    builder: FamilyBuilder
    bonds: Bonds
    masses: Total
    extent: Total


_LATEST: list[tuple[Spec, Whole | None]] = []
"""The last one, which is asked for once more for another member of an ensemble."""


def whole(spec: Spec) -> Whole | None:
    """The constraints as those of families, if there are many; None where they are of another kind."""
    for known, found in _LATEST:
        if known is spec:
            return found
    _LATEST[:] = [(spec, examined(spec))]
    return _LATEST[0][1]


def examined(spec: Spec) -> Whole | None:
    """The same of a system that has not been looked at."""
    if not spec.families.get("coordinates") or len(spec.constraints) <= DENSE or spec.lagrangian is not None:
        return None
    speeds = {velocity_name(family_name(name)) for name in bases_of(names_of(spec.coordinates))}
    if any(getattr(spec, part) for part in UNKNOWN):
        return None
    if any(depends(spec, one, speeds) for one in spec.potential.values()):
        return None
    names = [*spec.constraints]
    families = grouped(spec.constraints, spec.families.get("constraints", {}))
    if [name for one in families for name in one.members] != names:
        return None
    with suppress(Unsuited, Differ, ExpressionError, TooLarge, ArithmeticError):
        builder = ChainBuilder(spec)
        found = bonds(builder, spec)
        if found is None or any(one.kind is Kind.SWITCH for one in reachable([*found.nodes])):
            return None
        moving = particles(builder, spec)
        terms = [Term(one.domain, one.mass * one.slope * one.slope, one.rows) for one in moving]
        squares = [
            Term(domain, mass * x * x, np.zeros(domain.count, dtype=np.int64))
            for _, _, domain, x, mass in components(builder, spec)
        ]
        extent = Total(Source.TOTAL, 1, tuple(squares))
        return Whole(names, builder, found, total_of(builder.q.count, terms, builder.graph), extent)
    return None


class WholeEquations:
    """What ``model.start.equations.Equations`` gives, of all members at once, in doubles."""

    def __init__(self, system: Whole, spec: Spec, parameters: Mapping[str, Any]) -> None:
        self.system, self.spec = system, spec
        self.given = np.array([float(parameters[name]) for name in names_of(spec.parameters)])
        self._known: tuple[Any, ...] = ()
        self._found: State | None = None

    def state(self, t: float, q: Sequence[float], v: Sequence[float]) -> State:
        """The numbers at a state."""
        key = t, *q, *v
        if self._found is None or self._known != key:
            self._known = key
            self._found = State(self, float(t), np.array(q, dtype=np.float64), np.array(v, dtype=np.float64))
        return self._found

    def at(self, t: float, q: Sequence[float], v: Sequence[float]) -> Rates:
        """The constraints at a state. Raises ``SpecError`` where one of them has no value."""
        found = self.state(t, q, v)
        found.refuse()
        return Rates(found.values.tolist(), [*found.rows], found.drifts.tolist())

    def part(self, t: float, q: Sequence[float], chosen: Sequence[int]) -> Part:
        """Some of the constraints. Raises ``SpecError`` where one of them has no value."""
        if len(chosen) <= DENSE:
            return self._few.part(t, q, chosen)
        found = self.at(t, q, [0.0] * len(q))
        return {i: found.values[i] for i in chosen}, {i: found.rows[i] for i in chosen}

    @cached_property
    def _few(self) -> Equations:
        return Equations(self.spec, dict(zip(names_of(self.spec.parameters), self.given.tolist())))

    def masses(self, t: float, q: Sequence[float], v: Sequence[float]) -> Masses:
        """d2L/dq_dot dq_dot at a state, and sum m r^2."""
        found = self.state(t, q, v)
        return Masses({k: {k: m} for k, m in enumerate(found.inertia.tolist()) if m}, found.extent)


class State:
    """Numbers at one state."""

    def __init__(self, equations: WholeEquations, t: float, q: Values, v: Values) -> None:
        self.equations, self.t, self.q, self.v = equations, t, q, v
        self.system: Whole = equations.system
        with np.errstate(all="ignore"):
            builder, bounds = self.system.builder, self.system.bonds.bounds
            self.numbers = FamilyValues(builder, t, q, v, equations.given)
            self.values = self._of([one.node for one in bounds])
            self.drifts = self._of([builder.graph.diff(one.node, builder.time) for one in bounds])
            self.slopes = [
                [np.broadcast_to(self.numbers.node(a), one.domain.count) for a in one.slopes]
                for one in bounds
            ]

    def _of(self, nodes: Sequence[Any]) -> Values:
        """A number for each constraint."""
        made = np.zeros(self.system.bonds.count)
        for one, node in zip(self.system.bonds.bounds, nodes):
            np.add.at(made, one.numbers, self.numbers.node(node))
        return made

    @cached_property
    def inertia(self) -> Values:
        """M."""
        return self.numbers.of(self.system.masses)

    @cached_property
    def extent(self) -> float:
        """sum m r^2."""
        with np.errstate(all="ignore"):
            return float(self.numbers.of(self.system.extent)[0])

    @cached_property
    def rows(self) -> list[dict[int, float]]:
        """A, row by row."""
        made: list[dict[int, float]] = [{} for _ in range(self.system.bonds.count)]
        for one, slopes in zip(self.system.bonds.bounds, self.slopes):
            for places, values in zip(one.rows, slopes):
                for i, k, a in zip(one.numbers.tolist(), places.tolist(), values.tolist()):
                    made[i][k] = made[i].get(k, 0.0) + a
        return made

    def squares(self, scale: Values) -> Values:
        """The squares of the changes of constraints with q_k/``scale[k]``."""
        made = np.zeros(self.system.bonds.count)
        for one, slopes in zip(self.system.bonds.bounds, self.slopes):
            for places, values in zip(one.rows, slopes):
                np.add.at(made, one.numbers, (values * scale[places]) ** 2)
        return made

    def faint(self, scale: Values) -> NDArray[np.bool_]:
        """Which constraints have a slope that is all but 0 beside others (``generic.faint``)."""
        least, most = np.full(self.system.bonds.count, np.inf), np.zeros(self.system.bonds.count)
        for one, slopes in zip(self.system.bonds.bounds, self.slopes):
            for places, values in zip(one.rows, slopes):
                size = np.abs(values * scale[places])
                np.minimum.at(least, one.numbers, size)
                np.maximum.at(most, one.numbers, size)
        return least <= FAINT * most

    def rates(self, v: Values) -> Values:
        """A v."""
        made = np.zeros(self.system.bonds.count)
        for one, slopes in zip(self.system.bonds.bounds, self.slopes):
            for places, values in zip(one.rows, slopes):
                np.add.at(made, one.numbers, values * v[places])
        return made

    def refuse(self) -> None:
        """Raise ``SpecError`` at a constraint that has no value or no derivative."""
        if not np.all(np.isfinite(self.values + self.drifts + self.squares(np.ones(len(self.q))))):
            spec = self.equations.spec
            known = dict(zip(names_of(spec.parameters), self.equations.given.tolist()))
            Equations(spec, known).at(self.t, self.q.tolist(), self.v.tolist())
            raise ArithmeticError("a constraint has no value")


def satisfied(equations: WholeEquations, given: Given) -> Start | None:
    """The given state as a consistent start, where it clearly is one: every value is given, all constraints
    hold but for rounding, and they are independent. None where a closer look is needed."""
    here = equations.state(given.t, given.q, given.v)
    bonds, mass = here.system.bonds, here.inertia
    if given.open_q or not np.all(mass > 0.0) or twice(bonds):
        return None
    with np.errstate(all="ignore"):
        whole = math.sqrt(max(float(np.sum(mass * here.q**2)), here.extent))
        scale = whole / np.sqrt(mass)
        steep = np.sqrt(here.squares(scale))
        if not np.all((steep > 0.0) & (np.abs(here.values) <= 2 * ROUND * steep)):
            return None
        rates = here.rates(here.v) + here.drifts
        fastest = here.squares(math.sqrt(float(np.sum(mass * here.v**2))) / np.sqrt(mass))
        least = 0.0 if given.open_v else 2 * ROUND
        if not np.all(np.abs(rates) <= least * np.maximum(np.sqrt(fastest), np.abs(here.drifts))):
            return None
        if not clearly_independent(here, scale, steep):
            return None
        near = away(given.q, scale.tolist(), 0, NEARBY / math.sqrt(len(scale)))
        there = equations.state(given.t, near, given.v)
        typical = np.sqrt(there.squares(scale))
    if not np.all(np.isfinite(typical)):
        return None
    names = here.system.names
    faint = tuple(names[i] for i in np.flatnonzero(here.faint(scale) & there.faint(scale)).tolist())
    known = Generic(tuple(range(bonds.count)), tuple(typical.tolist()))
    return Start(tuple(given.q), tuple(given.v), (), (), (), (), known, faint, {})


def twice(bonds: Bonds) -> bool:
    """Whether a constraint has a coordinate at two places."""
    if any(np.any(one == other) for bound in bonds.bounds for one, other in combinations(bound.rows, 2)):
        return True
    terms = [(one.numbers, rows) for one in bonds.bounds if not one.whole for rows in one.rows]
    if not terms:
        return False
    met = np.concatenate([np.stack(one, axis=1) for one in terms])
    return len(np.unique(met, axis=0)) < len(met)


def clearly_independent(here: State, scale: Values, steep: Values) -> bool:
    """Whether slopes, which are as ``steep`` with q_k/``scale[k]``, are at clear angles to each other."""
    bonds = here.system.bonds
    pairs, places = bonds.pairs
    products = np.zeros(len(places))
    for pair in pairs:
        (b, a), (c, d) = pair.first, pair.second
        one, other = here.slopes[b][a][pair.members[0]], here.slopes[c][d][pair.members[1]]
        products += np.bincount(pair.entries, one * other * scale[pair.rows] ** 2, len(products))
    products /= steep[places[:, 0]] * steep[places[:, 1]]
    matrix: list[dict[int, float]] = [{} for _ in range(bonds.count)]
    for (i, j), x in zip(places.tolist(), products.tolist()):
        matrix[i][j] = matrix[j][i] = x
    factors = sparse.factored(matrix, FILLED * bonds.count)
    return factors is not None and min(factors.pivots) > CLEAR
