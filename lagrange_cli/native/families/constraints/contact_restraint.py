"""Constraints and resting contacts together, as totals (see ``families.impacts.coupled``).

With S for 1 of constraints and of contacts that hold, and 0 of others,

    M a = F + A^T lambda,    S (A a + c) = 0,    (1 - S) lambda = 0,

so that (S A M^-1 A^T S + 1 - S) lambda = -S (c + A M^-1 F).
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from lagrange_cli.expression.index_arrays import Places
from lagrange_cli.expression.node import Node
from lagrange_cli.families.arrays import Array, Domain, Source, Term, Total
from lagrange_cli.families.bonds import Bonds, Bound
from lagrange_cli.families.contacts import Coupled
from lagrange_cli.families.description import FamilySystem
from lagrange_cli.native.families.constraints.restraint import AlongMotion
from lagrange_cli.native.families.lasting import Lasting


class ContactRestraint(AlongMotion):
    """The totals of both along a motion."""

    def __init__(self, system: FamilySystem, lasting: Lasting) -> None:
        assert isinstance(system.contact, Coupled)
        self.contact = system.contact
        slots, graph, fixed, count = system.slots, system.slots.graph, self.contact.fixed, self.contact.count
        each = Domain(count)
        mode = slots.own(each, self.contact.signs)
        gates = [Term(each, mode * mode, fixed + each.every)]
        gates += [Term(Domain(fixed), graph.one, np.arange(fixed))] if fixed else []
        whole = Total(system.forces.source, fixed + count, tuple(gates))
        self.gates: Array = lasting.arranged(whole)
        self.solving = Array(Source.TOTAL, 0)
        """What solves for multipliers, where it has a place of its own."""
        super().__init__(system, lasting)

    def bonds_of(self, system: FamilySystem) -> Bonds:
        return self.contact.bonds

    def sides_of(self, right: Total) -> Sequence[Total]:
        domain = Domain(self.count)
        push = self.slots.own(domain, self.gates) * self.slots.own(domain, right)
        return [right, self.total(self.count, [Term(domain, push, domain.every)])]

    def finished(self, rates: Total) -> Total:
        """Coordinates that rest alone have no acceleration, not even a rounding error."""
        rows = [one.rows[0] for one in self.bounds if self._alone(one)]
        numbers = [one.numbers for one in self.bounds if self._alone(one)]
        if not rows:
            return rates
        terms = [Term(self.everyone, self.of_all(rates), self.everyone.every)]
        for some, own in zip(rows, numbers):
            domain = Domain(len(some))
            rest = self.slots.symbol(domain, self.gates, own) * self.slots.symbol(domain, rates, some)
            terms.append(Term(domain, -rest, some))
        return self.total(self.size, terms)

    def _alone(self, bound: Bound) -> bool:
        """Whether contacts depend on one coordinate each, linearly, and on nothing else that moves."""
        if bound.numbers[0] < self.contact.fixed or len(bound.rows) != 1:
            return False
        moving = self.system.time.symbols | self.slots.symbols_of(self.system.q)
        return not (bound.slopes[0].symbols & moving or bound.node.symbols & self.system.time.symbols)

    def hold(self, domain: Domain, first: Places, second: Places) -> Node:
        one: Node = self.slots.symbol(domain, self.gates, first)
        return one if np.array_equal(first, second) else one * self.slots.symbol(domain, self.gates, second)

    def loose(self, domain: Domain) -> Node | None:
        return 1.0 - self.slots.own(domain, self.gates)

    def _square(self) -> Total:
        return self.total(0, []) if self.bonds.elimination is None else super()._square()
