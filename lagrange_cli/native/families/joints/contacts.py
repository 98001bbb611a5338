"""Resting contacts of chains, trees and rigid bodies, as totals beside those of ``balance`` (see
``families.impacts.joint_contacts``).

With b for the accelerations that all other forces give, accelerations are a = b + u, where u = sum N d, and
N follows from dg/dq a + c = 0 of the contacts that hold; it is 0 of all others. The equations of motion are
those of b, in which J q_ddot is J (a - u). So the sweeps find b, and what u moves is added to it.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from lagrange_cli.expression.index_arrays import distinct
from lagrange_cli.expression.node import Node, union
from lagrange_cli.families.arrays import NONE, Array, Domain, Slot, Term, Total
from lagrange_cli.families.bonds import Bonds, Bound
from lagrange_cli.families.contacts import Coupled, Push
from lagrange_cli.families.description import FamilySystem
from lagrange_cli.families.tables import met
from lagrange_cli.native.families.constraints.restraint import Bonded
from lagrange_cli.native.families.corrected import Local, in_series
from lagrange_cli.native.families.joints.balance import Balance
from lagrange_cli.native.families.joints.kind_series import PushedJoints
from lagrange_cli.native.families.joints.node_arrays import array
from lagrange_cli.native.families.joints.reaching import Reaching
from lagrange_cli.native.families.lasting import Lasting

if TYPE_CHECKING:
    from lagrange_cli.expression.index_arrays import Places


class JointContacts(Bonded):
    """The totals of the contacts of a system, whose ``balance`` has all other forces."""

    def __init__(self, system: FamilySystem, lasting: Lasting, balance: Balance) -> None:
        assert isinstance(system.contact, Coupled) and system.joints is not None
        self.contact = system.contact
        super().__init__(system, lasting)
        self.balance, self.pushes = balance, self.contact.pushes
        self.nodes: Sequence[Array] = [lasting.arranged(one) for one in system.joints.nodes]
        self.slopes = [[array(one.domain.count) for _ in one.slopes] for one in self.bounds]
        """dg/dq."""
        self.directions = [array(one.domain.count) for one in self.pushes]
        """d."""
        self.gained = array(self.size)
        """u without what is newest in N, by series."""
        self.jolts = [array(balance.count) for _ in balance.axes]
        """J u of nodes, likewise."""
        self.pairs, terms = self._coupled()
        """The contacts (2, entries) of each entry of dg/dq d, by what is moved and by what pushes, if no
        places of nodes are in them."""
        self.square = self.total(self.pairs.shape[1], terms)
        """These entries."""
        self.reaching = Reaching(self, balance, self.contact.reaches)
        self.early = self.total(
            self.size, [*self.sum_of(self.gained), *self.reaching.pushed(self.reaching.early)]
        )
        """u without the newest N."""
        self.known = self.total(self.size, self.sum_of(balance.of_coordinates, self.early))
        """a without it."""
        self.ahead = [self.moved_by(self.early, c, self.jolts[c]) for c in balance.axes]
        """What u without it adds to accelerations of nodes beside their parents."""
        self.right = self._right()
        self.divided = self._divided() if self.alone else None
        if self.divided is not None:
            self.multipliers = self.divided
        self.newest = self._newest()
        """What the newest N adds to u."""
        self.swings = [self.moved_by(self.newest, c) for c in balance.axes]
        """What that adds to accelerations of nodes."""
        self.column = self._column()
        """dg/dq d N."""
        self.left = self._left()
        """What N leaves of the right side."""
        self.pushed = self.total(self.size, self.sum_of(self.early, self.newest))
        """u."""
        self.rates = self._rates()
        """a."""
        self.on_joints = self._on_joints()
        """u of the joints' coordinates."""
        relative = balance.found.relative is not None
        self.of_joints = (
            self.total(self.size, self.sum_of(balance.rates, self.on_joints)) if relative else self.rates
        )
        """a of these."""
        self.of_sums = balance.at_ends(self.of_joints)
        """a of sums of coordinates."""
        self.moved = [self.moved_by(self.on_joints, c, self.jolts[c]) for c in balance.axes]
        """What u adds to accelerations of nodes beside their parents."""

    @property
    def added(self) -> PushedJoints:
        """What contacts add to accelerations."""
        series = [self._local_of_bound(b, one) for b, one in enumerate(self.bounds)]
        series += [self._local_of_push(p, one) for p, one in enumerate(self.pushes)]
        rates = self.on_joints, self.of_joints, self.rates, self.of_sums
        return PushedJoints(*rates, self.gained, self.jolts, series, self.reaching.of_kind)

    def bonds_of(self, system: FamilySystem) -> Bonds:
        return self.contact.bonds

    @property
    def in_order(self) -> Sequence[Array]:
        """What series give in every order."""
        return [self.rest, self.gained, *self.jolts, *self.reaching.in_order]

    @property
    def in_first(self) -> Sequence[Array]:
        """What they give in order 0."""
        slopes = (one for some in self.slopes for one in some)
        return [*slopes, *self.directions, *self.reaching.in_first]

    @property
    def arrays(self) -> Sequence[Array]:
        """All that are computed."""
        own = [self.square, self.early, self.known, self.right, self.multipliers]
        own += [self.newest, self.column, self.left, self.pushed, self.rates]
        own += [self.on_joints, self.of_joints, *self.of_sums, *self.ahead, *self.swings, *self.moved]
        return list(dict.fromkeys([*self.in_order, *self.in_first, *self.reaching.arrays, *own]))

    @cached_property
    def alone(self) -> bool:
        """Whether no contact pushes what another one is at."""
        number = np.arange(self.count)
        placed = any(one.holds for one in self.bounds)
        return not placed and all(np.array_equal(one, number) for one in self.pairs)

    def sum_of(self, *arrays: Array) -> list[Term]:
        """The sum of arrays of all coordinates."""
        domain = self.system.everyone
        node = self.graph.sum([(self.slots.own(domain, one), 1.0) for one in arrays])
        return [Term(domain, node, domain.every)]

    def gate(self, domain: Domain, contacts: Places) -> Node:
        """1 of contacts that hold, and 0 of others."""
        mode = self.slots.symbol(domain, self.contact.signs, contacts)
        return mode * mode

    def _coupled(self) -> tuple[Places, list[Term]]:
        """Which contacts are at what which others push, and the terms of the entries of dg/dq d."""
        found: list[tuple[Domain, Node, Places]] = []
        for bound, slopes in zip(self.bounds, self.slopes):
            for rows, slope in zip(bound.rows, slopes):
                for push, direction in zip(self.pushes, self.directions):
                    first, second = met(rows, push.rows)
                    if len(first):
                        domain = Domain(len(first))
                        node = self.slots.symbol(domain, slope, first)
                        node = node * self.slots.symbol(domain, direction, second)
                        found.append(
                            (domain, node, bound.numbers[first] * self.count + push.contacts[second])
                        )
        keys = distinct(np.concatenate([np.zeros(0, dtype=np.int64), *(one for _, _, one in found)]))
        terms = [Term(domain, node, np.searchsorted(keys, one)) for domain, node, one in found]
        return np.stack(np.divmod(keys, self.count)), terms

    def along(self, number: int, coordinates: Array, nodes: Sequence[Sequence[tuple[Array, int]]]) -> Node:
        """dg/dq times what changes ``coordinates``, and along each axis the sum of what changes ``nodes``, in
        arrays of which each has so many places before the first node."""
        bound, symbol = self.bounds[number], self.slots.symbol
        parts = [
            (self.slots.own(bound.domain, slope) * symbol(bound.domain, coordinates, rows), 1.0)
            for slope, rows in zip(self.slopes[number], bound.rows)
        ]
        for column, hold in zip(self.reaching.columns[number], bound.holds):
            slope = self.slots.own(bound.domain, column)
            for one, before in nodes[hold.component]:
                parts.append((slope * symbol(bound.domain, one, hold.places + before), 1.0))
        return self.graph.sum(parts)

    def _right(self) -> Total:
        """What N follows from, of the contacts that hold."""
        terms = []
        nodes = [[(one, 1), (ahead, 0)] for one, ahead in zip(self.balance.accelerations, self.ahead)]
        for b, bound in enumerate(self.bounds):
            gate = self.gate(bound.domain, bound.numbers)
            terms.append(Term(bound.domain, -(gate * self.along(b, self.known, nodes)), bound.numbers))
        each = Domain(self.count)
        gate = self.gate(each, each.every)
        rest = gate * self.slots.own(each, self.rest)
        return self.total(self.count, [*terms, Term(each, -rest, each.every)])

    def _divided(self) -> Total:
        """N, each of its own."""
        each = Domain(self.count)
        gate = self.gate(each, each.every)
        own = gate * self.slots.own(each, self.square) + (1.0 - gate)  # which may be 0 where nothing holds
        return self.total(self.count, [Term(each, self.slots.own(each, self.right) / own, each.every)])

    def _newest(self) -> Total:
        terms = [*self.reaching.pushed(self.reaching.newest)]
        for push, direction in zip(self.pushes, self.directions):
            multiplier = self.slots.symbol(push.domain, self.multipliers, push.contacts)
            terms.append(Term(push.domain, self.slots.own(push.domain, direction) * multiplier, push.rows))
        return self.total(self.size, terms)

    def _column(self) -> Total:
        nodes = [[(one, 0)] for one in self.swings]
        terms = [
            Term(one.domain, self.along(b, self.newest, nodes), one.numbers)
            for b, one in enumerate(self.bounds)
        ]
        return self.total(self.count, terms)

    def _left(self) -> Total:
        each = Domain(self.count)
        product = self.gate(each, each.every) * self.slots.own(each, self.column)
        return self.total(self.count, [Term(each, self.slots.own(each, self.right) - product, each.every)])

    def _on_joints(self) -> Total:
        relative = self.balance.found.relative
        if relative is None:
            return self.pushed
        return self.lasting.arranged(relative.summed(self.pushed), kept=False)

    def _rates(self) -> Total:
        """Coordinates that rest alone have no acceleration, not even a rounding error."""
        before, own = np.full(self.size, NONE), self.balance.of_coordinates
        terms = self.sum_of(own, self.pushed)
        for bound in filter(self._still, self.bounds):
            rows, others = bound.rows[0], before[bound.rows[0]]
            before[rows] = bound.numbers
            for which in (others == NONE, others != NONE):
                at = rows[which]
                if not len(at):
                    continue
                domain = Domain(len(at))
                held = self.gate(domain, bound.numbers[which])
                if others[which][0] != NONE:  # one wall of a coordinate holds it at a time
                    held = held * (1.0 - self.gate(domain, others[which]))
                whole = self.slots.symbol(domain, own, at)
                whole = whole + self.slots.symbol(domain, self.pushed, at)
                terms.append(Term(domain, -(held * whole), at))
        return self.total(self.size, terms)

    def _still(self, bound: Bound) -> bool:
        """Whether what contacts are at is a coordinate each that does not move there."""
        moving = self.system.time.symbols | self.slots.symbols_of(self.system.q)
        fixed = not (bound.holds or bound.node.symbols & self.system.time.symbols)
        return len(bound.rows) == 1 and fixed and not bound.slopes[0].symbols & moving

    def moved_by(self, pushed: Array, c: int, besides: Array | None = None) -> Total:
        """What changes of accelerations of coordinates add to a component of nodes beside their parents."""
        terms = []
        for kind in self.balance.kinds:
            if kind.is_node:
                parts = [] if besides is None else [kind.node(besides)]
                parts += [kind.whole_slope(c, b) * kind.at_rows(pushed, b) for b in kind.bends]
                terms.append(Term(kind.domain, kind.summed(parts), kind.at))
        return self.total(self.balance.count, terms)

    # series

    def _series(self, domain: Domain, node: Node) -> tuple[Node, list[Node], list[Node]]:
        """An expression of coordinates and places, these, and their accelerations."""
        (one,) = self.total(domain.count, [Term(domain, node, domain.every)]).terms
        assert self.system.joints is not None
        rates = enumerate(self.system.joints.rates)
        placed: dict[Array, Array] = {self.system.v: self.system.q}
        placed |= {self.lasting.arranged(one): self.nodes[c] for c, one in rates if one is not None}
        found, places = in_series(self.slots, one.node, domain, placed)
        return found, [*places], [self._change(domain, slot) for slot in places.values()]

    def _change(self, domain: Domain, place: Slot) -> Node:
        """The acceleration of a coordinate or of a node."""
        if place.array is self.system.q:
            return self.slots.symbol(domain, self.rates, place.table)
        component = self.nodes.index(place.array)
        return self.slots.symbol(domain, self.balance.accelerations[component], place.table + 1)

    def _local_of_bound(self, number: int, bound: Bound) -> Local:
        """What the series of contacts give."""
        graph, domain = self.graph, bound.domain
        node, symbols, changes = self._series(domain, bound.node)
        moving, every = union((self.system.time, *symbols)), domain.every
        terms = [(Term(domain, graph.ddt(graph.ddt(node)), bound.numbers), self.rest)]
        columns = [
            (Term(domain, graph.diff(node, symbol), every), column)
            for symbol, column in zip(bound.symbols, self.slopes[number])
        ]
        multiplier = self.slots.symbol(domain, self.multipliers, bound.numbers)
        unknowns: list[Node] = []
        reaching = self.reaching
        for hold, column, rest in zip(bound.holds, reaching.columns[number], reaching.rests[number]):
            place = self.slots.symbol(domain, self.nodes[hold.component], hold.places)
            slope = graph.diff(node, place)
            columns.append((Term(domain, slope, every), column))
            if slope.symbols & moving:
                terms.append((Term(domain, slope * multiplier, every), rest))
                unknowns = [multiplier]
        return Local(domain, [*terms, *columns], len(columns), symbols, unknowns, changes)

    def _local_of_push(self, number: int, push: Push) -> Local:
        """What the series of their directions give."""
        domain = push.domain
        node, symbols, changes = self._series(domain, push.node)
        multiplier = self.slots.symbol(domain, self.multipliers, push.contacts)
        column = Term(domain, node, domain.every), self.directions[number]
        if not node.symbols & union((self.system.time, *symbols)):
            return Local(domain, [column], 1, symbols, [], changes)
        pushed = Term(domain, node * multiplier, push.rows), self.gained
        return Local(domain, [pushed, column], 1, symbols, [multiplier], changes)
