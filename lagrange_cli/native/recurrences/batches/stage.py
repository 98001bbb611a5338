"""One stage of eight members of a batch: values elsewhere in memory are gathered by tables of places.

The recurrences are those of ``Stage``; sums of many terms are loops over rows of tables.
"""

from __future__ import annotations

from functools import cached_property

from lagrange_cli.expression.node import Node
from lagrange_cli.mechanics.residual import Residual
from lagrange_cli.native.interface import LANES
from lagrange_cli.native.linear.blocks import Factorization
from lagrange_cli.native.llvm.function import Function
from lagrange_cli.native.llvm.text import Operand, Value
from lagrange_cli.native.llvm.vector import Integer, Pointer, Real
from lagrange_cli.native.numbers.lanes import LaneEmitter
from lagrange_cli.native.recurrences.batches.arrangement import grouped
from lagrange_cli.native.recurrences.batches.columns import Everywhere, column_at
from lagrange_cli.native.recurrences.batches.gathering import gathered, places_at
from lagrange_cli.native.recurrences.batches.layout import BEFORE, CHANGE, INVERSE, LOW, SLOPE, Blocks
from lagrange_cli.native.recurrences.batches.quotient import Moving, OperandView, Quotient
from lagrange_cli.native.recurrences.batches.saddle import Tabled
from lagrange_cli.native.recurrences.batches.tables import Tables
from lagrange_cli.native.recurrences.expansion import turning_masses
from lagrange_cli.native.recurrences.loaded import Loaded
from lagrange_cli.native.recurrences.vector_stage import VectorExpansion, VectorStage
from lagrange_cli.records import dataclass
from lagrange_cli.series.program import Op, Series


@dataclass
class JetData:
    """Data that all stages of the jet share while it is written."""

    residual: Residual
    quotient: Quotient
    blocks: Blocks
    tables: Tables
    f: Function
    emitter: LaneEmitter
    time: Operand = ""
    saddle: Tabled | None = None
    """The equations, if they have constraints."""

    @cached_property
    def turning(self) -> frozenset[Node]:
        """``Expansion.turning``."""
        return turning_masses(self.residual)

    @cached_property
    def groups(self) -> list[list[int]]:
        """Batches that one loop computes, in the order of their loops."""
        return grouped(self.blocks)


class BatchExpansion(VectorExpansion):
    """The expansion of eight members of a batch."""

    stage: BatchStage

    def coordinate(self, i: int) -> str:
        return self.stage.given(0)

    def velocity(self, i: int) -> str:
        return self.stage.given(1)


