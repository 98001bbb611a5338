"""The jet without series of chains and trees: accelerations, and forces of constraint, at a state."""

from __future__ import annotations

from collections.abc import Collection
from functools import cached_property

from lagrange_cli.families.arrays import Array, Total
from lagrange_cli.native.families.double_double import InConstants
from lagrange_cli.native.families.evaluation import Evaluation, room
from lagrange_cli.native.families.jets import Jet
from lagrange_cli.native.families.joints.articulated import ArticulatedJet
from lagrange_cli.native.families.joints.closed import ClosedJet
from lagrange_cli.native.families.joints.closed_projection import AT_A_STATE, times_of
from lagrange_cli.native.families.joints.closure import Closure
from lagrange_cli.native.families.preparation import Preparation
from lagrange_cli.native.families.vectors import Vectors
from lagrange_cli.native.llvm.vector import Bit, Integer, Pointer
from lagrange_cli.native.motions import RATES
from lagrange_cli.records import replace


class AtRest(Preparation):
    """The jet, and how it is asked for what follows from all equations together."""

    @cached_property
    def at_a_state(self) -> tuple[ArticulatedJet, Jet]:
        """The jet, and what is written of it."""
        kind = InConstants if self.kind.parts > 1 else self.kind
        given = replace(self.setting(RATES), system=self.sampled, kind=kind), AT_A_STATE
        if isinstance(self.resting, Closure):
            touch = self.touch if self.resting.balance.touched else None
            jet: ArticulatedJet = ClosedJet(self.resting, self.tabled, *given, touch)
        else:
            assert self.resting is not None
            jet = ArticulatedJet(self.resting, *given, self.touch if self.resting.touched else None)
        return jet, jet.write()

    def jet_at_a_state(self) -> str:
        """The text of the jet, if something calls it."""
        return self.at_a_state[1].text if "at_a_state" in self.__dict__ else ""

    def solved(self, totals: Collection[Total]) -> dict[Total, Array]:
        """Those that the jet finds: with their arrays in it."""
        found: dict[Total, Array] = {}
        if isinstance(self.resting, Closure):
            found[self.resting.bonds.multipliers] = self.resting.multipliers
        if self.resting is not None:
            balance = self.resting.balance if isinstance(self.resting, Closure) else self.resting
            found[self.system.accelerations] = balance.final
        return {one: array for one, array in found.items() if one in totals}

    def room_at_rest(self, vectors: Vectors, base: Pointer) -> tuple[Pointer, Pointer]:
        """Where state and work are, the next arrays of scratch."""
        sizes = 2 * self.layout.width, self.at_a_state[0].work
        state, work = (self.taken(vectors, base, room(one)) for one in sizes)
        return state, work

    def solve_at_rest(
        self,
        evaluation: Evaluation,
        at: tuple[Pointer, Pointer],
        sample: Integer,
        stride: Integer,
        solved: dict[Total, Array],
    ) -> None:
        """What is ``solved`` at a sample, whose state is copied for the jet, to the first place ``at``
        scratch; the second one is for its work."""
        f, vectors, jet, (state, work) = evaluation.f, evaluation.vectors, self.at_a_state[0], at
        for part in range(vectors.parts):
            before, target = part * self.sample_rows, part * self.layout.width
            with f.loop(0, 2 * self.degrees, tested=False) as i:
                row = stride * (i + before if before else i) + sample
                f.store(f.load("%states", row), state, i + target if target else i)
        time = f.load("%times", sample)
        times = times_of(vectors, time, f.constant(0.0))
        f.call(Bit, AT_A_STATE, f.pointer("%constants"), *times, state, work)
        for to, array in solved.items():
            found = vectors.place(work, jet.planes[array][0])
            with f.loop(0, to.count, tested=False) as i:
                vectors.store(vectors.load(found, i), evaluation.where(to), i)
