"""``@jet`` of systems with constraints whose M is not diagonal, and of those whose M is no constant, and the
same at a state (see ``together``)."""

from __future__ import annotations

from lagrange_cli.native.families.constraints.coupled_masses import MassFactors
from lagrange_cli.native.families.constraints.dense import SolvingTables
from lagrange_cli.native.families.constraints.equations import Pulled
from lagrange_cli.native.families.constraints.jet import ConstrainedJet, Saddle, saddle_of, solve
from lagrange_cli.native.families.constraints.restraint import AtAState, Restraint
from lagrange_cli.native.families.constraints.together import (
    FreeAtAState,
    TogetherAlongMotion,
    TogetherAtAState,
)
from lagrange_cli.native.families.evaluation import Evaluation
from lagrange_cli.native.families.series_places import JetSetting
from lagrange_cli.native.llvm.vector import Bit, Pointer


class TogetherJet(ConstrainedJet):
    """The jet of such a system, with its ``factors`` if they last."""

    motion: TogetherAlongMotion

    def __init__(
        self,
        motion: TogetherAlongMotion,
        tabled: SolvingTables,
        factors: MassFactors | None,
        setting: JetSetting,
        name: str,
    ) -> None:
        super().__init__(motion, tabled, setting, name)
        self.factors = factors

    def place_rates(self) -> None:
        self.planes.update({back: self.planes[one] for one, back in self.motion.backs.items()})
        self.planes[self.motion.multipliers] = self.planes[self.motion.solution][0] + self.degrees, 0

    def place_saddle(self) -> None:
        if self.factors is None:
            super().place_saddle()
            self.saddle.definite = self.motion.definite
        else:
            self.saddle = self.factors.saddle(self.vectors, self.at(self.factors.array, 0))

    def factor(self, evaluation: Evaluation) -> None:
        if self.factors is None:
            super().factor(evaluation)
        else:
            self.sound.set(self.factors.regular(self.vectors, self.at(self.factors.array, 0)))

    def regular(self) -> Bit:
        return self.sound.get() if self.system.curved else super().regular()

    def find(self, evaluation: Evaluation) -> None:
        evaluation.write([self.motion.right])
        solve(self.saddle, self.at(self.motion.right, 0), self.at(self.motion.solution, 0))
        self.motion.spin(evaluation, self.motion.solution)


def factored(
    restraint: Restraint,
    evaluation: Evaluation,
    tabled: SolvingTables,
    factors: MassFactors | None,
    scratch: Pointer,
) -> tuple[Saddle, Bit]:
    """What solves for forces of constraint, by factors that last or with room at ``scratch``, and whether its
    matrix is regular."""
    f, vectors, where = evaluation.f, evaluation.vectors, evaluation.where
    if factors is not None:
        base = where(factors.array)
        return factors.saddle(vectors, base), factors.regular(vectors, base)
    saddle, regular = saddle_of(vectors, tabled, scratch, 0), f.variable(Bit(f, "true", 1))
    saddle.definite = restraint.definite
    saddle.factor(where(restraint.square), restraint.placed(tabled), regular)
    return saddle, regular.get()


def solved_at_a_state(
    evaluation: Evaluation,
    restraint: Pulled,
    tabled: SolvingTables,
    factors: MassFactors | None,
    scratch: Pointer,
) -> None:
    """Compute the multipliers, and where M is not diagonal the accelerations, with room at ``scratch``."""
    to = restraint.bonds.multipliers if isinstance(restraint, AtAState) else restraint.solution
    if isinstance(restraint, FreeAtAState):
        assert factors is not None
        saddle: Saddle = factors.saddle(evaluation.vectors, evaluation.where(factors.array))
    else:
        saddle, _ = factored(restraint, evaluation, tabled, factors, scratch)
    solve(saddle, evaluation.where(restraint.right), evaluation.where(to))
    if isinstance(restraint, TogetherAtAState):
        restraint.spin(evaluation, restraint.solution)
