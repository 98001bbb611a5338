"""Stage k of the series of a loop: coefficients of eight members at a time."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any, cast

from lagrange_cli.expression.node import Node
from lagrange_cli.native.families.careful import careful_values
from lagrange_cli.native.families.evaluation import Evaluation, Writer
from lagrange_cli.native.families.everywhere import Everywhere
from lagrange_cli.native.families.series import INVERSE, SLOPE, LoopSeries, begin_sums
from lagrange_cli.native.families.vector_dots import Coefficients, Pair
from lagrange_cli.native.families.vectors import Operands
from lagrange_cli.native.interface import LANES
from lagrange_cli.native.linear.blocks import Factorization
from lagrange_cli.native.llvm.vector import Bit, Index, Integer, Pointer
from lagrange_cli.native.recurrences.evaluation import Loaded, emit_values
from lagrange_cli.native.recurrences.expansion import Expansion
from lagrange_cli.native.recurrences.stage import Factors, Stage
from lagrange_cli.records import dataclass
from lagrange_cli.series.program import FREE, Op, reciprocal


class SeriesWriter(Writer):
    """The code of one loop in stage ``k``, with coefficients ``at`` a place behind ``base``; ``phase``: how
    many stages there were since sums were begun, if they were; ``begins``: they are begun now, row by row."""

    def __init__(
        self,
        evaluation: Evaluation,
        series: LoopSeries,
        at: int,
        k: Index,
        phase: int | None,
        *,
        begins: bool = False,
    ) -> None:
        super().__init__(evaluation, series.loop)
        self.series, self.k, self.at, self.phase, self.begins = series, k, at, phase, begins
        self.block: Integer | None = None
        self.base: Pointer | str = "%work"

    def enter(self, r: Integer) -> None:
        blocks = self.series.blocks
        self.block = self.f.count(0) if len(blocks) == 2 else self.listed_at(blocks[:-1], r)
        if self.begins:
            assert isinstance(self.k, Integer)
            begin_sums(self.f, self.series, self.k, self.at, self.block, self.listed_at(blocks[1:], r))

    def of_eight(
        self, known: dict[Node, Operands], bases: Sequence[Integer], j: Integer, inside: Bit
    ) -> list[Operands]:
        values = self.values(known, j)
        return self.carefully(values, known, lambda one: {**one.fixed(bases), **one.changing(bases, j)})

    def carefully(
        self,
        values: list[Operands],
        known: dict[Node, Operands],
        numbers: Callable[[Any], Mapping[Node, Operands]],
    ) -> list[Operands]:
        """The ``values`` of terms; from all digits of the state where these count, and are known: functions
        have slopes that may be infinite."""
        low, slots, kind = self.evaluation.low, self.series.slots, self.evaluation.emitter
        if low is not None:
            nodes = {i: term.node for i, (term, _) in enumerate(self.loop.terms)}
            own = {i: one for i, one in nodes.items() if slots.moving(one, {*low.arrays})}
            for i, value in zip(own, careful_values(self, [*own.values()], known, numbers)):
                finite = kind.compare("oeq", kind.sub(value, value), None)
                values[i] = kind.select(finite, value, values[i])
        return values

    def values(self, known: dict[Node, Operands], j: Integer) -> list[Operands]:
        return MemberStage(self.evaluation, self.series, self.k, self.block_at(j), known, self.phase).values()

    def block_at(self, j: Integer) -> Pointer:
        """Where the coefficients of eight members begin."""
        assert self.block is not None
        place = self.series.place(self.f, self.block + j.operation("lshr", 3))
        return self.vectors.place(self.base, place + self.at)


@dataclass(frozen=True)
class Moving:
    """What an expansion asks of a residual here."""

    variables: int
    bent: bool = False


class MemberExpansion(Expansion[Any]):
    """The expansion of eight members, whose constants and first coefficients a ``stage`` knows."""

    stage: MemberStage

    def serve(self, stage: MemberStage) -> None:
        """Take them from there."""
        self.stage, self.sensitivities = stage, Loaded(stage.slopes)

        def first(index: int) -> Loaded[int, Operands]:
            return Loaded(lambda m: stage.first(index))

        self.table = [first(index) for index in range(len(self.program.series))]

    def constant(self, node: Node) -> Operands:
        return self.stage.constant(node)


class MemberStage(Stage[Any]):
    """Stage ``k``, a number or that of a loop, of eight members, whose coefficients are at ``block``."""

    def __init__(
        self,
        evaluation: Evaluation,
        series: LoopSeries,
        k: Index,
        block: Pointer,
        known: Mapping[Node, Operands],
        phase: int | None,
    ) -> None:
        emitter, constants = evaluation.emitter, Everywhere(evaluation.tables.constants.slots)
        expansion = MemberExpansion(
            cast("Any", Moving(series.moving)), series.program, emitter, constants,
            Factorization(emitter, 0), evaluation.known[series.time], 0,
        )  # fmt: skip
        super().__init__(expansion)
        expansion.serve(self)
        self.series, self.k, self.block, self.known, self.phase = series, k, block, known, phase
        self.vectors = evaluation.vectors
        self.emitter = emitter
        self._dots: dict[int, Sequence[Operands]] = {}
        """The dot products of each series, and the weighted ones."""
        self._whole: dict[int, Coefficients] = {}
        self.newest: dict[int, Operands] = {}
        self._loaded: dict[tuple[int, object], Operands] = {}
        self._behind: dict[tuple[int, int], Operands] = {}
        self._constants: dict[Node, Operands] = {}

    def pointer(self, index: int) -> Pointer:
        """Where coefficient 0 of a series is."""
        return self.vectors.place(self.block, LANES * self.series.stored[index])

    def place(self, index: int, m: Index) -> Pointer:
        """Where coefficient ``m`` of a series is, or what goes with it."""
        return self.vectors.place(self.block, self.series.vector(index, m) * LANES)

    def vector(self, index: int, m: Index) -> Operands:
        """Coefficient ``m`` of a series, or what stands before coefficient 0."""
        key = index, m if isinstance(m, int) else m.name
        if key not in self._loaded:
            row = self.vectors.load_row(self.place(index, m), 0, LANES)
            self._loaded[key] = self.vectors.operand(row)
        return self._loaded[key]

    def put(self, index: int, value: Operands, m: Index) -> None:
        """The same, stored."""
        self.vectors.store_row(self.vectors.number(value), self.place(index, m), 0)

    def dot(
        self, index: int, a: int, b: int, ahead: int, weighted: bool = False
    ) -> tuple[Operands, Factors[Any]]:
        if isinstance(self.k, int) and self.k + ahead < 2:
            return None, []
        if self.phase is None or index not in self.series.begun:
            if index not in self._dots:
                self._sum(index, self.k + ahead)
            return self._dots[index][weighted], []
        first, last = self.series.rest(index, self.phase)
        at = self.series.sums + self.series.begun[index] + LANES * self.phase
        total = self.vectors.operand(self.vectors.load_row(self.block, at, LANES))
        terms: Factors[Any] = [(self.vector(a, m), self.at(b, ahead - m)) for m in range(1, first + 1)]
        terms += [(self.at(a, ahead - m), self.vector(b, m)) for m in range(1, last + 1)]
        return total, terms

    def _sum(self, index: int, n: Index) -> None:
        """The dot product of a series and of those that are summed up with it, and for a power the weighted
        one, too."""
        together = self.series.together.get(index, [index])
        one = self.expansion.program.series[index]
        pairs = [self._pair(other) for other in together]
        weighted = one.op is Op.POWER and not reciprocal(one.data)
        same = pairs[0][0] is pairs[0][1]
        self._dots.update(zip(together, self.vectors.dots(pairs, n, same=same, weighted=weighted)))

    def _pair(self, index: int) -> Pair:
        """What the dot products of a series are of: a power takes itself and its base."""
        one = self.expansion.program.series[index]
        first, second = (index, *one.arguments) if one.op is Op.POWER else one.arguments
        return self._coefficients(first), self._coefficients(second)

    def _coefficients(self, index: int) -> Coefficients:
        """Those of a series, the same object every time."""
        if index not in self._whole:
            self._whole[index] = Coefficients(self.pointer(index), self.series.step)
        return self._whole[index]

    def is_index(self, ahead: int, index: int) -> bool:
        return isinstance(self.k, int) and self.k + ahead == index

    def reciprocal(self, ahead: int) -> Operands:
        return None

    def number(self, ahead: int) -> Operands:
        return self.vectors.rate(self.k, ahead)

    def divided(self, value: Operands, ahead: int) -> Operands:
        return self.vectors.over(value, self.k, ahead)

    def integrated(self, value: Operands, ahead: int) -> Operands:
        return self.vectors.integrated(value, self.k, ahead)

    def constant(self, node: Node) -> Operands:
        """A constant of the motion, or one of each member."""
        if node not in self._constants:
            known = dict(self.known)
            emit_values(self.emitter, [node], known, self.expansion.constants)
            self._constants[node] = known[node]
        return self._constants[node]

    def slopes(self, index: int) -> tuple[Operands, Operands]:
        """dp/dx and 1/x of a power p of x."""
        return self.vector(index, SLOPE), self.vector(index, INVERSE)

    def first(self, index: int) -> Operands:
        """Coefficient 0 of a series."""
        if self.is_index(self.series.program.series[index].level, 0) and index in self.newest:
            return self.newest[index]
        known = index in self.series.stored or (index, 0) in self.series.besides
        return self.vector(index, 0) if known else None

    def at(self, index: int, ahead: int) -> Operands:
        if isinstance(self.k, int) and self.k + ahead < 0:
            return None
        if ahead == self.series.program.series[index].level:
            return self.newest[index]
        if (index, ahead) not in self._behind:
            self._behind[index, ahead] = self.vector(index, self.k + ahead)
        return self._behind[index, ahead]

    def values(self) -> list[Operands]:
        """Coefficients k of the terms; all others are computed on the way."""
        self.advance()
        return self.terms()

    def advance(self) -> None:
        """The newest coefficients of all series."""
        program = self.series.program
        for index, one in enumerate(program.series):
            if one.level == FREE or (isinstance(self.k, int) and self.k + one.level < 0):
                continue
            if index not in self.series.lasting and not (isinstance(self.k, int) and self.k <= 0):
                continue
            begins = self.is_index(one.level, 0)
            if one.op is Op.COORDINATE:
                assert one.node is not None
                value = self.known[one.node]
            else:
                value = self.begin(index) if begins else self.recur(index)
            self.newest[index] = value
            if index in self.series.stored:
                self.put(index, value, self.k + one.level)
            elif begins and (index, 0) in self.series.besides:
                self.put(index, value, 0)
            if begins and one.op is Op.POWER:
                slope, inverse = self.expansion.sensitivities[index]
                self.put(index, slope, SLOPE)
                self.put(index, inverse, INVERSE)

    def terms(self) -> list[Operands]:
        """Coefficients k of the terms that have them."""
        first = isinstance(self.k, int) and self.k == 0
        residual = self.series.program.residual
        return [self.of_order(index) for index in (residual if first else residual[: self.series.terms])]

    def of_order(self, index: int) -> Operands:
        """Coefficient k of a term."""
        ahead = self.series.program.series[index].level > 0
        return self.vector(index, self.k) if ahead else self.newest.get(index)
