"""Values of parameters with which an energy jumps: whether there may be such ones, and which members of an
ensemble may have them.

``jumps`` decides for one set of values; this module finds the sets for which that is unnecessary.
"""

from __future__ import annotations

import random
from collections.abc import Collection, Iterator, Mapping, Sequence

import numpy as np
import numpy.typing as npt

from lagrange_cli.expression.arrays import evaluate, sizes
from lagrange_cli.expression.graph import Graph
from lagrange_cli.expression.node import Node
from lagrange_cli.mechanics.substitution import substituted
from lagrange_cli.mechanics.switching.jumps import (
    HALVINGS,
    MOST_SYMBOLS,
    NEARBY,
    PLACES,
    PLAIN,
    POINTS,
    ROUNDING,
    Case,
    differ,
    sides,
    switched,
)
from lagrange_cli.mechanics.variables import graph_of
from lagrange_cli.model.model import Model

Array = npt.NDArray[np.float64]
Mask = npt.NDArray[np.bool_]
Columns = Mapping[str, "Array | float"]
TOGETHER = 4096
"""Members that are examined together."""


def jumps_may_depend_on(model: Model[Node], names: Collection[str]) -> bool:
    """Whether an energy may jump with some values of the parameters ``names``, and not with others."""
    graph = graph_of(model)
    for one, u, _, part in switched(model):
        above, below = sides(graph, part, u)
        at = next(zeros(graph, u, one.symbols), {})
        (jump,) = substituted(graph, [above - below], at)
        decisive = [jump] if at or jump.is_zero else [jump, u]
        found = {str(symbol.data) for node in decisive for symbol in graph.symbols_of(node)}
        if found.intersection(names) and not (at and not differ(graph, above, below, at)):
            return True
    return False


def may_jump(model: Model[Node], parameters: Columns, members: int) -> Mask:
    """The members (members,) that have an energy which may jump, with values that all share, or with one each
    (members,)."""
    return jumping(graph_of(model), [*switched(model)], parameters, members)


def jumping(graph: Graph, listed: Sequence[Case], parameters: Columns, members: int) -> Mask:
    """The members (members,) in which one of the ``listed`` expressions may jump."""
    found = np.zeros(members, dtype=bool)
    for first in range(0, members, TOGETHER):
        part = slice(first, min(first + TOGETHER, members))
        count = part.stop - part.start
        values = {
            name: np.broadcast_to(x if isinstance(x, float) else x[part], (count,))
            for name, x in parameters.items()
        }
        found[part] = together(graph, listed, values, count)
    return found


def together(graph: Graph, listed: Sequence[Case], parameters: Mapping[str, Array], count: int) -> Mask:
    """The same for so many members at once."""
    found = np.zeros(count, dtype=bool)
    for one, u, own, part in listed:
        above, below = sides(graph, part, u)
        for at in zeros(graph, u, one.symbols):
            found |= differing(graph, above, below, at, parameters, count)
        for symbol in own[:MOST_SYMBOLS]:
            found |= at_roots(graph, (above, below, u), str(symbol.data), parameters, count)
    return found


def zeros(graph: Graph, u: Node, symbols: Sequence[Node]) -> Iterator[dict[Node, Node]]:
    """For each of the symbols that u is linear in, what it is where u is 0."""
    for symbol in symbols:
        slope = graph.diff(u, symbol)
        if not slope.is_zero and not slope.symbols & symbol.symbols:
            (rest,) = substituted(graph, [u], {symbol: graph.zero})
            yield {symbol: -1.0 * rest / slope}


def differing(
    graph: Graph,
    above: Node,
    below: Node,
    at: Mapping[Node, Node],
    parameters: Mapping[str, Array],
    count: int,
) -> Mask:
    """Members whose sides differ by more than rounding at random states, ``at`` which the argument is 0."""
    source = random.Random(0)
    equal, known = np.zeros(count, dtype=bool), np.zeros(count, dtype=bool)
    for _ in range(POINTS):
        values = states(graph, [above, below, *at.values()], parameters, source, signed=False)
        for symbol, node in at.items():
            values[str(symbol.data)] = evaluate([node], values)[0]
        high, low = evaluate([above, below], values)
        with np.errstate(invalid="ignore"):
            close = np.abs(high - low) <= ROUNDING * np.fmax(np.abs(high), np.abs(low))
        finite = np.isfinite(high) & np.isfinite(low)
        equal, known = equal | (finite & close), known | finite
    return known & ~equal


def at_roots(
    graph: Graph, nodes: tuple[Node, Node, Node], name: str, parameters: Mapping[str, Array], count: int
) -> Mask:
    """Members whose sides differ at a root of the argument, on lines in the direction of one symbol."""
    above, below, u = nodes
    source = random.Random(0)
    found, places = np.zeros(count, dtype=bool), np.array(PLACES)[:, None]
    for _ in range(POINTS):
        values = states(graph, nodes, parameters, source, signed=True)
        ends = np.broadcast_to(evaluate([u], {**values, name: places})[0], (len(PLACES), count))
        with np.errstate(invalid="ignore", over="ignore"):
            intervals, members = np.nonzero(ends[:-1] * ends[1:] < 0)
        if not len(members):
            continue
        these = {one: x if np.ndim(x) == 0 else np.asarray(x)[members] for one, x in values.items()}
        low, high = places[intervals, 0], places[intervals + 1, 0]
        first = ends[intervals, members]
        for _ in range(HALVINGS):
            middle = (low + high) / 2
            with np.errstate(invalid="ignore", over="ignore"):
                before = evaluate([u], {**these, name: middle})[0] * first > 0
            low, high = np.where(before, middle, low), np.where(before, high, middle)
        there = evaluate([above, below], {**these, name: low})
        near = evaluate([above, below], {**these, name: low + NEARBY * np.fmax(1.0, np.abs(low))})
        with np.errstate(invalid="ignore"):
            jump, beside = there[0] - there[1], near[0] - near[1]
            plain = np.abs(jump) > PLAIN * np.fmax(*sizes([above, below], {**these, name: low}))
            stays = np.abs(beside - jump) <= 0.1 * np.abs(jump)
        found[members[plain & stays]] = True
    return found


def states(
    graph: Graph,
    nodes: Collection[Node],
    parameters: Mapping[str, Array],
    source: random.Random,
    *,
    signed: bool,
) -> dict[str, Array | float]:
    """The parameters, and random values of all other symbols of the ``nodes``."""
    names = {str(one.data) for node in nodes for one in graph.symbols_of(node)}
    values: dict[str, Array | float] = dict(parameters)
    for name in sorted(names - {*parameters}):
        values[name] = source.uniform(0.2, 1.3) * (source.choice((-1, 1)) if signed else 1)
    return values
