"""The equations of motion of joints of one kind, as terms (see ``balance``)."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from copy import copy
from functools import cached_property

from lagrange_cli.expression.node import Node, union
from lagrange_cli.families.arrays import Array, Term, Total
from lagrange_cli.families.joints.joints import Joints
from lagrange_cli.native.families.joints.kind_masses import KindMasses
from lagrange_cli.native.families.joints.node_arrays import NodeArrays, array


class JointKind(KindMasses):
    """Joints of one kind."""

    resting = False
    """Whether there are no velocities: what follows from forces alone."""

    def __init__(self, balance: NodeArrays, joints: Joints) -> None:
        self.balance, self.joints, self.graph = balance, joints, balance.graph
        self.domain = joints.domain
        self.coordinates = tuple(map(balance.arranged_symbol, joints.coordinates))
        self.is_node, self.hangs = joints.nodes is not None, joints.parents is not None
        self.bends, count = range(len(joints.rows)), joints.domain.count
        self.weights = joints.hung
        self.slopes = {(s, b): array(count) for s, _ in enumerate(self.weights) for b in self.bends}
        self.rest = [array(count) for _ in self.weights]
        pairs = [(b, d) for b in self.bends for d in self.bends[b:]]
        self.free_masses = {one: array(count) for one in pairs if joints.free}
        """M of what hangs from nothing, if it is by energies."""
        self.spin = None if joints.free is None else joints.free.spin
        self.beside = {one: array(count) for one in pairs if self.spin is not None and self.spin not in one}
        """M beside a spin."""
        self.missing = [array(count) for _ in self.bends]
        """What J^T R is without R of the same order."""
        self.first: list[Total] = []
        self._inverse: dict[tuple[int, int], Node] = {}
        self.determinant: Total | None = None
        self._gains: dict[tuple[int, int], Node] = {}
        if not self.is_node:
            self._eliminate()
        self._begin()

    @property
    def in_first(self) -> Sequence[Array]:
        """What series give in order 0."""
        return [*self.slopes.values(), *self.free_masses.values(), *self.beside.values()]

    def _begin(self) -> None:
        self.free: list[Total] = []
        self.held_back: list[Total] = []
        self.change: list[Total] = []
        self.strain: list[Total] = []

    def alone(self, balance: NodeArrays) -> JointKind:
        """The same joints, moved from rest by the forces of another ``balance``."""
        made = copy(self)
        made.balance, made.resting = balance, True
        made._begin()
        return made

    def add(self, found: list[Total], made: Callable[[JointKind, int], Node]) -> None:
        """Totals for each coordinate."""
        found += [self.total(made(self, b)) for b in self.bends]

    def strained(self) -> None:
        """R of weights."""
        self.strain += [self.total(self._strain(s)) for s, _ in enumerate(self.weights)]

    # orders

    def known(self, c: int) -> Node:
        """M c - F of a node."""
        balance = self.balance
        every = balance.places
        terms = [] if self.resting else [self.mass(c, e) * self.node(balance.rest[e]) for e in every]
        if self.loaded(c):
            terms.append(self.node(balance.loads[c]))
        return self.summed(terms)

    def loaded(self, c: int) -> bool:
        """Whether a force acts along a component."""
        return c in self.balance.places and bool(self.balance.loads[c].terms)

    def freed(self, b: int) -> Node:
        """Q - J^T R, as far as R is known."""
        balance = self.balance
        terms = []
        if balance.forces.terms:
            terms.append(self.gate(b) * self.at_rows(balance.forces, b))
        if self.is_node:
            terms += [-(self.slope(c, b) * self.known(c)) for c in balance.axes]
        if self.resting:
            return self.summed(terms)
        terms.append(-(self.gate(b) * self.own(self.missing[b])))
        terms += [
            -(self.swing(s, b) * self.weight(s) * self.own(self.rest[s])) for s in range(len(self.weights))
        ]
        return self.summed(terms)

    def _carried(self, c: int) -> Node:
        """What goes on to the parent, whatever its children do."""
        terms = [self.weight(s) * self.own(self.rest[s]) for s in self.on(c) if not self.resting]
        terms += [self.gain(c, b) * self.freed(b) for b in self.bends]
        if self.is_node and c in self.balance.turns:
            turned = {e: self.balance.turned[e, c] for e in self.balance.axes}
            terms += [self.node(one) * self.known(e) for e, one in turned.items() if one.terms]
            terms.append(-self.stuck(c, self.acting))
        elif self.is_node:
            terms.append(self.known(c))
        return self.summed(terms)

    def acting(self, b: int) -> Node:
        """Q - J^T R of what sticks to the parent's coordinates, but for R of nodes."""
        terms = [-self.own(self.missing[b])]
        if self.balance.forces.terms:
            terms.append(self.at_rows(self.balance.forces, b))
        every = range(len(self.weights))
        terms += [-(self.whole_swing(s, b) * self.weight(s) * self.own(self.rest[s])) for s in every]
        return self.summed(terms)

    def pulls(self, c: int) -> list[Term]:
        if self.is_node or self.joints.parents is None:
            return []
        return [Term(self.domain, self._carried(c), self.joints.parents)]

    def pushes(self, c: int) -> list[Term]:
        return [Term(self.domain, self._carried(c), self.at)] if self.is_node else []

    def holding(self, b: int) -> Node:
        """q_ddot with parents at rest."""
        terms = []
        for d in self.bends:
            left = self.own(self.free[d])
            if self.is_node:
                pulls = [self.slope(c, d) * self.node(self.balance.pull[c]) for c in self.balance.axes]
                left = left - self.summed(pulls)
            terms.append(self.inverse(b, d) * left)
        return self.summed(terms)

    def drifts(self, c: int) -> list[Term]:
        if not self.is_node:
            return []
        terms = [self.slope(c, b) * self.holding(b) for b in self.bends]
        if not self.resting and c in self.balance.places:
            terms.append(self.node(self.balance.rest[c]))
        return [Term(self.domain, self.summed(terms), self.at)]

    def changing(self, b: int) -> Node:
        """q_ddot."""
        if self.is_node and b < len(self.balance.turns):
            return self.accelerated_node(self.balance.turns[b])  # to the last bit that of what sticks to it
        carried = [self.gain(c, b) * self.pulled(c) for c in self.balance.axes]
        carried += [-(self.carry(e, b) * self.pulled(e)) for e in self.balance.turns]
        return self.own(self.held_back[b]) - self.summed(carried)

    def strains(self, c: int) -> list[Term]:
        """R of nodes."""
        if not self.is_node:
            return []
        balance = self.balance
        terms = [self.mass(c, e) * self.accelerated_node(e) for e in balance.axes]
        terms.append(self.node(balance.pull[c]))
        if self.loaded(c):
            terms.append(self.node(balance.loads[c]))
        return [Term(self.domain, self.summed(terms), self.at)]

    def _strain(self, s: int) -> Node:
        """m a of weights."""
        one = self.weights[s]
        terms = [] if self.resting else [self.own(self.rest[s])]
        swing = self.whole_swing if self.balance.turns else self.swing
        terms += [swing(s, b) * self.changing(b) for b in self.bends]
        if one.component is not None:
            terms.append(self.pulled(one.component))
        return one.mass * self.summed(terms)

    def accelerated(self) -> list[Term]:
        return [Term(self.domain, self.changing(b), self.joints.rows[b]) for b in self.bends]

    def left(self, b: int, other: Total) -> list[Term]:
        """Q - J^T R of what is held."""
        terms = [-self.own(self.missing[b])]
        if other.terms:
            terms.append(self.at_rows(other, b))
        if self.is_node:
            terms += [-(self.whole_slope(c, b) * self.node(one)) for c, one in enumerate(self.balance.strain)]
        terms += [-(self.whole_swing(s, b) * self.own(one)) for s, one in enumerate(self.strain)]
        terms += [-(self.free_mass(b, d) * self.changing(d)) for d in self.bends]
        return [Term(self.domain, (1.0 - self.gate(b)) * self.summed(terms), self.joints.rows[b])]

    # series

    @cached_property
    def moving(self) -> int:
        """The symbols of what moves."""
        return union((self.balance.system.time, *self.coordinates))
