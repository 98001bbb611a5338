"""The masses of chains and trees at a place: products with M and with M^-1, joint by joint.

M is never written down. What coordinates move is found from the roots on, and what that takes of them from
the tips on; M^-1 takes both, with the masses that a joint feels as a matrix of the size of a place
(R. Featherstone, Rigid Body Dynamics Algorithms, 2008, chapter 7; see also
``native.families.joints.balance``).
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from functools import cached_property
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np

from lagrange_cli.expression.graph import Graph
from lagrange_cli.expression.index_arrays import Places
from lagrange_cli.families.arrays import NONE
from lagrange_cli.families.joints.joints import Articulation, Joints
from lagrange_cli.families.joints.sums import Sums, along
from lagrange_cli.families.values import FamilyValues
from lagrange_cli.model.start.equations import Solver
from lagrange_cli.records import dataclass

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Numbers: TypeAlias = NDArray[Any]

LEAST = 1e-13
"""The part of a coordinate's mass that is left where its parents are free to move, below which it is 0."""

OFTEN, WRITTEN = 10, 2000
"""After so many products with M^-1, it is written down if it has no more columns than that."""


class Kind:
    """Numbers of joints of one kind, ``count`` of them: ``moves`` (count, axes, coordinates), the changes of
    nodes with the coordinates, and ``weights``: the component of the parent, the changes (count,
    coordinates), and the masses (count,)."""

    def __init__(self, graph: Graph, joints: Joints, numbers: FamilyValues, axes: int, nodes: int) -> None:
        self.count, self.rows, self.nodes = joints.domain.count, joints.rows, joints.nodes
        none = np.full(self.count, nodes)
        self.parents: Places = none if joints.parents is None else joints.parents

        def slopes(node: Any) -> Numbers:
            made = numbers.kind.zeros(self.count, len(self.rows))
            for b, symbol in enumerate(joints.coordinates):
                made[:, b] = numbers.node(graph.diff(node, symbol))
            return made  # type: ignore[no-any-return]

        self.moves = numbers.kind.zeros(self.count, axes, len(self.rows))
        for axis, move in enumerate(joints.moves):
            self.moves[:, axis] = slopes(move)
        self.weights = [
            (one.component, slopes(one.move), np.broadcast_to(numbers.node(one.mass), self.count))
            for one in joints.weights
        ]


@dataclass(frozen=True, eq=False)
class Link:
    """A joint as it is eliminated: the numbers of its ``coordinates``, its ``parent`` and its ``node``, and
    ``moves``; ``own``, ``shared`` and ``passed`` are M of its weights by its coordinates, by these and the
    parent's place, and by this place."""

    coordinates: Places
    parent: int
    node: int
    moves: Numbers
    own: Numbers
    shared: Numbers
    passed: Numbers


