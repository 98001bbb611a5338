"""The mass matrix of chains and trees, and slopes of constraints by coordinates, entry by entry.

A coordinate moves all nodes behind its joint alike, by J = dx/dq. So an entry of M for it and a coordinate
nearer to the root is J J' W, with the mass W behind the farther joint; weights that a joint carries without
further joints move with the node that they hang from, too.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

from lagrange_cli.expression.node import Node
from lagrange_cli.families.arrays import Domain, Term, Total, placed, total_of
from lagrange_cli.families.bonds import Bonds
from lagrange_cli.families.description import FamilySystem
from lagrange_cli.families.joints.joints import Joints

if TYPE_CHECKING:
    from lagrange_cli.expression.index_arrays import Places


class JointMatrices:
    """The terms of both."""

    def __init__(self, system: FamilySystem) -> None:
        assert system.joints is not None
        self.system, self.joints = system, system.joints
        self.slots, self.graph, self.degrees = system.slots, system.slots.graph, system.q.count
        self.axes = range(len(system.joints.nodes))
        self.slopes = [total_of(self.degrees, self._slopes(c), self.graph) for c in self.axes]
        """J, by coordinates."""
        self.behind = [self._behind(c) for c in self.axes]
        """W, by nodes."""
        self.carried = [total_of(self.degrees, self._carried(c), self.graph) for c in self.axes]
        """J W, by coordinates, with weights that their joints carry."""

    def _slopes(self, c: int) -> Iterator[Term]:
        for kind in self.joints.joints:
            if kind.nodes is not None:
                for q, rows in zip(kind.coordinates, kind.rows):
                    yield Term(kind.domain, self.graph.diff(kind.moves[c], q), rows)

    def _behind(self, c: int) -> Total:
        """Masses behind nodes along an axis."""
        terms = [*self.joints.inertia[c].terms]
        for kind in self.joints.joints:
            if kind.parents is not None:
                own = [(one.mass, 1.0) for one in kind.weights if one.component == c]
                if own:
                    terms.append(Term(kind.domain, self.graph.sum(own), kind.parents))
        return total_of(self.joints.count, terms, self.graph, self.joints.nodes[c].tree, back=True)

    def _hung(self, kind: Joints, c: int, q: Node) -> Node:
        """m dx/dq of weights that hang from a node."""
        weights = [one for one in kind.weights if one.component == c and kind.parents is not None]
        return self.graph.sum([(one.mass * self.graph.diff(one.move, q), 1.0) for one in weights])

    def _carried(self, c: int) -> Iterator[Term]:
        for kind in self.joints.joints:
            for q, rows in zip(kind.coordinates, kind.rows):
                node = self._hung(kind, c, q)
                if kind.nodes is not None:
                    mass = self.slots.symbol(kind.domain, self.behind[c], kind.nodes)
                    node = node + self.graph.diff(kind.moves[c], q) * mass
                yield Term(kind.domain, node, rows)

    def masses(self) -> Iterator[Term]:
        """M, at rows times all coordinates, plus the column."""
        for kind in self.joints.joints:
            for b, q in enumerate(kind.coordinates):
                for d, other in enumerate(kind.coordinates[: b + 1]):
                    node = self._own(kind, q, other)
                    places = {(b, d), (d, b)}  # of the same digits on both sides
                    for i, j in sorted(places):
                        yield Term(kind.domain, node, kind.rows[i] * self.degrees + kind.rows[j])
                if kind.parents is not None:
                    yield from self._beyond(kind.rows[b], kind)

    def _own(self, kind: Joints, q: Node, other: Node) -> Node:
        """What two coordinates of a joint have in common."""
        diff = self.graph.diff
        parts = [(one.mass * diff(one.move, q) * diff(one.move, other), 1.0) for one in kind.weights]
        if kind.nodes is not None:
            for c, move in enumerate(kind.moves):
                mass = self.slots.symbol(kind.domain, self.behind[c], kind.nodes)
                parts.append((mass * diff(move, q) * diff(move, other), 1.0))
        return self.graph.sum(parts)

    def _beyond(self, rows: Places, kind: Joints) -> Iterator[Term]:
        """What coordinates have in common with those nearer to the root."""
        assert kind.parents is not None
        members, others = self.joints.movers(kind.parents)
        if len(members):
            domain, own = Domain(len(members)), rows[members]
            parts = [
                (self.slots.symbol(domain, slope, others) * self.slots.symbol(domain, carried, own), 1.0)
                for slope, carried in zip(self.slopes, self.carried)
            ]
            node = self.graph.sum(parts)
            yield Term(domain, node, own * self.degrees + others)
            yield Term(domain, node, others * self.degrees + own)

    def of_holds(self, bonds: Bonds) -> Iterator[Term]:
        """-A of the nodes in constraints, at constraints times all coordinates, plus the coordinate."""
        for bound in bonds.bounds:
            for hold in bound.holds:
                members, rows = self.joints.movers(hold.places)
                domain = Domain(len(members))
                slope = placed(self.slots, hold.slope, domain, members)
                node = -slope * self.slots.symbol(domain, self.slopes[hold.component], rows)
                yield Term(domain, node, bound.numbers[members] * self.degrees + rows)
