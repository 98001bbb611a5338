"""The jet without series of chains and trees with constraints: what forces of constraint do at a state."""

from __future__ import annotations

from functools import cached_property

from lagrange_cli.families.arrays import Array
from lagrange_cli.native.families.closed import ClosedJet
from lagrange_cli.native.families.closed_projection import AT_A_STATE, times_of
from lagrange_cli.native.families.double_double import InConstants
from lagrange_cli.native.families.evaluation import Evaluation, room
from lagrange_cli.native.families.jets import Jet
from lagrange_cli.native.families.preparation import Preparation
from lagrange_cli.native.families.vectors import Vectors
from lagrange_cli.native.llvm.vector import Bit, Integer, Pointer
from lagrange_cli.native.motions import RATES
from lagrange_cli.records import dataclass


@dataclass(frozen=True)
class Resting:
    """Where a jet without series has its ``state``, and its ``work``."""

    state: Pointer
    work: Pointer


class AtRest(Preparation):
    """The jet, and how it is asked for multipliers."""

    @cached_property
    def at_a_state(self) -> tuple[ClosedJet, Jet]:
        """The jet, and what is written of it."""
        assert self.closure is not None
        given = self.system, self.lasting, self.places, self.tables, self.layout, RATES
        kind = InConstants if self.kind.parts > 1 else self.kind
        jet = ClosedJet(self.closure, self.tabled, *given, kind, AT_A_STATE)
        return jet, jet.write()

    def room_at_rest(self, vectors: Vectors, base: Pointer) -> Resting:
        """Where they are, the next arrays of scratch."""
        places = []
        for count in (2 * self.layout.width, self.at_a_state[0].work):
            places.append(vectors.place(base, self.size))
            self.size += room(count)
        return Resting(*places)

    def multipliers_at_rest(
        self, evaluation: Evaluation, at: Resting, sample: Integer, stride: Integer, to: Array
    ) -> None:
        """The multipliers of a sample, whose state is copied for the jet."""
        f, vectors, jet = evaluation.f, evaluation.vectors, self.at_a_state[0]
        for part in range(vectors.parts):
            before, target = part * self.layout.rows, part * self.layout.width
            with f.loop(0, 2 * self.degrees, tested=False) as i:
                row = stride * (i + before if before else i) + sample
                f.store(f.load("%states", row), at.state, i + target if target else i)
        time = f.load("%times", sample)
        times = times_of(vectors, time, f.constant(0.0))
        f.call(Bit, AT_A_STATE, f.pointer("%constants"), *times, at.state, at.work)
        found = vectors.place(at.work, jet.planes[jet.closure.multipliers][0])
        with f.loop(0, jet.closure.count, tested=False) as i:
            vectors.store(vectors.load(found, i), evaluation.where(to), i)
