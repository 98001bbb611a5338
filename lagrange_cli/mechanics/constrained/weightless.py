"""Which coordinates have no inertia of their own: where the mass matrix is singular, whatever the state.

So are those of a point that more coordinates than necessary describe, and the length of a quaternion. Such
coordinates are allowed if constraints determine them.
"""

from __future__ import annotations

import random
from collections.abc import Mapping, Sequence
from itertools import chain
from math import isfinite

from lagrange_cli.expression.evaluate import evaluate
from lagrange_cli.expression.node import Kind, Node, reachable
from lagrange_cli.mechanics.matrices import connected
from lagrange_cli.mechanics.variables import nonzero

NOTHING = 1e-10
"""A pivot that is no larger than this part of its diagonal entry is 0 at random states."""
DRAWS = 3
LARGEST_BLOCK = 24
"""The largest block of coordinates that is looked at for momenta that depend on each other."""


def weightless(matrix: Sequence[Sequence[Node]]) -> frozenset[int]:
    """The coordinates whose pivots vanish as a positive mass matrix is eliminated at random states."""
    places = [nonzero(row, row[j].graph.zero, j) for j, row in enumerate(matrix)]
    entries = [row[k] for row, some in zip(matrix, places) for k in some]
    names = [str(node.data) for node in reachable(entries) if node.kind is Kind.SYMBOL]
    blocks = connected(matrix)
    source, found = random.Random(1), list[frozenset[int]]()
    for _ in range(DRAWS):
        values, _ = evaluate(entries, {name: source.uniform(0.3, 1.3) for name in names})
        numbers = [{k: float(values[row[k]]) for k in some} for row, some in zip(matrix, places)]
        found.append(frozenset(k for block in blocks for k in _vanishing(numbers, block)))
    return min(found, key=len)


def entangled(matrix: Sequence[Sequence[Node]]) -> list[int]:
    """Coordinates with a change of velocities that changes no momentum, at every state: those of the first
    block of the mass matrix that is singular. Nothing where a block is too large, or ill-conditioned."""
    source = random.Random(2)
    for block in connected(matrix):
        if not 1 < len(block) <= LARGEST_BLOCK:
            continue
        from lagrange_cli.mechanics.relations import dependent  # what is uncoupled does not need it

        columns = [[matrix[j][k] for j in block] for k in block]
        names = [str(one.data) for one in reachable(chain.from_iterable(columns)) if one.kind is Kind.SYMBOL]
        for _ in range(DRAWS):
            values, _ = evaluate(
                [*chain.from_iterable(columns)], {name: source.uniform(0.3, 1.3) for name in names}
            )
            rows = [[float(values[column[i]]) for column in columns] for i in range(len(block))]
            relations = dependent(rows, len(block)) if all(map(isfinite, chain.from_iterable(rows))) else {}
            if not relations or not singular(rows):
                break
        else:
            return sorted(block[i] for i in next(iter(relations.values())))
    return []


def singular(rows: Sequence[Sequence[float]]) -> bool:
    """Whether a matrix is singular, and not only ill-conditioned."""
    import numpy as np

    from lagrange_cli.mechanics.conditioning import conditioning

    found = conditioning(np.array(rows))
    return found is not None and bool(found.lost) and not found.graded


def _vanishing(matrix: Sequence[Mapping[int, float]], block: Sequence[int]) -> list[int]:
    rows = [[matrix[j].get(k, 0.0) for k in block] for j in block]
    found = []
    for p, place in enumerate(block):
        if not abs(rows[p][p]) > NOTHING * abs(matrix[place].get(place, 0.0)):
            found.append(place)
            continue
        for i in range(p + 1, len(block)):
            factor = rows[i][p] / rows[p][p]
            for k in range(p, len(block)):
                rows[i][k] -= factor * rows[p][k]
    return found
