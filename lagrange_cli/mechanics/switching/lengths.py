"""Lengths of vectors of velocities, |u|, in equations: where all components of u are 0, |u| has no series.

The square of |u| is a polynomial in velocities: sum_i d_i u_i^2, by completing squares, u_i = v_i + terms in
other velocities and in q, t. So no root is needed: |n|^2 = sum_i d_i n_i^2, where n_i stands for u_i/|u|."""

from __future__ import annotations

from collections.abc import Sequence
from functools import reduce
from operator import or_

from lagrange_cli.expression.graph import Graph
from lagrange_cli.expression.node import Kind, Node, factors_of, reachable, terms_of
from lagrange_cli.expression.zero import is_rounding, is_zero
from lagrange_cli.mechanics.substitution import substituted
from lagrange_cli.records import dataclass

SMALL = 0.25
"""Squares with a weight below this part of the largest one are completed later: the rounding of what is left
is at most multiplied by the reciprocal of this each time."""


@dataclass(frozen=True)
class Vector:
    """A vector: its ``square``, and the ``weights`` d_i and ``parts`` u_i = ``pivots`` v_i + ... of that."""

    square: Node
    weights: tuple[Node, ...]
    parts: tuple[Node, ...]
    pivots: tuple[Node, ...]
    holds: bool = True
    """Whether forces contain u/|u|, and may hold the motion where u = 0."""


def bases(nodes: Sequence[Node], speeds: int) -> dict[Node, bool]:
    """What stands under a root, if it depends on velocities; whether it does so in a denominator."""
    found = dict[Node, bool]()
    for node in reachable(nodes, lambda node: bool(node.symbols & speeds)):
        for base, e in factors_of(node):
            if base.symbols & speeds and (e == -0.5 or (e > 0.0 and e % 1.0 == 0.5)):
                found[base] = found.get(base, False) or e == -0.5
    return found


def completed(graph: Graph, square: Node, velocities: Sequence[Node]) -> Vector | None:
    """Squares of two or more independent functions of velocities whose sum with weights it is."""
    speeds = reduce(or_, (v.symbols for v in velocities), 0)
    rest, weights, parts, pivots = square, list[Node](), list[Node](), list[Node]()
    while True:
        listed = list[tuple[Node, Node, Node]]()
        for v in velocities:
            first = graph.diff(rest, v) if v not in pivots and rest.symbols & v.symbols else graph.zero
            if first.is_zero or is_rounding(first, graph.diff(square, v)):
                continue
            weight = graph.diff(first, v) / 2.0
            if weight.symbols & speeds or is_zero(weight):
                return None
            if weight.kind is Kind.NUMBER and weight.data < 0.0:
                return None
            listed.append((v, first, weight))
        if not listed:
            break
        largest = max((w.data for _, _, w in listed if w.kind is Kind.NUMBER), default=0.0)
        v, first, weight = next(
            one for one in listed if one[2].kind is not Kind.NUMBER or one[2].data >= SMALL * largest
        )
        part = graph.sum([(term / weight, 0.5 * c) for term, c in terms_of(first)])
        rest = rest - weight * part * part
        weights.append(weight)
        parts.append(part)
        pivots.append(v)
    if len(parts) < 2 or not (is_zero(rest) or (rest.symbols & speeds and is_rounding(rest, square))):
        return None  # what is left without velocities is no rounding: u^2 + 1e-12 is never 0
    at_rest = substituted(graph, [rest, square], dict.fromkeys(velocities, graph.zero))
    if not is_rounding(*at_rest):
        return None
    return Vector(square, tuple(weights), tuple(parts), tuple(pivots))
