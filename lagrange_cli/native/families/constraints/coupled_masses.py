"""``@jet`` of systems whose M is constant but not diagonal: ``@prepare`` factors it, and every order of the
accelerations is solved for with these factors."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from lagrange_cli.families.arrays import Array, Source, Total
from lagrange_cli.families.coupled_masses import CoupledMasses
from lagrange_cli.families.description import FamilySystem
from lagrange_cli.families.saddle_points import SaddlePoint
from lagrange_cli.native.families.constraints.dense import DenseTables, SolvingTables
from lagrange_cli.native.families.constraints.jet import Saddle, saddle_of, solve
from lagrange_cli.native.families.constraints.saddle_tables import SaddleTables
from lagrange_cli.native.families.constraints.together import lasting_entries
from lagrange_cli.native.families.diagonal import DiagonalJet, RatesInRows
from lagrange_cli.native.families.evaluation import Evaluation, room
from lagrange_cli.native.families.lasting import Lasting
from lagrange_cli.native.families.series_places import JetSetting
from lagrange_cli.native.families.tables import Tables
from lagrange_cli.native.families.vectors import Numbers, Vectors
from lagrange_cli.native.llvm.vector import Bit, Integer, Pointer


class MassFactors:
    """The factors of M, or of the matrix of M and constraints, in an ``array``, from the numbers of its
    ``entries``; behind them is 1 if it is regular, and positive if it is to be ``definite``, as M need not be
    in a given Lagrangian."""

    def __init__(
        self, matrix: CoupledMasses | SaddlePoint, entries: Array, tables: Tables, *, definite: bool
    ) -> None:
        self.matrix, self.entries, self.definite = matrix, entries, definite
        elimination = matrix.elimination
        self.tabled: SolvingTables = (
            DenseTables(matrix.count, tables) if elimination is None else SaddleTables(elimination, tables)
        )
        self.array = Array(Source.TOTAL, room(self.tabled.size) + 1)

    def saddle(self, vectors: Vectors, base: Pointer) -> Saddle:
        """What solves, with the array at ``base``."""
        saddle = saddle_of(vectors, self.tabled, base, 0)
        saddle.definite = self.definite
        return saddle

    def factor(self, evaluation: Evaluation) -> None:
        """Find the factors."""
        f, vectors, base = evaluation.f, evaluation.vectors, evaluation.where(self.array)
        regular = f.variable(Bit(f, "true", 1))
        placed = self.tabled.placed(self.matrix.pairs, self.matrix.sizes)
        self.saddle(vectors, base).factor(evaluation.where(self.entries), placed, regular)
        found = f.select(regular.get(), f.constant(1.0), f.constant(0.0))
        vectors.store(vectors.at(found), base, self.array.count - 1)

    def regular(self, vectors: Vectors, base: Pointer) -> Bit:
        """Whether the matrix is regular."""
        return vectors.high(vectors.load(base, self.array.count - 1)) > 0.5


def factors_of(system: FamilySystem, lasting: Lasting, tables: Tables) -> MassFactors | None:
    """The factors of a system whose M is not diagonal, if they last."""
    if system.coupled_masses is None:
        return None
    if system.saddle is not None:
        found = None if system.saddle.bonds.surplus else lasting_entries(system, lasting)
        lasting.matrix = found is not None
        return None if found is None else MassFactors(system.saddle, found, tables, definite=False)
    entries = lasting.arranged(system.coupled_masses.entries)
    return MassFactors(system.coupled_masses, entries, tables, definite=system.spec.lagrangian is None)


class CoupledMassesJet(DiagonalJet):
    """The jet of such a system."""

    tiled = False

    def __init__(self, factors: MassFactors, setting: JetSetting, name: str) -> None:
        super().__init__(setting, name)
        self.factors, self.solved = factors, Array(Source.TOTAL, self.degrees)

    def prepared(self) -> Sequence[Total]:
        totals = super().prepared()
        self.planes[self.solved] = self.take(room(self.degrees)), 0
        return totals

    def rates_of(self, evaluation: Evaluation) -> Callable[[Integer, int], Numbers]:
        vectors, solved = self.vectors, self.at(self.solved, 0)
        saddle = self.factors.saddle(vectors, self.at(self.factors.array, 0))
        solve(saddle, evaluation.where(self.whole), solved)
        return lambda i, lanes: vectors.load_row(solved, i, lanes)

    def regular(self) -> Bit:
        return self.factors.regular(self.vectors, self.at(self.factors.array, 0))


class CoupledMassesRates(RatesInRows, CoupledMassesJet):
    """The same without series, in rows as of the state."""
