"""``Residual``: the equations of motion in the implicit form that the Taylor series are solved from.

R_k(q, q_dot, q_ddot, t) = 0, affine in the accelerations with the matrix M = dR/dq_ddot. Time derivatives
stay unexpanded ``ddt`` nodes: their Taylor coefficients come from those of their arguments, so that
neither M^-1 nor M is ever a series. ``derive`` makes it.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import cached_property

from lagrange_cli.expression.graph import Graph
from lagrange_cli.expression.node import Node
from lagrange_cli.mechanics.conservation import Conserved
from lagrange_cli.mechanics.variables import variables
from lagrange_cli.model.model import Model
from lagrange_cli.records import dataclass


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
class Contact:
    """Where a motion may rest: at the ``event`` of that number, held by the generalized forces ``multiplier``
    times ``force`` (one for each coordinate) while ``rest`` is 1 or -1, and not 0."""

    event: int
    multiplier: Node
    rest: Node
    force: tuple[Node, ...]


@dataclass(frozen=True)
class Residual:
    """The equations R(q, q_dot, q_ddot, t) = 0 of a model over the graph.

    ``residual[k]`` is R_k with ``ddt`` nodes; ``mass_matrix[j][k]`` = dR_j/dq_ddot_k in q, q_dot, t;
    ``cyclic_momenta`` take the places of velocities: known from where a motion begins,
    the same ever after.
    ``inertias`` are what the equations were divided by: where one is 0, so is the determinant of the masses.
    ``definite`` tells that the matrix is symmetric and positive (a kinetic energy of masses).
    ``formulation`` names the form that was chosen and ``costs`` the convolutions that each form takes
    per order.
    ``cyclic`` names the coordinates that L does not contain, ``conserved`` what every motion keeps (between
    events). The multipliers of ``contacts`` stand in the equations like accelerations.
    """

    model: Model[Node]
    graph: Graph
    residual: tuple[Node, ...]
    mass_matrix: tuple[tuple[Node, ...], ...]
    cyclic_momenta: tuple[CyclicMomentum, ...]
    inertias: tuple[Node, ...]
    definite: bool
    formulation: str
    costs: Mapping[str, int]
    scleronomic: bool
    cyclic: tuple[str, ...]
    conserved: tuple[Conserved, ...]
    contacts: tuple[Contact, ...] = ()

    @property
    def coordinates(self) -> tuple[str, ...]:
        """The names of the coordinates, in the order of q."""
        return self.model.coordinates

    @cached_property
    def variables(self) -> int:
        """Bit set of the symbols that change along a motion: q, q_dot and t."""
        return variables(self.model)

    @cached_property
    def blocks(self) -> tuple[tuple[int, ...], ...]:
        """Coordinates that the mass matrix couples: its block-diagonal structure."""
        return connected(self.mass_matrix)

    @cached_property
    def constant_mass_matrix(self) -> bool:
        """Whether the mass matrix depends on nothing but parameters."""
        return all(not entry.symbols & self.variables for row in self.mass_matrix for entry in row)


def connected(matrix: Sequence[Sequence[Node]]) -> tuple[tuple[int, ...], ...]:
    """The index sets that a matrix's nonzero entries connect, each sorted, in order of first index."""
    neighbours: list[set[int]] = [set() for _ in matrix]
    zero = matrix[0][0].graph.zero if matrix else None
    for j, row in enumerate(matrix):
        for k, entry in enumerate(row):
            if entry is not zero:
                neighbours[j].add(k)
                neighbours[k].add(j)
    blocks = []
    done: set[int] = set()
    for first in range(len(matrix)):
        block: set[int] = set()
        pending = set() if first in done else {first}
        while pending:
            block |= pending
            pending = set[int]().union(*(neighbours[j] for j in pending)) - block
        if block:
            done |= block
            blocks.append(tuple(sorted(block)))
    return tuple(blocks)
