"""``Stage``: the recurrences by which one order of every series follows from the orders below.

For products and powers: Jorba and Zou, Experimental Mathematics 14 (2005), proposition 2.1. Every other
function z = f(u, ..) is the primitive of z' = sum_i (df/du_i) u_i', whose products are series themselves.
"""

from __future__ import annotations

from collections.abc import Iterable

from lagrange_cli.expression.node import Node
from lagrange_cli.native.numbers.double import ONE, Operand, Value, literal
from lagrange_cli.native.recurrences.convolution import Pair, packed, vector
from lagrange_cli.native.recurrences.expansion import Expansion
from lagrange_cli.native.recurrences.layout import Group
from lagrange_cli.records import dataclass, field
from lagrange_cli.series.program import Op, Series, reciprocal


@dataclass
class Stage:
    """What written-out and looped stages share: the recurrences. ``ahead`` is an index relative to k.

    ``sums`` holds the dot products of the stage that were made side by side, by series and whether weighted:
    a sum, and the factors of what is still to be added to it.
    """

    expansion: Expansion
    top: dict[int, Value] = field(default_factory=dict)
    careful: bool = False
    """Whether what q and q_dot hold beyond their doubles still matters at this order."""
    sums: dict[tuple[int, bool], tuple[Value, list[tuple[Value, Value]]]] = field(default_factory=dict)

    def at(self, index: int, ahead: int) -> Value:
        """Coefficient k + ahead of a series."""
        raise NotImplementedError

    def products(self, a: int, b: int, ahead: int) -> list[tuple[Value, Value, Value]]:
        """(m, a[m], b[n-m]) for m = 1 .. n-1, n = k + ahead, as far as neither is 0."""
        raise NotImplementedError

    def number(self, ahead: int) -> Value:
        """k + ahead."""
        raise NotImplementedError

    def reciprocal(self, ahead: int) -> Value:
        """1 / (k + ahead); None where its rounding counts.

        (A product with the rounded reciprocal errs by the same factor in every step: the energy would drift.)
        """
        raise NotImplementedError

    def divided(self, value: Value, ahead: int) -> Value:
        """``value / (k + ahead)``, correctly rounded or nearly so where that counts."""
        return self.expansion.emitter.mul(value, self.reciprocal(ahead))

    def product(self, index: int, one: Series) -> Value:
        """Coefficient k + level (at least 1) of a product."""
        emitter, table, ahead = self.expansion.emitter, self.expansion.table, one.level
        a, b = one.arguments
        terms = [(table[a][0], self.at(b, ahead)), (self.at(a, ahead), table[b][0])]
        if self.careful:
            low = self.expansion.low
            terms += [(low.get(a), self.at(b, ahead)), (self.at(a, ahead), low.get(b))]
        start, rest = self.dot(index, a, b, ahead)
        return emitter.total([*rest, *terms], start)

    def dot(
        self, index: int, a: int, b: int, ahead: int, weighted: bool = False
    ) -> tuple[Value, list[tuple[Value, Value]]]:
        """sum_{m=1}^{n-1} w(m) a[m] b[n-m], n = k + ahead: a sum, and the factors of what is still to be
        added to it."""
        if (index, weighted) in self.sums:
            return self.sums[index, weighted]
        products = self.products(a, b, ahead)
        return None, [(self.expansion.emitter.mul(m, x) if weighted else x, y) for m, x, y in products]

    def power(self, index: int, one: Series) -> Value:
        """Coefficient k + level (at least 1) of a power p = x^e.

        With n = k + level, n x[0] p[n] = sum_{m<n} (e (n-m) - m) x[n-m] p[m].
        """
        expansion, emitter, ahead, base = self.expansion, self.expansion.emitter, one.level, one.arguments[0]
        assert isinstance(one.data, Node)
        gain, inverse = expansion.gains[index]
        start, terms = self.dot(index, index, base, ahead)
        plain = emitter.total(terms, start)
        if reciprocal(one.data):
            rest = emitter.neg(plain)
        else:
            exponent = expansion.constants.value(emitter, one.data)
            start, terms = self.dot(index, index, base, ahead, weighted=True)
            weighted = emitter.total(terms, start)
            weighted = emitter.mul(emitter.add(exponent, ONE), self.divided(weighted, ahead))
            rest = emitter.sub(emitter.mul(exponent, plain), weighted)
        return emitter.fma(gain, self.at(base, ahead), emitter.mul(rest, inverse))

    def recur(self, index: int) -> Value:
        """Coefficient k + level (at least 1) of a series from those of its operands."""
        expansion, emitter = self.expansion, self.expansion.emitter
        one = expansion.program.series[index]
        ahead = one.level
        if one.op in (Op.COORDINATE, Op.TIME):
            return literal(1.0) if one.op is Op.TIME and self.is_index(ahead, 1) else None
        if one.op is Op.LINEAR:
            return expansion.linear(one, [self.at(argument, ahead) for argument in one.arguments])
        if one.op is Op.MULTIPLY:
            return self.product(index, one)
        if one.op is Op.DERIVATIVE:
            return emitter.mul(self.number(ahead + 1), self.at(one.arguments[0], ahead + 1))
        if one.op is Op.PRIMITIVE:
            return self.divided(self.at(one.arguments[0], ahead - 1), ahead)
        assert one.op is Op.POWER
        return self.power(index, one)

    def is_index(self, ahead: int, index: int) -> bool:
        """Whether k + ahead is ``index`` (in a loop it never is a small one)."""
        return False

    def correction(self, index: int, change: dict[int, Value], start: Value) -> Value:
        """``start`` + what the change of the operands' newest coefficients adds to a series' newest one."""
        expansion, emitter = self.expansion, self.expansion.emitter
        one = expansion.program.series[index]

        def changed(operand: int, ahead: int) -> Value:
            """The change of an operand's coefficient k + ahead: only its newest has changed."""
            newest = expansion.program.series[operand].level == ahead
            return change.get(operand) if newest else None

        if one.op is Op.LINEAR:
            return expansion.linear(one, [changed(argument, one.level) for argument in one.arguments], start)
        if one.op is Op.MULTIPLY:
            a, b = one.arguments
            terms = [
                (expansion.table[b][0], changed(a, one.level)),
                (expansion.table[a][0], changed(b, one.level)),
            ]
            return emitter.total(terms, start)
        if one.op is Op.DERIVATIVE:
            return emitter.total(
                [(self.number(one.level + 1), changed(one.arguments[0], one.level + 1))], start
            )
        if one.op is Op.PRIMITIVE:
            return emitter.add(start, self.divided(changed(one.arguments[0], one.level - 1), one.level))
        if one.op is Op.POWER:
            return emitter.total([(expansion.gains[index][0], changed(one.arguments[0], one.level))], start)
        raise ValueError(f"{one.op} is never corrected")

    def solve(self) -> None:
        """The accelerations' coefficient k, and what it adds to everything that depends on it."""
        expansion, program = self.expansion, self.expansion.program
        inverse = self.reciprocal(1)
        scale = literal(-1.0) if inverse is None else expansion.emitter.neg(inverse)
        solved = expansion.solved([self.at(index, 0) for index in program.residual], scale)
        change: dict[int, Value] = {}
        for coordinate, velocity, value in zip(program.coordinates, program.velocities, solved):
            change[velocity] = self.divided(value, 1) if inverse is None else value
            change[coordinate] = self.divided(change[velocity], 2)
        given = set(change)
        corrected = list(self.corrected())
        read = {i for index in corrected for i in program.series[index].arguments}
        for index in corrected:
            old = self.at(index, program.series[index].level)
            if index in given:
                self.set_top(index, expansion.emitter.add(old, change[index]))
                continue
            if index in read:
                change[index] = self.correction(index, change, None)
            self.set_top(index, self.correction(index, change, old))

    def corrected(self) -> Iterable[int]:
        """Series that depend on the newest acceleration and are read again later."""
        read = {i for one in self.expansion.program.series for i in one.arguments}
        read |= {*self.expansion.program.coordinates, *self.expansion.program.velocities}
        return [i for i, one in enumerate(self.expansion.program.series) if one.corrected and i in read]

    def set_top(self, index: int, value: Value) -> None:
        """Set coefficient k + level of a series."""
        raise NotImplementedError

    def take(self, group: Group, total: Operand | None) -> None:
        """Take ``sums`` from the vector sums of a group; to be added is what its vectors do not hold."""
        emitter = self.expansion.emitter
        for lane, (dot, (first, second)) in enumerate(zip(group.dots, group.shifts)):
            start = total and emitter.define(f"extractelement {vector(group)} {total}, i64 {lane}")
            table, n = self.expansion.table, dot.level
            terms: list[tuple[Value, Value]] = []
            for m in range(1, first + 1):
                a = table[dot.a].get(m)
                terms.append((emitter.mul(literal(m), a) if dot.weighted else a, self.at(dot.b, n - m)))
            for m in range(1, second + 1):
                a = self.at(dot.a, n - m)
                weight = self.number(n - m) if dot.weighted else ONE
                terms.append((emitter.mul(weight, a), table[dot.b].get(m)))
            self.sums[dot.index, dot.weighted] = start, terms

    def vectors(self, group: Group) -> Pair:
        """Vectors k + level of the group."""
        emitter = self.expansion.emitter
        first: list[Value] = []
        second: list[Value] = []
        for dot, shifts in zip(group.dots, group.shifts):
            a, b = (group.level + shift for shift in shifts)
            value = self.at(dot.a, a)
            first.append(emitter.mul(self.number(a), value) if dot.weighted else value)
            second.append(self.at(dot.b, b))
        return packed(emitter, group, first), packed(emitter, group, second)

    def state(self) -> list[Value]:
        """Coefficients k + 1 of q, v and the integrals."""
        return [self.at(index, 1) for index in self.expansion.layout.state]


def linear_data(one: Series) -> tuple[Node, tuple[Node, ...]]:
    """Constant and coefficients of a LINEAR series."""
    assert isinstance(one.data, tuple)
    constant, scales = one.data
    return constant, scales


def reciprocal_rest(m: int) -> float:
    """What 1/m is more than the double 1.0/m."""
    above, below = (1.0 / m).as_integer_ratio()
    return (below - m * above) / (m * below)
