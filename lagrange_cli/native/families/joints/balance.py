"""What acts on joints and what moves them, as totals: the equations of motion of chains and trees, order by
order.

With a for the accelerations of nodes, J for the slopes dx/dq of what a joint adds to its parent, and R for
what a node and all that hangs from it take, the equations are

    a = a_parent + J q_ddot + c,    R = m a - F + sum of the children's R,    J^T R = Q,

where c has what is known already. From the tips on, R = M a_parent + B: each joint is eliminated where it is
met, which leaves a matrix of the size of one place (R. Featherstone, Rigid Body Dynamics Algorithms, 2008,
ch. 7). So the work grows with the number of joints. Weights that a joint carries without further joints are
treated alike, but without children. M is found once a step; each order goes to the root with B and back with
a. What turns and hangs from nothing may have d/dt dT/dq_dot - dT/dq in place of J^T m a (see
``families.joints.free``)."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from copy import copy
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from lagrange_cli.expression.node import Node
from lagrange_cli.families.arrays import NONE, Array, Domain, Term, Total
from lagrange_cli.families.description import FamilySystem
from lagrange_cli.native.families.corrected import Local
from lagrange_cli.native.families.joints.kind_series import PushedJoints, local_of
from lagrange_cli.native.families.joints.kinds import JointKind
from lagrange_cli.native.families.joints.node_arrays import Arranged, NodeArrays, array

if TYPE_CHECKING:
    from lagrange_cli.expression.index_arrays import Places


class Balance(NodeArrays):
    """The totals of a system of joints, on which other ``forces`` and ``loads`` may act than its own."""

    touched: PushedJoints | None = None
    """What resting contacts add to accelerations, if there are any."""

    def __init__(
        self,
        system: FamilySystem,
        arranged: Arranged,
        forces: Total | None = None,
        loads: Sequence[Total] | None = None,
    ) -> None:
        super().__init__(system, arranged, forces, loads)
        found, many = self.found, self.count
        self.shifted = array(system.q.count) if found.relative and found.relative.driven else None
        """d2/dt2 of what moves the joints' coordinates besides those of the system."""
        self.kinds = [JointKind(self, one) for one in found.joints]
        self.masses = {
            (c, e): self.total(many, [t for one in self.kinds for t in one.held(c, e)], kept=False)
            for c, e in self.pairs
        }
        self.own = {one: self.total(many, [t for k in self.kinds for t in k.met(*one)]) for one in self.bonds}
        self.corners = {
            one: self.total(many, [t for k in self.kinds for t in k.corner(*one)]) for one in self.pivots
        }
        every = [(b, d) for b in range(self.size) for d in range(self.size)]
        self.spins = {
            one: self.total(many, [t for k in self.kinds for t in k.spinning(*one)])
            for one in every
            if any(k.spinning(*one) for k in self.kinds)
        }
        """What couples spins of nodes to others, divided by the masses of spins."""
        self.node_gates = self._gates_of_nodes()
        """``gates`` at nodes, of each coordinate of their joints."""
        self.weights = {
            (c, e): self.total(many, [t for k in self.kinds for t in k.weighed(c, e)])
            for c, e in self.pairs
            if c == e or e in self.turns
        }
        self.turned = {
            (c, e): self.total(many, [t for k in self.kinds for t in k.turned(c, e)])
            for c in self.axes
            for e in self.turns
        }
        self._respond()
        self.series = [*(local_of(one) for one in self.kinds), *self._drives()]
        """What the joints' series of each kind give, and those of shifts."""

    def add_pushes(self, touched: PushedJoints) -> None:
        """Let contacts change accelerations."""
        self.touched = touched
        self.series = [*(local_of(one, touched) for one in self.kinds), *self._drives(), *touched.series]

    @property
    def final(self) -> Total:
        """The accelerations of coordinates, with those by contacts."""
        return self.of_coordinates if self.touched is None else self.touched.rates

    @property
    def final_sums(self) -> Sequence[Total]:
        """Those of sums of coordinates."""
        return self.of_sums if self.touched is None else self.touched.of_sums

    def alone(self, forces: Total, loads: Sequence[Total]) -> Balance:
        """What ``forces`` and ``loads`` do alone, with the same masses."""
        made = copy(self)
        made.forces, made.loads = self.on_joints(forces, loads), self.on_nodes(loads)
        made.accelerations, made.shifted = [array(self.count) for _ in self.axes], None
        made.kinds = [one.alone(made) for one in self.kinds]
        made._respond()
        return made

    def _respond(self) -> None:
        """How joints move as forces act."""
        many = self.count
        for one in self.kinds:
            one.add(one.free, JointKind.freed)
        self.pull = [
            self.total(many, [t for k in self.kinds for t in k.pulls(c)], kept=False) for c in self.axes
        ]
        self.push = [self.total(many, [t for k in self.kinds for t in k.pushes(c)]) for c in self.axes]
        """What each node adds to B of its parent besides."""
        for one in self.kinds:
            one.add(one.held_back, JointKind.holding)
        self.drift = [self.total(many, [t for k in self.kinds for t in k.drifts(c)]) for c in self.axes]
        """What a node adds to a of its parent besides."""
        for one in self.kinds:
            one.add(one.change, JointKind.changing)
        self.strain = [self.total(many, [t for k in self.kinds for t in k.strains(c)]) for c in self.axes]
        for one in self.kinds:
            one.strained()
        rates = [term for one in self.kinds for term in one.accelerated()]
        self.rates = self.total(self.system.q.count, rates, kept=False)
        """The accelerations of the joints' coordinates."""
        self._sum_up()
        locks = self.system.modes and self.system.modes.locks
        self.other = self.on_joints(locks.other, self.system.loads) if locks else None
        self.left = None if self.other is None else self._left(self.other)
        """What would move coordinates that are held, and the forces on these without what holds them."""

    def _sum_up(self) -> None:
        """Accelerations of coordinates where those of joints are sums of these, and of these sums."""
        relative, self.of_coordinates, self.of_sums = self.found.relative, self.rates, list[Total]()
        if relative is None:
            return
        own = [*relative.rates(self.rates, self.shifted)]
        self.of_coordinates = self.total(self.rates.count, own, kept=False)
        self.of_sums = self.at_ends(self.rates)

    def at_ends(self, rates: Array) -> list[Total]:
        """The accelerations of sums of coordinates, from those of the joints' coordinates."""
        found = []
        for one, ends in self.found.relative.chains.items() if self.found.relative else ():
            members = np.flatnonzero(ends != NONE)
            domain = Domain(len(members))
            node = self.slots.symbol(domain, rates, ends[members])
            found.append(self.total(one.count, [Term(domain, node, members)], kept=False))
        return found

    def _drives(self) -> Iterator[Local]:
        """What the series of shifts give."""
        relative, shifted, graph = self.found.relative, self.shifted, self.graph
        if relative is None or shifted is None:
            return
        for one in relative.driven:
            every = one.domain.every
            (own,) = self.total(one.domain.count, [Term(one.domain, one.shift, every)]).terms
            term = Term(one.domain, graph.ddt(graph.ddt(own.node)), one.rows)
            yield Local(one.domain, [(term, shifted)], 0, [], [], [])

    def of_place(self, domain: Domain, component: int, places: Places) -> Node:
        """The accelerations of nodes, or of sums of coordinates (see ``Articulation.places``)."""
        if component in self.places:
            return self.slots.symbol(domain, self.accelerations[component], places + 1)
        return self.slots.symbol(domain, self.of_sums[component - len(self.places)], places)

    def _gates_of_nodes(self) -> Sequence[Total]:
        if self.gates is None:
            return ()
        every = [(b, k) for b in range(self.size) for k in self.kinds if k.is_node]
        terms = [(b, Term(k.domain, k.gate(b) if b in k.bends else k.graph.one, k.at)) for b, k in every]
        return [self.total(self.count, [one for d, one in terms if d == b]) for b in range(self.size)]

    def _left(self, other: Total) -> Total:
        terms = [term for one in self.kinds for b in one.bends for term in one.left(b, other)]
        return self.total(self.system.q.count, terms, kept=False)

    # in which order they are computed

    @cached_property
    def local(self) -> Sequence[Array]:
        """What the joints' series give in every order."""
        driven = [] if self.shifted is None else [self.shifted]
        return [*self.rest, *driven, *(one for kind in self.kinds for one in (*kind.rest, *kind.missing))]

    @cached_property
    def slopes(self) -> Sequence[Array]:
        """What they give in order 0."""
        return [*self.node_slopes.values(), *(one for kind in self.kinds for one in kind.in_first)]

    @cached_property
    def first(self) -> Sequence[Total]:
        """Before the masses are eliminated."""
        mine = [total for kind in self.kinds for total in kind.first]
        own = *self.own.values(), *self.corners.values(), *self.spins.values(), *self.node_gates
        return [*mine, *own, *self.weights.values(), *self.turned.values(), *self.masses.values()]

    @cached_property
    def before(self) -> Sequence[Total]:
        """Before B goes to the root."""
        return [*(total for kind in self.kinds for total in kind.free), *self.pull, *self.push]

    @cached_property
    def between(self) -> Sequence[Total]:
        """Before a goes to the tips."""
        return [*(total for kind in self.kinds for total in kind.held_back), *self.drift]

    @cached_property
    def moved(self) -> Sequence[Total]:
        """q_ddot."""
        return [*(total for kind in self.kinds for total in kind.change), self.rates, *self.differences]

    @cached_property
    def after(self) -> Sequence[Total]:
        """Afterwards."""
        mine = [total for kind in self.kinds for total in (*kind.change, *kind.strain)]
        left = [] if self.left is None else [self.left]
        return [*mine, *self.strain, self.rates, *self.differences, *left]

    @property
    def differences(self) -> Sequence[Total]:
        """What follows from ``rates``, where joints' coordinates are sums."""
        return () if self.of_coordinates is self.rates else (self.of_coordinates, *self.of_sums)

    @property
    def arrays(self) -> Sequence[Array]:
        """All that are computed."""
        sweeps = [*self.gains.values(), *self.inverse.values(), *self.passed.values(), *self.accelerations]
        totals = (*self.first, *self.before, *self.between, *self.after)
        return list(dict.fromkeys([*self.local, *self.slopes, *sweeps, *totals]))
