"""The functions that give the series of a system of families, or its rates alone, with those of what is
followed beside the motion."""

from __future__ import annotations

import math

from lagrange_cli.families.arrays import Array, Chain
from lagrange_cli.native.families.acting import ActingLists
from lagrange_cli.native.families.beside import BesideJet
from lagrange_cli.native.families.constraints.contacts import ContactJet, ContactRestraint
from lagrange_cli.native.families.constraints.coupled_masses import CoupledMassesJet, CoupledMassesRates
from lagrange_cli.native.families.constraints.held import HeldAlongMotion, HeldJet
from lagrange_cli.native.families.constraints.jet import ConstrainedJet
from lagrange_cli.native.families.constraints.restraint import AlongMotion
from lagrange_cli.native.families.constraints.sticking import StickingJet, StickingRates
from lagrange_cli.native.families.constraints.together import TogetherAlongMotion
from lagrange_cli.native.families.constraints.together_jet import TogetherJet
from lagrange_cli.native.families.corrected import CorrectedJet
from lagrange_cli.native.families.diagonal import DiagonalJet, regular
from lagrange_cli.native.families.evaluation import Evaluation, room
from lagrange_cli.native.families.jets import Jet, SeriesJet
from lagrange_cli.native.families.joints.articulated import ArticulatedJet
from lagrange_cli.native.families.joints.closed import ClosedJet
from lagrange_cli.native.families.joints.sticking import StickingClosure, StickingJointsJet
from lagrange_cli.native.families.loops import Loop, loops, needed
from lagrange_cli.native.families.near_lists import ListJet, suits
from lagrange_cli.native.families.nearness import NearJet, Watch, enclosed
from lagrange_cli.native.families.preparation import Preparation
from lagrange_cli.native.families.series_places import AT_ONCE, BESIDE, BRIEF, HEAD, JET, MOTION
from lagrange_cli.native.families.shared_work import SharedJet
from lagrange_cli.native.families.spans import in_vectors
from lagrange_cli.native.families.strips import Sharing
from lagrange_cli.native.families.vectors import DoubleVectors
from lagrange_cli.native.guards import FOUND
from lagrange_cli.native.llvm.function import Function
from lagrange_cli.native.llvm.vector import Bit, Real
from lagrange_cli.native.motions import RATES
from lagrange_cli.records import replace

MANY = 256
"""Contacts and constraints from which on a function for a few coefficients pays, although its code takes time
to compile."""


