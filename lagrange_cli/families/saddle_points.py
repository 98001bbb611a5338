"""Equations for accelerations and multipliers together, where M is not diagonal, or no constant:

    M a - A^T lambda = F,    -A a = c,

with the slopes A of the constraints, if there are any, and the rest c of their second derivatives (first
ones, of those on velocities). The matrix is symmetric and indefinite (M. Benzi, G. H. Golub and J. Liesen,
Numerical solution of saddle point problems, Acta Numerica 14, 2005). A constraint is eliminated behind all
coordinates that it contains: then no pivot is 0 as long as M is positive and the constraints are independent.
"""

from __future__ import annotations

from functools import cached_property

import numpy as np

from lagrange_cli.expression.index_arrays import Places, distinct
from lagrange_cli.expression.indices import Unsuited
from lagrange_cli.families.bonds import Bonds
from lagrange_cli.families.coupled_masses import CoupledMasses
from lagrange_cli.families.elimination import TOGETHER, Blocks, elimination_of, in_blocks, parts_of
from lagrange_cli.model.sparse import SparseElimination
from lagrange_cli.records import dataclass, replace


@dataclass(frozen=True, eq=False)
class SaddlePoint:
    """The matrix of these ``masses`` and ``bonds``: the unknowns are those of all coordinates, and then those
    of all constraints."""

    masses: CoupledMasses
    bonds: Bonds
    pivoting: bool = False
    """Whether pivots are chosen in each step, as M need not be positive."""

    @property
    def count(self) -> int:
        """The number of unknowns."""
        return self.masses.count + self.bonds.count

    @cached_property
    def _listed(self) -> tuple[list[Places], Places]:
        """Where each column of A goes among the entries, and the places of these."""
        size, bounds = self.count, self.bonds.bounds
        keys = [
            (self.masses.count + bounds[b].numbers) * size + bounds[b].rows[a] for b, a in self.bonds.pulls
        ]
        found = distinct(np.concatenate([np.zeros(0, dtype=np.int64), *keys]))
        before = len(self.masses.pairs)
        return [before + np.searchsorted(found, one) for one in keys], np.stack(
            np.divmod(found, size), axis=1
        )

    @property
    def places(self) -> list[Places]:
        """Where the numbers of each of the bonds' ``pulls`` go."""
        return self._listed[0]

    @cached_property
    def pairs(self) -> Places:
        """The places of the entries (entries, 2), those of M first: the larger number first."""
        return np.concatenate([self.masses.pairs, self._listed[1]])

    @property
    def places_of_entries(self) -> Places:
        """The same."""
        return self.pairs

    @cached_property
    def elimination(self) -> SparseElimination | None:
        """How the matrix is factored; None where it is taken as dense. Raises ``Unsuited`` where L has too
        many numbers."""
        return elimination_of(self.count, self.pairs, self.masses.count)

    @cached_property
    def blocks(self) -> Blocks:
        """How it is factored in blocks, as far as constraints are tied. Raises ``Unsuited`` likewise."""
        first = self.masses.count
        tied = [[first + i for i in group] for group in self.bonds.tied]
        return in_blocks(self.count, self.pairs, tied, first)

    @property
    def in_blocks(self) -> bool:
        """Whether the matrix is factored in blocks."""
        return self.pivoting or bool(self.bonds.surplus)

    def pivoted(self) -> SaddlePoint:
        """The same with pivoting. Raises ``Unsuited`` where too many unknowns meet each other."""
        if any(len(part) > TOGETHER for part in parts_of(self.count, self.pairs)):
            raise Unsuited
        return replace(self, pivoting=True)

    @property
    def sizes(self) -> Places:
        """What each pivot is compared with: of coordinates the entry on the diagonal, of constraints a number
        behind the entries, 0 and 1."""
        diagonal = np.flatnonzero(self.masses.pairs[:, 0] == self.masses.pairs[:, 1])
        return np.concatenate([diagonal, len(self.pairs) + 2 + np.arange(self.bonds.count)])


def refuse_coupled(equations: Bonds | SaddlePoint) -> None:
    """Raise ``Unsuited`` where too much is coupled for these to be solved."""
    bonds = equations if isinstance(equations, Bonds) else equations.bonds
    equations.blocks if bonds.surplus else equations.elimination  # noqa: B018 - found once
