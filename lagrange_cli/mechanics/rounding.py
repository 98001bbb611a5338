"""The size of the numbers from which an expression is computed: the measure of its rounding error."""

from __future__ import annotations

from collections.abc import Mapping

from lagrange_cli.expression.graph import Graph
from lagrange_cli.expression.node import Kind, Node, reachable

MOST = 2.0**12
"""What is known to so many units only, in a root or a denominator, may be a pole or a kink nearby: errors
count the less there."""


def size_of(
    graph: Graph, node: Node, exact: int = 0, known: Mapping[Node, Node] | None = None, *, steep: bool = True
) -> Node:
    """A bound on the rounding error, in units of the last place, up to a factor: of a sum that of its terms,
    and what is carried through factors and functions by their slopes (N. J. Higham, Accuracy and Stability of
    Numerical Algorithms, 2nd ed., sec. 3.1). Exponents of ``exact`` symbols alone, such as indices, have no
    error; the power may have no slope by them, as that of a negative number. The sizes of some nodes may be
    ``known``. Roots and poles are ``steep``, or have errors of so many units at most (``MOST``)."""
    made: dict[Node, Node] = dict(known or {})
    for one in reachable([node], lambda node: node not in made):
        inner = [made[argument] for argument in one.arguments]
        if one.kind is Kind.SUM:
            constant, coefficients = one.data
            terms = [(size, abs(c)) for size, c in zip(inner, coefficients)]
            made[one] = graph.sum([*terms, (graph.constant(abs(constant)), 1.0)])
        elif one.kind is Kind.PRODUCT:
            made[one] = _of_product(graph, one, inner, steep=steep)
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


def size_where_moving(graph: Graph, node: Node, moving: int) -> Node:
    """The same of an expression in what is ``moving``, in any state. What is constant in it has one error."""
    constant = {one: graph.absolute(one) for one in reachable([node]) if not one.symbols & moving}
    return size_of(graph, node, ~moving, constant, steep=False)


def has_terms(node: Node, moving: int) -> bool:
    """Whether terms that move may cancel in an expression: one without such sums is known to parts of
    itself."""
    return any(
        one.kind is Kind.SUM and one.symbols & moving and len(one.arguments) + bool(one.data[0]) > 1
        for one in reachable([node])
    )


def _of_product(graph: Graph, node: Node, sizes: list[Node], *, steep: bool) -> Node:
    factors = [*zip(node.arguments, sizes, node.data)]
    risky = [one for one in factors if not steep and (one[2] < 0 or one[2] != int(one[2]))]
    known = [  # |s| / (|s| + size / MOST), about 1 where s is known
        (graph.absolute(s), graph.sum([(graph.absolute(s), 1.0), (size, 1.0 / MOST)])) for s, size, _ in risky
    ]
    share = [pair for above, below in known for pair in ((above, 1), (below, -1))]
    terms: list[tuple[Node, float]] = []
    for one in factors:
        argument, size, exponent = one
        if one in risky:
            below = known[risky.index(one)][1]
            made = graph.product([(graph.absolute(node), 1), (size, 1), (below, -1)])
        else:
            rest = graph.product([(node, 1), (argument, -1)])
            made = graph.product([(graph.absolute(rest), 1), (size, 1), *share])
        terms.append((made, abs(exponent)))
    return graph.sum(terms)
