"""From graph nodes to series: products of two, sums that share parts, functions with their derivatives."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from lagrange_cli.expression.graph import Graph
from lagrange_cli.expression.node import Node
from lagrange_cli.series.builder import SeriesBuilder
from lagrange_cli.series.offsets import set_levels, set_levels_beside, sort
from lagrange_cli.series.program import FREE, Op, Series, SeriesProgram


def lower(
    graph: Graph,
    variables: int,
    q: Sequence[Node],
    v: Sequence[Node],
    t: Node,
    residual: Sequence[Node],
    integrands: Sequence[Node],
    multipliers: Sequence[Node] = (),
    own: int = 0,
    apart: bool = False,
    dependent: Mapping[int, tuple[Node | None, Node]] | None = None,
) -> SeriesProgram:
    """The series program of the equations ``residual`` and the quadratures of ``integrands``.

    The first ``own`` of these belong to the motion; it is computed as without the others. Where series are
    computed side by side (``apart``), requesting some earlier would change roundings. Coordinates that are
    ``dependent``, by their place in ``q``, and their velocities are such functions of the others; where that
    of a coordinate is None, it is the integral of its velocity.
    """
    builder = SeriesBuilder(graph, variables)
    builder.by_node[t] = builder.add(Series(Op.TIME, node=t, degree=1))
    dependent = dependent or {}
    unknown = [i for i in range(len(q)) if i not in dependent]
    for i in unknown:
        builder.by_node[q[i]] = builder.add(Series(Op.COORDINATE, data=i, node=q[i], order=0))
    for i in unknown:
        builder.by_node[v[i]] = builder.derivative(builder.by_node[q[i]])
    builder.lower_all(node for pair in dependent.values() for node in pair if node is not None)
    for i, (place, speed) in dependent.items():
        builder.follow(q[i], place, v[i], speed)
    coordinates, velocities = ([builder.by_node[symbol] for symbol in symbols] for symbols in (q, v))
    for symbol in multipliers:
        builder.by_node[symbol] = builder.add(Series(Op.MULTIPLIER, node=symbol, order=2))
    builder.lower_all([*residual, *integrands[:own]])
    builder.lower_all(integrands[own:])
    roots = [builder.by_node[node] for node in residual]
    integrals = [builder.integral(builder.by_node[node]) for node in integrands]
    bound = [builder.by_node[symbol] for symbol in multipliers]
    motion = [(coordinates, 2), (velocities, 1), (bound, 0), (roots, 0), (integrals[:own], 1)]
    set_levels(builder.series, motion)
    needed = [index for index, one in enumerate(builder.series) if one.level > FREE]
    set_levels_beside(builder.series, integrals[own:], apart)
    return sort(
        builder.series, coordinates, velocities, bound, roots, integrals, own, needed, tuple(dependent)
    )


def lower_functions(
    graph: Graph,
    variables: int,
    symbols: Sequence[Node],
    t: Node,
    nodes: Sequence[Node],
    multipliers: Sequence[Node] = (),
    ahead: int = FREE,
    others: Sequence[Node] = (),
) -> SeriesProgram:
    """The series program of the functions ``nodes`` of ``symbols`` whose series are known, so many orders
    ``ahead``, of t, of ``multipliers`` that are found with the accelerations, and of ``others`` whose series
    are known up to the same order."""
    builder = SeriesBuilder(graph, variables)
    builder.by_node[t] = builder.add(Series(Op.TIME, node=t, degree=1))
    known = [builder.add(Series(Op.COORDINATE, data=i, node=one, order=0)) for i, one in enumerate(symbols)]
    builder.by_node.update(zip(symbols, known))
    unknown = [builder.add(Series(Op.MULTIPLIER, node=one, order=2)) for one in multipliers]
    builder.by_node.update(zip(multipliers, unknown))
    for one in others:
        builder.by_node[one] = builder.add(Series(Op.COORDINATE, node=one, order=0))
    builder.lower_all(nodes)
    roots = [builder.by_node[node] for node in nodes]
    set_levels(builder.series, [(roots, 0), (known, ahead)])
    needed = [index for index, one in enumerate(builder.series) if one.level > FREE]
    return sort(builder.series, known, [], unknown, roots, [], 0, needed)
