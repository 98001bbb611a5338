"""What the equations of motion of joints of one kind are made of, as symbols (see ``kinds``)."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence

import numpy as np

from lagrange_cli.expression.graph import Graph
from lagrange_cli.expression.index_arrays import Places
from lagrange_cli.expression.node import Node
from lagrange_cli.families.arrays import Array, Domain, Term
from lagrange_cli.families.joints.joints import Joints, Weight
from lagrange_cli.native.families.joints.node_arrays import NodeArrays


class KindSymbols:
    """Arrays of joints of one kind, at their members."""

    balance: NodeArrays
    joints: Joints
    graph: Graph
    domain: Domain
    bends: range
    is_node: bool
    weights: Sequence[Weight]
    slopes: Mapping[tuple[int, int], Array]
    free_masses: Mapping[tuple[int, int], Array]
    beside: Mapping[tuple[int, int], Array]
    spin: int | None
    _inverse: Mapping[tuple[int, int], Node]
    _gains: Mapping[tuple[int, int], Node]

    @property
    def at(self) -> Places:
        assert self.joints.nodes is not None
        return self.joints.nodes

    def own(self, one: Array) -> Node:
        """An array of the kind's members."""
        return self.balance.slots.own(self.domain, one)

    def node(self, one: Array) -> Node:
        """An array of nodes, at the joints' own ones."""
        assert self.joints.nodes is not None
        return self.balance.slots.symbol(self.domain, one, self.joints.nodes)

    def pulled(self, c: int) -> Node:
        """The accelerations of the joints' parents."""
        parents = self.joints.parents
        if parents is None:
            return self.graph.zero
        places = np.where(parents == self.balance.count, 0, parents + 1)
        return self.balance.slots.symbol(self.domain, self.balance.accelerations[c], places)

    def accelerated_node(self, c: int) -> Node:
        """Those of their nodes."""
        accelerations = self.balance.accelerations[c]
        return self.balance.slots.symbol(self.domain, accelerations, self.at + 1)

    def gate(self, b: int) -> Node:
        """1, or 0 where friction holds a coordinate."""
        gates = self.balance.gates
        return self.graph.one if gates is None else self.at_rows(gates, b)

    def at_rows(self, array: Array, b: int) -> Node:
        """An array of coordinates."""
        return self.balance.slots.symbol(self.domain, array, self.joints.rows[b])

    def slope(self, c: int, b: int) -> Node:
        """J of a node, without what is held; 0 where it is."""
        return self.gate(b) * self.whole_slope(c, b)

    def whole_slope(self, c: int, b: int) -> Node:
        """J of a node."""
        if c in self.balance.turns:
            return self.graph.one if c - self.balance.turns.start == b else self.graph.zero
        slope = self.graph.diff(self.joints.moves[c], self.joints.coordinates[b])
        return self.graph.zero if slope.is_zero else self.node(self.balance.node_slopes[c, b])

    def swing(self, s: int, b: int) -> Node:
        """J of a weight, without what is held."""
        return self.gate(b) * self.whole_swing(s, b)

    def whole_swing(self, s: int, b: int) -> Node:
        """J of a weight."""
        slope = self.graph.diff(self.weights[s].move, self.joints.coordinates[b])
        return self.graph.zero if slope.is_zero else self.own(self.slopes[s, b])

    def free_mass(self, b: int, d: int) -> Node:
        """An entry of M of what hangs from nothing, if it is by energies."""
        free = self.joints.free
        if free is None or free.masses[b][d].is_zero:
            return self.graph.zero
        return self.own(self.free_masses[min(b, d), max(b, d)])

    def beside_spin(self, b: int, d: int) -> Node:
        """The same of what its elimination leaves."""
        free = self.joints.free
        if free is None or free.beside[b][d].is_zero:
            return self.graph.zero
        return self.own(self.beside[b, d])

    def inverse(self, b: int, d: int) -> Node:
        key = min(b, d), max(b, d)
        return self.node(self.balance.inverse[key]) if self.is_node else self._inverse[key]

    def gain(self, c: int, b: int) -> Node:
        return self.node(self.balance.gains[c, b]) if self.is_node else self._gains[c, b]

    def mass(self, c: int, e: int) -> Node:
        return self.node(self.balance.masses[min(c, e), max(c, e)])

    def summed(self, terms: Sequence[Node]) -> Node:
        return self.graph.sum([(one, 1.0) for one in terms])

    def carry(self, e: int, b: int) -> Node:
        """What the acceleration of a coordinate that sticks is of that of the parent's."""
        return self.at_rows(self.balance.carries[e - self.balance.turns.start], b)

    def stuck(self, e: int, slope: Callable[[int], Node]) -> Node:
        """What moves with the parent's coordinates, by the slopes of all of these."""
        return self.summed([self.carry(e, b) * slope(b) for b in self.bends])

    def turned(self, c: int, e: int) -> list[Term]:
        """The same of a node."""
        if not self.is_node:
            return []
        return [Term(self.domain, self.stuck(e, lambda b: self.whole_slope(c, b)), self.at)]

    def swung(self, s: int, e: int) -> Node:
        """The same of a weight."""
        return self.stuck(e, lambda b: self.whole_swing(s, b))
