"""Arguments of switches where forces are unbounded, as at the poles of 1/|u|.

There is no solution through such a state, and no multiplier of any size that could hold one there."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from functools import reduce
from operator import or_

from lagrange_cli.expression.graph import Graph
from lagrange_cli.expression.node import Kind, Node, reachable
from lagrange_cli.mechanics.switching.switches import switches, vanishes_with


def unbounded(graph: Graph, rows: Sequence[Node], moving: int) -> frozenset[Node]:
    """The arguments of switches in the ``rows`` of equations where one of these is unbounded, whatever the
    sides of other switches are."""
    places = list(dict.fromkeys(switch.arguments[0] for switch in switches(rows, moving)))
    if not places:
        return frozenset()
    nodes = reachable(rows)
    zeros = Zeros(graph, places)
    found: dict[Node, int] = {}
    for node in nodes:
        found[node] = _at(node, found, zeros)
    poles = union_of(found[row] for row in rows)
    return frozenset(u for i, u in enumerate(places) if poles >> i & 1)


class Zeros:
    """Which of several ``places`` are among the zeros of nodes, as bit sets."""

    def __init__(self, graph: Graph, places: Sequence[Node]) -> None:
        self.graph = graph
        self.bits = {u: 1 << i for i, u in enumerate(places)}
        self._possible: dict[Node, int] = {}

    def possible(self, node: Node) -> int:
        """Those where the node is 0 on some side of each switch that it is."""
        if node.kind is Kind.SWITCH:
            return self.possible(node.arguments[1]) | self.possible(node.arguments[2])
        if node not in self._possible:
            near = [(u, bit) for u, bit in self.bits.items() if u.symbols & node.symbols]
            self._possible[node] = sum(bit for u, bit in near if vanishes_with(self.graph, node, u))
        return self._possible[node]

    def certain(self, node: Node) -> int:
        """Those where it is 0 on all sides. At 0 a switch has neither value, so that none is looked into."""
        if node.kind is Kind.SWITCH:
            return self.certain(node.arguments[1]) & self.certain(node.arguments[2])
        zeros = self.possible(node)
        inside = {one.arguments[0] for one in reachable([node]) if one.kind is Kind.SWITCH} if zeros else ()
        return zeros & ~union_of(self.bits.get(u, 0) for u in inside)


def _at(node: Node, known: dict[Node, int], zeros: Zeros) -> int:
    """Where a node is unbounded, as ``known`` of its arguments. Functions of what is unbounded may be
    bounded, as exp(-1/u**2) is; so may products with what is 0 there."""
    if node.kind in (Kind.SUM, Kind.DDT):
        return union_of(known[a] for a in node.arguments)
    if node.kind is Kind.PRODUCT:
        factors = [*zip(node.arguments, node.data)]
        poles = union_of(known[a] if e > 0 else zeros.certain(a) for a, e in factors)
        return poles & ~union_of(zeros.possible(a) if e > 0 else known[a] for a, e in factors if poles)
    if node.kind is Kind.SWITCH:
        u, above, below = node.arguments
        either = (known[above] | known[below]) & zeros.bits.get(u, 0)
        return either | known[above] & known[below]
    return 0


def union_of(sets: Iterable[int]) -> int:
    """The union of bit sets."""
    return reduce(or_, sets, 0)
