"""Events at multiple zeros: where u**3 is 0, u is, and that is a zero which rounding does not blur."""

from __future__ import annotations

from collections.abc import Mapping

from lagrange_cli.expression.node import Kind, Node
from lagrange_cli.mechanics.variables import graph_of
from lagrange_cli.model.model import Model
from lagrange_cli.records import replace


def with_simple_zeros(model: Model[Node]) -> Model[Node]:
    """``model`` with odd powers of factors of events' expressions as the first power, and even ones as the
    second: they have the same zeros and signs."""
    if not model.events:
        return model
    graph, events = graph_of(model), []
    for event in model.events:
        scale, u = graph.split_coefficient(event.argument)
        spare = {a: -(e - 2 + e % 2) for a, e in factors(u).items() if e > 2}
        if u.kind is Kind.SUM and spare:  # so that factors of all terms do not stand before the sum
            terms = zip(u.arguments, u.data[1])
            u = graph.sum((graph.product([(term, 1), *spare.items()]), c) for term, c in terms)
        elif spare:
            u = graph.product([(u, 1), *spare.items()])
        events.append(replace(event, argument=scale * u))
    return replace(model, events=tuple(events))


def factors(node: Node) -> Mapping[Node, int]:
    """The factors of an expression with whole positive powers; of a sum, those that all terms have."""
    if node.kind is Kind.PRODUCT:
        return {a: e for a, e in zip(node.arguments, node.data) if isinstance(e, int) and e > 0}
    if node.kind is not Kind.SUM or node.data[0] != 0:
        return {node: 1}
    first, *others = map(factors, node.arguments)
    return {a: min(e, *(one.get(a, 0) for one in others)) if others else e for a, e in first.items()}
