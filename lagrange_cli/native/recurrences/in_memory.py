"""``@jet`` in double-double: rows of coefficients in memory.

Stages with coefficients 0 and 1 are unrolled, the others are a loop. The series are in (t - t0)/scale, a
power of two about as long as a step: so they do not overflow near a singularity.
"""

from __future__ import annotations

from functools import partial

from lagrange_cli.mechanics.residual import Residual
from lagrange_cli.native.interface import LANES
from lagrange_cli.native.linear.blocks import Factorization
from lagrange_cli.native.llvm.function import Function
from lagrange_cli.native.llvm.vector import Bit, Index, Integer, Real
from lagrange_cli.native.numbers.double_double import TYPE, DDReal, DoubleDouble, called
from lagrange_cli.native.numbers.error_free import fast_sum, two_sum
from lagrange_cli.native.recurrences.cyclic_momenta import cyclic_values
from lagrange_cli.native.recurrences.evaluation import Constants, Loaded
from lagrange_cli.native.recurrences.expansion import Expansion
from lagrange_cli.native.recurrences.layout_rows import RowLayout
from lagrange_cli.native.recurrences.stage import Factors, Stage
from lagrange_cli.records import dataclass

UNROLLED = {"definite": 5, "general": 0}
"""Rows of a block up to which its elimination is unrolled."""


@dataclass
class Memory:
    """Where the coefficients of the series are, for all stages; ``inverse`` is 1/scale."""

    expansion: Expansion[DDReal]
    kind: DoubleDouble
    rows: RowLayout
    inverse: Real

    def load(self, row: int, m: int) -> DDReal:
        """Coefficient m of a row. (What a loop holds for long costs more than to load it.)"""
        return self.kind.load("%work", self.rows.row(row) + m, self.rows.beyond)


class InMemory(Stage[DDReal]):
    """Stage ``k``, a number or the counter of a loop."""

    whole = True

    def __init__(self, memory: Memory, k: Index) -> None:
        super().__init__(memory.expansion)
        self.k, self._memory, f = k, memory, memory.kind.body
        self._base, self._offset = ("%work", k) if isinstance(k, int) else (f.place("%work", k).name, 0)

    def real(self, ahead: int) -> Real:
        """k + ahead as a double."""
        n = self.k + ahead
        return n.to_real() if isinstance(n, Integer) else self._memory.kind.body.constant(float(n))

    def slot(self, row: int, ahead: int) -> int:
        """Where coefficient k + ahead of a row is, from ``_base`` on."""
        return self._memory.rows.row(row) + self._offset + ahead

    def rate(self, ahead: int) -> Real:
        """The factor of coefficient k + ahead in a derivative."""
        return self.real(ahead) * self._memory.inverse

    def is_index(self, ahead: int, index: int) -> bool:
        return isinstance(self.k, int) and self.k + ahead == index

    def at(self, index: int, ahead: int) -> DDReal | None:
        if ahead == self.expansion.program.series[index].level and index in self.top:
            return self.top[index]
        if isinstance(self.k, int) and self.k + ahead < 0:
            return None
        return self._memory.kind.load(self._base, self.slot(index, ahead), self._memory.rows.beyond)

    def set_top(self, index: int, value: DDReal | None) -> None:
        self.top[index] = value
        level = self.expansion.program.series[index].level
        self.put(index, value, level)
        if self.is_index(level, 0):
            self.expansion.table[index][0] = value

    def put(self, row: int, value: DDReal | None, ahead: int) -> None:
        """Store coefficient k + ahead of a row; one that is 0 is there already."""
        if value is not None:
            self._memory.kind.store(value, self._base, self.slot(row, ahead), self._memory.rows.beyond)

    def reciprocal(self, ahead: int) -> DDReal | None:
        return None

    def divided(self, value: DDReal | None, ahead: int) -> DDReal | None:
        return None if value is None else value.divided(self.real(ahead))

    def derived(self, value: DDReal | None, ahead: int, start: DDReal | None = None) -> DDReal | None:
        return start if value is None else self._memory.kind.add(start, value.scaled(self.rate(ahead)))

    def integrated(self, value: DDReal | None, ahead: int) -> DDReal | None:
        return None if value is None else value.divided(self.rate(ahead))

    def dot(
        self, index: int, a: int, b: int, ahead: int, weighted: bool = False
    ) -> tuple[DDReal | None, Factors[DDReal]]:
        rows, f, n = self._memory.rows, self._memory.kind.body, self.k + ahead
        first = rows.row(rows.weighted[a] if weighted else a)
        places = (f.place("%work", row) for row in (first, rows.row(b)))
        return called(f, "convolve", *places, f.count(n) if isinstance(n, int) else n), []

    def write(self) -> None:
        """Compute and store the stage's coefficients."""
        series, k = self.expansion.program.series, self.k
        known = [i for i, one in enumerate(series) if isinstance(k, Integer) or k + one.level >= 0]
        self.evaluate(known)
        if k == 0:
            self.expansion.factor()
        if isinstance(k, Integer) or k >= 0:
            self.solve()
        for index, row in self._memory.rows.weighted.items():
            level, value = series[index].level, self.top.get(index)
            if value is not None and not self.is_index(level, 0):
                self.put(row, value.scaled(self.real(level)), level)