class JointMasses:
    """``Matter`` of an articulation of ``count`` coordinates, whose numbers at a place are ``numbers``."""

    def __init__(
        self, found: Articulation, graph: Graph, numbers: FamilyValues, count: int, extent: float
    ) -> None:
        self.nodes, self.count, self.extent, self.numbers = found.count, count, extent, numbers
        self._solvers: dict[tuple[int, ...], Solver | None] = {}
        self.tree = found.nodes[0].tree if found.nodes else None
        self.inertia = [numbers.of(one) for one in found.inertia]
        self.kinds = [Kind(graph, one, numbers, len(found.nodes), self.nodes) for one in found.joints]
        self.relative = found.relative
        self.sums = None if found.relative is None else Sums.of(found.relative, numbers)

    @property
    def axes(self) -> range:
        return range(len(self.inertia))

    def blocks(self) -> Mapping[int, Mapping[int, Any]]:
        """M where there are no nodes: a block for each joint."""
        found: dict[int, dict[int, Any]] = {}
        for kind in self.kinds:
            for b, rows in enumerate(kind.rows):
                for c, others in enumerate(kind.rows):
                    whole = self.numbers.kind.zeros(kind.count)
                    for _, slopes, mass in kind.weights:
                        whole += mass * slopes[:, b] * slopes[:, c]
                    for j, k, m in zip(rows.tolist(), others.tolist(), whole.tolist()):
                        found.setdefault(j, {})[k] = m
        return found

    def felt(self, pushes: Sequence[Numbers]) -> Numbers:
        """Forces on nodes, and on sums of coordinates behind these (each (places, columns)), as coordinates
        feel them (coordinates, columns)."""
        made = self._felt(np.stack(pushes[: len(self.axes)], axis=1)) if self.nodes else None
        if self.relative is None or self.sums is None:
            assert made is not None
            return made
        if made is None:
            made = self.numbers.kind.zeros(self.count, pushes[0].shape[1])
        for push, ends in zip(pushes[len(self.axes) :], self.relative.chains.values()):
            np.add.at(made, ends[ends != NONE], push[ends != NONE])
        return self.sums.felt(made)

    def _felt(self, pushes: Numbers) -> Numbers:
        """The same of nodes (nodes, axes, columns), as the joints' coordinates feel it."""
        along(self.tree, pushes, back=True)
        made = self.numbers.kind.zeros(self.count, pushes.shape[2])
        for kind in self.kinds:
            if kind.nodes is not None:
                for b, rows in enumerate(kind.rows):
                    for axis in self.axes:
                        made[rows] += kind.moves[:, axis, b, None] * pushes[kind.nodes, axis]
        return made  # type: ignore[no-any-return]

    def product(self, way: Numbers) -> Numbers:
        """M times a vector."""
        if self.sums is None:
            return self._product(way)
        return self.sums.felt(self._product(self.sums.summed(way)))

    def _product(self, way: Numbers) -> Numbers:
        """The same of the joints' coordinates."""
        zeros = self.numbers.kind.zeros
        places = zeros(self.nodes + 1, len(self.axes))  # behind the last one is what does not move
        for kind in self.kinds:
            if kind.nodes is not None:
                places[kind.nodes] = sum(
                    kind.moves[:, :, b] * way[rows, None] for b, rows in enumerate(kind.rows)
                )
        along(self.tree, places[: self.nodes])
        pushes, direct = zeros(self.nodes + 1, len(self.axes), 1), zeros(self.count)
        for axis in self.axes:
            pushes[: self.nodes, axis, 0] = self.inertia[axis] * places[: self.nodes, axis]
        for kind in self.kinds:
            for component, slopes, mass in kind.weights:
                moved = sum(slopes[:, b] * way[rows] for b, rows in enumerate(kind.rows))
                if component is not None:
                    moved = moved + places[kind.parents, component]
                    np.add.at(pushes[:, component, 0], kind.parents, mass * moved)
                for b, rows in enumerate(kind.rows):
                    direct[rows] += slopes[:, b] * mass * moved
        return direct + self._felt(pushes[: self.nodes])[:, 0]  # type: ignore[no-any-return]

    def times(self, way: Sequence[Any], chosen: Iterable[int]) -> dict[int, Any]:
        product = self.product(self.numbers.kind.array(way)).tolist()
        return {k: product[k] for k in chosen}

    @cached_property
    def rows(self) -> Mapping[int, Mapping[int, Any]]:
        """M, column by column."""
        columns = [self.product(column).tolist() for column in self.numbers.kind.array(np.eye(self.count))]
        return {k: {j: m for j, m in enumerate(column) if m} for k, column in enumerate(columns)}

    def diagonal(self, count: int) -> list[Any]:
        if self.sums is None:
            return self._diagonal(count)
        return [self.rows[k].get(k, 0.0) for k in range(count)]

    def _diagonal(self, count: int) -> list[Any]:
        """M_kk of the joints' coordinates."""
        carried = self.numbers.kind.zeros(self.nodes + 1, len(self.axes))
        for axis in self.axes:
            carried[: self.nodes, axis] = self.inertia[axis]
        made = self.numbers.kind.zeros(count)
        for kind in self.kinds:
            for component, slopes, mass in kind.weights:
                if component is not None:
                    np.add.at(carried[:, component], kind.parents, mass)
                for b, rows in enumerate(kind.rows):
                    made[rows] += mass * slopes[:, b] ** 2
        along(self.tree, carried[: self.nodes], back=True)
        for kind in self.kinds:
            if kind.nodes is not None:
                for b, rows in enumerate(kind.rows):
                    made[rows] += np.sum(carried[kind.nodes] * kind.moves[:, :, b] ** 2, axis=1)
        return made.tolist()  # type: ignore[no-any-return]

    def links(self, fixed: NDArray[np.bool_]) -> Iterator[Link]:
        """The joints, tips before their parents; coordinates that are ``fixed`` move nothing."""
        of_node: list[Link | None] = [None] * self.nodes
        size = len(self.axes)
        for kind in self.kinds:
            coordinates = np.array(kind.rows, dtype=np.int64).reshape(-1, kind.count).T
            free = np.where(fixed[coordinates], 0.0, 1.0)
            moves = as_doubles(kind.moves) * free[:, None, :]
            own = np.zeros((kind.count, len(kind.rows), len(kind.rows)))
            own[:, range(len(kind.rows)), range(len(kind.rows))] = 1.0 - free
            shared = np.zeros((kind.count, size, len(kind.rows)))
            passed = np.zeros((kind.count, size, size))
            for component, slopes, mass in kind.weights:
                m, slope = as_doubles(mass), as_doubles(slopes) * free
                own += m[:, None, None] * slope[:, :, None] * slope[:, None, :]
                if component is not None:
                    shared[:, component] += m[:, None] * slope
                    passed[:, component, component] += m
            nodes = [NONE] * kind.count if kind.nodes is None else kind.nodes.tolist()
            for i, (parent, node) in enumerate(zip(kind.parents.tolist(), nodes)):
                link = Link(coordinates[i], parent, node, moves[i], own[i], shared[i], passed[i])
                if node == NONE:
                    yield link
                else:
                    of_node[node] = link
        order = [] if self.tree is None else self.tree.order[::-1].tolist()
        yield from (link for node in order if (link := of_node[node]) is not None)

    def solver(self, chosen: Sequence[int]) -> Solver | None:
        if self.sums is not None and len(chosen) < self.count:
            return None  # where such a coordinate rests, none of the joints' has to
        chosen = tuple(chosen)
        if chosen not in self._solvers:
            self._solvers[chosen] = self._solver(chosen)
        return self._solvers[chosen]

    def _solver(self, chosen: tuple[int, ...]) -> Solver | None:
        fixed = np.ones(self.count, dtype=bool)
        fixed[list(chosen)] = False
        felt = np.zeros((self.nodes + 1, len(self.axes), len(self.axes)))
        for axis in self.axes:
            felt[: self.nodes, axis, axis] = self.inertia[axis]
        least = LEAST * as_doubles(np.array(self._diagonal(self.count)))
        found: list[Eliminated] = []
        for link in self.links(fixed):
            own, shared, passed = link.own, link.shared, link.passed
            if link.node != NONE:
                pushed = felt[link.node] @ link.moves
                own, shared = own + link.moves.T @ pushed, shared + pushed
                passed = passed + felt[link.node]
            inverse = inverted(own, least[link.coordinates])
            if inverse is None:
                return None
            gain = shared @ inverse
            felt[link.parent] += passed - gain @ shared.T
            found.append(Eliminated(link, inverse, gain, shared))

        solve, sums = Inverse(self, chosen, found), self.sums
        return solve if sums is None else lambda right: sums.apart(solve(sums.divided(right)))


