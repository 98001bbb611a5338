"""``Scene``: a system's points over the expression graph, while a drawing is made of them."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from typing import cast

import numpy as np

from lagrange_cli.drawing.drawing import FREE
from lagrange_cli.drawing.probe import Probe
from lagrange_cli.expression.arrays import Array, evaluate
from lagrange_cli.expression.graph import Graph
from lagrange_cli.expression.graph_algebra import GraphAlgebra
from lagrange_cli.expression.indices import integer
from lagrange_cli.expression.node import Kind, Node, bits, union
from lagrange_cli.expression.syntax import Name
from lagrange_cli.expression.vocabulary import TIME, member_name
from lagrange_cli.model.scope import Scope
from lagrange_cli.spec.spec import Expression, Spec
from lagrange_cli.spec.values import Values
from lagrange_cli.spec.wanted import Course, Wanted

Place = tuple[Node, ...]
"""The components of a point."""
HEIGHTS = frozenset({"y", "z", "h", "height", "Y", "Z", "H"})
"""Names of coordinates that are drawn upward, where they are the only one."""


class Scene:
    """The names of a system file over the graph, the positions in a common dimension, and a probe."""

    def __init__(self, spec: Spec, values: Values, start: float) -> None:
        self.spec = spec
        self.values = values
        self.start = start
        self.algebra = GraphAlgebra()
        self.graph = self.algebra.graph
        self.scope: Scope[Node] = Scope(spec, self.algebra)
        self.probe = Probe(spec, values, start)
        self.coordinates = self.scope.q
        self.bits = {q.symbols.bit_length() - 1: k for k, q in enumerate(self.coordinates)}
        self.number = {one.name: k for k, one in enumerate(spec.coordinates)}
        self.moving = union(self.coordinates)
        self.time = self.graph.symbol(TIME).symbols
        given = {name: cast(Place, self.scope.values[name]) for name in spec.embedding}
        wanted = () if spec.draw is None else self._wanted(spec.draw)
        deep = any(len(place) == 3 and not place[2].is_zero for place in (*given.values(), *wanted))
        self.dimension = 3 if deep or spec.bodies else 2
        self.upright = all(len(place) == 1 for place in given.values()) and self._upright(given)
        self.positions = {name: self.lifted(place) for name, place in given.items()}
        self.flat = {name for name, place in given.items() if len(place) == 1}
        self.zero: Place = (self.graph.zero,) * self.dimension

    def _wanted(self, draw: Wanted) -> Iterator[Place]:
        """The points that the section ``draw`` names."""
        paths = (*(draw.rods or ()), *(draw.springs or ()), draw.points, draw.trails or ())
        for path in (*paths, *(one.through for one in draw.curves or ())):
            yield from map(self.vector, path)
        for course in draw.curves or ():
            if course.at is not None:
                yield self._along(course)[0]

    def place(self, expression: Expression) -> Place:
        """A point of the section ``draw``: a particle where it is drawn, or a place, or 0 for the origin."""
        tree = expression.tree
        if isinstance(tree, Name):
            name = tree.identifier
            if tree.indices:
                known = {**self.spec.sizes, **expression.indices}
                name = member_name(name, [integer(index, known) for index in tree.indices])
            if name in self.positions:
                return self.positions[name]
        vector = self.vector(expression)
        return self.zero if len(vector) == 1 and vector[0].is_zero else self.lifted(vector)

    def along(self, course: Course) -> tuple[Place, list[str]]:
        """The place of a curve, and the names that run along it and are no coordinates, in their order: in
        the place is the symbol of ``FREE`` with their number."""
        vector, free = self._along(course)
        if course.at is not None and isinstance(course.at.tree, Name) and not free:
            return self.place(course.at), free
        return self.lifted(vector), free

    def _along(self, course: Course) -> tuple[Place, list[str]]:
        free = [name for name in course.ranges if name in course.free]
        for name, symbol in zip(free, FREE):
            ends = course.ranges[name]
            assert ends is not None and course.at is not None
            low, high = map(self.scope.scalar, ends)
            self.scope.values[name] = low + (high - low) * self.graph.symbol(symbol)
        assert course.at is not None
        vector = self.vector(course.at)
        for name in free:
            del self.scope.values[name]
        return vector, free

    def vector(self, expression: Expression) -> Place:
        """A place of the section ``draw``."""
        return self.scope.vector(expression)

    def _upright(self, given: dict[str, Place]) -> bool:
        """Whether places of one component are heights."""
        used = [one for place in given.values() for one in self.graph.symbols_of(place[0])]
        names = {one.data.partition("[")[0].rstrip("0123456789_") for one in used if one in self.coordinates}
        return bool(names) and names <= HEIGHTS

    def lifted(self, place: Sequence[Node]) -> Place:
        """A place of any number of components in the dimension of the drawing."""
        zero = self.graph.zero
        if len(place) == 1 and self.upright:
            place = (*(zero,) * (self.dimension - 1), place[0])
        return (*place, *(zero,) * self.dimension)[: self.dimension]

    def depends(self, place: Sequence[Node]) -> tuple[int, ...]:
        """The numbers of the coordinates that a place depends on."""
        return tuple(sorted(self.bits[bit] for bit in bits(union(place) & self.moving)))

    def at(self, place: Place) -> Array:
        """The place at the random states (dimension, STATES)."""
        return self.probe(place)

    def swing(self, names: Iterable[str] = ()) -> float:
        """A rough size of the coordinates of these names, or of all: their initial values, else their
        velocities, else 1."""
        numbers = [self.number[name] for name in names] or range(len(self.coordinates))
        for row in (self.values.q, self.values.v):
            largest = max((abs(row[k]) for k in numbers), default=0.0)
            if largest > 0:
                return largest
        return 1.0

    def now(self, place: Place) -> list[float]:
        """The initial position of a place."""
        symbols = {**self.values.parameters, TIME: self.start}
        symbols |= zip(self.number, self.values.q)
        return [float(one) for one in evaluate(place, symbols)]

    def without(self, place: Place, mask: int) -> Place:
        """The place less all of its terms that depend on the symbols of ``mask``."""
        return tuple(without(self.graph, component, mask) for component in place)

    def without_constants(self, node: Node) -> Node:
        """A sum less those of its terms that depend neither on a coordinate nor on t."""
        if node.kind is not Kind.SUM:
            return node
        varying = self.moving | self.time
        return self.graph.sum([(x, c) for x, c in zip(node.arguments, node.data[1]) if x.symbols & varying])

    def difference(self, a: Place, b: Place) -> Place:
        """a - b."""
        return tuple(x - y for x, y in zip(a, b))


def without(graph: Graph, node: Node, mask: int) -> Node:
    """A node less all of its terms that depend on the symbols of ``mask``."""
    if not node.symbols & mask:
        return node
    if node.kind is Kind.SUM:
        constant, coefficients = node.data
        kept = [(one, c) for one, c in zip(node.arguments, coefficients) if not one.symbols & mask]
        return graph.sum([*kept, (graph.constant(constant), 1.0)])
    if node.kind is Kind.PRODUCT:  # a factor before a sum
        sums = [one for one, e in zip(node.arguments, node.data) if one.kind is Kind.SUM and e == 1]
        if len(sums) == 1 and not any(one.symbols & mask for one in node.arguments if one is not sums[0]):
            inner = without(graph, sums[0], mask)
            return graph.product([(node, 1), (sums[0], -1), (inner, 1)])
    return graph.zero


def lengths(values: Array) -> Array:
    """The lengths (STATES,) of vectors (dimension, STATES)."""
    return np.asarray(np.sqrt((values * values).sum(axis=0)))