class MotionJets(Preparation):
    """``@jet``, and what gives rates where ``@jet`` gives series."""

    def jet(self, watch: Watch | None) -> Jet:
        """``@jet``; steps ``watch`` guards, if there are any."""
        if self.order == RATES:
            return self.rates_alone(JET)
        made, setting = self.coupled(self.order, JET), self.setting(self.order)
        if made is not None:
            return self.with_short(self.with_beside(made, BESIDE))
        if self.scheme:
            return self.with_beside(self.by_masses(self.order, JET), BESIDE)
        watch = watch if self.looks(watch) else None
        own = JET if watch is None else MOTION
        made = self.by_masses(self.order, own)
        if self.parts is not None and self.factors is None:
            made = SharedJet(self.parts, setting, own)
        jet = self.with_beside(made, BESIDE) if watch is None else self.with_near(made, watch)
        return self.with_short(replace(jet, text=jet.text + self.by_masses(RATES, BRIEF).write().text))

    def with_short(self, jet: Jet) -> Jet:
        """The jet, and the function for single states, if there is one."""
        if not self.looked_at:
            return jet
        made = self.coupled(FOUND, AT_ONCE) or self.by_masses(FOUND, AT_ONCE)
        short = self.with_beside(made, f"{BESIDE}_{AT_ONCE}")
        work = max(jet.work, short.work)
        return replace(jet, text=jet.text + short.text, work=work, single=short.work)

    def by_masses(self, order: int, name: str) -> DiagonalJet:
        """The jet of a system whose accelerations follow from forces and a constant M."""
        given = self.setting(order), name
        return DiagonalJet(*given) if self.factors is None else CoupledMassesJet(self.factors, *given)

    @property
    def looked_at(self) -> bool:
        """Whether callers look at a few derivatives at single states, where switches change: a function,
        ``AT_ONCE``, computes no more coefficients than these."""
        plain = self.order > FOUND and not self.scheme and self.kind is DoubleVectors
        mixed = self.closure or self.balance or self.sticking or self.motion
        many = isinstance(self.motion, ContactRestraint) and self.motion.count >= MANY
        return plain and (many or (not mixed and self.modes is not None))

    def rates_alone(self, name: str) -> Jet:
        """A function of that name that gives the rates, without series."""
        made = self.coupled(RATES, name)
        if made is None and self.factors is not None:
            made = CoupledMassesRates(self.factors, self.setting(RATES), name)
        if made is None:
            return self.accelerations(name)
        return self.with_beside(made, f"{BESIDE}_{name}")

    def coupled(self, order: int, name: str) -> SeriesJet | None:
        """The jet of a system whose accelerations follow from all members together; None if M is constant and
        there are no constraints."""
        given = self.setting(order), name
        if isinstance(self.closure, StickingClosure):
            return StickingJointsJet(self.closure, self.tabled, *given)
        if self.closure is not None:
            return ClosedJet(self.closure, self.tabled, *given, self.touch)
        if self.balance is not None:
            return ArticulatedJet(self.balance, *given, self.touch)
        if self.sticking is not None:
            return (StickingRates if order == RATES else StickingJet)(self.sticking, self.tabled, *given)
        if isinstance(self.motion, TogetherAlongMotion):
            return TogetherJet(self.motion, self.tabled, self.factors, *given)
        if self.motion is None:
            return None
        kinds: dict[type[AlongMotion], type[ConstrainedJet]]
        kinds = {ContactRestraint: ContactJet, HeldAlongMotion: HeldJet}
        kind = kinds.get(type(self.motion), ConstrainedJet)
        return kind(self.motion, self.tabled_in_motion, *given)

    def with_beside(self, motion: SeriesJet, name: str) -> Jet:
        """The jet of a motion, and of what is followed beside it, by a function of that name."""
        motion.beside, motion.copied = "" if self.integrands is None else name, not self.concise
        if isinstance(motion, CorrectedJet):
            motion.kept = self.multipliers_beside
        jet = motion.write()
        if self.integrands is None:
            return jet
        further = BesideJet(self.integrands, motion, name)
        further.copied = motion.copied
        beside = further.write()
        return Jet(beside.text + jet.text, beside.work, jet.operations + beside.operations)

    def looks(self, watch: Watch | None) -> bool:
        """Whether steps look for those guards whose arguments need series (``nearness``)."""
        if self.integrands is None or watch is None or not watch.pays or self.kind is not DoubleVectors:
            return False
        if self.silent < len(self.integrals):  # others have a say in how long steps are
            return False
        return bool(enclosed(self.integrands, *self.watched))

    @property
    def watched(self) -> tuple[list[Loop | Chain], tuple[Array, ...]]:
        """The loops of the arguments, and the arrays of numbers in these."""
        assert self.integrands is not None
        listed = loops(needed([self.integrands], self.slots, self.lasting.fixed), self.slots)
        return listed, (self.system.q, self.system.v, *self.lasting.fixed)

    @property
    def lists(self) -> bool:
        """Whether steps look at lists of these."""
        assert self.integrands is not None
        return suits(self.integrands, *self.watched, self.slots)

    def with_near(self, motion: SeriesJet, watch: Watch) -> Jet:
        """The jet of a motion, and functions of their own for it and for the arguments of guards."""
        assert self.integrands is not None
        kind = ListJet if watch.whole(self.integrands.count) and self.lists else NearJet
        jet, beside = motion.write(), kind(watch, self.integrands, motion, BESIDE).write()
        f = Function(HEAD.format(JET, DoubleVectors.times))
        places = f.pointer("%constants"), Real(f, "%t", 1), *f.pointers("state", "work")
        regular = f.call(Bit, MOTION, *places)
        f.call(Bit, BESIDE, *places, f.constant(math.inf))  # whatever may become 0 at any time
        f.give(regular)
        texts, operations = beside.text + jet.text + f.text(), jet.operations + beside.operations
        return replace(beside, text=texts, operations=operations)

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
        acting = ActingLists(self.tables, self.degrees, self.spare)
        share = None if self.parts is None else Sharing(within, self.parts).take

        def apart(evaluation: Evaluation, loop: Loop) -> bool:
            return acting.write(evaluation, loop) or (share is not None and share(evaluation, loop))

        evaluation = replace(evaluation, parted=acting.parted, apart=apart)
        evaluation.write(totals)
        if beside is not None:  # whole vectors of accelerations go beyond them
            source, target = evaluation.where(beside), f.place("%work", width + 2 * self.degrees)
            in_vectors(f, beside.count, lambda i, lanes: f.store_row(f.load_row(source, i, lanes), target, i))
        positive = self.system.spec.lagrangian is None
        f.give(regular(f, evaluation.where(self.lasting.masses), self.degrees, positive=positive))
        return Jet(f.text(), work, evaluation.emitter.operations)