def write_jet(residual: Residual, rows: RowLayout, constants: Constants) -> tuple[str, int, int]:
    """The text of ``i1 @jet(constants, t, its low part, scale, state, work)``, false where M is singular, and
    of what it calls; the doubles of ``work``; and the number of operations."""
    heads = "ptr %constants, double %t, double %tl, double %scale, ptr %state, ptr %work"
    f = Function(f"define internal i1 @jet({heads}) #0")
    kind, program, time = DoubleDouble(f), rows.program, DDReal(Real(f, "%t"), Real(f, "%tl"))
    f.call(None, "clear", f.pointer("%work"), f.count(rows.blocks))
    factorization = Factorization(kind, rows.blocks, UNROLLED)
    expansion = Expansion(residual, program, kind, constants, factorization, time, rows.width)
    if residual.cyclic_momenta:
        symbols = (*residual.state_q, *residual.state_v)
        known = {x: kind.load("%state", i, rows.width) for i, x in enumerate(symbols)}
        known[residual.model.time] = time
        expansion.cyclic = cyclic_values(kind, residual, program, rows.width, {**known}, constants)[0]
    memory = Memory(expansion, kind, rows, 1.0 / Real(f, "%scale"))
    last = rows.order - 2
    rolled = min(max(1, 2 - min(one.level for one in program.series)), last + 1)
    for k in range(-2, rolled):
        InMemory(memory, k).write()
    expansion.table = [Loaded(partial(memory.load, row)) for row in range(len(program.series))]
    with f.loop(rolled, last + 1) as counter:
        InMemory(memory, counter).write()
    f.give(Bit(f, expansion.regular))
    text = "".join([*factorization.functions, convolve(rows.beyond), f.text()])
    return text, factorization.place, f.operations


def convolve(beyond: int) -> str:
    """``@convolve(a, b, n)``: sum_{m=0}^{n} a[m] b[n-m].

    ``a`` and ``b`` are the addresses of coefficients 0; low parts are ``beyond`` doubles behind, and
    there are zeros before coefficients 0. A lane has the sum of every eighth term, and apart from it all that
    was rounded off.
    """
    f = Function(f"define internal {TYPE} @convolve(ptr %a, ptr %b, i64 %n) #0")
    n, zero = Integer(f, "%n"), f.splat(f.constant(0.0), LANES)
    high_sum, low_sum = f.variable(zero), f.variable(zero)

    def backward(index: Integer) -> Real:
        return f.shuffle(f.load_row("%b", index, LANES), [*reversed(range(LANES))])

    with f.loop(0, n + 1, LANES, tested=False) as m:
        high, low = (f.load_row("%a", m + part, LANES, aligned=True) for part in (0, beyond))
        last = n - m - (LANES - 1)
        other, lower = (backward(last + part) for part in (0, beyond))
        product = high * other
        error = f.fma(low, other, f.fma(high, lower, f.fma(high, other, -product)))
        total, lost = two_sum(high_sum.get(), product)
        high_sum.set(total)
        low_sum.set(low_sum.get() + (lost + error))
    sums = [(f.lane(high_sum.get(), i), f.lane(low_sum.get(), i)) for i in range(LANES)]
    while len(sums) > 1:
        pairs = [
            (*two_sum(one, other), low + lower) for (one, low), (other, lower) in zip(sums[::2], sums[1::2])
        ]
        sums = [(total, error + low) for total, error, low in pairs]
    f.give(*fast_sum(*sums[0]))
    return f.text()
