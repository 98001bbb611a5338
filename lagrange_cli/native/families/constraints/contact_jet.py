"""``@jet`` of systems with contacts whose forces depend on one another (see ``contact_restraint``).

While no contact holds, its series are those of other forces alone: nothing is computed of contacts. What
solves for forces is not among the arrays that callers clear, as only a few contacts of many hold at a time.
"""

from __future__ import annotations

from lagrange_cli.native.families.constraints.contact_restraint import ContactRestraint
from lagrange_cli.native.families.constraints.dense import DenseTables
from lagrange_cli.native.families.constraints.held import HeldDense
from lagrange_cli.native.families.constraints.jet import ConstrainedJet
from lagrange_cli.native.families.evaluation import Evaluation, room
from lagrange_cli.native.llvm.flow import Variable
from lagrange_cli.native.llvm.vector import Bit, Index, Integer


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