class BatchStage(VectorStage):
    """Stage ``k`` of the eight members of a batch from the ``b``-th block on."""

    def __init__(self, jet: JetData, k: int | Integer, batch: int, b: Integer) -> None:
        expansion = BatchExpansion(
            jet.residual, jet.quotient.program, jet.emitter,
            Everywhere(jet.tables.constants.slots),
            Factorization(jet.emitter, 0, {}, {}), jet.time, 0,
        )  # fmt: skip
        super().__init__(expansion, careful=True)
        expansion.serve(self)
        expansion.turning = jet.turning
        expansion.remainders = Loaded(lambda i: self.vector(i, LOW), lambda i: self.view(i).moving)
        self.jet, self.k, self.batch, self.b = jet, k, batch, b
        self.f, self.emitter, self._dots = jet.f, jet.emitter, {}
        self._places: dict[int, Operand] = {}
        self._pointers: dict[int, Pointer] = {}
        self._known: dict[tuple[int, int, bool], Operand] = {}

    # places

    def view(self, index: int) -> OperandView:
        return self.jet.quotient.views[index]

    def _vector_at(self, m: int, relative: bool) -> str:
        """The number of a vector, from coefficient 0 on, or from coefficient k on, in doubles."""
        if not relative:
            return str(LANES * m)
        if isinstance(self.k, int):
            return str(LANES * (self.k + m))
        return (self.k * LANES + LANES * m if m else self.k * LANES).name

    def pointer(self, index: int) -> Pointer:
        """Where coefficient 0 of a series is, if it stands beside the members in blocks of its own."""
        if index not in self._pointers:
            span, block = self.jet.blocks.span, self.view(index).block
            assert block is not None
            at = self.b * (LANES * span) + LANES * (span * block + BEFORE)
            self._pointers[index] = self.f.place("%work", at, "double")
        return self._pointers[index]

    def vector(self, index: int, m: int, *, relative: bool = False) -> Operand:
        """A vector of a series: coefficient m or, if that is ``relative``, k + m; or what stands before."""
        key = index, m, relative
        if key not in self._known:
            at = self._vector_at(m, relative)
            if self.view(index).block is not None:
                self._known[key] = self.f.load_row(self.pointer(index), at, LANES, aligned=True).name
            else:
                base = self.f.place("%work", at, "double").name
                self._known[key] = gathered(self.emitter, base, self.places(self.view(index).table))
        return self._known[key]

    def put(self, value: Value, m: int, *, relative: bool = False) -> None:
        """Store a vector of the batch."""
        whole, at = Real(self.f, self.emitter.written(value), LANES), self._vector_at(m, relative)
        self.f.store_row(whole, self.pointer(self.batch), at, aligned=True)
        self._known.pop((self.batch, m, relative), None)

    def places(self, table: int) -> Operand:
        """The members' row of a table of places."""
        if table not in self._places:
            self._places[table] = places_at(self.f, self.b * LANES + table if table else self.b * LANES)
        return self._places[table]

    def given(self, derivatives: int) -> Operand:
        """The coordinates or the velocities of the state."""
        table = self.jet.quotient.given[self.batch]
        degrees = len(self.jet.residual.model.q)
        base = self.f.place("%state", derivatives * degrees, "double")
        return gathered(self.emitter, base.name, self.places(table))

    def constant(self, node: Node) -> Operand:
        column = self.jet.quotient.columns.get(node)
        if column is None:
            return self.emitter.everywhere("%constants", "0", self.jet.tables.constants.slot(node))
        return column_at(self.f, self.emitter, column, self.b * LANES, self.places)

    # what Stage asks for

    def first(self, index: int) -> Value:
        return self.vector(index, 0)

    def slopes(self, index: int) -> tuple[Value, Value]:
        return self.vector(index, SLOPE), self.vector(index, INVERSE)

    def at(self, index: int, ahead: int) -> Value:
        if isinstance(self.k, int) and self.k + ahead < 0:
            return None
        return self.vector(index, ahead, relative=True)

    # stages

    def write(self) -> None:
        """The newest coefficients of the batch, as far as they are known before the accelerations."""
        one = self.expansion.program.series[self.batch]
        begins = self.is_index(one.level, 0)
        if self.jet.blocks.batches[self.batch].long:
            value: Value = self._long_sum(begins, one)
        else:
            value = self.begin(self.batch) if begins else self.recur(self.batch)
        self.put(value, one.level, relative=True)
        if begins and one.op is Op.POWER:
            slope, inverse = self.expansion.sensitivities[self.batch]
            self.put(slope, SLOPE)
            self.put(inverse, INVERSE)
        if begins and self.view(self.batch).moving:
            self.put(self._remainder(one), LOW)

    def _remainder(self, one: Series) -> Value:
        """The remainder of a coordinate or velocity, or of the series that the batch copies."""
        if one.op is Op.LINEAR:
            return self.vector(one.arguments[0], LOW)
        base = self.f.place(
            "%state", self.jet.quotient.low + (one.op is Op.DERIVATIVE) * self.degrees, "double"
        )
        return gathered(self.emitter, base.name, self.places(self.jet.quotient.given[self.batch]))

    @property
    def degrees(self) -> int:
        return len(self.jet.residual.model.q)

    def _long_sum(self, begins: bool, one: Series) -> Value:
        batch, start = self.jet.quotient.sums[self.batch], None
        if begins:
            assert isinstance(one.data, tuple)
            start = None if one.data[0].is_zero else self.constant(one.data[0])
            if batch.remainders:
                start = self.summed(self.batch, str(LANES * LOW), start)
        return self.summed(self.batch, self._vector_at(one.level, True), start)

    def summed(self, index: int, at: str, start: Value, *, changes: bool = False) -> Operand:
        """``start`` + the sum of the vectors ``at`` that distance of all terms of a long sum."""
        table = self.jet.quotient.sums[index]
        total = self.f.variable(Real(self.f, self.emitter.written(start), LANES))
        base = self.f.place("%work", at, "double").name
        first = self.b * (LANES * table.terms)
        with self.f.loop(0, table.terms, tested=False) as t:
            row = first + t * LANES
            places = places_at(self.f, row + table.places if table.places else row)
            known: dict[int, Operand] = {}

            def listed(start: int) -> Operand:
                if start not in known:
                    known[start] = places_at(self.f, row + start if start else row)
                return known[start]

            column = table.changing if changes else table.factors
            factor = column_at(self.f, self.emitter, column, row, listed)
            value = self.emitter.fma(factor, gathered(self.emitter, base, places), total.get().name)
            assert value is not None
            total.set(Real(self.f, value, LANES))
        return total.get().name

    def correct(self) -> None:
        """Add what the accelerations add to the newest coefficients of the batch."""
        one, index = self.expansion.program.series[self.batch], self.batch
        if one.op is Op.PRIMITIVE and self.is_index(one.level, 0):
            return
        if self.jet.blocks.batches[index].long:
            change: Value = self.summed(index, str(LANES * CHANGE), None, changes=True)
        else:
            change = self.correction(index, self._changes(), None)
        self.put(self.emitter.add(self.at(index, one.level), change), one.level, relative=True)
        self.put(change, CHANGE)

    def _changes(self) -> Loaded[int, Value]:
        """Corrections of the newest coefficients of series."""
        series = self.expansion.program.series
        return Loaded(lambda i: self.vector(i, CHANGE), lambda i: series[i].corrected)

    def acceleration(self, one: Moving) -> Value:
        """The newest coefficients of the accelerations."""
        if self.jet.saddle is not None:
            return self.unknown(one.rows)
        scale = self.vector(self.batch, INVERSE)
        return self.emitter.neg(self.emitter.mul(self.vector(one.root, 0, relative=True), scale))

    def unknown(self, rows: tuple[int, ...]) -> Value:
        """The solution for each member."""
        assert self.jet.saddle is not None
        places = self.places(self.jet.saddle.table(rows))
        return self.emitter.neg(gathered(self.emitter, "%work", places))

    def multiply(self, rows: tuple[int, ...]) -> None:
        """The newest coefficients of multipliers."""
        value = self.unknown(rows)
        self.put(value, 0, relative=True)
        self.put(value, CHANGE)

    def accelerate(self, velocity: BatchStage, one: Moving) -> None:
        """The newest coefficients of coordinates and velocities."""
        value = self.integrated(self.acceleration(one), 1)
        velocity.put(value, 1, relative=True)
        velocity.put(value, CHANGE)
        value = self.integrated(value, 2)
        self.put(value, 2, relative=True)
        self.put(value, CHANGE)
