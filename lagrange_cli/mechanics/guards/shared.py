"""Forces that hold the same motion, as friction of two pucks on a table and on each other does: if all of
them hold, only their sum follows from the equations. While they do, their multipliers m are those of least
norm.

Let the velocity u that one of them holds be sum_i a_i u_i of those that others hold. Then m may change by any
d if m_i change by -a_i d, and m - sum_i a_i m_i = 0 is the condition for the least norm."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from lagrange_cli.expression.graph import Graph
from lagrange_cli.expression.node import Kind, Node
from lagrange_cli.expression.zero import is_zero

ROUNDING = 2.0**-40
"""Coefficients below this part of the largest one are rounding errors."""

Row = dict[int, float]


def dependent(
    graph: Graph, speeds: Sequence[Node], velocities: Mapping[Node, int]
) -> dict[int, dict[int, float]]:
    """The numbers of ``speeds`` that are sums of earlier ones times constants, and these constants by the
    numbers of the earlier ones. ``velocities`` are numbered symbols."""
    known = list[tuple[int, Row, Row]]()
    found = dict[int, dict[int, float]]()
    for number, speed in enumerate(speeds):
        slopes = graph.gradient(speed, velocities)
        if any(one.kind is not Kind.NUMBER for one in slopes.values()):
            continue
        row: Row = {k: float(one.data) for k, one in slopes.items()}
        least, sum_of = ROUNDING * max(map(abs, row.values()), default=0.0), Row()
        for pivot, other, made_of in known:
            factor = row.get(pivot, 0.0) / other[pivot]
            if factor:
                row = added(row, other, -factor)
                sum_of = added(sum_of, made_of, factor)
        pivot = max(row, key=lambda k: abs(row[k]), default=-1)
        if pivot >= 0 and abs(row[pivot]) > least:
            known.append((pivot, row, {**added({}, sum_of, -1.0), number: 1.0}))
            continue
        terms = [(speeds[i], -one) for i, one in sum_of.items()]
        if is_zero(graph.sum([(speed, 1.0), *terms])):
            found[number] = sum_of
    return found


def added(row: Row, other: Row, factor: float) -> Row:
    """``row`` and so many times an ``other`` one."""
    total = {k: row.get(k, 0.0) + factor * other.get(k, 0.0) for k in {**row, **other}}
    return {k: one for k, one in total.items() if one}
