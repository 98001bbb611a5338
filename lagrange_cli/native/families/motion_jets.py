"""The functions that give the series of a system of families, or its rates alone, with those of what is
followed beside the motion."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from lagrange_cli.families.arrays import Array, Total
from lagrange_cli.native.families.articulated import ArticulatedJet
from lagrange_cli.native.families.closed import ClosedJet
from lagrange_cli.native.families.constrained import ConstrainedJet
from lagrange_cli.native.families.corrected import CorrectedJet
from lagrange_cli.native.families.diagonal import DiagonalJet, regular
from lagrange_cli.native.families.evaluation import Evaluation, room
from lagrange_cli.native.families.jets import Jet, SeriesJet
from lagrange_cli.native.families.loops import needed
from lagrange_cli.native.families.preparation import Preparation
from lagrange_cli.native.families.series_places import BESIDE, BRIEF, HEAD, JET
from lagrange_cli.native.families.shared_jets import SharedJet
from lagrange_cli.native.families.spans import Span, in_vectors
from lagrange_cli.native.families.sticking import StickingJet, StickingRates
from lagrange_cli.native.families.strips import Sharing
from lagrange_cli.native.families.vectors import DoubleVectors
from lagrange_cli.native.llvm.function import Function
from lagrange_cli.native.llvm.vector import Bit, Index, Integer, Real
from lagrange_cli.native.motions import RATES
from lagrange_cli.records import replace


class BesideJet(SeriesJet):
    """The series of integrals of ``integrands``, such as the arguments of events: behind the velocities of a
    ``motion`` in its arrays, and after its series, which do not depend on them."""

    tiled = False

    def __init__(self, integrands: Total, motion: SeriesJet, name: str, *given: Any) -> None:
        self.integrands, self.motion, self.local = integrands, motion, motion.local
        super().__init__(*(*given, type(motion.vectors), name))

    def of_state(self) -> dict[Array, tuple[int, int]]:
        self.work = self.motion.work
        given = self.system.q, self.system.v, *self.motion.carried
        return {one: self.motion.planes[one] for one in given}

    def prepared(self) -> Sequence[Total]:
        known = *self.lasting.fixed, *self.motion.carried
        totals = needed([self.integrands], self.slots, known)
        self.arrange(totals)
        return totals

    def write(self) -> Jet:
        f, count = self.f, self.integrands.count
        self.totals = self.prepared()
        self.bounded()
        operations = self.emitter.operations + self.stages()
        last = self.vectors.place(self.at(self.system.v, self.order), self.degrees)
        with f.loop(0, count, tested=False) as i:
            self.vectors.store(self.vectors.zero(1), last, i)
        f.give(self.regular())
        return Jet(f.text(), self.work, operations)

    def accelerate(
        self, evaluation: Evaluation, k: Index, phase: int | None, span: Span | None = None
    ) -> None:
        vectors, divisor = self.vectors, self.vectors.divisor(k, 1)
        values = evaluation.where(self.integrands)
        rows = vectors.place(self.at(self.system.v, k + 1), self.degrees)

        def write(i: Integer, lanes: int) -> None:
            vectors.store_row(vectors.divided(vectors.load_row(values, i, lanes), divisor), rows, i)

        in_vectors(self.f, (self.f.count(0), self.f.count(self.integrands.count)), write)

    def regular(self) -> Bit:
        return Bit(self.f, "true", 1)


class MotionJets(Preparation):
    """``@jet``, and what gives rates where ``@jet`` gives series."""

    def jet(self) -> Jet:
        """``@jet``."""
        if self.order == RATES:
            return self.rates_alone(JET)
        given = self.system, self.lasting, self.places, self.tables, self.layout, self.order
        made = self.coupled(self.order, JET)
        if made is not None:
            return self.with_beside(made, BESIDE, *given)
        if self.scheme:
            return self.with_beside(DiagonalJet(*given, self.kind), BESIDE, *given)
        made = DiagonalJet(*given, self.kind) if self.parts is None else SharedJet(self.parts, *given)
        jet = self.with_beside(made, BESIDE, *given)
        brief = DiagonalJet(*given[:-1], RATES, self.kind, BRIEF).write()
        return replace(jet, text=jet.text + brief.text)

    def rates_alone(self, name: str) -> Jet:
        """A function of that name that gives the rates, without series."""
        made = self.coupled(RATES, name)
        if made is None:
            return self.accelerations(name)
        given = self.system, self.lasting, self.places, self.tables, self.layout, RATES
        return self.with_beside(made, f"{BESIDE}_{name}", *given)

    def coupled(self, order: int, name: str) -> SeriesJet | None:
        """The jet of a system whose accelerations follow from all members together; None if M is diagonal and
        there are no constraints."""
        given = self.system, self.lasting, self.places, self.tables, self.layout, order, self.kind, name
        if self.closure is not None:
            return ClosedJet(self.closure, self.tabled, *given)
        if self.balance is not None:
            return ArticulatedJet(self.balance, *given)
        if self.sticking is not None:
            return (StickingRates if order == RATES else StickingJet)(self.sticking, self.tabled, *given)
        return None if self.motion is None else ConstrainedJet(self.motion, self.tabled, *given)

    def with_beside(self, motion: SeriesJet, name: str, *given: Any) -> Jet:
        """The jet of a motion, and of what is followed beside it, by a function of that name."""
        motion.beside, motion.copied = "" if self.integrands is None else name, not self.concise
        if isinstance(motion, CorrectedJet):
            motion.kept = self.multipliers_beside
        jet = motion.write()
        if self.integrands is None:
            return jet
        further = BesideJet(self.integrands, motion, name, *given)
        further.copied = motion.copied
        beside = further.write()
        return Jet(beside.text + jet.text, beside.work, jet.operations + beside.operations)

    def accelerations(self, name: str) -> Jet:
        """The rates where M is diagonal."""
        f, width = Function(HEAD.format(name, DoubleVectors.times)), self.layout.width
        beside = self.integrands
        work = room(width * (RATES + 1) + self.degrees)
        roots = [self.rates] if beside is None else [self.rates, beside]
        totals = needed(roots, self.slots, self.lasting.fixed)
        at: dict[Array, tuple[str, int]] = {
            self.system.q: ("%state", 0),
            self.system.v: ("%state", self.degrees),
            self.rates: ("%work", width + self.degrees),
        }
        for total in totals:
            if total is not self.rates:
                at[total] = "%work", work
                work += room(total.count)

        def within(f: Function) -> Evaluation:
            arrays = {array: f.place(base, place, "double") for array, (base, place) in at.items()}
            return self.evaluation(DoubleVectors(f), arrays, Real(f, "%t", 1))

        evaluation = within(f)
        if self.parts is not None:
            evaluation = replace(evaluation, share=Sharing(within, self.parts).take)
        evaluation.write(totals)
        if beside is not None:  # whole vectors of accelerations go beyond them
            source, target = evaluation.where(beside), f.place("%work", width + 2 * self.degrees)
            in_vectors(
                f,
                (f.count(0), f.count(beside.count)),
                lambda i, lanes: f.store_row(f.load_row(source, i, lanes), target, i),
            )
        positive = self.system.spec.lagrangian is None
        f.give(regular(f, evaluation.where(self.lasting.masses), self.degrees, positive=positive))
        return Jet(f.text(), work, evaluation.emitter.operations)