@dataclass(frozen=True, eq=False)
class Eliminated:
    """A joint whose coordinates are found from its parent's place: the ``inverse`` of their mass, the
    ``gain`` of the parent's pull, and M by the parent's place and the coordinates, ``shared``."""

    link: Link
    inverse: Numbers
    gain: Numbers
    shared: Numbers


class Inverse:
    """M^-1 for the ``chosen`` coordinates, with the joints in the order of their elimination."""

    def __init__(self, masses: JointMasses, chosen: tuple[int, ...], joints: Sequence[Eliminated]) -> None:
        self.chosen, self.joints, self.count = list(chosen), joints, masses.count
        self.places = masses.nodes + 1, len(masses.axes)
        self._calls = 0

    def __call__(self, right: Numbers) -> Numbers:
        """M^-1 b (coordinates, columns)."""
        self._calls += 1
        if self._calls > OFTEN and len(self.chosen) <= WRITTEN:
            return self.matrix @ right
        return self.solved(right)

    @cached_property
    def matrix(self) -> Numbers:
        """M^-1."""
        return self.solved(np.eye(len(self.chosen)))

    def solved(self, right: Numbers) -> Numbers:
        """The same joint by joint."""
        whole = np.zeros((self.count, right.shape[1]))
        whole[self.chosen] = right
        pulls = np.zeros((*self.places, right.shape[1]))
        for one in self.joints:
            link = one.link
            pull = whole[link.coordinates]
            if link.node != NONE:
                pull = pull + link.moves.T @ pulls[link.node]
                pulls[link.parent] += pulls[link.node]
            whole[link.coordinates] = pull
            pulls[link.parent] -= one.gain @ pull
        places = np.zeros(pulls.shape)
        for one in reversed(self.joints):
            link, parent = one.link, places[one.link.parent]
            moved = one.inverse @ (whole[link.coordinates] - one.shared.T @ parent)
            whole[link.coordinates] = moved
            if link.node != NONE:
                places[link.node] = parent + link.moves @ moved
        return whole[self.chosen]


def inverted(matrix: NDArray[np.float64], least: NDArray[np.float64]) -> NDArray[np.float64] | None:
    """The inverse of a small positive matrix; None where a pivot is not larger than the ``least``."""
    if len(matrix) == 1:
        return 1.0 / matrix if matrix[0, 0] > least[0] else None
    try:
        pivots = np.diag(np.linalg.cholesky(matrix)) ** 2
    except np.linalg.LinAlgError:
        return None
    return as_doubles(np.linalg.inv(matrix)) if np.all(pivots > least) else None


def as_doubles(values: Numbers) -> NDArray[np.float64]:
    """Numbers of any kind, rounded."""
    return np.asarray(values, dtype=np.float64)
