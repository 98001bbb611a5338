"""``Formulation``: one way to write the equations of motion, and Euler and Lagrange's.

R_k = d/dt dL/dq_dot_k - dL/dq_k - Q_k = 0 with M = d2L/dq_dot dq_dot.
"""

from __future__ import annotations

from collections.abc import Sequence

from lagrange_cli.expression.graph import Graph
from lagrange_cli.expression.node import Node, terms_of, union
from lagrange_cli.mechanics.residual import CyclicMomentum
from lagrange_cli.mechanics.rows import Matrix, Row
from lagrange_cli.mechanics.substitution import substituted
from lagrange_cli.mechanics.variables import graph_of, nonzero, numbered, rate, variables
from lagrange_cli.model.model import Model
from lagrange_cli.records import dataclass


@dataclass(frozen=True)
class Formulation:
    """One way to write the equations: R_k, M, and what else is in ``Residual``."""

    residual: tuple[Node, ...]
    mass_matrix: Matrix
    cyclic_momenta: tuple[CyclicMomentum, ...] = ()
    inertias: tuple[Node, ...] = ()


def euler_lagrange(
    model: Model[Node], graph: Graph, lagrangian: Node, forces: tuple[Node, ...]
) -> tuple[list[Node], list[Row]]:
    """R_k and M; ``forces`` holds every force outside L."""
    momenta = [graph.diff(lagrangian, v) for v in model.v]
    moving = variables(model)
    residual = [
        rate(graph, p, moving) - graph.diff(lagrangian, q) - force
        for p, q, force in zip(momenta, model.q, forces)
    ]
    velocities = numbered(model.v)
    rows = []
    for p in momenta:
        row = graph.gradient(p, velocities)
        graph.work.charge(len(row), f"a mass matrix of {len(model.v)} coordinates")
        rows.append(Row(row, len(model.v), graph.zero))
    return residual, rows


def gyroscopic(model: Model[Node], graph: Graph, lagrangian: Node, residual: list[Node]) -> list[Node] | None:
    """``residual`` of ``euler_lagrange`` with the rates of b_k(q, t) written out; None if there are none.

    These are the momenta at rest, from terms b_k q_dot_k of L: a field's, or a total time derivative's. The
    remainder of their rates is sum_j (db_k/dq_j - db_j/dq_k) q_dot_j + ..., often far less.
    """
    moving, found = variables(model), list(residual)
    at_rest = dict.fromkeys(model.v, graph.zero)
    fields = substituted(graph, [graph.diff(lagrangian, v) for v in model.v], at_rest)
    for k, field in enumerate(fields):
        if field.symbols & moving:
            slopes = graph.gradient(field, numbered(model.q)).items()
            own = graph.sum([(slope * model.v[j], 1.0) for j, slope in slopes])
            found[k] += own + graph.diff(field, model.time) - rate(graph, field, moving)
    return None if found == residual else found


def normalized(model: Model[Node], residual: Sequence[Node], matrix: Sequence[Row]) -> Formulation:
    """Equations whose acceleration stands alone with a constant factor, divided by it.

    The factor cancels against those of the forces before any number is known: one rounding instead of three.
    (With forces of constraint the matrix would no longer be symmetric.)
    """
    graph, moving = graph_of(model), variables(model)
    multipliers = union(one.multiplier for one in model.constraints)
    rows, equations = [*matrix], [*residual]
    for k, row in enumerate(matrix):
        alone = nonzero(row, graph.zero, k) in ([], [k])
        free = alone and not residual[k].symbols & multipliers
        if free and not row[k].symbols & moving and not row[k].is_zero:
            equations[k] = divided(graph, residual[k], row[k])
            rows[k] = row.replaced(k, graph.one)
    return Formulation(tuple(equations), tuple(rows))


def divided(graph: Graph, node: Node, by: Node) -> Node:
    """``node / by``, term by term."""
    return graph.sum((term / by, c) for term, c in terms_of(node))
