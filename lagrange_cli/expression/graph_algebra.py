"""The expression graph as an algebra that expression trees are built over."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from functools import reduce

from lagrange_cli.expression.algebra import Undecided
from lagrange_cli.expression.graph import Graph
from lagrange_cli.expression.node import Node


class GraphAlgebra(Undecided):
    """``Algebra[Node]`` over one graph; see ``expression.algebra``."""

    def __init__(self) -> None:
        self.graph = Graph()

    def number(self, text: str) -> Node:
        return self.graph.constant(float(text))

    def pi(self) -> Node:
        return self.graph.constant(math.pi)

    def symbol(self, name: str) -> Node:
        return self.graph.symbol(name)

    def function(self, name: str, arguments: Sequence[Node]) -> Node:
        graph = self.graph
        if name == "abs":
            return graph.absolute(arguments[0])
        if name == "sign":
            return graph.sign(arguments[0])
        if name == "max":
            return reduce(lambda a, b: graph.switch(a - b, a, b), arguments)
        if name == "min":
            return reduce(lambda a, b: graph.switch(a - b, b, a), arguments)
        return graph.function(name, arguments)

    def switch(self, u: Node, above: Node, below: Node, at: int) -> Node:
        return self.graph.switch(u, above, below, at)

    def total(self, terms: Sequence[Node]) -> Node:
        return self.graph.sum([(term, 1.0) for term in terms])

    def symbols(self, expression: Node) -> list[Node]:
        return self.graph.symbols_of(expression)

    def diff(self, expression: Node, symbol: Node) -> Node:
        return self.graph.diff(expression, symbol)


class KnownParameters(GraphAlgebra):
    """The same with numbers in place of some symbols."""

    def __init__(self, values: Mapping[str, float]) -> None:
        super().__init__()
        self.values = values

    def symbol(self, name: str) -> Node:
        return self.graph.constant(self.values[name]) if name in self.values else super().symbol(name)
