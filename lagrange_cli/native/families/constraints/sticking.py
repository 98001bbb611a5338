"""The forces of friction that hold members to each other, and ``@jet`` of systems with them.

With A for the slopes of relative velocities by those of coordinates, and S for 1 where members stick and 0
where they slip,

    M a = F + A^T f,    S A a = 0,    (1 - S) f = 0,    so that    (S A M^-1 A^T S + 1 - S) f = -S A M^-1 F.

M and A are constant: every order of f follows from the same order of F. Accelerations take only the forces
on members that do not move as one (``anchoring``).
"""

from __future__ import annotations

from collections.abc import Sequence

from lagrange_cli.expression.node import Node
from lagrange_cli.families.arrays import Array, Domain, Source, Term, Total
from lagrange_cli.families.bonds import Bound
from lagrange_cli.families.description import FamilySystem
from lagrange_cli.native.families.constraints.anchoring import PAIR, Anchoring, AnchorLoops, Rubbing
from lagrange_cli.native.families.constraints.dense import SolvingTables
from lagrange_cli.native.families.constraints.jet import saddle_of, solve
from lagrange_cli.native.families.constraints.restraint import Restraint
from lagrange_cli.native.families.diagonal import DiagonalJet, RatesInRows
from lagrange_cli.native.families.evaluation import Evaluation, room
from lagrange_cli.native.families.lasting import Lasting
from lagrange_cli.native.families.series_places import JetSetting
from lagrange_cli.native.families.spans import Span
from lagrange_cli.native.interface import LANES
from lagrange_cli.native.llvm.vector import Bit, Index, Pointer
from lagrange_cli.native.state import whole_vectors


class Sticking(Rubbing, Restraint):
    """The totals of these forces: ``right`` side, and the ``whole`` force on each coordinate, without those
    between members that move as one."""

    def __init__(self, system: FamilySystem, lasting: Lasting) -> None:
        super().__init__(system, lasting)
        self.multipliers = self.bonds.multipliers
        assert self.modes.loose is not None
        self.forces = lasting.arranged(self.modes.loose, kept=False)
        self.free = self.pushed(self.forces)
        held = {b: self.hold(one.domain, one.numbers, one.numbers) for b, one in enumerate(self.bounds)}
        self.right = self.of_bounds({b: -stuck * self.along(b, self.free) for b, stuck in held.items()})
        terms = [Term(self.everyone, self.of_all(self.forces), self.everyone.every)]
        for b, one in enumerate(self.bounds):
            if len(one.rows) > PAIR:
                force = self.own(b, self.multipliers)
                terms += [Term(one.domain, self.slope(b, a) * force, rows) for a, rows in enumerate(one.rows)]
        self.whole = self.total(self.size, terms)
        self.anchoring = Anchoring(self)

    def column(self, bound: Bound, slope: Node) -> Array:
        return self.lasting_column(bound.domain, slope)

    def loose(self, domain: Domain) -> Node | None:
        return self.slips(domain, domain.every)


class StickingJet(DiagonalJet):
    """The jet of a system with such forces."""

    tiled = False

    def __init__(self, sticking: Sticking, tabled: SolvingTables, setting: JetSetting, name: str) -> None:
        super().__init__(setting, name)
        self.sticking, self.tabled = sticking, tabled
        self.gathered = Array(Source.TOTAL, self.degrees), Array(Source.TOTAL, self.degrees)

    @property
    def forces(self) -> Total:
        return self.sticking.forces

    @property
    def masses(self) -> Sequence[Array]:
        """With those of all that is held added to what holds it."""
        return self.gathered

    @property
    def carried(self) -> Sequence[Array]:
        return [self.sticking.multipliers]

    def prepared(self) -> Sequence[Total]:
        totals, sticking = super().prepared(), self.sticking
        for array in (sticking.square, sticking.free, sticking.right, sticking.whole):
            self.planes[array] = self.take(room(array.count)), 0
        step = room(sticking.count)
        for gathered in self.gathered:
            self.planes[gathered] = self.take(room(gathered.count)), 0
        self.planes[sticking.multipliers] = self.take(step * (self.order + 1)), step
        self.saddle = saddle_of(self.vectors, self.tabled, "%work", self.work)
        self.take(room(self.tabled.size))
        self.listed = self.take(room(sticking.count + 1))
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
            self.gather_masses()
        evaluation.write([sticking.free])
        evaluation.write([sticking.right])
        solve(self.saddle, self.at(sticking.right, 0), self.at(sticking.multipliers, k), zeroed=True)
        evaluation.write([sticking.whole])
        self.anchored.gather(self.at(sticking.whole, 0))
        super().accelerate(evaluation, k, phase, span)

    @property
    def anchored(self) -> AnchorLoops:
        given = self.sticking.anchoring, self.vectors, self.tables
        return AnchorLoops(*given, lambda one: self.at(one, 0), self.f.place("%work", self.listed, "i64"))

    def gather_masses(self) -> None:
        masses, inverses = (self.at(one, 0) for one in self.gathered)
        self.copy(self.at(self.lasting.masses, 0), masses, self.degrees)
        self.anchored.list()
        self.anchored.gather(masses, 2)
        f, vectors, kind = self.f, self.vectors, self.vectors.kind
        with f.loop(0, whole_vectors(self.degrees), LANES, tested=False) as i:
            inverse = kind.div(kind.one, vectors.operand(vectors.load_row(masses, i, LANES)))
            vectors.store_row(vectors.number(inverse), inverses, i)

    def bind(self, velocities: Pointer) -> None:
        self.anchored.spread(velocities)

    def regular(self) -> Bit:
        return super().regular() & self.sound


class StickingRates(RatesInRows, StickingJet):
    """The same without series, in rows as of the state."""
