"""``@jet`` in double-double: rows of coefficients in memory.

Stages with coefficients 0 and 1 are written out, the others are a loop. The series are in (t - t0)/scale, a
power of two about as long as a step: so they do not overflow near a singularity.
"""

from __future__ import annotations

from functools import partial

from lagrange_cli.mechanics.residual import Residual
from lagrange_cli.native.functions import elementary
from lagrange_cli.native.interface import LANES
from lagrange_cli.native.linear.blocks import Factorization
from lagrange_cli.native.linear.lu import LargeGeneral
from lagrange_cli.native.llvm.text import Operand, Value, literal
from lagrange_cli.native.numbers.double_double import TYPE, DoubleDouble, DoubleDoubleBody, Pair, function
from lagrange_cli.native.numbers.error_free import fast_sum, two_product, two_sum
from lagrange_cli.native.numbers.lanes import VECTOR, LaneEmitter
from lagrange_cli.native.recurrences.cyclic_momenta import cyclic_values
from lagrange_cli.native.recurrences.evaluation import Constants
from lagrange_cli.native.recurrences.expansion import Expansion
from lagrange_cli.native.recurrences.layout_rows import Rows
from lagrange_cli.native.recurrences.stage import Factors, Stage
from lagrange_cli.records import dataclass

UNROLLED = {"definite": 5, "general": 0}
"""Rows of a block up to which its elimination is written out."""


@dataclass
class Memory:
    """Where the coefficients of the series are, for all stages; ``inverse`` is 1/scale."""

    expansion: Expansion[Pair]
    kind: DoubleDouble
    rows: Rows
    inverse: Value


class Firsts(dict[int, "Pair | None"]):
    """Coefficient 0 of a series, loaded where it is needed: what a loop holds for long costs more."""

    def __init__(self, memory: Memory, row: int) -> None:
        self._memory, self._place = memory, memory.rows.row(row)

    def __missing__(self, m: int) -> Pair:
        return self._memory.kind.load("%work", self._place + m, self._memory.rows.beyond)


class InMemory(Stage[Pair]):
    """Stage ``k``, a number or the counter of a loop."""

    whole = True

    def __init__(self, memory: Memory, k: int | str) -> None:
        super().__init__(memory.expansion)
        self.k, self._memory, self._body = k, memory, memory.kind.body
        self._base, self._offset = ("%work", k) if isinstance(k, int) else (self._body.place("%work", k), 0)

    def index(self, ahead: int) -> int | str:
        """k + ahead."""
        return self.k + ahead if isinstance(self.k, int) else self._body.integer("add", self.k, ahead)

    def real(self, ahead: int) -> Value:
        """The same as a double."""
        n = self.index(ahead)
        return literal(n) if isinstance(n, int) else self._body.define(f"sitofp i64 {n} to double")

    def slot(self, row: int, ahead: int) -> int:
        """Where coefficient k + ahead of a row is, from ``_base`` on."""
        return self._memory.rows.row(row) + self._offset + ahead

    def rate(self, ahead: int) -> Value:
        """What derivation multiplies coefficient k + ahead with."""
        return self._body.mul(self.real(ahead), self._memory.inverse)

    def is_index(self, ahead: int, index: int) -> bool:
        return isinstance(self.k, int) and self.k + ahead == index

    def at(self, index: int, ahead: int) -> Pair | None:
        if ahead == self.expansion.program.series[index].level and index in self.top:
            return self.top[index]
        if isinstance(self.k, int) and self.k + ahead < 0:
            return None
        return self._memory.kind.load(self._base, self.slot(index, ahead), self._memory.rows.beyond)

    def set_top(self, index: int, value: Pair | None) -> None:
        self.top[index] = value
        level = self.expansion.program.series[index].level
        self.put(index, value, level)
        if self.is_index(level, 0):
            self.expansion.table[index][0] = value

    def put(self, row: int, value: Pair | None, ahead: int) -> None:
        """Store coefficient k + ahead of a row; one that is 0 is there already."""
        if value is not None:
            self._memory.kind.store(value, self._base, self.slot(row, ahead), self._memory.rows.beyond)

    def reciprocal(self, ahead: int) -> Pair | None:
        return None

    def divided(self, value: Pair | None, ahead: int) -> Pair | None:
        return None if value is None else value.divided(self.real(ahead))

    def derived(self, value: Pair | None, ahead: int, start: Pair | None = None) -> Pair | None:
        return start if value is None else self._memory.kind.add(start, value.scaled(self.rate(ahead)))

    def integrated(self, value: Pair | None, ahead: int) -> Pair | None:
        return None if value is None else value.divided(self.rate(ahead))

    def dot(
        self, index: int, a: int, b: int, ahead: int, weighted: bool = False
    ) -> tuple[Pair | None, Factors[Pair]]:
        rows = self._memory.rows
        first = rows.row(rows.weighted[a] if weighted else a)
        places = ", ".join(f"ptr {self._body.place('%work', row)}" for row in (first, rows.row(b)))
        made = self._body.define(f"call {TYPE} @convolve({places}, i64 {self.index(ahead)})")
        return self._body.unpacked(made), []

    def write(self) -> None:
        """Compute and store the stage's coefficients."""
        series, k = self.expansion.program.series, self.k
        known = [i for i, one in enumerate(series) if isinstance(k, str) or k + one.level >= 0]
        self.evaluate(known)
        if k == 0:
            self.expansion.factor()
        if isinstance(k, str) or k >= 0:
            self.solve()
        for index, row in self._memory.rows.weighted.items():
            level, value = series[index].level, self.top.get(index)
            if value is not None and not self.is_index(level, 0):
                self.put(row, value.scaled(self.real(level)), level)


