"""Events whose expression is the same at all states, although it contains coordinates: x - (x - 1). Surfaces
of sections whose expression never changes its sign: x**2 is touched, and never crossed."""

from __future__ import annotations

from lagrange_cli.expression.node import Node, bits
from lagrange_cli.expression.signs import Sign, signs
from lagrange_cli.expression.zero import independent
from lagrange_cli.mechanics.variables import graph_of
from lagrange_cli.model.build import never_changes
from lagrange_cli.model.model import Model
from lagrange_cli.spec.spec import SURFACE


def refuse_unchanging(model: Model[Node]) -> None:
    """Raise ``SpecError`` for an event whose expression is proven to depend on no state and no time, and for
    a surface that is never crossed: zeros would be those of rounding errors."""
    graph = graph_of(model)
    multipliers = (one.multiplier for one in model.constraints)
    varying = {x.symbols.bit_length() - 1: x for x in (*model.q, *model.v, model.time, *multipliers)}
    assert model.spec is not None
    for event in model.events:
        argument = event.argument
        present = (varying[bit] for bit in bits(argument.symbols) if bit in varying)
        if all(independent(graph, [argument], x) for x in present):
            raise never_changes(model.spec, event.name)
        if event.name == SURFACE and any(signs(one, {}) is not Sign.ANY for one in (argument, -argument)):
            raise never_changes(model.spec, event.name, "never changes its sign")
