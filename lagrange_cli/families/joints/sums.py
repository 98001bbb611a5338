"""Numbers of joints whose coordinates are sums of those of the system, u = C q (see ``joints.relative``)."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np

from lagrange_cli.families.arrays import NONE, Tree
from lagrange_cli.families.joints.relative import Relative
from lagrange_cli.families.values import FamilyValues
from lagrange_cli.records import dataclass

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Numbers: TypeAlias = NDArray[Any]


@dataclass(frozen=True, eq=False)
class Sums:
    """C at a state: u_k = ``factors[k]`` q_k and that of the coordinate before, along a ``tree``. Vectors
    may be side by side, as the columns of matrices."""

    tree: Tree
    factors: Numbers

    @staticmethod
    def of(relative: Relative, numbers: FamilyValues) -> Sums:
        factors = numbers.kind.zeros(len(relative.before))
        for one in relative.steps:
            factors[one.rows] = numbers.node(one.factor)
        return Sums(relative.tree, factors)

    def summed(self, rates: Numbers) -> Numbers:
        """C times a vector."""
        made: Numbers = self._columns(rates) * rates
        along(self.tree, made)
        return made

    def felt(self, forces: Numbers) -> Numbers:
        """C^T times a vector."""
        made: Numbers = forces.copy()
        along(self.tree, made, back=True)
        return np.asarray(self._columns(forces) * made)

    def apart(self, sums: Numbers) -> Numbers:
        """C^-1 times a vector."""
        made, (has, before) = sums.copy(), self._before
        made[has] -= sums[before]
        return np.asarray(made / self._columns(sums))

    def divided(self, forces: Numbers) -> Numbers:
        """C^-T times a vector."""
        (has, before), own = self._before, forces / self._columns(forces)
        made: Numbers = own.copy()
        np.subtract.at(made, before, own[has])
        return made

    def _columns(self, vector: Numbers) -> Numbers:
        return self.factors.reshape(-1, *[1] * (vector.ndim - 1))

    @property
    def _before(self) -> tuple[Numbers, Numbers]:
        """Which coordinates have one before, and these."""
        has = self.tree.parents != NONE
        return has, self.tree.parents[has]


def along(tree: Tree | None, values: Numbers, *, back: bool = False) -> None:
    """Add numbers (nodes, ...) up along a tree from the roots on, or from the tips on, in place."""
    if tree is None:
        return
    if tree.is_chain:
        way = values[::-1] if back else values
        np.add.accumulate(way, out=way)
        return
    order, parents = tree.order.tolist(), tree.parents.tolist()
    for node in reversed(order) if back else order:
        if parents[node] != NONE:
            if back:
                values[parents[node]] += values[node]
            else:
                values[node] += values[parents[node]]
