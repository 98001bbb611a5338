"""Edges of domains that steps would pass: what the equations are made of has a value beyond them.

Where sqrt(u), u**1.5 or log(u) stands in the equations, they have no series at u = 0, and steps become shorter
before it. Often less is left: of u**1.5 in a position, the kinetic energy has the square of its slope, 9 u/4.
Then u is watched. Where the kinetic energy has 1/u, as for sqrt(u) in a position, u becomes 0 as the square of
a time does, and the motion seems to turn there. What changes its sign is then the root of u.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from typing import Any

from lagrange_cli.expression.node import Kind, Node, reachable
from lagrange_cli.expression.signs import Sign, proportional, signs
from lagrange_cli.mechanics.residual import Residual


def edges_to_watch(residual: Residual) -> list[Node]:
    """What is positive inside such edges, and passes 0 there."""
    known: dict[Node, Sign] = {}
    edges = [u for u in residual.model.edges if u.symbols & residual.variables and not signs(u, known)]
    if not edges:
        return []
    count = len(residual.model.q)
    entries = [(j, k, node) for j, row in enumerate(residual.entries) for k, node in row.items()]
    masses = powers(node for j, k, node in entries if max(j, k) < count)
    slopes = powers(node for j, k, node in entries if max(j, k) >= count)
    others = powers(residual.residual)
    found = (passing(u, *(least(u, one) for one in (masses, slopes, others))) for u in edges)
    return [one for one in found if one is not None]


def powers(nodes: Iterable[Node]) -> list[tuple[Node, Any]]:
    """Bases and exponents in expressions, as far as these have no series where the bases are 0."""
    products = (one for one in reachable([*nodes]) if one.kind is Kind.PRODUCT)
    pairs = dict.fromkeys(pair for one in products for pair in zip(one.arguments, one.data))
    return [(base, e) for base, e in pairs if e < 0 or e % 1 != 0]


def least(u: Node, given: Iterable[tuple[Node, Any]]) -> Any:
    """The least exponent of u; infinity where there is none."""
    plain = plain_of(u)
    return min((e for base, e in given if proportional(plain, plain_of(base))), default=math.inf)


def plain_of(node: Node) -> Node:
    """A node without its coefficient."""
    return node.graph.split_coefficient(node)[1]


def passing(u: Node, mass: Any, slope: Any, other: Any) -> Node | None:
    """What passes 0 where u reaches it, by the least exponents of u in the masses, the slopes of constraints
    and the equations; None if steps cannot pass."""
    if -2 < mass < 0:  # configurations lie along s with ds/du = u**(mass/2)
        return u ** (1 + mass / 2)
    if -1 < slope < 0:
        return u ** (1 + slope)
    return u if other == math.inf else None
