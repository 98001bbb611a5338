"""Constraints and resting contacts together (see ``families.impacts.coupled``): equations and jet.

With S for 1 of constraints and of contacts that hold, and 0 of others,

    M a = F + A^T lambda,    S (A a + c) = 0,    (1 - S) lambda = 0,

so that (S A M^-1 A^T S + 1 - S) lambda = -S (c + A M^-1 F). While no contact holds, series are those of other
forces alone: nothing is computed of contacts. What solves for forces is not among the arrays that callers
clear, as only a few contacts of many hold at a time.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from lagrange_cli.expression.index_arrays import Places
from lagrange_cli.expression.node import Node
from lagrange_cli.families.arrays import Array, Domain, Source, Term, Total
from lagrange_cli.families.bonds import Bonds, Bound, CoupledMembers
from lagrange_cli.families.contacts import Coupled
from lagrange_cli.families.description import FamilySystem
from lagrange_cli.native.families.constraints.dense import Dense, DenseTables
from lagrange_cli.native.families.constraints.jet import ConstrainedJet
from lagrange_cli.native.families.constraints.restraint import AlongMotion
from lagrange_cli.native.families.evaluation import Evaluation, room
from lagrange_cli.native.families.lasting import Lasting
from lagrange_cli.native.families.tables import place_at
from lagrange_cli.native.llvm.flow import Variable
from lagrange_cli.native.llvm.vector import Bit, Index, Integer
from lagrange_cli.native.state import whole_vectors


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
        alone = not self.bonds.surplus and self.bonds.elimination is None
        return self.total(0, []) if alone else super()._square()


class HeldDense(Dense):
    """What solves for them, and for the multipliers of constraints."""

    def factor_held(self, motion: ContactRestraint, evaluation: Evaluation, regular: Variable[Bit]) -> None:
        """L and D of those that hold, and whether they are regular."""
        f, vectors = self.f, self.vectors
        self._list_held(motion, evaluation)
        number = self._number
        width = self.begin(number)
        self.clear("alone", f.count(whole_vectors(self.tabled.count)))
        for pair in motion.bonds.pairs[0]:
            self._add(motion, evaluation, pair, number, width)
        with f.loop(0, number) as k:
            vectors.store(vectors.load(self.row(k, width), k), self.place("diagonal"), k)
        self.eliminate(number, width, regular)

    def _list_held(self, motion: ContactRestraint, evaluation: Evaluation) -> None:
        f, order, listed = self.f, self.integers("order"), self.integers("listed")
        modes, fixed, number = evaluation.where(motion.contact.signs), motion.contact.fixed, f.count(0)
        if fixed:
            with f.loop(0, fixed, tested=False) as i:
                f.store(i, order, i)
                f.store(i, listed, i)
        found = f.variable(number + fixed)
        with f.loop(0, motion.contact.count, tested=False) as i:
            f.store(f.count(self.tabled.count), order, i + fixed)
            with f.when(~self.vectors.high(self.vectors.load(modes, i)).equals(0.0)):
                f.store(found.get(), order, i + fixed)
                f.store(i + fixed, listed, found.get())
                found.set(found.get() + 1)
        f.store(found.get(), self.integers("number"))

    def _add(
        self, motion: ContactRestraint, evaluation: Evaluation, pair: CoupledMembers, number: Integer,
        width: Integer,
    ) -> None:  # fmt: skip
        """The products of two slopes of those that hold."""
        f, vectors, order = self.f, self.vectors, self.integers("order")
        slots = pair.first, pair.second
        both = [motion.bounds[b].numbers[some] for (b, _), some in zip(slots, pair.members)]
        each = np.arange(self.tabled.count)
        first = np.argsort(both[0], kind="stable")
        numbers = both[0][first]
        begin, end = (np.searchsorted(numbers, each, side) for side in ("left", "right"))
        listed = begin, end, both[1][first], pair.rows[first], *(some[first] for some in pair.members)
        begins, ends, others, rows, *members = map(self.tables.of_array, listed)
        slopes = [evaluation.where(motion.slopes[b][a]) for b, a in slots]
        inverses = evaluation.where(motion.lasting.inverses)
        with f.loop(0, number) as k:
            i = self._listed(k)
            with f.loop(place_at(f, i + begins), place_at(f, i + ends)) as t:
                other = f.load_integer(order, place_at(f, t + others))
                with f.when(other < self.tabled.count):
                    value = self.everywhere(vectors.load(inverses, place_at(f, t + rows)))
                    for slope, member in zip(slopes, members):
                        one = vectors.load(slope, place_at(f, t + member))
                        value = vectors.kind.mul(value, self.everywhere(one))
                    place = self.place("matrix", other * width + k)
                    total = vectors.kind.add(value, self.everywhere(vectors.load(place)))
                    vectors.store(vectors.lane(vectors.number(total), 0), place)


class ContactJet(ConstrainedJet):
    """The jet of such a system."""

    motion: ContactRestraint
    held: Bit
    """Whether anything holds members."""

    def place_saddle(self) -> None:
        own, tabled = self.places.get(self.motion.solving), self.tabled
        if not isinstance(tabled, DenseTables):
            super().place_saddle()
        elif own is not None:
            self.saddle = HeldDense(self.vectors, tabled, own, 0)
        else:
            self.saddle = HeldDense(self.vectors, tabled, "%work", self.take(room(tabled.size)))

    def factor(self, evaluation: Evaluation) -> None:
        if isinstance(self.saddle, HeldDense):
            self.saddle.factor_held(self.motion, evaluation, self.sound)
        else:
            super().factor(evaluation)

    def begin(self) -> None:
        f, vectors, motion = self.f, self.vectors, self.motion
        held: Variable[Bit] = f.variable(Bit(f, "true" if motion.contact.fixed else "false", 1))
        if not motion.contact.fixed:
            modes = self.at(motion.contact.signs, 0)
            with f.loop(0, motion.contact.count, tested=False) as i:
                held.set(held.get() | ~vectors.high(vectors.load(modes, i)).equals(0.0))
        self.held = held.get()
        with f.when(self.held):
            super().begin()
        with f.otherwise():
            self.evaluation(0).clear([motion.multipliers])

    def begin_sums(self, k: Integer) -> None:
        self.begin_those(self.loops, k)
        with self.f.when(self.held):
            self.begin_those(self.members, k)

    def force(self, evaluation: Evaluation, k: Index, phase: int | None) -> None:
        with self.f.when(self.held):
            super().force(evaluation, k, phase)
        with self.f.otherwise():
            evaluation.write([self.motion.free])
            self.finish(evaluation)
