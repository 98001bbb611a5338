"""One node of the expression graph, and what is reachable from it.

Nodes are numbered in the order of their creation, so a node's arguments always have smaller numbers than the
node itself.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from enum import Enum
from functools import reduce
from operator import attrgetter, or_
from typing import Any, Protocol

from lagrange_cli.limits import Work

_number = attrgetter("number")


class Kind(Enum):
    """What a node is; ``Node.data`` holds what its arguments do not."""

    NUMBER = "number"  # data: the float
    SYMBOL = "symbol"  # data: the name
    SUM = "sum"  # data: (constant, coefficients); value = constant + sum coefficient_i * argument_i
    PRODUCT = "product"  # data: exponents (int or float); value = prod argument_i ** exponent_i
    POWER = "power"  # arguments: base and an exponent that is no number
    FUNCTION = "function"  # data: the function's name
    SWITCH = "switch"  # arguments: u, above, below; data: +1, -1 or 0, the side where u is 0 or their mean
    DDT = "ddt"  # the total time derivative of the argument along the motion

    __hash__ = object.__hash__  # that of the name takes a call for every look into the table


class Table(Protocol):
    """The interface of a graph that its nodes use."""

    nodes: list[Node]
    vanishing: dict[Node, bool]
    work: Work
    zero: Node
    one: Node

    def lift(self, value: Node | float) -> Node: ...
    def sum(self, terms: Iterable[tuple[Node, float]]) -> Node: ...
    def split_coefficient(self, node: Node) -> tuple[float, Node]: ...
    def product(self, factors: Iterable[tuple[Node, int | float]]) -> Node: ...
    def power(self, base: Node, exponent: Node) -> Node: ...
    def function(self, name: str, arguments: Sequence[Node]) -> Node: ...


class Node:
    """One expression; made only by its ``Graph``. Combines with ``+ - * / **`` and numbers."""

    __slots__ = ("arguments", "data", "graph", "kind", "number", "symbols")

    def __init__(
        self, graph: Table, kind: Kind, data: Any, arguments: tuple[Node, ...], symbols: int
    ) -> None:
        self.graph = graph
        self.kind = kind
        self.data = data
        self.arguments = arguments
        self.symbols = symbols
        """Bit set of the symbols this expression depends on."""
        self.number = len(graph.nodes)
        """Position in the order of creation."""

    def __add__(self, other: Node | float) -> Node:
        return self.graph.sum([(self, 1.0), (self.graph.lift(other), 1.0)])

    __radd__ = __add__

    def __sub__(self, other: Node | float) -> Node:
        return self.graph.sum([(self, 1.0), (self.graph.lift(other), -1.0)])

    def __rsub__(self, other: Node | float) -> Node:
        return self.graph.sum([(self.graph.lift(other), 1.0), (self, -1.0)])

    def __neg__(self) -> Node:
        return self.graph.sum([(self, -1.0)])

    def __mul__(self, other: Node | float) -> Node:
        if other == 1.0:
            return self
        return self.graph.product([(self, 1), (self.graph.lift(other), 1)])

    __rmul__ = __mul__

    def __truediv__(self, other: Node | float) -> Node:
        return self.graph.product([(self, 1), (self.graph.lift(other), -1)])

    def __rtruediv__(self, other: Node | float) -> Node:
        return self.graph.product([(self.graph.lift(other), 1), (self, -1)])

    def __pow__(self, other: Node | float) -> Node:
        return self.graph.power(self, self.graph.lift(other))

    def __rpow__(self, other: Node | float) -> Node:
        return self.graph.power(self.graph.lift(other), self)

    @property
    def is_zero(self) -> bool:
        """Whether the expression is identically 0 by structure."""
        return self.kind is Kind.NUMBER and self.data == 0.0

    def __repr__(self) -> str:
        inner = ", ".join([repr(self.data)] * (self.data is not None) + [repr(a) for a in self.arguments])
        return f"{self.kind.value}({inner})"


def reachable(roots: Iterable[Node], enter: Any = None) -> list[Node]:
    """All nodes below ``roots`` (those for which ``enter`` holds), arguments before their users."""
    seen: set[Node] = set()
    pending = [root for root in roots if enter is None or enter(root)]
    count = 0
    while pending:
        node = pending.pop()
        if node not in seen:
            seen.add(node)
            count += 1 + len(node.arguments)
            pending.extend(a for a in node.arguments if a not in seen and (enter is None or enter(a)))
    if seen:
        node.graph.work.charge(count)
    return in_order(seen)


def terms_of(node: Node) -> list[tuple[Node, float]]:
    """The terms of a sum with their coefficients, its constant last; anything else is one term."""
    if node.kind is Kind.NUMBER:
        return [(node.graph.one, node.data)]
    if node.kind is not Kind.SUM:
        return [(node, 1.0)]
    constant, coefficients = node.data
    return [*zip(node.arguments, coefficients), *([(node.graph.one, constant)] if constant else [])]


def factors_of(node: Node) -> list[tuple[Node, int | float]]:
    """The factors of a product with their exponents; anything else is one factor."""
    return [*zip(node.arguments, node.data)] if node.kind is Kind.PRODUCT else [(node, 1)]


def in_order(nodes: Iterable[Node]) -> list[Node]:
    """The nodes in the order of their creation."""
    return sorted(nodes, key=_number)


def union(nodes: Iterable[Node]) -> int:
    """The symbols in any of the nodes, as a bit set."""
    return reduce(or_, (node.symbols for node in nodes), 0)


def bits(mask: int) -> Iterator[int]:
    """The positions of the ones in ``mask``, in ascending order."""
    while mask:
        lowest = mask & -mask
        yield lowest.bit_length() - 1
        mask ^= lowest
