"""``Stage``: the recurrences by which one order of every series follows from the orders below.

For products and powers: Jorba and Zou, Experimental Mathematics 14 (2005), proposition 2.1. Every other
function z = f(u, ..) is the primitive of z' = sum_i (df/du_i) u_i', whose products are series themselves.
"""

from __future__ import annotations

from collections.abc import Iterable

from lagrange_cli.expression.graph import Kind, Node
from lagrange_cli.mechanics.series import Op, Series
from lagrange_cli.native.emitter import Value, literal
from lagrange_cli.native.expansion import Expansion
from lagrange_cli.records import dataclass, field


@dataclass
class Stage:
    """What written-out and looped stages share: the recurrences. ``ahead`` is an index relative to k."""

    expansion: Expansion
    top: dict[int, Value] = field(default_factory=dict)
    careful: bool = False
    """Whether what q and q_dot hold beyond their doubles still matters at this order."""

    def at(self, index: int, ahead: int) -> Value:
        """Coefficient k + ahead of a series."""
        raise NotImplementedError

    def middle(self, a: int, b: int, ahead: int) -> Value:
        """sum_{m=1}^{n-1} a[m] b[n-m] with n = k + ahead."""
        raise NotImplementedError

    def weighted(self, index: int, base: int, exponent: Value, ahead: int) -> Value:
        """sum_{m=1}^{n-1} (exponent (n-m) - m) base[n-m] series[m] with n = k + ahead."""
        raise NotImplementedError

    def number(self, ahead: int) -> Value:
        """k + ahead."""
        raise NotImplementedError

    def divided(self, value: Value, ahead: int) -> Value:
        """``value / (k + ahead)``, correctly rounded or nearly so.

        (A product with the rounded reciprocal errs by the same factor in every step: the energy would drift.)
        """
        raise NotImplementedError

    def product(self, a: int, b: int, ahead: int) -> Value:
        """Coefficient k + ahead (at least 1) of a product."""
        emitter, table = self.expansion.emitter, self.expansion.table
        total = self.middle(a, b, ahead)
        if self.careful:
            low = self.expansion.low
            total = emitter.fma(low.get(a), self.at(b, ahead), total)
            total = emitter.fma(self.at(a, ahead), low.get(b), total)
        total = emitter.fma(table[a][0], self.at(b, ahead), total)
        return emitter.fma(self.at(a, ahead), table[b][0], total)

    def recur(self, index: int) -> Value:
        """Coefficient k + level (at least 1) of a series from those of its operands."""
        expansion, emitter = self.expansion, self.expansion.emitter
        one = expansion.program.series[index]
        ahead = one.level
        if one.op in (Op.COORDINATE, Op.TIME):
            return literal(1.0) if one.op is Op.TIME and self.is_index(ahead, 1) else None
        if one.op is Op.LINEAR:
            total: Value = None
            for argument, scale in zip(one.arguments, linear_data(one)[1]):
                total = expansion.add_scaled(scale, self.at(argument, ahead), total)
            return total
        if one.op is Op.MULTIPLY:
            return self.product(one.arguments[0], one.arguments[1], ahead)
        if one.op is Op.DERIVATIVE:
            return emitter.mul(self.number(ahead + 1), self.at(one.arguments[0], ahead + 1))
        if one.op is Op.PRIMITIVE:
            return self.divided(self.at(one.arguments[0], ahead - 1), ahead)
        assert one.op is Op.POWER and isinstance(one.data, Node)
        gain, inverse = expansion.gains[index]
        base = one.arguments[0]
        if one.data.kind is Kind.NUMBER and one.data.data == -1.0:
            rest = emitter.neg(emitter.mul(inverse, self.middle(index, base, ahead)))
        else:
            rest = self.weighted(index, base, expansion.constants.value(emitter, one.data), ahead)
            rest = self.divided(emitter.mul(rest, inverse), ahead)
        return emitter.fma(gain, self.at(base, ahead), rest)

    def is_index(self, ahead: int, index: int) -> bool:
        """Whether k + ahead is ``index`` (in a loop it never is a small one)."""
        return False

    def correction(self, index: int, change: dict[int, Value]) -> Value:
        """What the change of the operands' newest coefficients adds to the newest one of a series."""
        expansion, emitter = self.expansion, self.expansion.emitter
        one = expansion.program.series[index]

        def changed(operand: int, ahead: int) -> Value:
            """The change of an operand's coefficient k + ahead: only its newest has changed."""
            newest = expansion.program.series[operand].level == ahead
            return change.get(operand) if newest else None

        if one.op is Op.LINEAR:
            total: Value = None
            for argument, scale in zip(one.arguments, linear_data(one)[1]):
                total = expansion.add_scaled(scale, changed(argument, one.level), total)
            return total
        if one.op is Op.MULTIPLY:
            a, b = one.arguments
            total = emitter.mul(expansion.table[b][0], changed(a, one.level))
            return emitter.fma(expansion.table[a][0], changed(b, one.level), total)
        if one.op is Op.DERIVATIVE:
            return emitter.mul(self.number(one.level + 1), changed(one.arguments[0], one.level + 1))
        if one.op is Op.PRIMITIVE:
            return self.divided(changed(one.arguments[0], one.level - 1), one.level)
        if one.op is Op.POWER:
            return emitter.mul(expansion.gains[index][0], changed(one.arguments[0], one.level))
        raise ValueError(f"{one.op} is never corrected")

    def solve(self) -> None:
        """The accelerations' coefficient k, and what it adds to everything that depends on it."""
        expansion, emitter, program = self.expansion, self.expansion.emitter, self.expansion.program
        accelerations = expansion.accelerations([self.at(index, 0) for index in program.residual])
        change: dict[int, Value] = {}
        for coordinate, velocity, value in zip(program.coordinates, program.velocities, accelerations):
            change[velocity] = self.divided(value, 1)
            change[coordinate] = self.divided(change[velocity], 2)
        for index in self.corrected():
            if index not in change:
                change[index] = self.correction(index, change)
            self.set_top(index, emitter.add(self.at(index, program.series[index].level), change[index]))

    def corrected(self) -> Iterable[int]:
        """Series that depend on the newest acceleration and are read again later."""
        read = {i for one in self.expansion.program.series for i in one.arguments}
        read |= {*self.expansion.program.coordinates, *self.expansion.program.velocities}
        return [i for i, one in enumerate(self.expansion.program.series) if one.corrected and i in read]

    def set_top(self, index: int, value: Value) -> None:
        """Set coefficient k + level of a series."""
        raise NotImplementedError


def linear_data(one: Series) -> tuple[Node, tuple[Node, ...]]:
    """Constant and coefficients of a LINEAR series."""
    assert isinstance(one.data, tuple)
    constant, scales = one.data
    return constant, scales


def reciprocal_rest(m: int) -> float:
    """What 1/m is more than the double 1.0/m."""
    above, below = (1.0 / m).as_integer_ratio()
    return (below - m * above) / (m * below)
