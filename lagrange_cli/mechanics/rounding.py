"""The size of the numbers from which an expression is computed: the measure of its rounding error."""

from __future__ import annotations

from lagrange_cli.expression.graph import Graph
from lagrange_cli.expression.node import Kind, Node, reachable


def size_of(graph: Graph, node: Node, exact: int = 0) -> Node:
    """A bound on the rounding error, in units of the last place, up to a factor: of a sum that of its terms,
    and what is carried through factors and functions by their slopes (N. J. Higham, Accuracy and Stability of
    Numerical Algorithms, 2nd ed., sec. 3.1). Exponents of ``exact`` symbols alone, such as indices, have no
    error; the power may have no slope by them, as that of a negative number."""
    made: dict[Node, Node] = {}
    for one in reachable([node]):
        inner = [made[argument] for argument in one.arguments]
        if one.kind is Kind.SUM:
            constant, coefficients = one.data
            terms = [(size, abs(c)) for size, c in zip(inner, coefficients)]
            made[one] = graph.sum([*terms, (graph.constant(abs(constant)), 1.0)])
        elif one.kind is Kind.PRODUCT:
            rests = [graph.product([(one, 1), (argument, -1)]) for argument in one.arguments]
            factors = zip(rests, inner, one.data)
            made[one] = graph.sum(
                [(graph.product([(graph.absolute(rest), 1), (size, 1)]), abs(e)) for rest, size, e in factors]
            )
        elif one.kind is Kind.SWITCH:
            made[one] = graph.switch(one.arguments[0], inner[1], inner[2], one.data)
        elif one.kind in (Kind.FUNCTION, Kind.POWER):
            carried = [*zip(graph.partials(one), inner)]
            if one.kind is Kind.POWER and 0 < one.arguments[1].symbols == one.arguments[1].symbols & exact:
                carried = carried[:1]
            terms = [(graph.product([(graph.absolute(slope), 1), (size, 1)]), 1.0) for slope, size in carried]
            made[one] = graph.sum([(graph.absolute(one), 1.0), *terms])
        else:
            made[one] = graph.absolute(one)
    return made[node]
