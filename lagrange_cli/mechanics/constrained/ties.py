"""Constraints that depend on each other along a direction that turns, such as those of a ball that rolls in a
pipe: of the three components of its velocity where it touches, the one along the normal is 0 anyway.

Let A be the slopes of the constraints, and n(q, t) a vector with n . A = 0 in every state. Without one of the
constraints the equations would be singular where its component of n is 0. So all constraints are kept, and
what leaves their multipliers undetermined is tied: the equations A q_ddot = b become

    A q_ddot + s n (n . lambda) = b.

As n . b = 0, it follows that n . lambda = 0: the multipliers are those of least norm, and the motion is the
same for each s > 0. With s = A_k . A_k / (M_kk n . n), for a coordinate k, both terms of A M^-1 A^T + s n n^T
are of similar size (augmented Lagrangian: M. Fortin and R. Glowinski, Augmented Lagrangian Methods, 1983,
ch. 1)."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from itertools import combinations

from lagrange_cli.expression.graph import Graph
from lagrange_cli.expression.node import Kind, Node, factors_of, reachable, terms_of
from lagrange_cli.expression.zero import is_zero
from lagrange_cli.mechanics.constrained.redundancy import coupled
from lagrange_cli.mechanics.constraints import Constraints
from lagrange_cli.mechanics.rows import Matrix
from lagrange_cli.mechanics.substitution import substituted
from lagrange_cli.mechanics.variables import state_symbols
from lagrange_cli.model.model import Model, Tie
from lagrange_cli.records import replace

FEW = 6
"""Among so many constraints that are coupled it is looked for those that depend on each other; most
relations are between a few."""
TOGETHER = 2
"""Of so many constraints another one follows, at most."""


def tied(model: Model[Node], masses: Matrix) -> Model[Node]:
    """The model with the constraints that had been left out, and ties in their place, where each of them
    depends on a few others by factors that change, and never vanish together."""
    whole = Constraints(replace(model, constraints=(*model.constraints, *model.redundant)))
    count, ties = len(model.constraints), dict[int, Tie[Node]]()
    for mine, others in coupled(whole.slopes[:count], whole.slopes[count:]):
        if len(others) == 1 and len(mine) <= FEW:
            tie = next(relations(whole, mine, count + others[0], masses), None)
            if tie is not None:
                ties[others[0]] = tie
    kept = tuple(one for j, one in enumerate(model.redundant) if j not in ties)
    added = (one for j, one in enumerate(model.redundant) if j in ties)
    return replace(model, constraints=(*model.constraints, *added), redundant=kept, ties=tuple(ties.values()))


def relations(whole: Constraints, mine: Sequence[int], last: int, masses: Matrix) -> Iterator[Tie[Node]]:
    """The ties of one constraint with some of others that it may follow from."""
    graph, multipliers, moving = whole.graph, whole.multipliers, state_symbols(whole.model)
    for count in range(1, TOGETHER + 1):
        for some in combinations(mine, count):
            rows = [whole.slopes[i] for i in (*some, last)]
            drifts = [whole.drifts[i] for i in (*some, last)]
            places = sorted(set().union(*rows))
            columns = {k: [row.get(k, graph.zero) for row in rows] for k in places}
            if any(sum(k in row for row in rows) == 1 for k in places):
                continue
            for chosen in combinations(places, count):
                n = without_common(graph, normal(*(columns[k] for k in chosen)))
                if n[-1].is_zero or not lasts(graph, n, moving):
                    continue
                if all(is_zero(dot(graph, n, one)) for one in (drifts, *columns.values())):
                    if not n[-1].symbols & moving:
                        return  # the last one may be left out everywhere
                    scale = scale_of(graph, columns, n, masses, moving)
                    yield Tie(tuple(zip((multipliers[i] for i in (*some, last)), n)), scale)


def normal(a: Sequence[Node], b: Sequence[Node] = ()) -> list[Node]:
    """A vector with two components that is orthogonal to one, or one with three to two."""
    if not b:
        return [a[1], -a[0]]
    return [a[i - 2] * b[i - 1] - a[i - 1] * b[i - 2] for i in range(3)]


def without_common(graph: Graph, n: Sequence[Node]) -> list[Node]:
    """The vector without the factors that all terms of its components have in common."""
    terms = [term for one in n for term, _ in terms_of(one) if not one.is_zero]
    products = [dict(factors_of(graph.split_coefficient(term)[1])) for term in terms]
    common = {
        base: min(one[base] for one in products)
        for base in (products[0] if products else ())
        if all(base in one for one in products)
    }
    divisor = graph.product(common.items())
    return [graph.sum((term / divisor, factor) for term, factor in terms_of(one)) for one in n]


def lasts(graph: Graph, n: Sequence[Node], moving: int) -> bool:
    """Whether it is never 0: one of its components is constant, or its length."""
    constant = any(not one.is_zero and not one.symbols & moving for one in n)
    return constant or not settled(graph, dot(graph, n, n), moving).symbols & moving


def settled(graph: Graph, node: Node, moving: int) -> Node:
    """An expression whose value does not depend on what moves, without that, if that is easily seen."""
    symbols = [one for one in graph.symbols_of(node) if one.symbols & moving]
    if not all(is_zero(graph.diff(node, one)) for one in symbols):
        return node
    at_zero = dict.fromkeys(symbols, graph.zero)
    powers = (
        pair for one in reachable([node]) if one.kind is Kind.PRODUCT for pair in zip(one.arguments, one.data)
    )
    if any(e < 0 and base.symbols & moving for base, e in powers):
        return node
    return substituted(graph, [node], at_zero)[0]


def scale_of(
    graph: Graph, columns: Mapping[int, Sequence[Node]], n: Sequence[Node], masses: Matrix, moving: int
) -> Node:
    """s, from the slopes by one coordinate, if these are never 0 together, or else from all."""
    heavy = [k for k in columns if not masses[k][k].is_zero]
    lasting = [k for k in heavy if lasts(graph, columns[k], moving)][:1]
    sizes = [
        (settled(graph, dot(graph, columns[k], columns[k]), moving), settled(graph, masses[k][k], moving))
        for k in lasting or heavy
    ]
    whole = graph.sum((square / mass, 1.0) for square, mass in sizes) if sizes else graph.one
    return whole / settled(graph, dot(graph, n, n), moving)


def dot(graph: Graph, a: Sequence[Node], b: Sequence[Node]) -> Node:
    """a . b."""
    return graph.sum((x * y, 1.0) for x, y in zip(a, b))
