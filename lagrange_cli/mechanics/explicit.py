"""The equations with their time derivatives written out, R(q, q_dot, q_ddot, t), and what Newton
iterations need.

Taylor series never need this form; implicit methods do, for the Jacobian of the accelerations
a(q, q_dot, t): from R(q, q_dot, a, t) = 0, M da/dx = -dR/dx at fixed a.
"""

from __future__ import annotations

from collections.abc import Sequence

from lagrange_cli.expression.node import Kind, Node, reachable
from lagrange_cli.expression.vocabulary import acceleration_name
from lagrange_cli.mechanics.residual import Residual
from lagrange_cli.mechanics.substitution import rebuilt, substituted
from lagrange_cli.records import dataclass


@dataclass(frozen=True)
class Linearization:
    """``accelerations`` are the symbols q_ddot; ``by_q[j][k]`` = dR_j/dq_k and ``by_v[j][k]`` =
    dR_j/dq_dot_k."""

    accelerations: tuple[Node, ...]
    by_q: tuple[tuple[Node, ...], ...]
    by_v: tuple[tuple[Node, ...], ...]


def expanded(
    residual: Residual, nodes: Sequence[Node] | None = None
) -> tuple[tuple[Node, ...], tuple[Node, ...]]:
    """(symbols of the accelerations, R_k in q, q_dot, q_ddot, t and cyclic momenta without ``ddt`` nodes); or
    other ``nodes`` than R_k."""
    nodes = residual.residual if nodes is None else nodes
    graph, model = residual.graph, residual.model
    accelerations = tuple(graph.symbol(acceleration_name(name)) for name in model.coordinates)
    rates = list(zip(model.q, model.v)) + list(zip(model.v, accelerations)) + [(model.time, graph.one)]
    plain: dict[Node, Node] = {}
    for node in reachable(nodes):
        arguments = [plain[argument] for argument in node.arguments]
        if node.kind is Kind.DDT:
            terms = [(graph.diff(arguments[0], symbol) * rate, 1.0) for symbol, rate in rates]
            plain[node] = graph.sum(terms)
        else:
            plain[node] = rebuilt(graph, node, arguments)
    return accelerations, tuple(plain[node] for node in nodes)


def write_out(residual: Residual) -> tuple[tuple[Node, ...], tuple[Node, ...]]:
    """(symbols of the accelerations, R_k in q, q_dot, q_ddot, t without ``ddt`` nodes)."""
    accelerations, rows = expanded(residual)
    momenta = {one.symbol: one.momentum for one in residual.cyclic_momenta}
    return accelerations, substituted(residual.graph, rows, momenta)


def linearize(residual: Residual) -> Linearization:
    """The derivatives of R at fixed accelerations."""
    graph, model = residual.graph, residual.model
    accelerations, rows = write_out(residual)
    return Linearization(
        accelerations,
        tuple(tuple(graph.diff(row, q) for q in model.q) for row in rows),
        tuple(tuple(graph.diff(row, v) for v in model.v) for row in rows),
    )
