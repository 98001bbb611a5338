"""Whether a function of the state is constant along every motion.

With R(q, v, a, t) = M a + f = 0, where multipliers of constraints count as accelerations, it does where

    det M (dg/dq v + dg/dt) - dg/dv adj(M) f

vanishes identically: then no motion crosses a surface g = 0.
"""

from __future__ import annotations

from lagrange_cli.expression.node import Node
from lagrange_cli.expression.zero import is_zero
from lagrange_cli.mechanics.explicit import write_out
from lagrange_cli.mechanics.matrices import determinant
from lagrange_cli.mechanics.residual import Residual
from lagrange_cli.mechanics.substitution import substituted

WORTH = 300_000
"""Steps of work after which the question is left open."""


def is_constant(residual: Residual, node: Node) -> bool:
    """Whether it is proven to be."""
    return bool(residual.graph.work.attempt(WORTH, lambda: _vanishes(residual, node)))


def _vanishes(residual: Residual, node: Node) -> bool:
    graph, model = residual.graph, residual.model
    accelerations, rows = write_out(residual)
    unknown = (*accelerations, *residual.multipliers)
    matrix = [[graph.diff(row, a) for a in unknown] for row in rows]
    forces = substituted(graph, rows, dict.fromkeys(unknown, graph.zero))
    drift = graph.sum(
        [
            (graph.diff(node, model.time), 1.0),
            *((graph.diff(node, q) * v, 1.0) for q, v in zip(model.q, model.v)),
        ]
    )
    terms = [(drift * determinant(graph, matrix), 1.0)]
    for k, v in enumerate(model.v):
        slope = graph.diff(node, v)
        if not slope.is_zero:  # Cramer's rule: f in place of column k
            replaced = [[*row[:k], f, *row[k + 1 :]] for row, f in zip(matrix, forces)]
            terms.append((slope * determinant(graph, replaced), -1.0))
    return is_zero(graph.sum(terms))
