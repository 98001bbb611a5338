"""The constraints of families at a start: the numbers of all members at once (see ``model.start``)."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from contextlib import suppress
from functools import cached_property
from itertools import combinations
from typing import TYPE_CHECKING, Any

import numpy as np

from lagrange_cli.errors import TooLarge
from lagrange_cli.expression.graph_algebra import GraphAlgebra
from lagrange_cli.expression.index_arrays import Differ
from lagrange_cli.expression.indices import Unsuited
from lagrange_cli.expression.node import Kind, Node, reachable
from lagrange_cli.expression.syntax import ExpressionError
from lagrange_cli.expression.vocabulary import family_name, velocity_name
from lagrange_cli.families.arrays import Domain, Source, Term, Total
from lagrange_cli.families.bonds import Bonds, bonds, bound_families
from lagrange_cli.families.chains import ChainBuilder
from lagrange_cli.families.constraint_values import JointedState, State, Whole
from lagrange_cli.families.joints.articulation import articulation, weights_of
from lagrange_cli.families.joints.platforms import put_on_platforms
from lagrange_cli.families.masses import components, energies_of, masses_of, particles, separated
from lagrange_cli.families.values import DOUBLES, Doubles
from lagrange_cli.model import sparse
from lagrange_cli.model.start.consistent import Start
from lagrange_cli.model.start.dependence import CLEAR
from lagrange_cli.model.start.equations import Equations, Matter, Part, Rates, depends
from lagrange_cli.model.start.linear import DENSE, FILLED
from lagrange_cli.model.start.nearest import ROUND
from lagrange_cli.model.start.search import NEARBY, Generic, Given, away
from lagrange_cli.spec.content import bases_of, names_of
from lagrange_cli.spec.spec import Spec

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Values = NDArray[np.float64]

FEWEST = 50
"""Coordinates of chains and trees below which few constraints are looked at member by member."""
UNKNOWN = "replaced", "left_out", "massless"
"""Parts of a system with which constraints are looked at member by member."""


_LATEST: list[tuple[Spec, bool, Whole | None]] = []
"""The last one, which is asked for once more for another member of an ensemble."""


def whole(spec: Spec, *, exact: bool = False) -> Whole | None:
    """The constraints as those of families, if there are many or many coordinates; None where they are of
    another kind. With many digits, expressions are ``exact``."""
    for known, digits, found in _LATEST:
        if known is spec and digits == exact:
            return found
    _LATEST[:] = [(spec, exact, examined(spec, exact=exact))]
    return _LATEST[0][2]


def examined(spec: Spec, *, exact: bool) -> Whole | None:
    """The same of a system that has not been looked at."""
    if not spec.coordinate_families:
        return None
    if len(spec.all_constraints) <= DENSE and len(spec.coordinates) < FEWEST:
        return None
    speeds = {velocity_name(family_name(name)) for name in bases_of(names_of(spec.coordinates))}
    if any(getattr(spec, part) for part in UNKNOWN):
        return None
    if any(depends(spec, one, speeds) for one in spec.potential.values()):
        return None
    if [name for one, _, _ in bound_families(spec) for name in one.members] != [*spec.all_constraints]:
        return None
    for made in (separate, jointed, on_platforms, together):
        with suppress(Unsuited, Differ, ExpressionError, TooLarge, ArithmeticError):
            found = made(spec, ChainBuilder(spec, algebra_of(exact=exact)))
            if not any(one.kind is Kind.SWITCH for one in reachable([*found.bonds.nodes])):
                return found
    return None


def algebra_of(*, exact: bool) -> GraphAlgebra:
    """The algebra of expressions."""
    if not exact:
        return GraphAlgebra()
    from lagrange_cli.expression.exact import ExactGraphAlgebra

    return ExactGraphAlgebra()


def separate(spec: Spec, builder: ChainBuilder) -> Whole:
    """The constraints where M is diagonal and constant. Raises ``Unsuited`` where it is not, or there are
    few."""
    if spec.bodies or len(spec.all_constraints) <= DENSE:
        raise Unsuited
    if spec.lagrangian is not None:
        _, masses = separated(builder, builder.of_root(spec.lagrangian.tree, spec.lagrangian.indices))
    else:
        masses = masses_of(builder, [*particles(builder, spec)])
    placed = [(domain, x, mass) for _, _, domain, x, mass in components(builder, spec)]
    found = bonds(builder, spec)
    if found is None:
        raise Unsuited
    return Whole([*spec.all_constraints], builder, found, masses, extent_of(placed))


def together(spec: Spec, builder: ChainBuilder) -> Whole:
    """The same where M is constant, but not diagonal, also with few constraints: M has many entries."""
    if spec.bodies:
        raise Unsuited
    energies = energies_of(builder, spec, coupled=True)
    found = bonds(builder, spec)
    if energies.coupled is None or found is None:
        raise Unsuited
    found.pairs  # noqa: B018 - refuses what is coupled to too much
    placed = [(domain, x, mass) for _, _, domain, x, mass in components(builder, spec)]
    names = [*spec.all_constraints]
    return Whole(names, builder, found, energies.masses, extent_of(placed), coupled=energies.coupled)


def on_platforms(spec: Spec, builder: ChainBuilder) -> Whole:
    """The same on chains that hang from platforms."""
    put_on_platforms(builder, spec)
    return jointed(spec, builder)


def jointed(spec: Spec, builder: ChainBuilder) -> Whole:
    """The constraints on chains and trees. Raises ``Unsuited`` where it is of another kind."""
    joints = articulation(builder, spec)
    found = bonds(builder, spec, joints)
    if found is None:
        raise Unsuited
    placed = weights_of(builder, spec)
    none = Total(Source.TOTAL, builder.q.count)
    return Whole([*spec.all_constraints], builder, found, none, extent_of(placed), joints)


def extent_of(placed: Iterable[tuple[Domain, Node, Node]]) -> Total:
    """sum m x^2 of places and masses."""
    terms = [Term(domain, mass * x * x, domain.together) for domain, x, mass in placed]
    return Total(Source.TOTAL, 1, tuple(terms))


def equations_of(spec: Spec, parameters: Mapping[str, Any], *, exact: bool = False) -> WholeEquations | None:
    """The constraints and masses of a system with these numbers, which have many digits if they are
    ``exact``; None where they are of another kind."""
    found = whole(spec, exact=exact)
    if found is None:
        return None
    kind = DOUBLES
    if exact:
        from lagrange_cli.families.long_values import LongNumbers

        kind = LongNumbers()
    return WholeEquations(found, spec, parameters, kind)


class WholeEquations:
    """What ``model.start.equations.Equations`` gives, of all members at once, in numbers of a ``kind``."""

    def __init__(
        self, system: Whole, spec: Spec, parameters: Mapping[str, Any], kind: Doubles = DOUBLES
    ) -> None:
        self.system, self.spec, self.kind = system, spec, kind
        self.given = kind.array([parameters[name] for name in names_of(spec.parameters)])
        self._known: tuple[Any, ...] = ()
        self._found: State | None = None

    def state(self, t: Any, q: Sequence[Any], v: Sequence[Any]) -> State:
        """The numbers at a state."""
        key = t, *q, *v
        if self._found is None or self._known != key:
            self._known = key
            made = State if self.system.joints is None else JointedState
            self._found = made(self.system, self.kind, self.given, t, q, v)
        return self._found

    def at(self, t: Any, q: Sequence[Any], v: Sequence[Any]) -> Rates:
        """The constraints at a state. Raises ``SpecError`` where one of them has no value."""
        found = self.state(t, q, v)
        found.refuse()
        return Rates(found.values.tolist(), [*found.rows], found.drifts.tolist())

    def part(self, t: float, q: Sequence[float], chosen: Sequence[int]) -> Part:
        """Some of the constraints. Raises ``SpecError`` where one of them has no value."""
        if len(chosen) <= DENSE and self.system.joints is None:
            return self._few.part(t, q, chosen)
        found = self.at(t, q, [0.0] * len(q))
        return {i: found.values[i] for i in chosen}, {i: found.rows[i] for i in chosen}

    @cached_property
    def _few(self) -> Equations:
        return Equations(self.spec, dict(zip(names_of(self.spec.parameters), self.given.tolist())))

    def masses(self, t: Any, q: Sequence[Any], v: Sequence[Any]) -> Matter:
        """d2L/dq_dot dq_dot at a state, and sum m r^2."""
        return self.state(t, q, v).masses

    def satisfied(self, given: Given) -> Start | None:
        """The given state as a consistent start, where it clearly is one: every value is given, all
        constraints hold but for rounding, and they are independent. None where a closer look is needed."""
        here = self.state(given.t, given.q, given.v)
        bonds = here.system.bonds
        if given.open_q or any(one.holds for one in bonds.bounds) or twice(bonds):
            return None
        mass = here.inertia
        if not np.all(mass > 0.0):
            return None
        with np.errstate(all="ignore"):
            whole = math.sqrt(max(float(np.sum(mass * here.q**2)), here.extent))
            scale = whole / np.sqrt(mass)
            steep = np.sqrt(here.squares(scale))
            off = np.abs(here.values)
            off[bonds.holonomic :] = 0.0
            if not np.all((steep > 0.0) & (off <= 2 * ROUND * steep)):
                return None
            rates = here.rates(here.v) + here.drifts
            fastest = here.squares(math.sqrt(float(np.sum(mass * here.v**2))) / np.sqrt(mass))
            least = 0.0 if given.open_v else 2 * ROUND
            if not np.all(np.abs(rates) <= least * np.maximum(np.sqrt(fastest), np.abs(here.drifts))):
                return None
            if not clearly_independent(here, scale, steep):
                return None
            near = away(given.q, scale.tolist(), 0, NEARBY / math.sqrt(len(scale)))
            there = self.state(given.t, near, given.v)
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
