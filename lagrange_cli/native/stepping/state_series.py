"""The series by which a proof encloses what moves: of q and v, of combinations, and of sums.

A combination of q and v is a polynomial, as they are.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Collection, Iterable, Mapping, Sequence

from lagrange_cli.expression.node import Kind, Node
from lagrange_cli.mechanics.approach import fixed_factors, linear_in
from lagrange_cli.native.llvm.text import ZERO
from lagrange_cli.native.llvm.vector import Integer, Real
from lagrange_cli.native.recurrences.disk import Disks
from lagrange_cli.native.recurrences.disk_arithmetic import ROUNDING, Disk
from lagrange_cli.native.stepping.lengths import Lengths
from lagrange_cli.records import dataclass

SEVERAL = 2
"""Terms of a sum that can cancel."""


@dataclass(frozen=True)
class Combination:
    """A sum of ``symbols`` times constant ``factors``, and of the ``rest``: other terms, and what these are
    multiplied by."""

    symbols: Sequence[Node]
    factors: Sequence[Node]
    rest: Sequence[tuple[Node, float]] = ()


def combinations(nodes: Iterable[Node], variables: int, symbols: Collection[Node]) -> dict[Node, Combination]:
    """The sums in which several of these symbols, which are among the ``variables``, may cancel."""
    found = dict[Node, Combination]()
    for node in nodes:
        if node.kind is not Kind.SUM or not node.symbols & variables:
            continue
        inside, factors, rest = list[Node](), list[Node](), list[tuple[Node, float]]()
        for argument, scale in zip(node.arguments, node.data[1]):
            symbol = linear_in(argument, variables)
            if symbol is not None and symbol in symbols:
                inside.append(symbol)
                factors.append(scale * node.graph.product(fixed_factors(argument, variables)))
            else:
                rest.append((argument, scale))
        if len(inside) >= SEVERAL:
            found[node] = Combination(inside, factors, rest)
    return found


@dataclass(frozen=True)
class Weighted:
    """The combination in a sum ``node``: symbols, and their weights."""

    node: Node
    terms: Sequence[tuple[Node, Real]]


class StateSeries(ABC):
    """The series of symbols, of which ``places`` and ``speeds`` are rows of the state, and of ``sums``. All
    that moves is made of ``variables``, of which one is ``time``. Series of q have the order that ``lengths``
    say; ``totals``, which are symbols for sums over members, and ``sums`` are known to one order less than
    accelerations."""

    lengths: Lengths
    variables: int
    time: Node
    places: Collection[Node]
    speeds: Collection[Node]
    totals: Collection[Node] = ()
    sums: Collection[Node]
    combined: Collection[Node] = ()
    """Combinations that have series of their own: the sizes of their coefficients, with rounding errors.
    Coefficient 0 is that of rounding errors and low parts alone."""

    @abstractmethod
    def coefficient(self, node: Node, m: Integer) -> Real:
        """Coefficient ``m`` of a symbol, or of what has a series of its own."""

    @abstractmethod
    def late(self, symbol: Node) -> Real:
        """The low part of a symbol's number in the state."""

    def beyond(self, total: Node) -> Real:
        """The radii of what is beyond the series of a total."""
        raise NotImplementedError

    def farther(self, total: Node) -> Real:
        """The radii of a total within larger disks of time (``cancelling.Tail``)."""
        raise NotImplementedError

    def size(self, one: Weighted, m: Integer, coefficient: Callable[[Node], Real]) -> Real:
        """The size of coefficient ``m`` of a combination, given those of symbols."""
        if one.node in self.combined:
            return self.coefficient(one.node, m)
        f, total = m.body, Real(m.body, ZERO, 1)
        for symbol, weight in one.terms:
            total = f.fused(coefficient(symbol), weight, total)
        return f.magnitude(total)

    def widened(self, disks: Disks, one: Weighted, known: Mapping[Node, Disk | None], extent: Real) -> Real:
        """The radius of a combination that changes by an ``extent``: with rounding errors, low parts, and
        what is beyond the series of totals."""
        f, spread, late = disks.f, disks.all(0.0), disks.f.constant(0.0)
        sizes = [(symbol, f.magnitude(weight)) for symbol, weight in one.terms]
        if one.node in self.combined:
            radius = extent + f.splat(self.coefficient(one.node, f.count(0)), disks.lanes)
        else:
            for symbol, size in sizes:
                disk = known[symbol] or disks.constant(0)
                spread = f.fused(f.splat(size, disks.lanes), disks.most(disk), spread)
                if symbol not in self.totals:
                    late = f.fused(size, f.magnitude(self.late(symbol)), late)
            radius = f.fused(spread, disks.all(len(sizes) * ROUNDING), extent) + f.splat(late, disks.lanes)
        for symbol, size in sizes:
            if symbol in self.totals:
                radius = f.fused(f.splat(size, disks.lanes), self.beyond(symbol), radius)
        return radius
