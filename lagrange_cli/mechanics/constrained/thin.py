"""Thin rods, which have no moment of inertia about their own axis: what determines their rotation about it?

An orientation that turns a rod about its own axis only has no effect: another axis is meant. Angles that only
give the direction of a rod leave nothing undetermined. A quaternion, or three angles, do: there the matrix of
masses and constraints is singular in every state, unless a further constraint determines the rotation.
"""

from __future__ import annotations

import random
from collections.abc import Mapping, Sequence

from lagrange_cli.errors import Spinning
from lagrange_cli.expression.evaluate import evaluate
from lagrange_cli.expression.node import Kind, Node, reachable
from lagrange_cli.mechanics.residual import Residual
from lagrange_cli.mechanics.variables import graph_of, numbered
from lagrange_cli.model.model import Model
from lagrange_cli.model.scope import Scope

NOTHING = 1e-10
"""The remainder of a row is 0 if it is this small relative to the row."""


def refuse_spinning(residual: Residual) -> None:
    """Raise ``Spinning`` where nothing determines how a rod turns about its axis."""
    spec, rods = residual.model.spec, rods_of(residual.model)
    if spec is None or not rods:
        return
    graph, velocities = graph_of(residual.model), numbered(residual.model.v)
    scope = Scope(spec, residual.model.algebra)
    turns = [graph.gradient(scope.turning(name).component("w3"), velocities) for name in rods]
    entries = [node for row in (*residual.entries, *turns) for node in row.values()]
    names = [str(node.data) for node in reachable(entries) if node.kind is Kind.SYMBOL]
    source = random.Random(1)
    values, _ = evaluate(entries, {name: source.uniform(0.3, 1.3) for name in names})

    def numbers(row: Mapping[int, Node]) -> dict[int, float]:
        return {k: float(values[node]) for k, node in row.items()}

    matrix = [numbers(row) for row in residual.entries]
    known = rank(matrix)
    if known == len(matrix):
        return
    for name, turn in zip(rods, turns):
        if rank([*matrix, numbers(turn)]) > known:
            raise Spinning(name)


def refuse_idle(model: Model[Node]) -> None:
    """Raise ``Spinning`` where a rod turns about its axis only."""
    rods = rods_of(model)
    if model.spec is None or not rods:
        return
    scope, velocities = Scope(model.spec, model.algebra), numbered(model.v)
    for name in rods:
        w1, w2, w3 = scope.turning(name).in_body
        if w1.is_zero and w2.is_zero and graph_of(model).gradient(w3, velocities):
            raise Spinning(name, only=True)


def rods_of(model: Model[Node]) -> list[str]:
    """The names of the bodies that are thin rods."""
    bodies = {} if model.spec is None else model.spec.bodies
    return [name for name, one in bodies.items() if one.inertia.solid == "rod"]


def rank(rows: Sequence[Mapping[int, float]]) -> int:
    """The number of rows that do not depend on others, by elimination with the largest entries."""
    left = [(dict(row), max(map(abs, row.values()), default=0.0)) for row in rows]
    found = 0
    while left:
        best = max(left, key=lambda one: max(map(abs, one[0].values()), default=0.0) / (one[1] or 1.0))
        row, size = best
        place = max(row, key=lambda k: abs(row[k]), default=-1)
        if place < 0 or not abs(row[place]) > NOTHING * size:
            break
        left.remove(best)
        found += 1
        for other, _ in left:
            factor = other.pop(place, 0.0) / row[place]
            for k, value in row.items() if factor else ():
                if k != place:
                    other[k] = other.get(k, 0.0) - factor * value
    return found
