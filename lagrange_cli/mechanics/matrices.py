"""The blocks of a matrix of expressions, and its determinant."""

from __future__ import annotations

from collections.abc import Sequence

from lagrange_cli.expression.graph import Graph
from lagrange_cli.expression.node import Node
from lagrange_cli.mechanics.variables import nonzero

Matrix = Sequence[Sequence[Node]]


def connected(matrix: Matrix) -> tuple[tuple[int, ...], ...]:
    """The index sets that a matrix's nonzero entries connect, each sorted, in order of first index."""
    neighbours: list[set[int]] = [set() for _ in matrix]
    for j, row in enumerate(matrix):
        for k in nonzero(row, row[j].graph.zero, j):
            neighbours[j].add(k)
            neighbours[k].add(j)
    blocks = []
    done: set[int] = set()
    for first in range(len(matrix)):
        block: set[int] = set()
        pending = set() if first in done else {first}
        while pending:
            block |= pending
            pending = set[int]().union(*(neighbours[j] for j in pending)) - block
        if block:
            done |= block
            blocks.append(tuple(sorted(block)))
    return tuple(blocks)


def determinant(graph: Graph, matrix: Matrix) -> Node:
    """By its first column, of which zeros are left out."""
    if not matrix:
        return graph.one
    terms = []
    for i, row in enumerate(matrix):
        if not row[0].is_zero:
            rest = [other[1:] for j, other in enumerate(matrix) if j != i]
            graph.work.charge(len(matrix))
            terms.append((row[0] * determinant(graph, rest), 1.0 if i % 2 == 0 else -1.0))
    return graph.sum(terms)
