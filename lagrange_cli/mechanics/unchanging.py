"""Events whose expression is the same at all states, although it contains coordinates: x - (x - 1)."""

from __future__ import annotations

from lagrange_cli.expression.node import Node
from lagrange_cli.expression.zero import independent
from lagrange_cli.mechanics.variables import graph_of
from lagrange_cli.model.build import never_changes
from lagrange_cli.model.model import Model


def refuse_unchanging(model: Model[Node]) -> None:
    """Raise ``SpecError`` for an event whose expression is proven to depend on no state and no time: its
    zeros would be those of its rounding errors."""
    graph = graph_of(model)
    varying = (*model.q, *model.v, model.time, *(one.multiplier for one in model.constraints))
    assert model.spec is not None
    for event in model.events:
        argument = event.argument
        present = (x for x in varying if x.symbols & argument.symbols)
        if all(independent(graph, [argument], x) for x in present):
            raise never_changes(model.spec, event.name)
