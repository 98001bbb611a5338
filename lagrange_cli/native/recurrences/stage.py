"""``Stage``: the recurrences by which one order of every series follows from the orders below.

For products and powers: Jorba and Zou, Experimental Mathematics 14 (2005), proposition 2.1. Every other
function z = f(u, ..) is the primitive of z' = sum_i (df/du_i) u_i', whose products are series themselves.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import Generic, TypeAlias

from lagrange_cli.expression.node import Node
from lagrange_cli.native.numbers.kind import V
from lagrange_cli.native.recurrences.expansion import Expansion
from lagrange_cli.records import dataclass, field
from lagrange_cli.series.program import Op, Series, reciprocal

Factors: TypeAlias = "list[tuple[V | None, V | None]]"


@dataclass
class Stage(Generic[V]):
    """The common base of stages in any schedule: the recurrences, for any kind of numbers. ``ahead`` is an
    index relative to k.

    ``sums`` holds the dot products of the stage that were made side by side, by series and whether weighted:
    a sum, and the factors of what is still to be added to it.
    """

    expansion: Expansion[V]
    top: dict[int, V | None] = field(default_factory=dict)
    careful: bool = False
    """Whether the remainders of q and q_dot still matter at this order."""
    sums: dict[tuple[int, bool], tuple[V | None, Factors[V]]] = field(default_factory=dict)

    whole = False
    """Whether dot products have both their ends, the terms with a coefficient 0."""

    def at(self, index: int, ahead: int) -> V | None:
        """Coefficient k + ahead of a series."""
        raise NotImplementedError

    def set_top(self, index: int, value: V | None) -> None:
        """Set coefficient k + level of a series."""
        raise NotImplementedError

    def products(self, a: int, b: int, ahead: int) -> list[tuple[V | None, V | None, V | None]]:
        """(m, a[m], b[n-m]) for m = 1 .. n-1, n = k + ahead, as far as neither is 0."""
        raise NotImplementedError

    def number(self, ahead: int) -> V | None:
        """k + ahead."""
        raise NotImplementedError

    def reciprocal(self, ahead: int) -> V | None:
        """1 / (k + ahead); None where its rounding counts.

        (A product with the rounded reciprocal errs by the same factor in every step: the energy would drift.)
        """
        raise NotImplementedError

    def is_index(self, ahead: int, index: int) -> bool:
        """Whether k + ahead is ``index`` (in a loop it never is a small one)."""
        return False

    def divided(self, value: V | None, ahead: int) -> V | None:
        """``value / (k + ahead)``, correctly rounded or nearly so where that counts."""
        return self.expansion.kind.mul(value, self.reciprocal(ahead))

    def derived(self, value: V | None, ahead: int, start: V | None = None) -> V | None:
        """``start`` + what coefficient k + ahead of a series gives to its derivative."""
        return self.expansion.kind.total([(self.number(ahead), value)], start)

    def integrated(self, value: V | None, ahead: int) -> V | None:
        """The contribution of a rate to coefficient k + ahead."""
        return self.divided(value, ahead)

    def evaluate(self, moving: Iterable[int]) -> None:
        """Coefficients k + level of these series, as far as they are known before the accelerations."""
        for index in moving:
            begins = self.is_index(self.expansion.program.series[index].level, 0)
            self.set_top(index, self.begin(index) if begins else self.recur(index))

    def begin(self, index: int) -> V | None:
        """Coefficient 0 of a series."""
        one = self.expansion.program.series[index]
        if one.op is Op.DERIVATIVE:
            return self.derived(self.at(one.arguments[0], one.level + 1), one.level + 1)
        return self.expansion.start(index)

    def product(self, index: int, one: Series) -> V | None:
        """Coefficient k + level (at least 1) of a product."""
        kind, table, ahead = self.expansion.kind, self.expansion.table, one.level
        a, b = one.arguments
        terms: Factors[V] = []
        if not self.whole:
            terms = [(table[a][0], self.at(b, ahead)), (self.at(a, ahead), table[b][0])]
        if self.careful:
            low = self.expansion.remainders
            terms += [(low.get(a), self.at(b, ahead)), (self.at(a, ahead), low.get(b))]
        start, rest = self.dot(index, a, b, ahead)
        return kind.total([*rest, *terms], start)

    def dot(
        self, index: int, a: int, b: int, ahead: int, weighted: bool = False
    ) -> tuple[V | None, Factors[V]]:
        """sum_{m=1}^{n-1} w(m) a[m] b[n-m], n = k + ahead: a sum, and the factors of what is still to be
        added to it."""
        if (index, weighted) in self.sums:
            return self.sums[index, weighted]
        products = self.products(a, b, ahead)
        return None, [(self.expansion.kind.mul(m, x) if weighted else x, y) for m, x, y in products]

    def power(self, index: int, one: Series) -> V | None:
        """Coefficient k + level (at least 1) of a power p = x^e.

        With n = k + level, n x[0] p[n] = sum_{m<n} (e (n-m) - m) x[n-m] p[m].
        """
        expansion, kind, ahead, base = self.expansion, self.expansion.kind, one.level, one.arguments[0]
        assert isinstance(one.data, Node)
        sensitivity, inverse = expansion.sensitivities[index]
        start, terms = self.dot(index, index, base, ahead)
        plain = kind.total(terms, start)
        if reciprocal(one.data):
            rest = kind.neg(plain)
        else:
            exponent = expansion.constant(one.data)
            start, terms = self.dot(index, index, base, ahead, weighted=True)
            weighted = kind.total(terms, start)
            weighted = kind.mul(kind.add(exponent, kind.one), self.divided(weighted, ahead))
            rest = kind.sub(kind.mul(exponent, plain), weighted)
        if self.whole:
            return kind.mul(rest, inverse)
        return kind.fma(sensitivity, self.at(base, ahead), kind.mul(rest, inverse))

    def recur(self, index: int) -> V | None:
        """Coefficient k + level (at least 1) of a series from those of its operands."""
        expansion = self.expansion
        one = expansion.program.series[index]
        ahead = one.level
        if one.op in (Op.COORDINATE, Op.TIME):
            if not self.is_index(ahead, 1):
                return None
            coordinates = expansion.program.coordinates
            rate = expansion.kind.one if one.op is Op.TIME else expansion.velocity(coordinates.index(index))
            return self.integrated(rate, ahead)
        if one.op is Op.MULTIPLIER:
            return None
        if one.op is Op.LINEAR:
            values = [self.at(argument, ahead) for argument in one.arguments]
            return expansion.linear(one, values, careful=self.careful)
        if one.op is Op.MULTIPLY:
            return self.product(index, one)
        if one.op is Op.SELECT:
            above, below = (self.at(argument, ahead) for argument in one.arguments)
            return expansion.select(one, above, below)
        if one.op is Op.DERIVATIVE:
            return self.derived(self.at(one.arguments[0], ahead + 1), ahead + 1)
        if one.op is Op.PRIMITIVE:
            return self.integrated(self.at(one.arguments[0], ahead - 1), ahead)
        assert one.op is Op.POWER
        return self.power(index, one)

    def correction(self, index: int, change: dict[int, V | None], start: V | None) -> V | None:
        """``start`` + what the change of the operands' newest coefficients adds to a series' newest one."""
        expansion, kind = self.expansion, self.expansion.kind
        one = expansion.program.series[index]

        def changed(operand: int, ahead: int) -> V | None:
            """The change of an operand's coefficient k + ahead: only its newest has changed."""
            newest = expansion.program.series[operand].level == ahead
            return change.get(operand) if newest else None

        if one.op is Op.LINEAR:
            changes = [changed(argument, one.level) for argument in one.arguments]
            return expansion.linear(one, changes, start, self.careful)
        if one.op is Op.MULTIPLY:
            both = [changed(argument, one.level) for argument in one.arguments]
            pairs = [(one.arguments[1], both[0]), (one.arguments[0], both[1])]
            terms = [(expansion.table[other][0], value) for other, value in pairs if value is not None]
            first, second = both
            if self.is_index(one.level, 0) and first is not None and second is not None:
                terms.append((kind.neg(first), second))  # both have changed since the product
            return kind.total(terms, start)
        if one.op is Op.SELECT:
            above, below = (changed(argument, one.level) for argument in one.arguments)
            return kind.add(start, expansion.select(one, above, below))
        if one.op is Op.DERIVATIVE:
            return self.derived(changed(one.arguments[0], one.level + 1), one.level + 1, start)
        if one.op is Op.PRIMITIVE and self.is_index(one.level, 0):
            return start  # of multipliers that have been found already
        if one.op is Op.PRIMITIVE:
            return kind.add(start, self.integrated(changed(one.arguments[0], one.level - 1), one.level))
        if one.op is Op.POWER:
            return kind.total(
                [(expansion.sensitivities[index][0], changed(one.arguments[0], one.level))], start
            )
        raise ValueError(f"{one.op} is never corrected")

    def solve(self) -> None:
        """The accelerations' coefficient k, and what it adds to everything that depends on it."""
        expansion, program, kind = self.expansion, self.expansion.program, self.expansion.kind
        inverse = self.reciprocal(1)
        scale = kind.number(-1.0) if inverse is None else kind.neg(inverse)
        solved = expansion.solved([self.at(index, 0) for index in program.residual], scale)
        change: dict[int, V | None] = {}
        unknown = program.unknown
        for (coordinate, velocity), value in zip(unknown, solved):
            change[velocity] = self.integrated(value, 1) if inverse is None else value
            change[coordinate] = self.integrated(change[velocity], 2)
        for multiplier, value in zip(program.multipliers, solved[len(unknown) :]):
            change[multiplier] = value if inverse is None else kind.mul(value, self.number(1))
        given = set(change)
        corrected = list(self.corrected())
        read = {i for index in corrected for i in program.series[index].arguments}
        for index in corrected:
            if self.is_index(program.series[index].level, -1):
                continue  # rates of multipliers begin with the next stage
            old = self.at(index, program.series[index].level)
            if index not in given and (index in read or not kind.fused):
                change[index] = self.correction(index, change, None)
            if index in given or not kind.fused:
                self.set_top(index, kind.add(old, change[index]))
            else:
                self.set_top(index, self.correction(index, change, old))

    def corrected(self) -> Iterable[int]:
        """Series that depend on the newest acceleration and are read again later, or are rows of the
        state."""
        program = self.expansion.program
        read = {*program.state, *(i for one in program.series for i in one.arguments)}
        return [i for i, one in enumerate(program.series) if one.corrected and i in read]


def reciprocal_rest(m: int) -> float:
    """The rounding error of the double 1.0/m."""
    above, below = (1.0 / m).as_integer_ratio()
    return (below - m * above) / (m * below)
