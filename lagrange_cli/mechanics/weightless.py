"""Which coordinates have no inertia of their own: where the mass matrix is singular, whatever the state.

So are those of a point that more coordinates than necessary describe, and the length of a quaternion. Such
coordinates are allowed if constraints determine them.
"""

from __future__ import annotations

import random
from collections.abc import Sequence

from lagrange_cli.expression.evaluate import evaluate
from lagrange_cli.expression.node import Kind, Node, reachable
from lagrange_cli.mechanics.residual import connected

NOTHING = 1e-10
"""A pivot that is no larger than this part of its diagonal entry is 0 at random states."""
DRAWS = 3


def weightless(matrix: Sequence[Sequence[Node]]) -> frozenset[int]:
    """The coordinates whose pivots vanish as a positive mass matrix is eliminated at random states."""
    entries = [entry for row in matrix for entry in row]
    names = [str(node.data) for node in reachable(entries) if node.kind is Kind.SYMBOL]
    source, found = random.Random(1), list[frozenset[int]]()
    for _ in range(DRAWS):
        values, _ = evaluate(entries, {name: source.uniform(0.3, 1.3) for name in names})
        numbers = [[float(values[entry]) for entry in row] for row in matrix]
        found.append(frozenset(k for block in connected(matrix) for k in _vanishing(numbers, block)))
    return min(found, key=len)


def _vanishing(matrix: Sequence[Sequence[float]], block: Sequence[int]) -> list[int]:
    rows = [[matrix[j][k] for k in block] for j in block]
    found = []
    for p, place in enumerate(block):
        if not abs(rows[p][p]) > NOTHING * abs(matrix[place][place]):
            found.append(place)
            continue
        for i in range(p + 1, len(block)):
            factor = rows[i][p] / rows[p][p]
            for k in range(p, len(block)):
                rows[i][k] -= factor * rows[p][k]
    return found
