"""Resting contacts of chains, trees and rigid bodies, as totals beside those of ``balance`` (see
``families.joint_contacts``).

With b for the accelerations that all other forces give, accelerations are a = b + u, where u = sum N d, and
N follows from dg/dq a + c = 0 of the contacts that hold; it is 0 of all others. The equations of motion are
those of b, in which J q_ddot is J (a - u). So the sweeps find b, and what u moves is added to it.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from lagrange_cli.expression.node import Node, union
from lagrange_cli.families.arrays import NONE, Array, Domain, Term, Total
from lagrange_cli.families.bonds import Bonds, Bound
from lagrange_cli.families.contacts import Coupled, Push
from lagrange_cli.families.description import FamilySystem
from lagrange_cli.native.families.corrected import Local, in_series
from lagrange_cli.native.families.lasting import Lasting
from lagrange_cli.native.families.node_arrays import array
from lagrange_cli.native.families.restraint import Bonded

if TYPE_CHECKING:
    from lagrange_cli.expression.index_arrays import Places
    from lagrange_cli.native.families.balance import Balance


class JointContacts(Bonded):
    """The totals of the contacts of a system, whose ``balance`` has all other forces."""

    def __init__(self, system: FamilySystem, lasting: Lasting, balance: Balance) -> None:
        assert isinstance(system.contact, Coupled)
        self.contact = system.contact
        super().__init__(system, lasting)
        self.balance, self.pushes = balance, self.contact.pushes
        self.slopes = [[array(one.domain.count) for _ in one.slopes] for one in self.bounds]
        """dg/dq."""
        self.directions = [array(one.domain.count) for one in self.pushes]
        """d."""
        self.gained = array(self.size)
        """u without what is newest in N."""
        self.jolts = [array(balance.count) for _ in balance.axes]
        """J u of nodes, likewise."""
        self.pairs, terms = self._coupled()
        """The contacts (2, entries) of each entry of dg/dq d, by what is moved and by what pushes."""
        self.square = self.total(self.pairs.shape[1], terms)
        """These entries."""
        every = np.arange(self.size)
        everyone = Domain(self.size)
        rates, gained = (self.slots.symbol(everyone, one, every) for one in (balance.rates, self.gained))
        self.known = self.total(self.size, [Term(everyone, rates + gained, every)])
        """a without the newest N."""
        self.right = self._right()
        self.divided = self._divided() if self.alone else None
        if self.divided is not None:
            self.multipliers = self.divided
        self.left = self._left()
        """What N leaves of the right side."""
        self.pushed = self._pushed()
        """u."""
        self.rates = self._rates()
        """a."""
        self.moved = [self._moved(c) for c in balance.axes]
        """J u of nodes."""
        self.series = [self._local_of_bound(b, one) for b, one in enumerate(self.bounds)]
        self.series += [self._local_of_push(p, one) for p, one in enumerate(self.pushes)]

    def bonds_of(self, system: FamilySystem) -> Bonds:
        return self.contact.bonds

    @property
    def in_order(self) -> Sequence[Array]:
        """What series give in every order."""
        return [self.rest, self.gained, *self.jolts]

    @property
    def in_first(self) -> Sequence[Array]:
        """What they give in order 0."""
        return [*(one for some in self.slopes for one in some), *self.directions]

    @property
    def arrays(self) -> Sequence[Array]:
        """All that are computed."""
        own = [
            self.square,
            self.known,
            self.right,
            self.left,
            self.multipliers,
            self.pushed,
            self.rates,
            *self.moved,
        ]
        return [*self.in_order, *self.in_first, *own]

    @cached_property
    def alone(self) -> bool:
        """Whether no contact pushes what another one is at."""
        number = np.arange(self.count)
        return all(np.array_equal(one, number) for one in self.pairs)

    def gate(self, domain: Domain, contacts: Places) -> Node:
        """1 of contacts that hold, and 0 of others."""
        mode = self.slots.symbol(domain, self.contact.signs, contacts)
        return mode * mode

    def own(self, domain: Domain, one: Array) -> Node:
        """An array of the members of a domain."""
        return self.slots.symbol(domain, one, np.arange(domain.count))

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
        keys = np.unique(np.concatenate([one for _, _, one in found]))
        terms = [Term(domain, node, np.searchsorted(keys, one)) for domain, node, one in found]
        return np.stack(np.divmod(keys, self.count)), terms

    def _right(self) -> Total:
        """What N follows from, of the contacts that hold."""
        terms = []
        for bound, slopes in zip(self.bounds, self.slopes):
            parts = [
                (self.own(bound.domain, slope) * self.slots.symbol(bound.domain, self.known, rows), 1.0)
                for slope, rows in zip(slopes, bound.rows)
            ]
            gate = self.gate(bound.domain, bound.numbers)
            terms.append(Term(bound.domain, -(gate * self.graph.sum(parts)), bound.numbers))
        each, numbers = Domain(self.count), np.arange(self.count)
        rest = self.gate(each, numbers) * self.own(each, self.rest)
        return self.total(self.count, [*terms, Term(each, -rest, numbers)])

    def _divided(self) -> Total:
        """N, each of its own."""
        each = Domain(self.count)
        node = self.own(each, self.right) / self.own(each, self.square)
        return self.total(self.count, [Term(each, node, np.arange(self.count))])

    def _left(self) -> Total:
        each, entries = Domain(self.count), Domain(self.pairs.shape[1])
        row, column = self.pairs
        multiplier = self.slots.symbol(entries, self.multipliers, column)
        product = self.own(entries, self.square) * multiplier * self.gate(entries, row)
        terms = [Term(each, self.own(each, self.right), np.arange(self.count))]
        return self.total(self.count, [*terms, Term(entries, -product, row)])

    def _pushed(self) -> Total:
        everyone, every = Domain(self.size), np.arange(self.size)
        terms = [Term(everyone, self.own(everyone, self.gained), every)]
        for push, direction in zip(self.pushes, self.directions):
            multiplier = self.slots.symbol(push.domain, self.multipliers, push.contacts)
            terms.append(Term(push.domain, self.own(push.domain, direction) * multiplier, push.rows))
        return self.total(self.size, terms)

    def _rates(self) -> Total:
        """Coordinates that rest alone have no acceleration, not even a rounding error."""
        everyone, every = Domain(self.size), np.arange(self.size)
        rates = self.own(everyone, self.balance.rates) + self.own(everyone, self.pushed)
        before, terms = np.full(self.size, NONE), []
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
                whole = self.slots.symbol(domain, self.balance.rates, at)
                whole = whole + self.slots.symbol(domain, self.pushed, at)
                terms.append(Term(domain, -(held * whole), at))
        return self.total(self.size, [Term(everyone, rates, every), *terms])

    def _still(self, bound: Bound) -> bool:
        """Whether what contacts are at is a coordinate each that does not move there."""
        moving = self.system.time.symbols | self.slots.symbols_of(self.system.q)
        fixed = not (bound.node.symbols & self.system.time.symbols)
        return len(bound.rows) == 1 and fixed and not bound.slopes[0].symbols & moving

    def _moved(self, c: int) -> Total:
        """What u adds to a component of nodes beside their parents."""
        terms = []
        for kind in self.balance.kinds:
            if kind.is_node:
                parts = [(kind.node(self.jolts[c]), 1.0)]
                for b in kind.bends:
                    slope = kind.whole_slope(c, b)
                    pushed = self.slots.symbol(kind.domain, self.pushed, kind.joints.rows[b])
                    parts.append((slope * pushed, 1.0))
                terms.append(Term(kind.domain, self.graph.sum(parts), kind.at))
        return self.total(self.balance.count, terms)

    def _series(self, domain: Domain, node: Node) -> tuple[Node, list[Node], list[Node]]:
        """An expression of coordinates, these, and their accelerations."""
        (one,) = self.total(domain.count, [Term(domain, node, np.arange(domain.count))]).terms
        found, places = in_series(self.slots, one.node, domain, {self.system.v: self.system.q})
        changes = [self.slots.symbol(domain, self.rates, slot.table) for slot in places.values()]
        return found, [*places], changes

    def _local_of_bound(self, number: int, bound: Bound) -> Local:
        """What the series of contacts give."""
        graph, domain = self.graph, bound.domain
        node, symbols, changes = self._series(domain, bound.node)
        every = np.arange(domain.count)
        terms = [(Term(domain, graph.ddt(graph.ddt(node)), bound.numbers), self.rest)]
        columns = [
            (Term(domain, graph.diff(node, symbol), every), column)
            for symbol, column in zip(bound.symbols, self.slopes[number])
        ]
        return Local(domain, [*terms, *columns], len(columns), symbols, [], changes)

    def _local_of_push(self, number: int, push: Push) -> Local:
        """What the series of their directions give."""
        domain = push.domain
        node, symbols, changes = self._series(domain, push.node)
        multiplier = self.slots.symbol(domain, self.multipliers, push.contacts)
        column = Term(domain, node, np.arange(domain.count)), self.directions[number]
        if not node.symbols & union((self.system.time, *symbols)):
            return Local(domain, [column], 1, symbols, [], changes)
        pushed = Term(domain, node * multiplier, push.rows), self.gained
        return Local(domain, [pushed, column], 1, symbols, [multiplier], changes)


def met(rows: Places, others: Places) -> tuple[Places, Places]:
    """All pairs of places at which two tables have the same number."""
    order = np.argsort(others, kind="stable")
    left, right = (np.searchsorted(others[order], rows, side) for side in ("left", "right"))
    counts = right - left
    first = np.repeat(np.arange(len(rows)), counts)
    within = np.arange(len(first)) - np.repeat(np.cumsum(counts) - counts, counts)
    return first, order[np.repeat(left, counts) + within]
