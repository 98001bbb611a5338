"""``Residual``: the equations of motion in the implicit form that the Taylor series are solved from.

R_k(q, q_dot, q_ddot, t) = 0, affine in the accelerations with the matrix M = dR/dq_ddot. Time derivatives
stay unexpanded ``ddt`` nodes: their Taylor coefficients come from those of their arguments, so that
neither M^-1 nor M is ever a series. ``derive`` makes it.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import cached_property, reduce
from operator import or_
from typing import Any

from lagrange_cli.expression.graph import Graph
from lagrange_cli.expression.node import Node, union
from lagrange_cli.mechanics.conservation import Conserved
from lagrange_cli.mechanics.matrices import connected
from lagrange_cli.mechanics.rows import Matrix, Row
from lagrange_cli.mechanics.variables import nonzero, variables
from lagrange_cli.model.model import Constraint, Model
from lagrange_cli.records import dataclass, replace
from lagrange_cli.series.lowering import lower
from lagrange_cli.series.program import SeriesProgram


@dataclass(frozen=True)
class CyclicMomentum:
    """A constant of the motion in place of a velocity: ``symbol`` stands for it in the equations.

    ``momentum`` is its expression in q, q_dot, t; ``speed`` that of ``velocity`` in q, t, such symbols and
    velocities that no constant is in place of.
    """

    symbol: Node
    momentum: Node
    velocity: Node
    speed: Node


@dataclass(frozen=True)
class Dependent:
    """A coordinate that a constraint gives: it is not among the unknowns, but is a part of the state.

    ``index`` is its place among all coordinates, ``q`` and ``v`` are its symbols. ``place`` and ``speed`` are
    they as functions of the other coordinates, their velocities, and t. ``place`` is None where the
    constraint is one on velocities, and the coordinate the integral of its velocity.
    """

    name: str
    constraint: str
    index: int
    q: Node
    v: Node
    place: Node | None
    speed: Node


@dataclass(frozen=True)
class Contact:
    """Where a motion may rest: at the ``event`` of that number, held by the generalized forces ``multiplier``
    times ``force`` (one for each coordinate) while ``rest`` is 1 or -1, and not 0. Without constraints it
    would change the accelerations along the ``direction``."""

    event: int
    multiplier: Node
    rest: Node
    force: Row
    direction: Row


@dataclass(frozen=True)
class Residual:
    """The equations R(q, q_dot, q_ddot, t) = 0 of a model over the graph.

    ``residual[k]`` is R_k with ``ddt`` nodes; ``mass_matrix[j][k]`` = dR_j/dq_ddot_k in q, q_dot, t. Behind
    the coordinates are the constraints and their ``multipliers``, which the equations are linear in, too;
    ``cyclic_momenta`` take the places of velocities: known from the start of a motion, and constant.
    ``inertias`` are what the equations were divided by: where one is 0, so is the determinant of the masses.
    ``definite`` tells that the matrix is symmetric and positive (a kinetic energy of masses).
    ``formulation`` names the form that was chosen and ``costs`` the convolutions that each form takes
    per order.
    ``cyclic`` names the coordinates that L does not contain, ``conserved`` the conserved quantities (between
    events). Coordinates that are ``weightless`` have no inertia of their own. The multipliers of ``contacts``
    stand in the equations like accelerations. Forces that depend on multipliers have ``pushed`` the matrix
    out of its symmetry; without these forces the equations are ``quiet``, where they are not linear in
    multipliers. Of some equations and their coordinates the series are known already (``lowered``).
    The ``model`` may be that of some coordinates only, from which the others follow: these are
    ``dependent``, in order.
    """

    model: Model[Node]
    graph: Graph
    residual: tuple[Node, ...]
    mass_matrix: Matrix
    cyclic_momenta: tuple[CyclicMomentum, ...]
    inertias: tuple[Node, ...]
    definite: bool
    formulation: str
    costs: Mapping[str, int]
    scleronomic: bool
    cyclic: tuple[str, ...]
    conserved: tuple[Conserved, ...]
    contacts: tuple[Contact, ...] = ()
    weightless: frozenset[int] = frozenset()
    pushed: bool = False
    quiet: Residual | None = None
    lowered: tuple[tuple[Node, ...], SeriesProgram] | None = None
    dependent: tuple[Dependent, ...] = ()
    surplus: frozenset[int] = frozenset()

    @property
    def coordinates(self) -> tuple[str, ...]:
        """The names of the coordinates, in the order of q."""
        return self.model.coordinates

    def series(self, integrands: Sequence[Node] = (), own: int = 0, apart: bool = False) -> SeriesProgram:
        """The series of the equations, and of the quadratures of ``integrands`` (see ``lower``)."""
        model, rows = self.model, (*self.residual, *self.model.q)
        if not integrands and self.lowered is not None and self.lowered[0] == rows:
            return self.lowered[1]
        following = {one.index: (one.place, one.speed) for one in self.dependent}
        given = self.variables, self.state_q, self.state_v, model.time, self.residual, integrands
        return lower(self.graph, *given, self.multipliers, own=own, apart=apart, dependent=following)

    @cached_property
    def state_q(self) -> tuple[Node, ...]:
        """The coordinates, those that follow from others at their places."""
        found = [*self.model.q]
        for one in self.dependent:
            found.insert(one.index, one.q)
        return tuple(found)

    @cached_property
    def state_v(self) -> tuple[Node, ...]:
        """Their velocities."""
        found = [*self.model.v]
        for one in self.dependent:
            found.insert(one.index, one.v)
        return tuple(found)

    @cached_property
    def unknown(self) -> tuple[int, ...]:
        """The places of the coordinates of ``model`` among all."""
        gone = {one.index for one in self.dependent}
        return tuple(k for k in range(len(self.state_q)) if k not in gone)

    @cached_property
    def multipliers(self) -> tuple[Node, ...]:
        """The multipliers of the model's constraints."""
        return tuple(one.multiplier for one in self.model.constraints)

    @cached_property
    def independent(self) -> Model[Node]:
        """The model without the constraints that follow from others, which are redundant in it."""
        constraints, gone = [*self.model.constraints], list[Constraint[Node]]()
        for i in sorted(self.surplus, reverse=True):
            gone.insert(0, constraints.pop(i))
        redundant = (*self.model.redundant, *gone)
        return (
            replace(self.model, constraints=tuple(constraints), redundant=redundant) if gone else self.model
        )

    @cached_property
    def unpushed(self) -> Residual:
        """The same with the matrix without forces that depend on multipliers: for projections onto the
        constraints, and of impulses."""
        if not self.pushed:
            return self
        matrix, first = self.mass_matrix, len(self.mass_matrix) - len(self.multipliers)
        upper = [(*row[:first], *(other[j] for other in matrix[first:])) for j, row in enumerate(matrix)]
        return replace(self, mass_matrix=(*upper[:first], *matrix[first:]), pushed=False)

    @cached_property
    def found(self) -> dict[str, Any]:
        """What has been found out about the equations, by name, for stages that ask again."""
        return {}

    @cached_property
    def bent(self) -> bool:
        """Whether the equations are not linear in the multipliers."""
        bound = union(self.multipliers)
        return self.pushed and any(entry.symbols & bound for row in self.mass_matrix for entry in row)

    @property
    def bound(self) -> bool:
        """Whether constraints hold the state, also those that give coordinates."""
        return bool(self.multipliers or self.dependent)

    @property
    def timed(self) -> bool:
        """Whether the equations depend on t explicitly."""
        followed = (one.speed if one.place is None else one.place for one in self.dependent)
        return any(row.symbols & self.model.time.symbols for row in (*self.residual, *followed))

    @cached_property
    def variables(self) -> int:
        """Bit set of the symbols that change along a motion: q, q_dot and t."""
        return reduce(
            or_, (x.symbols for one in self.dependent for x in (one.q, one.v)), variables(self.model)
        )

    @cached_property
    def blocks(self) -> tuple[tuple[int, ...], ...]:
        """Coordinates that the mass matrix couples: its block-diagonal structure."""
        return connected(self.mass_matrix)

    @cached_property
    def entries(self) -> tuple[Mapping[int, Node], ...]:
        """The entries of the mass matrix that are not 0, row by row."""
        zero = self.graph.zero
        return tuple({k: row[k] for k in nonzero(row, zero, j)} for j, row in enumerate(self.mass_matrix))

    @cached_property
    def separate(self) -> bool:
        """Whether every acceleration stands alone in its equation, with a constant of the motion."""
        bound = self.multipliers or self.cyclic_momenta or self.inertias or self.dependent
        return not bound and self.constant_mass_matrix and len(self.blocks) == len(self.model.q)

    @cached_property
    def constant_mass_matrix(self) -> bool:
        """Whether the mass matrix depends on nothing but parameters."""
        return all(not entry.symbols & self.variables for row in self.entries for entry in row.values())
