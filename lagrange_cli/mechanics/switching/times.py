"""Energies that jump at times, as where a spring becomes stiffer: h jumps with them.

In the sense of distributions dh/dt = -dL/dt + sum Q_k q_dot_k has an impulse there. What jumps, J, is
subtracted from h, and the rate of J between the jumps from that of h: h - J and the integral of this rate are
continuous, and their difference is the same. Roots such as abs(t - 1)**0.5 are treated alike: their rates are
infinite at a time, and no rule integrates them to rounding.
"""

from __future__ import annotations

from lagrange_cli.expression.graph import Graph
from lagrange_cli.expression.node import Kind, Node, factors_of, reachable, terms_of, union
from lagrange_cli.expression.switch_forms import whole
from lagrange_cli.mechanics.substitution import substituted
from lagrange_cli.mechanics.switching.switches import vanishes_with
from lagrange_cli.mechanics.variables import graph_of, numbered
from lagrange_cli.model.model import Model


def jumps_at_times(graph: Graph, node: Node, model: Model[Node]) -> bool:
    """Whether a switch below the node jumps at times that do not depend on the motion, or the rate of a root
    is infinite at such a time."""
    moving = union((*model.q, *model.v))

    def timed(argument: Node) -> bool:
        return bool(argument.symbols & model.time.symbols) and not argument.symbols & moving

    for one in reachable([node], lambda one: bool(one.symbols & model.time.symbols)):
        if one.kind is Kind.SWITCH and timed(one.arguments[0]):
            u, above, below = one.arguments
            if not vanishes_with(graph, above - below, u):
                return True
        elif one.kind is Kind.POWER:
            if timed(one.arguments[0]):
                return True
        elif any(timed(base) and exponent < 1 and not whole(exponent) for base, exponent in factors_of(one)):
            return True
    return False


def switched_energy(model: Model[Node], lagrangian: Node) -> tuple[Node, Node]:
    """J, the terms of -L at rest that jump at times, or have infinite rates there, and its rate between.

    dL/dq_dot may not jump at a time (``jumps``), so that J and h jump by the same.
    """
    graph = graph_of(model)
    jumping = [(term, -c) for term, c in terms_of(lagrangian) if jumps_at_times(graph, term, model)]
    (energy,) = substituted(graph, [graph.sum(jumping)], dict.fromkeys(model.v, graph.zero))
    slopes = graph.gradient(energy, numbered(model.q))
    rate = [(slope * model.v[k], 1.0) for k, slope in slopes.items()]
    return energy, graph.sum([*rate, (graph.diff(energy, model.time), 1.0)])
