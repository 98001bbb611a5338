"""The first stages of a step, written out coefficient by coefficient."""

from __future__ import annotations

from lagrange_cli.native.numbers.double import Value, literal
from lagrange_cli.native.recurrences.convolution import store, store_rows, sum_unrolled
from lagrange_cli.native.recurrences.expansion import Expansion
from lagrange_cli.native.recurrences.layout import FIRST
from lagrange_cli.native.recurrences.stage import Stage, linear_data, reciprocal_rest
from lagrange_cli.series.program import Op, Series

SIDE_BY_SIDE = 4
"""The lowest sum of their vectors' indices from which on dot products are summed in lanes."""
RECENT = 4
"""Vectors that the next stages take from registers: from memory they would come later."""
CAREFUL = 4
"""Stages whose products include the low parts of q and q_dot."""
ROUNDED = 7
"""The first stage that multiplies with the rounded reciprocal of its index."""


class Unrolled(Stage):
    """Stage ``k`` with every coefficient a value of its own."""

    def __init__(self, expansion: Expansion, k: int) -> None:
        super().__init__(expansion, careful=k < CAREFUL)
        self.k = k

    def at(self, index: int, ahead: int) -> Value:
        return self.expansion.table[index].get(self.k + ahead)

    def set_top(self, index: int, value: Value) -> None:
        self.expansion.table[index][self.k + self.expansion.program.series[index].level] = value

    def products(self, a: int, b: int, ahead: int) -> list[tuple[Value, Value, Value]]:
        n, table = self.k + ahead, self.expansion.table
        listed = ((m, table[a].get(m), table[b].get(n - m)) for m in range(1, n))
        return [(literal(m), x, y) for m, x, y in listed if x is not None and y is not None]

    def number(self, ahead: int) -> Value:
        return literal(self.k + ahead)

    def reciprocal(self, ahead: int) -> Value:
        return literal(1.0 / (self.k + ahead)) if self.k >= ROUNDED else None

    def divided(self, value: Value, ahead: int) -> Value:
        if self.reciprocal(ahead) is not None:
            return super().divided(value, ahead)
        n, emitter = self.k + ahead, self.expansion.emitter
        rest = literal(reciprocal_rest(n))
        return emitter.fma(value, literal(1.0 / n), emitter.mul(value, rest))

    def is_index(self, ahead: int, index: int) -> bool:
        return self.k + ahead == index

    def write(self) -> None:
        """Compute, solve (from stage 0 on) and store this stage's coefficients."""
        expansion = self.expansion
        for group in expansion.layout.groups:
            n = self.k + group.level
            if n >= SIDE_BY_SIDE:
                recent = expansion.recent[group]
                self.take(group, sum_unrolled(expansion.emitter, group, n - FIRST, "%work", n, recent))
        for index, one in enumerate(expansion.program.series):
            if one.level + self.k == 0:
                expansion.table[index][0] = self.begin(index, one)
            elif one.level + self.k > 0:
                if self.k < 0 and index in expansion.program.coordinates:  # q[1] is the velocity of the state
                    assert isinstance(one.data, int)
                    value: Value = expansion.emitter.load(
                        "%state", one.data + len(expansion.program.coordinates)
                    )
                else:
                    value = self.recur(index)
                expansion.table[index][self.k + one.level] = value
        if self.k == 0:
            expansion.factor()
        if self.k >= 0:
            self.solve()
        self.keep()

    def keep(self) -> None:
        """Store this stage's coefficients."""
        expansion = self.expansion
        for group in expansion.layout.groups:
            m, recent = self.k + group.level, expansion.recent.setdefault(group, {})
            if m >= FIRST:
                recent[m] = self.vectors(group)
                store(expansion.emitter, group, recent[m], "%work", m)
                recent.pop(m - RECENT, None)
        layout = expansion.layout
        if self.k >= 0:
            store_rows(expansion.emitter, layout.width, self.state(), "%work", layout.width * (self.k + 1))
        for index, one in enumerate(expansion.program.series):
            m = self.k + one.level
            if m >= 1 and index in layout.rows:
                expansion.emitter.store(expansion.table[index][m], "%work", layout.slot(index, m))

    def begin(self, index: int, one: Series) -> Value:
        """Coefficient 0."""
        expansion, emitter = self.expansion, self.expansion.emitter
        first = [expansion.table[i].get(0) for i in one.arguments]
        if one.op is Op.LINEAR:
            constant, scales = linear_data(one)
            total: Value = None
            for index, scale in zip(one.arguments, scales):
                total = expansion.add_scaled(scale, expansion.low.get(index), total)
            if not constant.is_zero:
                total = emitter.add(total, expansion.constant(constant))
            for value, scale in zip(first, scales):
                total = expansion.add_scaled(scale, value, total)
            return total
        if one.op is Op.MULTIPLY:
            a, b = one.arguments
            rest = emitter.fma(first[0], expansion.low.get(b), emitter.mul(first[1], expansion.low.get(a)))
            return emitter.fma(first[0], first[1], rest)
        if one.op is Op.DERIVATIVE:
            return expansion.table[one.arguments[0]][1]
        if one.op is Op.PRIMITIVE and one.node is None:
            return None
        return expansion.start(index)
