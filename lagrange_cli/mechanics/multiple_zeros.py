"""Events at multiple zeros: where u**3 is 0, u is, and that is a zero which rounding does not blur."""

from __future__ import annotations

from lagrange_cli.expression.node import Kind, Node
from lagrange_cli.mechanics.variables import graph_of
from lagrange_cli.model.model import Model
from lagrange_cli.records import replace


def with_simple_zeros(model: Model[Node]) -> Model[Node]:
    """``model`` with odd powers of factors of events' expressions as the first power, and even ones as the
    second: they have the same zeros and signs."""
    graph, events = graph_of(model), []
    for event in model.events:
        scale, u = graph.split_coefficient(event.argument)
        if u.kind is Kind.PRODUCT:
            powers = zip(u.arguments, u.data)
            u = graph.product([(a, 2 - e % 2 if isinstance(e, int) and e > 2 else e) for a, e in powers])
        events.append(replace(event, argument=scale * u))
    return replace(model, events=tuple(events))
