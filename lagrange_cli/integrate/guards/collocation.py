"""Collocation at Gauss's nodes: the polynomial through values there, and its integrals."""

from __future__ import annotations

from functools import cache
from typing import TYPE_CHECKING

import numpy as np
from numpy.polynomial.legendre import legint, legvander

from lagrange_cli.integrate.guards.gauss import gauss
from lagrange_cli.records import dataclass

if TYPE_CHECKING:
    from lagrange_cli.integrate.arrays import Array

STAGES = 8
"""Nodes."""


@dataclass(frozen=True)
class Rule:
    """Collocation at Gauss's ``nodes`` on [0, 1]: ``series`` gives the coefficients of Legendre's polynomials
    from values there, ``once`` and ``twice`` their integrals up to the nodes."""

    nodes: Array
    series: Array
    once: Array
    twice: Array

    def until(self, end: float) -> tuple[Array, Array]:
        """The weights of the integral from 0 to some part, and of the integral of that."""
        return up_to(np.array([end]), self.series, 1)[0], up_to(np.array([end]), self.series, 2)[0]


def up_to(ends: Array, series: Array, times: int) -> Array:
    """The weights of integrals from 0 to some parts, repeated some times."""
    integrals = legint(np.eye(STAGES), times, lbnd=-1, scl=0.5)
    weights: Array = legvander(2.0 * ends - 1.0, STAGES - 1 + times) @ integrals @ series
    return weights


@cache
def rule() -> Rule:
    """That of all nodes."""
    nodes, weights = (np.array(one) for one in zip(*gauss(STAGES)))
    values = legvander(2.0 * nodes - 1.0, STAGES - 1) * weights[:, None]
    series = (values * (2.0 * np.arange(STAGES) + 1.0)).T
    return Rule(nodes, series, up_to(nodes, series, 1), up_to(nodes, series, 2))