def write_jet(residual: Residual, rows: Rows, constants: Constants) -> tuple[str, int, int]:
    """The text of ``i1 @jet(constants, t, its low part, scale, state, work)``, false where M is singular, and
    of what it calls; the doubles of ``work``; and the number of operations."""
    kind, program, model = DoubleDouble(), rows.program, residual.model
    body = kind.body
    body.line(f"  call void @clear(ptr %work, i64 {rows.blocks})")
    time = Pair(body, "%t", "%tl")

    large = dict.fromkeys(UNROLLED, partial(LargeGeneral[Pair], kind))
    factorization = Factorization(kind, rows.blocks, large, UNROLLED)
    expansion = Expansion(residual, program, kind, constants, factorization, time, rows.width)
    if residual.cyclic_momenta:
        known = {x: kind.load("%state", i, rows.width) for i, x in enumerate((*model.q, *model.v))}
        known[model.time] = time
        expansion.cyclic = cyclic_values(kind, residual, program, rows.width, {**known}, constants)[0]
    memory = Memory(expansion, kind, rows, body.div(literal(1.0), "%scale"))
    last = rows.order - 2
    looped = min(max(1, 2 - min(one.level for one in program.series)), last + 1)
    for k in range(-2, looped):
        InMemory(memory, k).write()
    expansion.table = [Firsts(memory, row) for row in range(len(program.series))]
    body.loop(looped, last + 1, lambda k: InMemory(memory, k).write())
    body.line(f"  ret i1 {expansion.regular}")
    heads = "ptr %constants, double %t, double %tl, double %scale, ptr %state, ptr %work"
    text = "".join([*factorization.functions, convolve(rows.beyond), function(f"i1 @jet({heads})", body)])
    return text, factorization.place, body.operations


def convolve(beyond: int) -> str:
    """``@convolve(a, b, n)``: sum_{m=0}^{n} a[m] b[n-m].

    ``a`` and ``b`` are the addresses of coefficients 0; low parts are ``beyond`` doubles behind, and
    there are zeros before coefficients 0. A lane has the sum of every eighth term, and apart from it all that
    was rounded off.
    """
    e, lanes = DoubleDoubleBody(), LaneEmitter(elementary, "%w")
    lanes.lines = e.lines
    sums = e.define(f"alloca [2 x {VECTOR}], align 64")
    for part in range(2):
        lanes.store(None, sums, part)
    order = ", ".join(f"i32 {LANES - 1 - lane}" for lane in range(LANES))

    def load(pointer: str, align: int) -> tuple[Operand, Operand]:
        high, low = (
            lanes.define(f"load {VECTOR}, ptr {e.place(pointer, offset)}, align {align}")
            for offset in (0, beyond)
        )
        return high, low

    def term(m: str) -> None:
        high, low = load(e.place("%a", m), 64)
        last = e.place("%b", e.integer("sub", e.integer("sub", "%n", m), LANES - 1))
        other, lower = (
            lanes.define(f"shufflevector {VECTOR} {x}, {VECTOR} poison, <{LANES} x i32> <{order}>")
            for x in load(last, 8)
        )
        product, error = two_product(lanes, high, other)
        error = lanes.exact_fma(low, other, lanes.exact_fma(high, lower, error))
        total, lost = two_sum(lanes, lanes.load(sums, 0), product)
        rest = lanes.add(lanes.load(sums, 1), lanes.add(lost, error))
        lanes.store(total, sums, 0)
        lanes.store(rest, sums, 1)

    e.loop(0, e.integer("add", "%n", 1), term, by=LANES)
    totals: list[tuple[Value, Value]] = [
        (
            e.define(f"extractelement {VECTOR} {high}, i64 {i}"),
            e.define(f"extractelement {VECTOR} {low}, i64 {i}"),
        )
        for high, low in [(lanes.load(sums, 0), lanes.load(sums, 1))]
        for i in range(LANES)
    ]
    while len(totals) > 1:
        pairs = []
        for (a, low_a), (b, low_b) in zip(totals[::2], totals[1::2]):
            total, error = two_sum(e, a, b)
            pairs.append((total, e.add(error, e.add(low_a, low_b))))
        totals = pairs
    e.returned(Pair(e, *fast_sum(e, *totals[0])))
    return function(f"{TYPE} @convolve(ptr %a, ptr %b, i64 %n)", e)
