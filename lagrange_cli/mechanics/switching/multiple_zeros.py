"""Events at multiple zeros: where u**3 is 0, u is, and that is a zero which rounding does not blur.

A factor that is never negative, such as u**2 or abs(u), changes no sign where it is 0. With 1 + u**2 in its
place nothing happens there, which rounding would decide else. It is undefined where u is.

Powers that are multiplied out, such as x**3 - 3*x**2 + 3*x - 1, are found as squares are (see
``expression.squares``).
"""

from __future__ import annotations

from collections.abc import Mapping
from fractions import Fraction
from typing import Any

from lagrange_cli.expression.graph import Graph
from lagrange_cli.expression.node import Kind, Node, factors_of
from lagrange_cli.expression.polynomials import HIGHEST, LONG_NOISE, NOISE
from lagrange_cli.expression.signs import Sign, signs
from lagrange_cli.expression.squares import power
from lagrange_cli.mechanics.variables import graph_of
from lagrange_cli.model.model import Model
from lagrange_cli.records import replace


def with_simple_zeros(model: Model[Node]) -> Model[Node]:
    """``model`` with odd powers of factors of events' expressions as the first power, and factors that are
    never negative without zeros: signs change where they did."""
    if not model.events:
        return model
    graph = graph_of(model)
    events = (replace(one, argument=with_simple_zero(graph, one.argument)) for one in model.events)
    return replace(model, events=tuple(events))


def with_simple_zero(graph: Graph, node: Node) -> Node:
    """The same for one expression."""
    scale, u = graph.split_coefficient(collected(graph, node))
    if u.kind is Kind.SUM and signs(u, {}) is Sign.NEVER_NEGATIVE:
        return scale * (1.0 + u * u)
    own = {a: e for a, e in factors(u).items() if e > 0}
    even = [a for a, e in own.items() if e % 2 == 0 or signs(a, {}) is Sign.NEVER_NEGATIVE]
    spare = {a: (0 if a in even else 1) - e for a, e in own.items() if e > 1 or a in even}
    if u.kind is Kind.SUM and spare:  # so that factors of all terms do not stand before the sum
        terms = zip(u.arguments, u.data[1])
        u = graph.sum((graph.product([(term, 1), *spare.items()]), c) for term, c in terms)
    elif spare:
        u = graph.product([(u, 1), *spare.items()])
    return scale * graph.product([(u, 1), *((1.0 + a * a, 1) for a in even)])


def collected(graph: Graph, node: Node) -> Node:
    """``node`` with powers in place of factors that are multiplied out."""
    scale, u = graph.split_coefficient(node)
    powers = factors_of(u)
    pairs: list[tuple[Node, Any]] = []
    roots: list[tuple[Node, int]] = []
    for base, e in powers:
        found = power(graph, base, *range(HIGHEST, 1, -1)) if base.kind is Kind.SUM else None
        if found is None or not isinstance(e, int):
            pairs.append((base, e))
        else:
            roots.append((found.root, e * found.order))
            pairs += [(found.factor, e), *((below, e * times) for below, times in found.denominators)]
    for root, e in roots:
        alike = ((base, _ratio(root, base)) for base, _ in pairs)
        base, ratio = next(((base, ratio) for base, ratio in alike if ratio is not None), (root, 1))
        scale = scale * ratio**e
        pairs.append((base, e))
    return scale * graph.product(pairs)


def _ratio(root: Node, other: Node) -> Any:
    """``root`` over ``other`` where that is a number up to rounding, so that (x - a)**2 and a root x - b
    that was found have one zero and not two."""
    if not root.kind is other.kind is Kind.SUM or root.arguments != other.arguments:
        return None
    one, two = ((node.data[0], *node.data[1]) for node in (root, other))
    ratio = one[1] / two[1]
    noise = LONG_NOISE if isinstance(ratio, Fraction) else NOISE
    same = all(abs(x - ratio * y) <= noise * abs(x) for x, y in zip(one, two))
    return ratio if same else None


def factors(node: Node) -> Mapping[Node, int]:
    """The factors of an expression with whole positive powers; of a sum, those that all terms have."""
    if node.kind is Kind.PRODUCT:
        return {a: e for a, e in zip(node.arguments, node.data) if isinstance(e, int) and e > 0}
    if node.kind is not Kind.SUM or node.data[0] != 0:
        return {node: 1}
    first, *others = map(factors, node.arguments)
    return {a: min(e, *(one.get(a, 0) for one in others)) if others else e for a, e in first.items()}
