"""``@approach`` for implicit steps: by how much one may bring a motion nearer to where narrow forces act.

Friction tanh(v/w) is as constant as can be until v is no larger than w, and a force may be so in places. What
is not to become much less within a step is 1 + (v/w)^2, or the square of a distance (``mechanics.approach``).
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence

from lagrange_cli.expression.node import Node
from lagrange_cli.mechanics.approach import lost
from lagrange_cli.mechanics.residual import Residual
from lagrange_cli.native.llvm.function import Function
from lagrange_cli.native.llvm.text import Value
from lagrange_cli.native.llvm.vector import Real
from lagrange_cli.native.numbers.double import Emitter
from lagrange_cli.native.rates.places import wide_of
from lagrange_cli.native.recurrences.evaluation import Constants, emit_values
from lagrange_cli.native.state import StateLayout

APPROACH = (
    "define internal double @approach(ptr %constants, double %t, ptr %state, ptr %bounds, double %h) #0"
)


def approach(
    residual: Residual,
    listed: Sequence[Node],
    layout: StateLayout,
    constants: Constants,
    make: Callable[[Function], Emitter],
) -> str:
    """The text of the function: the largest part by which one of those that are ``listed`` becomes less."""
    graph, f = residual.graph, Function(APPROACH)
    kind, wide, time = make(f), wide_of(layout), (residual.model.time, graph.symbol("step"))
    known: dict[Node, Value] = dict(zip(time, ("%t", "%h")))
    moved = list[tuple[Node, Node, Node]]()
    for first, symbols in ((0, residual.state_q), (layout.degrees, residual.state_v)):
        for k, one in enumerate(symbols, first):
            bound, shift = graph.symbol(f"bound {k}"), graph.symbol(f"shift {k}")
            known[one] = kind.load("%state", k)
            known |= {bound: kind.load("%bounds", k), shift: kind.load("%bounds", k + wide)}
            moved.append((one, bound, shift))
    parts = [lost(graph, one, residual.variables, time, moved) for one in listed]
    emit_values(kind, parts, known, constants)
    most = f.constant(0.0)
    for one in parts:
        part = Real(f, kind.written(known[one]))
        most = f.larger(most, f.select(part >= part, part, f.constant(math.inf)))
    f.give(most)
    return f.text()
