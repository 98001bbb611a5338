"""How positions depend on coordinates, and displacements of the particles as changes of the coordinates."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import cached_property

from lagrange_cli.expression.graph import Graph
from lagrange_cli.expression.node import Kind, Node, terms_of
from lagrange_cli.expression.zero import is_zero, zeros
from lagrange_cli.mechanics.matrices import determinant, united
from lagrange_cli.mechanics.relations import Relations
from lagrange_cli.mechanics.variables import OfModel, numbered
from lagrange_cli.records import dataclass, field

Component = tuple[str, int]
"""A particle and the number of an axis."""
MOST_AT_ONCE = 3
"""Equations of so many coordinates are solved by Cramer's rule."""
QUATERNION = 4
"""Up to this many coordinates, all linear changes of them are tried."""


@dataclass(frozen=True)
class Embedding(OfModel):
    """The components of the particles' positions, and their derivatives by the coordinates."""

    _known: dict[frozenset[tuple[Component, Node]], Mapping[int, Node] | None] = field(
        default_factory=dict, compare=False
    )
    """By the displacements: what ``change`` has found."""

    @cached_property
    def positions(self) -> Mapping[Component, Node]:
        """Each component of each particle."""
        return {(one.name, i): x for one in self.model.particles for i, x in enumerate(one.position)}

    @cached_property
    def slopes(self) -> Mapping[Component, Mapping[int, Node]]:
        """dx/dq_k by k, as far as they are not 0."""
        coordinates = numbered(self.model.q)
        return {one: self.graph.gradient(x, coordinates) for one, x in self.positions.items()}

    @cached_property
    def blocks(self) -> tuple[tuple[tuple[int, ...], tuple[Component, ...]], ...]:
        """The coordinates and components that depend on each other, directly or not."""
        size, components = len(self.model.q), [*self.positions]
        sets = ((size + i, *self.slopes[one]) for i, one in enumerate(components))
        return tuple(
            (tuple(k for k in block if k < size), tuple(components[i - size] for i in block if i >= size))
            for block in united(size + len(components), sets)
        )

    def change(self, displacements: Mapping[Component, Node]) -> Mapping[int, Node] | None:
        """xi with sum_k dx/dq_k xi_k = the displacement of each component, functions of q and t.

        None where no such change of the coordinates is found.
        """
        key = frozenset(displacements.items())
        if key not in self._known:
            self._known[key] = self._changed(displacements)
        return self._known[key]

    def _changed(self, displacements: Mapping[Component, Node]) -> Mapping[int, Node] | None:
        """The same, found for the first time."""
        found: dict[int, Node] = {}
        for coordinates, components in self.blocks:
            asked = [displacements.get(one, self.graph.zero) for one in components]
            if all(one.is_zero for one in asked):
                continue
            if len(coordinates) == len(components) == 1:
                slope = self.slopes[components[0]][coordinates[0]]
                if slope.kind is Kind.NUMBER:  # a component that is a coordinate
                    found[coordinates[0]] = asked[0] / slope
                    continue
            changing = self._changing(coordinates, components, asked)
            if changing is None:
                return None
            changes = self._by_ansatz(changing, components, asked)
            if changes is None:
                changes = self._one_by_one(changing, components, asked)
            if changes is None or not self._makes(changes, components, asked):
                return None
            found |= {k: change for k, change in changes.items() if not change.is_zero}
        return found

    def _changing(
        self, coordinates: Sequence[int], components: Sequence[Component], asked: Sequence[Node]
    ) -> list[int] | None:
        """The coordinates that change, such as those of the first body of a chain as all of it is turned;
        None where the displacements are no combination of dx/dq_k at a random state, as they would have to be
        at every one."""
        zero = self.graph.zero
        columns = [[self.slopes[one].get(k, zero) for one in components] for k in coordinates]
        found = Relations(self.graph).parts(columns, asked)
        return None if found is None else [coordinates[i] for i in found]

    def _makes(
        self, changes: Mapping[int, Node], components: Sequence[Component], asked: Sequence[Node]
    ) -> bool:
        """Whether the changes are proven to give the displacements."""
        graph = self.graph
        left = [
            graph.sum(
                [
                    (one, -1.0),
                    *((slope * changes[k], 1.0) for k, slope in self.slopes[place].items() if k in changes),
                ]
            )
            for place, one in zip(components, asked)
        ]
        return zeros(left) >= {*left}

    def _one_by_one(
        self, coordinates: Sequence[int], components: Sequence[Component], asked: Sequence[Node]
    ) -> dict[int, Node] | None:
        """First those of components in which one coordinate is left, such as the place of the first body of a
        chain, or the height of a point of a body's axis; then the others by least squares."""
        graph, moving, found = self.graph, self._moving, dict[int, Node]()
        pairs = [*zip(components, asked)]
        for _ in coordinates:
            alone: dict[int, list[tuple[Node, list[tuple[Node, float]]]]] = {}
            for place, one in pairs:
                own = {k: slope for k, slope in self.slopes[place].items() if k in coordinates}
                left = [k for k in own if k not in found]
                if len(left) == 1:
                    terms = [*terms_of(one), *((own[j] * found[j], -1.0) for j in own if j in found)]
                    alone.setdefault(left[0], []).append((own[left[0]], terms))
            for k, rows in alone.items():
                steady = [row for row in rows if not row[0].symbols & moving]
                rows = steady[:1] or rows
                above = graph.sum([(slope * one, c) for slope, terms in rows for one, c in terms])
                found[k] = above / graph.sum([(slope * slope, 1.0) for slope, _ in rows])
        left = [k for k in coordinates if k not in found]
        if len(left) > MOST_AT_ONCE:
            return None
        rest = [
            graph.sum([(one, 1.0), *((self.slopes[place][k] * xi, -1.0) for k, xi in known)])
            for place, one in zip(components, asked)
            for known in [[(k, xi) for k, xi in found.items() if k in self.slopes[place]]]
        ]
        others = self._by_least_squares(left, components, rest)
        return None if others is None else found | others

    def _by_least_squares(
        self, coordinates: Sequence[int], components: Sequence[Component], asked: Sequence[Node]
    ) -> dict[int, Node] | None:
        """The solution of J^T J xi = J^T g by Cramer's rule."""
        graph = self.graph
        rows = [[self.slopes[one].get(k, graph.zero) for k in coordinates] for one in components]
        if not coordinates:
            return {}
        pairs = range(len(coordinates))
        matrix = [[graph.sum([(row[j] * row[k], 1.0) for row in rows]) for k in pairs] for j in pairs]
        if len(rows) == len(coordinates) and not all(matrix[j][k].is_zero for j in pairs for k in range(j)):
            matrix, right = rows, [*asked]  # not orthogonal
        else:
            right = [graph.sum([(row[j] * g, 1.0) for row, g in zip(rows, asked)]) for j in pairs]
        solved = solution(graph, matrix, right)
        return None if solved is None else dict(zip(coordinates, solved))

    def _by_ansatz(
        self, coordinates: Sequence[int], components: Sequence[Component], asked: Sequence[Node]
    ) -> dict[int, Node] | None:
        """xi_k constant, linear in t, or linear in the coordinates that positions are linear in: as in a
        chain, whose first end moves and whose links turn. Those of a body's orientation are linear in a
        quaternion."""
        graph, model, moving = self.graph, self.model, self._moving
        linear = [
            k
            for k in coordinates
            if len(coordinates) <= QUATERNION
            or not any(self.slopes[one][k].symbols & moving for one in components if k in self.slopes[one])
        ]
        terms = [(k, graph.one) for k in coordinates]
        terms += [(k, model.q[j]) for k in linear for j in linear]
        terms += [(k, model.time) for k in coordinates]
        columns = [
            [self.slopes[one].get(k, graph.zero) * factor for one in components] for k, factor in terms
        ]
        numbers = Relations(graph).combination(columns, asked)
        if numbers is None:
            return None
        sums: dict[int, list[tuple[Node, float]]] = {k: [] for k in coordinates}
        for (k, factor), number in zip(terms, numbers):
            sums[k].append((factor, number))
        return {k: graph.sum(parts) for k, parts in sums.items()}


def solution(graph: Graph, matrix: Sequence[Sequence[Node]], right: Sequence[Node]) -> list[Node] | None:
    """x with matrix x = right by Cramer's rule; None where the determinant is 0."""
    whole = determinant(graph, matrix)
    if is_zero(whole):
        return None
    replaced = [
        [[right[i] if j == k else entry for j, entry in enumerate(row)] for i, row in enumerate(matrix)]
        for k in range(len(right))
    ]
    return [determinant(graph, other) / whole for other in replaced]
