"""Which nodes change along the motion and which are constant, and sums arranged accordingly."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from functools import cached_property
from itertools import compress, repeat
from operator import is_not

from lagrange_cli.expression.graph import Graph
from lagrange_cli.expression.graph_algebra import GraphAlgebra
from lagrange_cli.expression.node import Kind, Node, union
from lagrange_cli.mechanics.rows import Row
from lagrange_cli.model.model import Model
from lagrange_cli.records import dataclass


def graph_of(model: Model[Node]) -> Graph:
    """The graph that a model's nodes live in."""
    assert isinstance(model.algebra, GraphAlgebra)
    return model.algebra.graph


@dataclass(frozen=True)
class OfModel:
    """What is computed of a model, when it is asked for."""

    model: Model[Node]

    @property
    def graph(self) -> Graph:
        """The graph that its nodes live in."""
        return graph_of(self.model)

    @cached_property
    def _moving(self) -> int:
        return variables(self.model)


def variables(model: Model[Node]) -> int:
    """Bit set of the symbols that change along a motion: q, q_dot, t, and the multipliers of constraints."""
    return state_symbols(model) | union(one.multiplier for one in model.constraints)


def state_symbols(model: Model[Node]) -> int:
    """Those of them that are not multipliers."""
    return union((model.time, *model.q, *model.v))


def nonzero(row: Sequence[Node], zero: Node, likely: int) -> list[int]:
    """The places of what is not ``zero`` in a row: often the ``likely`` one alone."""
    if isinstance(row, Row):
        return row.places
    if row.count(zero) == len(row) - 1 and row[likely] is not zero:
        return [likely]
    return [*compress(range(len(row)), map(is_not, row, repeat(zero)))]


def numbered(symbols: Iterable[Node]) -> dict[Node, int]:
    """The symbols with their places among themselves."""
    return {symbol: place for place, symbol in enumerate(symbols)}


def rate(graph: Graph, node: Node, moving: int) -> Node:
    """d/dt of a node along the motion, constants of the motion in front of it."""
    if node.kind is Kind.SUM:
        return graph.sum([(rate(graph, a, moving), c) for a, c in zip(node.arguments, node.data[1])])
    if not node.symbols & moving:
        return graph.zero
    fixed, rest = graph.split_parameters(node, moving)
    return fixed * graph.ddt(rest)


def contract(graph: Graph, terms: Iterable[tuple[Node, Node]], variables: int) -> Node:
    """``sum a_i * b_i`` with one product for each distinct moving part of the a_i.

    A chain's dr_i/dq_k are the same for all particles beyond k, so that summing the b_i first makes one
    convolution of what would be one for each particle.
    """
    grouped: dict[Node, dict[Node, list[tuple[Node, float]]]] = {}
    for a, b in terms:
        if a.is_zero or b.is_zero:
            continue
        fixed, moving = graph.split_parameters(a, variables)
        grouped.setdefault(moving, {}).setdefault(fixed, []).append((b, 1.0))
    return graph.sum(
        [
            (moving * graph.sum([(fixed * graph.sum(parts), 1.0) for fixed, parts in by_factor.items()]), 1.0)
            for moving, by_factor in grouped.items()
        ]
    )
