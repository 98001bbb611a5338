"""The forces of friction that hold members to each other, and ``@jet`` of systems with them.

With A for the slopes of relative velocities by those of coordinates, and S for 1 where members stick and 0
where they slip,

    M a = F + A^T f,    S A a = 0,    (1 - S) f = 0,    so that    (S A M^-1 A^T S + 1 - S) f = -S A M^-1 F.

M and A are constant: every order of f follows from the same order of F.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from lagrange_cli.expression.index_arrays import Places
from lagrange_cli.expression.node import Node
from lagrange_cli.families.arrays import Array, Domain, Source, Term, Total
from lagrange_cli.families.bonds import Bonds, Bound
from lagrange_cli.families.description import FamilySystem
from lagrange_cli.families.friction import gate
from lagrange_cli.native.families.constrained import saddle_of, solve
from lagrange_cli.native.families.dense import SolvingTables
from lagrange_cli.native.families.diagonal import DiagonalJet
from lagrange_cli.native.families.evaluation import Evaluation, room
from lagrange_cli.native.families.lasting import Lasting
from lagrange_cli.native.families.restraint import Restraint
from lagrange_cli.native.families.series_places import JetSetting
from lagrange_cli.native.families.spans import Span
from lagrange_cli.native.llvm.vector import Bit, Index, Pointer


class Sticking(Restraint):
    """The totals of these forces: ``right`` side, and the ``whole`` force on each coordinate."""

    def __init__(self, system: FamilySystem, lasting: Lasting) -> None:
        super().__init__(system, lasting)
        self.multipliers = self.bonds.multipliers
        assert self.modes.loose is not None
        self.forces = lasting.arranged(self.modes.loose, kept=False)
        self.free = self.pushed(self.forces)
        held = {b: self.hold(one.domain, one.numbers, one.numbers) for b, one in enumerate(self.bounds)}
        self.right = self.of_bounds({b: -stuck * self.along(b, self.free) for b, stuck in held.items()})
        terms = [Term(self.everyone, self.of_all(self.forces), np.arange(self.size))]
        for b, one in enumerate(self.bounds):
            force = self.own(b, self.multipliers)
            terms += [Term(one.domain, self.slope(b, a) * force, rows) for a, rows in enumerate(one.rows)]
        self.whole = self.total(self.size, terms)

    def bonds_of(self, system: FamilySystem) -> Bonds:
        assert system.modes is not None and system.modes.sticking is not None
        self.modes = system.modes
        return system.modes.sticking

    def column(self, bound: Bound, slope: Node) -> Array:
        every = np.arange(bound.domain.count)
        return self.lasting.arranged(Total(Source.TOTAL, len(every), (Term(bound.domain, slope, every),)))

    def slips(self, domain: Domain, numbers: Places) -> Node:
        """1 where a mode is not 0."""
        return gate(self.slots, domain, self.modes.signs, self.modes.holding[numbers])

    def hold(self, domain: Domain, first: Places, second: Places) -> Node:
        stuck: Node = 1.0 - self.slips(domain, first)
        return stuck if np.array_equal(first, second) else stuck * (1.0 - self.slips(domain, second))

    def square_terms(self) -> list[Term]:
        numbers = np.arange(self.count)
        domain = Domain(self.count)
        places = np.array([self.entries[i, i] for i in range(self.count)])
        return [*super().square_terms(), Term(domain, self.slips(domain, numbers), places)]


class StickingJet(DiagonalJet):
    """The jet of a system with such forces."""

    tiled = False

    def __init__(self, sticking: Sticking, tabled: SolvingTables, setting: JetSetting, name: str) -> None:
        super().__init__(setting, name)
        self.sticking, self.tabled = sticking, tabled

    @property
    def forces(self) -> Total:
        return self.sticking.forces

    @property
    def carried(self) -> Sequence[Array]:
        return [self.sticking.multipliers]

    def prepared(self) -> Sequence[Total]:
        totals, sticking = super().prepared(), self.sticking
        for array in (sticking.square, sticking.free, sticking.right, sticking.whole):
            self.planes[array] = self.take(room(array.count)), 0
        step = room(sticking.count)
        self.planes[sticking.multipliers] = self.take(step * (self.order + 1)), step
        self.saddle = saddle_of(self.vectors, self.tabled, "%work", self.work)
        self.take(room(self.tabled.size))
        self.whole = sticking.whole
        return totals

    def accelerate(
        self, evaluation: Evaluation, k: Index, phase: int | None, span: Span | None = None
    ) -> None:
        sticking = self.sticking
        if isinstance(k, int) and k == 0:
            evaluation.write([sticking.square])
            regular = self.f.variable(Bit(self.f, "true", 1))
            self.saddle.factor(self.at(sticking.square, 0), sticking.placed(self.tabled), regular)
            self.sound = regular.get()
        evaluation.write([sticking.free])
        evaluation.write([sticking.right])
        solve(self.saddle, self.at(sticking.right, 0), self.at(sticking.multipliers, k), zeroed=True)
        evaluation.write([sticking.whole])
        super().accelerate(evaluation, k, phase, span)

    def regular(self) -> Bit:
        return super().regular() & self.sound


class StickingRates(StickingJet):
    """The same without series, in rows as of the state."""

    local = False

    def follow(self, k: Index, source: Pointer, target: Pointer, count: int) -> None:
        if k == 0:
            super().follow(k, source, target, count)
