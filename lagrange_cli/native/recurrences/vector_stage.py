"""The common parts of stages that compute eight members at once, for any layout of their series.

Coefficients of a series are vectors, from ``pointer`` on, each ``step`` behind the one before.
"""

from __future__ import annotations

from lagrange_cli.expression.node import Node
from lagrange_cli.native.llvm.function import Function
from lagrange_cli.native.llvm.text import Operand, Value, table
from lagrange_cli.native.llvm.vector import Integer, Pointer
from lagrange_cli.native.numbers.lanes import LaneEmitter
from lagrange_cli.native.recurrences.expansion import Expansion
from lagrange_cli.native.recurrences.loaded import Loaded
from lagrange_cli.native.recurrences.stage import Factors, Stage, reciprocal_rest
from lagrange_cli.native.recurrences.vector_dots import Coefficients, dots
from lagrange_cli.series.program import Op, Series, reciprocal


class VectorExpansion(Expansion[str]):
    """The expansion of eight members, whose constants their stage knows."""

    stage: VectorStage

    def serve(self, stage: VectorStage) -> None:
        """Take what is not known from a stage."""
        self.stage, self.sensitivities = stage, Loaded(stage.slopes)

        def first(index: int) -> Loaded[int, Value]:
            return Loaded(lambda m: stage.first(index))

        self.table = [first(index) for index in range(len(self.program.series))]

    def constant(self, node: Node) -> Value:
        return self.stage.constant(node)


class VectorStage(Stage[str]):
    """Stage ``k``, a number or that of a loop, of eight members."""

    f: Function
    k: int | Integer
    emitter: LaneEmitter
    _dots: dict[int, list[Operand]]
    """The dot products of each series, and the weighted ones."""
    step = 1

    def pointer(self, index: int) -> Pointer:
        """Where coefficient 0 of a series is."""
        raise NotImplementedError

    def first(self, index: int) -> Value:
        """Coefficient 0 of a series."""
        raise NotImplementedError

    def slopes(self, index: int) -> tuple[Value, Value]:
        """dp/dx and 1/x of a power p of x."""
        raise NotImplementedError

    def constant(self, node: Node) -> Value:
        """A constant of the motion, or one of each member."""
        raise NotImplementedError

    def number(self, ahead: int) -> Value:
        return numbered(self.emitter, self.k, ahead)

    def reciprocal(self, ahead: int) -> Value:
        return None

    def divided(self, value: Value, ahead: int) -> Value:
        """By k + ahead, correctly rounded except for the product of two small numbers."""
        return over(self.emitter, value, self.k, ahead)

    def is_index(self, ahead: int, index: int) -> bool:
        return isinstance(self.k, int) and self.k + ahead == index

    def dot(
        self, index: int, a: int, b: int, ahead: int, weighted: bool = False
    ) -> tuple[Value, Factors[str]]:
        if isinstance(self.k, int) and self.k + ahead < 2:
            return None, []
        if index not in self._dots:
            self._dots[index] = self._summed(self.expansion.program.series[index], a, b, self.k + ahead)
        return self._dots[index][weighted], []

    def _summed(self, one: Series, a: int, b: int, n: int | Integer) -> list[Operand]:
        """The dot product of a series, and for a power the weighted one, too."""
        first, second = (Coefficients(self.pointer(index), self.step) for index in (a, b))
        weighted = one.op is Op.POWER and not reciprocal(one.data)
        return self.dots(first, second, n, same=a == b, weighted=weighted)

    def dots(
        self, a: Coefficients, b: Coefficients, n: int | Integer, *, same: bool, weighted: bool
    ) -> list[Operand]:
        """Those sums for two series, or twice the same one."""
        return dots(self.f, a, b, n, same=same, weighted=weighted)


def numbered(emitter: LaneEmitter, k: int | Integer, ahead: int) -> Value:
    """The number k + ahead in every lane."""
    if isinstance(k, int):
        return emitter.number(k + ahead)
    return emitter.everywhere("@numbers", k.name, ahead)


def over(emitter: LaneEmitter, value: Value, k: int | Integer, ahead: int) -> Value:
    """``value / (k + ahead)``, correctly rounded except for the product of two small numbers."""
    if isinstance(k, int):
        inverse = emitter.number(1.0 / (k + ahead))
        rest = emitter.number(reciprocal_rest(k + ahead))
    else:
        inverse, rest = (emitter.everywhere(f"@{name}", k.name, ahead) for name in ("reciprocals", "rests"))
    return emitter.fma(value, inverse, emitter.mul(value, rest))


def rests(size: int) -> str:
    """The table of the rounding errors of 1/m."""
    return table("rests", [reciprocal_rest(m) if m else 0.0 for m in range(size)], "double")
