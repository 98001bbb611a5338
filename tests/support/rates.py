"""Rates of change along motions at random states, in floating-point numbers.

The search for what is conserved takes another route.
"""

from __future__ import annotations

import random
from collections.abc import Iterator, Sequence

import numpy as np

from lagrange_cli.expression.evaluate import evaluate
from lagrange_cli.expression.node import Kind, Node, reachable
from lagrange_cli.mechanics.conserved.noether import Noether
from lagrange_cli.mechanics.variables import graph_of
from lagrange_cli.model.model import Model

STATES, TRIES = 12, 120
"""The states, and those that are drawn at most: numbers need not be finite everywhere, as where a frequency
is sqrt(g/m - k**2/m**2) with any parameters."""
NEWTON = 12
"""Steps towards the holonomic constraints."""


def rates(
    model: Model[Node], nodes: Sequence[Node], seed: int = 0, level: Node | None = None
) -> Iterator[tuple[list[float], list[float]]]:
    """df/dt of the nodes at random states that constraints allow, and the sizes of their terms.

    Without constraints, a ``level`` that is proportional to velocities may be 0 at these states.
    """
    graph, noether, n = graph_of(model), Noether(model), len(model.q)
    energetics, constraints = noether.energetics, noether.constraints
    matrix = [[graph.diff(p, v) for v in model.v] for p in energetics.momenta]
    forces = [
        energetics.lagrangian_rate(q) + force - noether.rate(p)
        for q, force, p in zip(model.q, energetics.applied, energetics.momenta)
    ]
    holonomic = [i for i, one in enumerate(model.constraints) if one.holonomic]
    bound = [model.constraints[i].expression for i in holonomic]
    slopes = [[row.get(k, graph.zero) for k in range(n)] for row in constraints.slopes]
    turning = [noether.rate(speed) for speed in constraints.speeds]
    drift = [noether.rate(one) for one in nodes]
    steep = [[graph.diff(one, v) for v in model.v] for one in nodes]
    parts = [[graph.diff(one, q) for q in model.q] for one in nodes]
    steps = [] if level is None else [graph.diff(level, one) for one in model.v]
    groups = [bound, steps, *matrix, forces, *slopes, turning, [*constraints.drifts], drift, *steep, *parts]
    wanted = [one for group in groups for one in group]
    symbols = [str(one.data) for one in reachable(wanted) if one.kind is Kind.SYMBOL]
    source = random.Random(seed)
    count = 0
    for _ in range(TRIES):
        if count == STATES:
            break
        given = {name: source.uniform(0.4, 1.3) for name in symbols}
        v = np.array([given.setdefault(str(one.data), source.uniform(0.4, 1.3)) for one in model.v])
        value, _ = evaluate(wanted, given)
        for _ in range(NEWTON if bound else 0):
            a, f = numbers([slopes[i] for i in holonomic], value), numbers([bound], value)[0]
            step = np.linalg.lstsq(a, f, rcond=None)[0]
            given |= {str(x.data): given.get(str(x.data), 1.0) - float(d) for x, d in zip(model.q, step)}
            value, _ = evaluate(wanted, given)
        if slopes:
            a = numbers(slopes, value)
            b = np.array([float(value[one]) for one in constraints.drifts])
            v = v - np.linalg.lstsq(a, a @ v + b, rcond=None)[0]
            given |= {str(one.data): float(x) for one, x in zip(model.v, v)}
            value, _ = evaluate(wanted, given)
        if steps:
            along = numbers([steps], value)[0]
            v = v - along * (along @ v) / (along @ along)
            given |= {str(one.data): float(x) for one, x in zip(model.v, v)}
            value, _ = evaluate(wanted, given)
        m = numbers(matrix, value)
        f = np.array([float(value[one]) for one in forces])
        if slopes:
            a, c = numbers(slopes, value), np.array([float(value[one]) for one in turning])
            whole = np.block([[m, -a.T], [a, np.zeros((len(a), len(a)))]])
            acceleration = np.linalg.lstsq(whole, np.concatenate([f, -c]), rcond=None)[0][:n]
        else:
            acceleration = np.linalg.solve(m, f)
        found = [float(value[x]) + numbers([row], value)[0] @ acceleration for x, row in zip(drift, steep)]
        sizes = [
            np.abs(numbers([row], value)[0] * acceleration).sum()
            + np.abs(numbers([part], value)[0] * v).sum()
            + 1e-3
            for row, part in zip(steep, parts)
        ]
        if np.isfinite(found).all() and np.isfinite(sizes).all():
            count += 1
            yield [float(x) for x in found], [float(x) for x in sizes]


def numbers(rows: Sequence[Sequence[Node]], value: dict[Node, float]) -> np.ndarray:
    """The values of a matrix."""
    return np.array([[float(value[one]) for one in row] for row in rows])
