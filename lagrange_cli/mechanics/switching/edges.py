"""Edges of domains that steps would pass: what the equations are made of has a value beyond them.

Where sqrt(u), u**1.5 or log(u) stands in the equations, they have no series at u = 0, and steps become
shorter before it. Often less is left: of u**1.5 in a position, the kinetic energy has the square of its
slope, 9 u/4. Then u is watched.

Where the kinetic energy has 1/u, as for sqrt(u) in a position, u becomes 0 as the square of a time does. The
motion seems to turn there, and rounding decides whether steps pass. So it ends where u is almost 0, in terms
of what it is the difference of.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from typing import Any

from lagrange_cli.expression.node import Kind, Node, reachable
from lagrange_cli.expression.signs import Sign, proportional, signs
from lagrange_cli.expression.squares import square
from lagrange_cli.mechanics.residual import Residual

NEAR = 2.0**-45
"""An argument that has come to so small a part of its terms is at the edge, if it is only touched."""


def watched_edges(residual: Residual) -> list[Node]:
    """What is positive until a motion is at an edge that steps may pass."""
    known: dict[Node, Sign] = {}
    edges = [u for u in residual.model.edges if u.symbols & residual.variables and may_change(u, known)]
    if not edges:
        return []
    inertias = powers(node for row in residual.entries for node in row.values())
    others = powers(residual.residual)
    found = []
    for u in edges:
        if is_touched(u, inertias):
            found.append(u * u - NEAR**2 * squares(u))
        elif least(u, others) == math.inf:
            found.append(u)
    return found


def touched(residual: Residual) -> bool:
    """Whether a motion may come to an edge with no change of any sign."""
    inertias = powers(node for row in residual.entries for node in row.values())
    known: dict[Node, Sign] = {}
    return any(is_touched(u, inertias) and may_change(u, known) for u in residual.model.edges)


def may_change(u: Node, known: dict[Node, Sign]) -> bool:
    """Whether its sign may change, as far as its form shows: that of a square, as 1 - cos(x), does not."""
    if signs(u, known):
        return False
    found = square(u.graph, u) if u.kind is Kind.SUM else None
    return found is None or not signs(found.factor, known)


def is_touched(u: Node, inertias: Sequence[tuple[Node, Any]]) -> bool:
    """Whether masses are infinite where u is 0, but motions come there."""
    return bool(-2 < least(u, inertias) < 0)


def powers(nodes: Iterable[Node]) -> list[tuple[Node, Any]]:
    """Bases and exponents in expressions, as far as these have no series where the bases are 0."""
    products = (one for one in reachable([*nodes]) if one.kind is Kind.PRODUCT)
    pairs = dict.fromkeys(pair for one in products for pair in zip(one.arguments, one.data))
    return [(base, e) for base, e in pairs if e < 0 or e % 1 != 0]


def least(u: Node, given: Sequence[tuple[Node, Any]]) -> Any:
    """The least exponent of u; infinity where there is none."""
    split = u.graph.split_coefficient
    return min((e for base, e in given if proportional(split(u)[1], split(base)[1])), default=math.inf)


def squares(u: Node) -> Node:
    """The sum of the squares of the terms of u."""
    if u.kind is not Kind.SUM:
        return u * u
    constant, coefficients = u.data
    return sum((c * c * a * a for a, c in zip(u.arguments, coefficients)), u.graph.lift(constant**2))
