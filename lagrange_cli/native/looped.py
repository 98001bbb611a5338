"""The later stages of a step, as the body of a loop whose convolutions run over vectors of coefficients."""

from __future__ import annotations

from lagrange_cli.mechanics.series import SHORT
from lagrange_cli.native.emitter import ONE, Value, literal, operand
from lagrange_cli.native.expansion import Expansion
from lagrange_cli.native.layout import LANES
from lagrange_cli.native.stage import Stage


class Looped(Stage):
    """Stages ``first`` .. ``last`` as the body of a loop over ``k``."""

    def __init__(self, expansion: Expansion, k: str, first: int, last: int) -> None:
        super().__init__(expansion)
        self.k, self.first, self.last = k, first, last
        self._known: dict[tuple[str, int], Value] = {}
        self._rows = expansion.emitter.define(f"getelementptr inbounds double, ptr %work, i64 {k}")
        minus = expansion.emitter.define(f"sub nsw i64 0, {k}")
        self._mirrored = expansion.emitter.define(f"getelementptr inbounds double, ptr %work, i64 {minus}")

    def at(self, index: int, ahead: int) -> Value:
        one, layout = self.expansion.program.series[index], self.expansion.layout
        if one.degree < self.first + ahead:
            return None
        if ahead == one.level:
            return self.top[index]
        if index in layout.forward:
            return self.expansion.emitter.load(self._rows, layout.forward_slot(index) + ahead)
        return self.expansion.emitter.load(self._mirrored, layout.backward_slot(index) - ahead)

    def set_top(self, index: int, value: Value) -> None:
        self.top[index] = value

    def middle(self, a: int, b: int, ahead: int) -> Value:
        series = self.expansion.program.series
        if series[a].degree > SHORT:
            a, b = b, a
        if series[a].degree <= SHORT:
            total: Value = None
            for m in range(1, series[a].degree + 1):
                total = self.expansion.emitter.fma(
                    self.expansion.table[a].get(m), self.at(b, ahead - m), total
                )
            return total
        layout = self.expansion.layout
        if a not in layout.forward or b not in layout.backward:
            a, b = b, a
        return self._dot(a, b, ahead, None)

    def weighted(self, index: int, base: int, exponent: Value, ahead: int) -> Value:
        if self.expansion.program.series[base].degree > SHORT:
            return self._dot(index, base, ahead, exponent)
        emitter, table = self.expansion.emitter, self.expansion.table
        total: Value = None
        for j in range(1, self.expansion.program.series[base].degree + 1):  # j = n - m
            weight = emitter.sub(
                emitter.mul(exponent, literal(j)), emitter.sub(self.number(ahead), literal(j))
            )
            total = emitter.fma(emitter.mul(weight, table[base].get(j)), self.at(index, ahead - j), total)
        return total

    def _dot(self, a: int, b: int, ahead: int, exponent: Value) -> Value:
        """The vectors' part of a convolution; weighted as the power rule wants if an exponent is given."""
        emitter, layout = self.expansion.emitter, self.expansion.layout
        blocks = -(-(self.last + ahead - 1) // LANES)
        vector = f"<{LANES} x double>"
        total: str | None = None
        slope = offset = ""
        if exponent is not None:
            slope = self._splat(emitter.neg(emitter.add(exponent, ONE)))
            offset = self._splat(emitter.mul(exponent, self.number(ahead)))
        for block in range(blocks):
            place = layout.forward_slot(a) + 1 + LANES * block
            x = emitter.define(f"getelementptr inbounds double, ptr %work, i64 {place}")
            x = emitter.define(f"load {vector}, ptr {x}, align 64")
            place = layout.backward_slot(b) - ahead + 1 + LANES * block
            y = emitter.define(f"getelementptr inbounds double, ptr {self._mirrored}, i64 {place}")
            y = emitter.define(f"load {vector}, ptr {y}, align 8")
            if exponent is not None:
                steps = ", ".join(f"double {operand(literal(1 + LANES * block + i))}" for i in range(LANES))
                weight = self._vector_fma(slope, f"<{steps}>", offset)
                y = emitter.define(f"fmul {vector} {y}, {weight}")
            if total is None:
                total = emitter.define(f"fmul {vector} {x}, {y}")
            else:
                total = self._vector_fma(x, y, total)
            emitter.operations += LANES
        zero = operand(None)
        return emitter.define(
            f"call reassoc double @llvm.vector.reduce.fadd.v{LANES}f64(double {zero}, {vector} {total})"
        )

    def _vector_fma(self, a: str, b: str, c: str) -> str:
        vector = f"<{LANES} x double>"
        return self.expansion.emitter.define(
            f"call {vector} @llvm.fmuladd.v{LANES}f64({vector} {a}, {vector} {b}, {vector} {c})"
        )

    def _splat(self, value: Value) -> str:
        emitter, vector = self.expansion.emitter, f"<{LANES} x double>"
        one = emitter.define(f"insertelement {vector} poison, double {operand(value)}, i64 0")
        return emitter.define(
            f"shufflevector {vector} {one}, {vector} poison, <{LANES} x i32> zeroinitializer"
        )

    def _tabulated(self, name: str, ahead: int) -> Value:
        key = (name, ahead)
        if key not in self._known:
            emitter = self.expansion.emitter
            place = emitter.define(f"getelementptr inbounds double, ptr @{name}, i64 {self.k}")
            self._known[key] = emitter.load(place, ahead)
        return self._known[key]

    def number(self, ahead: int) -> Value:
        return self._tabulated("numbers", ahead)

    def divided(self, value: Value, ahead: int) -> Value:
        rest = self.expansion.emitter.mul(value, self._tabulated("reciprocal_rests", ahead))
        return self.expansion.emitter.fma(value, self._tabulated("reciprocals", ahead), rest)

    def write(self) -> None:
        """Compute, solve and store one stage's coefficients."""
        expansion = self.expansion
        for index, one in enumerate(expansion.program.series):
            if one.degree >= self.first + one.level:
                self.top[index] = self.recur(index)
            else:
                self.top[index] = None
        self.solve()
        for index, one in enumerate(expansion.program.series):
            if one.degree < self.first + one.level:
                continue
            if index in expansion.layout.forward:
                expansion.emitter.store(
                    self.top[index], self._rows, expansion.layout.forward_slot(index) + one.level
                )
            if index in expansion.layout.backward:
                expansion.emitter.store(
                    self.top[index], self._mirrored, expansion.layout.backward_slot(index) - one.level
                )
