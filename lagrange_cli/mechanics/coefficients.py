"""Coefficients of a linear relation between expressions, as functions of parameters.

At simple values of the variables, 0 and 1, the relation is a linear equation whose coefficients are functions
of the parameters alone. Those that contain the fewest unknown coefficients are taken and solved.
"""

from __future__ import annotations

import math
import random
from collections.abc import Callable, Iterator, Mapping, Sequence

from lagrange_cli.expression.evaluate import evaluate
from lagrange_cli.expression.graph import Graph
from lagrange_cli.expression.node import Node, reachable
from lagrange_cli.mechanics.laurent import multiplied_out
from lagrange_cli.mechanics.matrices import determinant
from lagrange_cli.mechanics.substitution import substituted

SIMPLE = (0.0, 1.0, -1.0, 2.0, 0.5)
"""Values of variables that are tried."""
MOST_IN_PAIRS = 7
"""For so many variables, states are tried at which two of them are not 0."""
DRAWN = 12
"""States with such values at random, after those where few variables are not 0."""
MOST_COUPLED = 5
"""Unknown coefficients that are found from as many equations at once."""
NEGLIGIBLE = 1e-9
"""A value that is smaller, relative to the terms of its sum, is 0."""
WORK = 4
"""Steps of work of a node at a state: its value, and what it becomes with these numbers."""

Row = Sequence[Node]
"""The coefficients of an equation, without those that are 0 by their values."""


def coefficients(
    graph: Graph,
    columns: Sequence[Sequence[Node]],
    variables: Sequence[Node],
    parameters: Mapping[str, float],
    known: Mapping[int, Node],
    is_new: Callable[[Sequence[float]], bool],
) -> list[Node] | None:
    """Functions c_i of the parameters with sum_i c_i column_i = 0, where there is one such relation, and all
    columns occur in it; None where they are not found. Some may be ``known``, else the relation is found up
    to a factor. ``parameters`` are values at which it is true, and ``is_new`` says of numbers in front of the
    unknown ones whether they are no combination of those before. The relation has to be proven."""
    found = list[tuple[Row, list[float]]]()
    first: list[tuple[Row, list[float]]] | None = None
    for values in states(variables):
        here = [*rows_at(graph, columns, variables, values, parameters)]
        first = first or (here if len(here) == len(columns[0]) else None)
        if first and len(here) == len(first):
            found += [differing(graph, one, other) for one, other in zip(here, first) if here is not first]
        found += here
    unknown = [i for i in range(len(columns)) if i not in known]
    some = [(row, [numbers[i] for i in unknown]) for row, numbers in found]
    fewest = sorted(some, key=lambda one: sum(map(bool, one[1])))
    rows = [row for row, numbers in fewest if any(numbers) and is_new(numbers)]
    if len(rows) != len(unknown) - (not known):
        return None
    graph.work.charge(len(rows) ** 3)
    starts = [known] if known else [{i: graph.one} for i, x in enumerate(rows[0]) if not x.is_zero]
    return next((one for one in (solution(graph, rows, start) for start in starts) if one is not None), None)


def rows_at(
    graph: Graph,
    columns: Sequence[Sequence[Node]],
    variables: Sequence[Node],
    values: Mapping[str, float],
    parameters: Mapping[str, float],
) -> Iterator[tuple[Row, list[float]]]:
    """The equations at a state, and their numbers where the parameters have values."""
    fixed = {one: graph.constant(values[str(one.data)]) for one in variables}
    graph.work.charge(WORK * len(reachable([one for column in columns for one in column])))
    for row in zip(*columns):
        value, size = evaluate(row, {**parameters, **values})
        numbers = [0.0 if abs(value[one]) <= NEGLIGIBLE * size[one] else float(value[one]) for one in row]
        if all(map(math.isfinite, numbers)):
            nodes = substituted(graph, row, fixed)
            yield [node if number else graph.zero for node, number in zip(nodes, numbers)], numbers


def differing(
    graph: Graph, one: tuple[Row, list[float]], other: tuple[Row, list[float]]
) -> tuple[Row, list[float]]:
    """The difference of two equations, from which what does not move is gone."""
    nodes = [a - b for a, b in zip(one[0], other[0])]
    numbers = [0.0 if abs(a - b) <= NEGLIGIBLE * abs(a) else a - b for a, b in zip(one[1], other[1])]
    return [node if number else graph.zero for node, number in zip(nodes, numbers)], numbers


def states(variables: Sequence[Node]) -> Iterator[dict[str, float]]:
    """Values of the variables, simple ones first."""
    names = [str(one.data) for one in variables]
    still = dict.fromkeys(names, 0.0)
    yield still
    for i, name in enumerate(names):
        yield {**still, name: 1.0}
        if len(names) <= MOST_IN_PAIRS:
            yield from ({**still, name: 1.0, other: 1.0} for other in names[:i])
    yield dict.fromkeys(names, 1.0)
    source = random.Random(len(names))
    for _ in range(DRAWN):
        yield {name: source.choice(SIMPLE) for name in names}


def solution(graph: Graph, rows: Sequence[Row], start: Mapping[int, Node]) -> list[Node] | None:
    """All unknowns, from some: one after the other where an equation contains just one that is not known,
    else several at once."""
    known, left = {**start}, [*rows]
    while left:
        unknown = [[j for j, x in enumerate(row) if not x.is_zero and j not in known] for row in left]
        sets = [frozenset(own) for own in unknown if own]
        closed = [one for one in sets if sum(other <= one for other in sets) >= len(one)]
        least = min((*closed, frozenset().union(*sets)), key=len)
        wanted, coupled = sorted(least), [row for row, own in zip(left, unknown) if own and {*own} <= least]
        coupled = coupled[: len(wanted)]
        if not wanted or len(wanted) > min(MOST_COUPLED, len(coupled)):
            return None
        right = [graph.sum([(row[j] * x, -1.0) for j, x in known.items()]) for row in coupled]
        matrix = [[row[j] for j in wanted] for row in coupled]
        below = determinant(graph, matrix)
        if below.is_zero:
            return None
        for k, j in enumerate(wanted):
            replaced = [[*row[:k], x, *row[k + 1 :]] for row, x in zip(matrix, right)]
            known[j] = multiplied_out(graph, determinant(graph, replaced) / below)
        left = [row for row in left if not any(row is one for one in coupled)]
    return [known[j] for j in sorted(known)]
