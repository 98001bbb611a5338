"""``@jet`` of systems whose M is constant but not diagonal: ``@prepare`` factors it, and every order of the
accelerations is solved for with these factors."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from lagrange_cli.families.arrays import Array, Source, Total
from lagrange_cli.families.coupled_masses import CoupledMasses
from lagrange_cli.native.families.constraints.dense import DenseTables, SolvingTables
from lagrange_cli.native.families.constraints.jet import Saddle, saddle_of, solve
from lagrange_cli.native.families.constraints.saddle_tables import SaddleTables
from lagrange_cli.native.families.diagonal import DiagonalJet, RatesInRows
from lagrange_cli.native.families.evaluation import Evaluation, room
from lagrange_cli.native.families.series_places import JetSetting
from lagrange_cli.native.families.tables import Tables
from lagrange_cli.native.families.vectors import Numbers, Vectors
from lagrange_cli.native.llvm.vector import Bit, Integer, Pointer


class MassFactors:
    """The factors of M in an ``array``, from the numbers of its ``entries``; behind them is 1 if M is
    regular, and positive if it is to be ``definite``, as it need not be in a given Lagrangian."""

    def __init__(self, masses: CoupledMasses, entries: Array, tables: Tables, *, definite: bool) -> None:
        self.masses, self.entries, self.definite = masses, entries, definite
        elimination = masses.elimination
        self.tabled: SolvingTables = (
            DenseTables(masses.count, tables) if elimination is None else SaddleTables(elimination, tables)
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
        placed = self.tabled.placed(self.masses.pairs)
        self.saddle(vectors, base).factor(evaluation.where(self.entries), placed, regular)
        found = f.select(regular.get(), f.constant(1.0), f.constant(0.0))
        vectors.store(vectors.at(found), base, self.array.count - 1)

    def regular(self, vectors: Vectors, base: Pointer) -> Bit:
        """Whether M is regular."""
        return vectors.high(vectors.load(base, self.array.count - 1)) > 0.5


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
