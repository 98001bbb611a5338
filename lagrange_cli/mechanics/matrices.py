"""The blocks of a matrix of expressions, and its determinant."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from lagrange_cli.expression.graph import Graph
from lagrange_cli.expression.node import Node
from lagrange_cli.mechanics.variables import nonzero

Matrix = Sequence[Sequence[Node]]


def connected(matrix: Matrix) -> tuple[tuple[int, ...], ...]:
    """The index sets that a matrix's nonzero entries connect, each sorted, in order of first index."""
    rows = ((j, *nonzero(row, row[j].graph.zero, j)) for j, row in enumerate(matrix))
    return united(len(matrix), rows)


def united(count: int, sets: Iterable[Sequence[int]]) -> tuple[tuple[int, ...], ...]:
    """The numbers below ``count`` in blocks: those of one of the ``sets`` are in the same. Each block is
    sorted, and they are in the order of their first numbers.

    In a time that is proportional to what the sets hold, up to a logarithm (union-find: B. A. Galler and
    M. J. Fischer, Commun. ACM 7, 1964, 301).
    """
    parent = [*range(count)]

    def first_of(j: int) -> int:
        while parent[j] != j:
            parent[j] = j = parent[parent[j]]
        return j

    for one in sets:
        for j in one[1:]:
            low, high = sorted((first_of(one[0]), first_of(j)))
            parent[high] = low
    blocks: dict[int, list[int]] = {}
    for j in range(count):
        blocks.setdefault(first_of(j), []).append(j)
    return tuple(map(tuple, blocks.values()))


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


def matrix_of(coordinates: int, multipliers: int) -> str:
    """What takes work, for messages."""
    return f"a matrix of {coordinates} coordinates and {multipliers} multipliers"
