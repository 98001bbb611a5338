"""Forces along a vector u with several components that become 0 together: friction, which contains u/|u|,
and drag, which contains |u| u.

While u is not 0, u/|u| has a series; the mode is 1. Where u = 0 the motion may be held there, with mode 0, as
by a switch (see ``held``): u_i/|u| is an unknown n_i then, whose equation is du_i/dt = 0, as long as |n| <=
1. Where forces contain no u/|u|, but other odd powers of |u|, nothing holds the motion; it passes u = 0,
where these have no series either."""

from __future__ import annotations

from collections.abc import Sequence
from functools import reduce
from operator import or_

from lagrange_cli.expression.graph import Graph
from lagrange_cli.expression.node import Kind, Node, factors_of, reachable, terms_of
from lagrange_cli.expression.zero import is_rounding, is_zero
from lagrange_cli.mechanics.constraints import Constraints
from lagrange_cli.mechanics.residual import Residual
from lagrange_cli.mechanics.substitution import rebuilt, substituted
from lagrange_cli.mechanics.switching.lengths import Vector, bases, completed
from lagrange_cli.records import replace


def vectors(residual: Residual) -> list[Vector]:
    """The vectors whose lengths forces contain, if forces have finite values where these are 0."""
    if "vectors" not in residual.found:
        residual.found["vectors"] = _vectors(residual)
    found: list[Vector] = residual.found["vectors"]
    return found


def _vectors(residual: Residual) -> list[Vector]:
    graph, model = residual.graph, residual.model
    speeds = reduce(or_, (v.symbols for v in model.v), 0)
    squares, found = bases(residual.residual, speeds), []
    inertial = set(bases(_inertias(residual), speeds)) if squares else set()
    for square, holds in squares.items():
        vector = None if square in inertial else completed(graph, square, model.v)
        if vector is not None and all(held(graph, row, vector) is not None for row in residual.residual):
            found.append(replace(vector, holds=holds))
    return found


def _inertias(residual: Residual) -> list[Node]:
    entries = [entry for row in residual.unpushed.entries for entry in row.values()]
    momenta = [node for one in residual.cyclic_momenta for node in (one.momentum, one.speed)]
    return [*entries, *residual.inertias, *momenta]


def constrained(residual: Residual, vector: Vector) -> list[tuple[int, list[Node], bool]]:
    """The constraints on velocities that are some on the vector alone, sum_i b_i u_i + c = 0: the numbers of
    their equations, the factors b_i, and whether they are driven, c is not 0."""
    graph, model, found = residual.graph, residual.model, []
    constraints, zero = Constraints(model), dict.fromkeys(model.v, graph.zero)
    first, at_rest = len(residual.residual) - len(model.constraints), substituted(graph, vector.parts, zero)
    for j, (slopes, drift) in enumerate(zip(constraints.slopes, constraints.drifts), first):
        factors = made_of(graph, model.v, vector, [slopes.get(k, graph.zero) for k in range(len(model.q))])
        if factors is not None:
            for b, own in zip(factors, at_rest):
                drift = drift - b * own
            found.append((j, factors, not is_zero(drift)))
    return found


def made_of(
    graph: Graph, velocities: Sequence[Node], vector: Vector, slopes: Sequence[Node]
) -> list[Node] | None:
    """The factors b_i of sum_i b_i u_i with these slopes by velocities; None if the vector does not make up
    what has them."""
    rest, factors = [*slopes], list[Node]()
    for pivot, part in zip(vector.pivots, vector.parts):
        factors.append(rest[velocities.index(pivot)])
        rest = [a - factors[-1] * graph.diff(part, v) for a, v in zip(rest, velocities)]
    return factors if all(map(is_zero, rest)) else None


def held(graph: Graph, node: Node, vector: Vector) -> tuple[Node, tuple[Node, ...]] | None:
    """``node`` where u = 0: a node without u/|u|, and the factor of each u_i/|u|; None where it has no
    value there, or is not linear in these."""
    if vector.square.symbols & ~node.symbols:
        return node, (graph.zero,) * len(vector.parts)
    inverse = graph.symbol("inverse length")
    made: dict[Node, Node] = {}
    for one in reachable([node]):
        arguments = [made[a] for a in one.arguments]
        if one.kind is Kind.PRODUCT and vector.square in one.arguments:
            place = one.arguments.index(vector.square)
            exponent = one.data[place]
            if exponent < 0 and exponent != -0.5:
                return None
            others = graph.product((a, e) for i, (a, e) in enumerate(zip(arguments, one.data)) if i != place)
            made[one] = others * inverse if exponent < 0 else graph.zero
        elif (one.kind is Kind.POWER and vector.square in one.arguments) or (
            one.kind is Kind.DDT and one.arguments[0] is not arguments[0]
        ):
            return None
        else:
            made[one] = rebuilt(graph, one, arguments)
    slope = graph.diff(made[node], inverse)
    (plain,) = substituted(graph, [made[node]], {inverse: graph.zero})
    if slope.is_zero:
        return plain, (graph.zero,) * len(vector.parts)
    if slope.symbols & inverse.symbols:
        return None
    symbols = [graph.symbol(f"component {i}") for i in range(len(vector.parts))]
    values: dict[Node, Node] = {}
    for v, part, u in reversed([*zip(vector.pivots, vector.parts, symbols)]):
        (others,) = substituted(graph, [part - v], values)
        values[v] = u - others
    (by_parts,) = substituted(graph, [slope], values)
    if any(one.kind is Kind.DDT for one in reachable([by_parts])):
        return None
    at_rest = dict.fromkeys(symbols, graph.zero)
    if not is_rounding(substituted(graph, [by_parts], at_rest)[0], slope):
        return None
    slopes = [graph.diff(by_parts, u) for u in symbols]
    return plain, substituted(graph, slopes, at_rest)


def at_rest(graph: Graph, node: Node, velocities: Sequence[Node]) -> Node:
    """``node`` without u/|u| for the vectors u that may hold the motion where they are 0."""
    for square in bases([node], reduce(or_, (v.symbols for v in velocities), 0)):
        vector = completed(graph, square, velocities)
        found = None if vector is None else held(graph, node, vector)
        if found is not None:
            node = found[0]
    return node


def split(graph: Graph, node: Node, vector: Vector) -> tuple[Node, Node]:
    """The terms of a node without roots of the square, and the sum of those with them."""
    with_roots = {
        one
        for one in reachable([node], lambda one: bool(one.symbols & vector.square.symbols))
        if one.kind is Kind.PRODUCT and any(a is vector.square and e != int(e) for a, e in factors_of(one))
    }
    inside: set[Node] = set()
    for one in reachable([node]):
        if one in with_roots or not inside.isdisjoint(one.arguments):
            inside.add(one)
    terms = terms_of(node)
    return (
        graph.sum((term, c) for term, c in terms if term not in inside),
        graph.sum((term, c) for term, c in terms if term in inside),
    )
