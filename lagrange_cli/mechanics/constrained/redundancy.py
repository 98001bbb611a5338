"""The multipliers of constraints of which some depend on others: of all that give the same forces, those of
least norm.

Let A be the slopes of the constraints that the equations are derived with, B = C A those of the ones left
out, and lambda the multipliers found. The forces A^T lambda are also those of the multipliers lambda - C^T mu
and mu, whatever mu. Their norm is least where

    (1 + C C^T) mu = C lambda,    with (A A^T) C^T = A B^T

(A. Ben-Israel and T. N. E. Greville, Generalized Inverses, 2nd ed., sec. 3.2).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from lagrange_cli.expression.graph import Graph
from lagrange_cli.expression.node import Node
from lagrange_cli.mechanics.constraints import Constraints
from lagrange_cli.mechanics.variables import graph_of
from lagrange_cli.model.model import Model
from lagrange_cli.records import replace

Row = Mapping[int, Node]
Matrix = list[list[Node]]


def multipliers_of_least_norm(model: Model[Node]) -> dict[str, Node]:
    """The multiplier of each constraint by name, those that were left out too, as a function of the state and
    the multipliers' symbols."""
    graph = graph_of(model)
    found = {one.name: one.multiplier for one in model.constraints}
    rows = Constraints(model).slopes
    left = Constraints(replace(model, constraints=model.redundant)).slopes
    for mine, others in coupled(rows, left):
        a, b = [rows[i] for i in mine], [left[i] for i in others]
        lambdas = [model.constraints[i].multiplier for i in mine]
        turned = solved(graph, products(graph, a, a), products(graph, a, b))
        weights = [[turned[i][j] for i in range(len(mine))] for j in range(len(others))]
        whole = [
            [
                graph.sum([(graph.one, float(i == j)), *((x * y, 1.0) for x, y in zip(one, other))])
                for j, other in enumerate(weights)
            ]
            for i, one in enumerate(weights)
        ]
        right = [[graph.sum([(c * one, 1.0) for c, one in zip(row, lambdas)])] for row in weights]
        shares = [row[0] for row in solved(graph, whole, right)]
        for j, number in enumerate(others):
            found[model.redundant[number].name] = shares[j]
        for i, number in enumerate(mine):
            taken = [(weights[j][i] * share, -1.0) for j, share in enumerate(shares)]
            found[model.constraints[number].name] = graph.sum([(lambdas[i], 1.0), *taken])
    return found


def with_those_in_turn(model: Model[Node]) -> tuple[Model[Node], frozenset[int]]:
    """The model with those of its redundant constraints that depend on others by factors that change along a
    motion: no other choice would do everywhere. And their numbers: the multipliers are those of least norm
    (``native.linear.dependent``)."""
    names = () if model.spec is None else model.spec.in_turn
    back = tuple(one for one in model.redundant if one.name in names)
    if not back:
        return model, frozenset()
    count, rest = len(model.constraints), tuple(one for one in model.redundant if one not in back)
    whole = replace(model, constraints=(*model.constraints, *back), redundant=rest)
    return whole, frozenset(range(count, count + len(back)))


def coupled(rows: Sequence[Row], left: Sequence[Row]) -> list[tuple[list[int], list[int]]]:
    """Constraints with those left out that they have coordinates in common with, directly or by others."""
    groups: list[tuple[set[int], list[int], list[int]]] = []
    for i, row in enumerate((*rows, *left)):
        mine, others = ([i], []) if i < len(rows) else ([], [i - len(rows)])
        inside: set[int] = set(row)
        apart = []
        for group in groups:
            if group[0] & inside:
                inside, mine, others = inside | group[0], group[1] + mine, group[2] + others
            else:
                apart.append(group)
        groups = [*apart, (inside, mine, others)]
    return [(sorted(mine), sorted(others)) for _, mine, others in groups if others]


def products(graph: Graph, rows: Sequence[Row], others: Sequence[Row]) -> Matrix:
    """The scalar products of rows with others."""
    return [
        [graph.sum([(a * other[k], 1.0) for k, a in row.items() if k in other]) for other in others]
        for row in rows
    ]


def solved(graph: Graph, matrix: Matrix, right: Matrix) -> Matrix:
    """X in ``matrix`` X = ``right``, for a matrix that is symmetric and positive: by elimination."""
    size, width = len(matrix), len(right[0])
    rows = [[*one, *other] for one, other in zip(matrix, right)]
    for p in range(size):
        for i in range(p + 1, size):
            if rows[i][p].is_zero:
                continue
            factor = rows[i][p] / rows[p][p]
            rows[i] = [
                x if k < p or rows[p][k].is_zero else graph.zero if k == p else x - factor * rows[p][k]
                for k, x in enumerate(rows[i])
            ]
    for p in reversed(range(size)):
        for j in range(size, size + width):
            known = [(rows[p][k] * rows[k][j], -1.0) for k in range(p + 1, size)]
            rows[p][j] = graph.sum([(rows[p][j], 1.0), *known]) / rows[p][p]
    return [row[size:] for row in rows]
