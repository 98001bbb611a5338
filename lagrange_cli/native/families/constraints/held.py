"""Constraints on coordinates that dry friction may hold (see ``families.switching.holding``): equations and
jet.

What friction holds is as if its mass were infinite: with W for 1/M, and 0 of what is held,

    a = W (F + A^T lambda),    A a + c = 0,    so that    A W A^T lambda = -c - A W F.

The force that holds a coordinate is opposite to all others on it, A^T lambda among them. If so much is held
that a constraint follows from others, n A W = 0, these forces are not determined, but what moves is: one of
them is left out, with a multiplier of 0 (``saddle``). It is satisfied if n c = 0 in all orders, as of a rod
between bodies at rest. Else friction cannot hold all that: the multipliers that callers see are far beyond
its limits, along n.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from lagrange_cli.expression.node import Node
from lagrange_cli.families.arrays import Array, Domain, Source, Term, Total
from lagrange_cli.families.description import FamilySystem
from lagrange_cli.native.families.constraints.jet import ConstrainedJet, solve
from lagrange_cli.native.families.constraints.restraint import AlongMotion
from lagrange_cli.native.families.constraints.saddle import Tabled
from lagrange_cli.native.families.evaluation import Evaluation
from lagrange_cli.native.families.lasting import Lasting
from lagrange_cli.native.families.spans import Span
from lagrange_cli.native.families.windows import Windows
from lagrange_cli.native.interface import LANES
from lagrange_cli.native.llvm.vector import Index
from lagrange_cli.native.state import vectors_of

ROUNDED = 16.0
"""Units of rounding of all that is coupled, up to which an acceleration is nothing else."""
LOCKED = 2.0**-40
"""The acceleration, of what a force of 1 to 2 for each mass gives, up to which something is bound."""
SEVERAL, STRIDE = 97, 31
"""So many forces are unlike, which are this far apart."""
MISSED = 2.0**-32
"""The part of all accelerations by which rounding may make a constraint off that is left out."""
BEYOND = 2.0**40
"""How many times as large as all forces those are that friction would have to exert."""


class HeldAlongMotion(AlongMotion):
    """The totals along a motion, in numbers of so many ``parts``."""

    def __init__(self, system: FamilySystem, lasting: Lasting, parts: int) -> None:
        self.rounding = ROUNDED * 2.0 ** (-52 * parts)
        super().__init__(system, lasting)

    def arrange(self) -> None:
        super().arrange()
        self.check()

    def finished(self, rates: Total) -> Total:
        """What is at rest and bound to something that friction holds does not move, not even by rounding
        errors: friction that is at its limit there would follow these. It is what a random force does not
        move (``locked``)."""
        graph, everyone, size = self.graph, self.everyone, self.graph.absolute
        numbers = everyone.every * STRIDE % SEVERAL
        force = 1.0 + self.slots.symbol(everyone, self.system.whole, numbers) / float(SEVERAL)
        probe = Term(everyone, self.of_all(self.gates) * force, everyone.every)
        given = self.lasting.arranged(Total(Source.TOTAL, self.size, (probe,)))
        self.probed = self.of_bounds({b: -self.along(b, given) for b, _ in enumerate(self.bounds)})
        """What multipliers that answer such a force follow from, and the accelerations then."""
        self.answer = self.on_coordinates(self.of_all(given), self.multipliers)
        moves = graph.switch(size(self.of_all(self.answer)) - LOCKED, graph.zero, graph.one, -1)
        still = graph.switch(size(self.of_all(self.system.v)), graph.zero, moves, -1)
        self.locked = self.total(self.size, [Term(everyone, still, everyone.every)])
        pushed = size(self.of_all(self.forces)) * self.of_all(self.lasting.inverses)
        terms = [Term(everyone, pushed, everyone.every)]
        for b, one in enumerate(self.bounds):
            for a, rows in enumerate(one.rows):
                push = self.slots.symbol(one.domain, self.inverses, rows) * self.slope(b, a)
                terms.append(Term(one.domain, size(push * self.own(b, self.multipliers)), rows))
        self.sizes = self.total(self.size, terms)
        """The sizes of the terms of accelerations, and their sums over all that constraints couple."""
        joined = np.array(self.joined)
        self.whole = self.total(self.size, [Term(everyone, self.of_all(self.sizes), joined)])
        found, most = self.of_all(rates), self.slots.symbol(everyone, self.whole, joined)
        less = self.rounding * self.of_all(self.locked) * most - size(found)
        node = graph.switch(less, graph.zero, found, -1)
        return self.total(self.size, [Term(everyone, node, everyone.every)])

    def check(self) -> None:
        """Find out whether all constraints are satisfied."""
        assert self.halts is not None
        graph, slots, size, every = self.graph, self.slots, self.graph.absolute, Domain(self.count)
        changes = {b: -self.along(b, self.final) for b, _ in enumerate(self.bounds)}
        self.off = self.of_bounds(changes, less=self.rest)
        """By how much they are off in an order."""
        other, usual = self.lasting.arranged(self.halts.other, kept=False), dict[int, Node]()
        for b, one in enumerate(self.bounds):
            found = [(graph.zero, 1.0)]
            for a, rows in enumerate(one.rows):
                force, inverse, own = (
                    slots.symbol(one.domain, array, rows)
                    for array in (other, self.lasting.inverses, self.sizes)
                )
                found.append((size(self.slope(b, a)) * (size(force) * inverse + own), 1.0))
            usual[b] = graph.sum(found)
        self.usual = self.of_bounds(usual)
        """How large the terms are that make them up."""
        self.missed = Array(self.off.source, self.count)
        """How far off they are in the first order in which they are."""
        off, terms = (slots.own(every, one) for one in (self.off, self.usual))
        known, most = slots.own(every, self.missed), MISSED * terms
        first = graph.switch(size(off) - most, graph.switch(off, BEYOND, -BEYOND, -1) * (size(off) + terms),
                             graph.zero, -1)  # fmt: skip
        node = graph.switch(size(known), graph.zero, first, -1)
        self.newly = self.total(self.count, [Term(every, node, every.every)])
        whole = slots.symbol(every, self.square, len(self.entries) + 2 + every.every)
        self.beyond = self.total(self.count, [Term(every, known / size(whole), every.every)])

    @property
    def arrays(self) -> Sequence[Array]:
        found = [self.probed, self.answer, self.locked, self.sizes, self.whole]
        return [*super().arrays, *found, self.off, self.usual, self.missed, self.newly, self.beyond]


class HeldJet(ConstrainedJet):
    """The jet of such a system."""

    motion: HeldAlongMotion
    saddle: Tabled

    def factor(self, evaluation: Evaluation) -> None:
        super().factor(evaluation)
        evaluation.clear([self.motion.missed])
        motion = self.motion
        evaluation.write([motion.probed])
        solve(self.saddle, self.at(motion.probed, 0), self.at(motion.multipliers, 0), zeroed=True)
        evaluation.write([motion.answer])
        evaluation.write([motion.locked])

    def finish(self, evaluation: Evaluation) -> None:
        evaluation.write([self.motion.sizes])
        evaluation.write([self.motion.whole])
        super().finish(evaluation)

    def accelerate(
        self, evaluation: Evaluation, k: Index, phase: int | None, span: Span | None = None
    ) -> None:
        super().accelerate(evaluation, k, phase, span)
        motion = self.motion
        if self.kept is not None:
            with self.f.when(self.saddle.left_out.get()):
                for one in (motion.off, motion.usual, motion.newly):
                    evaluation.write([one])
                self._add(motion.newly, motion.missed)

    def stages(self, windows: Windows | None = None) -> int:
        operations = super().stages(windows)
        motion = self.motion
        if self.kept is not None:
            with self.f.when(self.saddle.left_out.get()):
                self.evaluation(0).write([motion.beyond])
                self.saddle.release()
                solve(self.saddle, self.at(motion.beyond, 0), self.at(motion.multipliers, 0), zeroed=True)
                self._add(motion.multipliers, self.kept)
        return operations

    def _add(self, source: Array, target: Array) -> None:
        vectors, f = self.vectors, self.f
        given, to = (self.at(one, 0) for one in (source, target))
        with f.loop(0, vectors_of(source.count), tested=False) as b:
            one, other = (vectors.operand(vectors.load_row(each, b * LANES, LANES)) for each in (given, to))
            vectors.store_row(vectors.number(vectors.kind.add(one, other)), to, b * LANES)
