"""Roots in forces whose arguments are 0: there the motion has no Taylor series."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence

import numpy as np

from lagrange_cli.expression.arrays import evaluate
from lagrange_cli.expression.node import Kind, Node, factors_of, reachable, union
from lagrange_cli.mechanics.guards.vectors import held
from lagrange_cli.mechanics.switching.jumps import switching
from lagrange_cli.mechanics.switching.lengths import completed
from lagrange_cli.mechanics.variables import graph_of, numbered, variables
from lagrange_cli.model.model import Model
from lagrange_cli.records import dataclass


@dataclass(frozen=True)
class Root:
    """A root in the equations whose argument is 0: whether something is ``divided`` by it, as the derivative
    of a square root does, and whether the argument ``passes`` 0 when coordinates change."""

    divided: bool
    passes: bool


def root_in_forces(model: Model[Node], known: Mapping[str, float]) -> Root | None:
    """A root in the equations of motion whose argument is 0 with these values of all symbols."""
    graph, moving = graph_of(model), variables(model)
    nodes = [one for one in forces(model) if all(str(x.data) in known for x in graph.symbols_of(one))]
    parts = [*reachable(nodes)]
    values = dict(zip(parts, map(float, evaluate(parts, known))))
    found = None
    for base, exponent in roots(nodes, values):
        if not base.symbols & moving:
            continue
        divided, vector = exponent < 0.0, completed(graph, base, model.v)
        if not divided and (switching([base]) or vector is not None):
            continue  # the motion passes: see ``mechanics.guards``
        if divided and vector is not None and all(held(graph, one, vector) is not None for one in nodes):
            continue  # friction holds it there
        slopes = [*graph.gradient(base, numbered([*model.q, *model.v, model.time])).values()]
        passes = any(np.any(one) for one in evaluate(slopes, known))
        if divided:
            return Root(divided, passes)
        found = found or Root(divided, passes)
    return found


def forces(model: Model[Node]) -> list[Node]:
    """What the equations of motion are made of."""
    graph, state = graph_of(model), numbered([*model.q, *model.v])
    energy = model.potential if model.lagrangian is None else model.lagrangian
    nodes = [*graph.gradient(energy, state).values(), *graph.gradient(model.dissipation, state).values()]
    nodes += model.generalized_forces
    speeds = union(model.v)
    for particle in model.particles:
        nodes += [*particle.force, *(u for u in particle.velocity if u.symbols & speeds)]
    return [*nodes, *(one.expression for one in model.constraints if not one.holonomic)]


def roots(nodes: Sequence[Node], values: Mapping[Node, float]) -> Iterator[tuple[Node, float]]:
    """The bases that are 0 of powers without a series, and their exponents; arguments of asin and acos that
    are 1 or -1 count as such. Of switches, the side that applies is looked at, and none if neither does."""
    pending, seen = [*nodes], set[Node]()
    while pending:
        node = pending.pop()
        if node in seen:
            continue
        seen.add(node)
        if node.kind is Kind.SWITCH:
            u, above, below = node.arguments
            pending += [u, *([above] if values[u] > 0.0 else [below] if values[u] < 0.0 else [])]
            continue
        powers = factors_of(node) if node.kind is Kind.PRODUCT else []
        if node.kind is Kind.POWER:
            powers = [(node.arguments[0], values[node.arguments[1]])]
        yield from ((base, e) for base, e in powers if values[base] == 0.0 and (e < 0.0 or e % 1.0))
        if node.kind is Kind.FUNCTION and node.data in ("asin", "acos"):
            yield from ((u, 0.5) for u in node.arguments if abs(values[u]) == 1.0)
        pending += node.arguments
