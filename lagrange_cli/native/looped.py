"""The later stages of a step, as the body of a loop whose convolutions run over vectors of coefficients.

sum_j x[j] y[n-j] pairs the oldest coefficients of one operand with the newest of the other. The old ones are
vectors in memory; the newest, reversed, are kept in *windows*, vectors that move on by one lane a stage.
(Reading
them from memory would wait for the stores of the stage before.) With j and n-j >= 2 in groups of 8 lanes,

    x[2..9] . (newest y)  +  y[2..9] . (newest x of index >= 10)  +  x[10..17] . (y of index >= 10, 8
    stages older),

and the pairs with index 0 and 1, the latest to be known, are scalars.
"""

from __future__ import annotations

from lagrange_cli.mechanics.series import SHORT
from lagrange_cli.native.emitter import ONE, Emitter, Value, literal, operand
from lagrange_cli.native.expansion import Expansion
from lagrange_cli.native.layout import LANES
from lagrange_cli.native.stage import Stage
from lagrange_cli.records import dataclass, field

VECTOR = f"<{LANES} x double>"
FIRST = 2
"""The first index that is taken by vectors."""
SECOND = FIRST + LANES
HIGHEST_ORDER = SECOND + 2 * LANES - 1
"""Up to here a convolution's three vector products hold all its pairs."""


@dataclass(frozen=True)
class Window:
    """Lane m at stage k holds coefficient k + ahead - lag - m of ``series``, or 0 below index ``floor``."""

    series: int
    ahead: int
    lag: int
    floor: int


@dataclass
class Loop:
    """A loop over the stages ``first`` .. ``last`` that is being written; ``windows`` maps to (phi, next)."""

    k: str
    first: int
    last: int
    before: dict[Window, str]
    windows: dict[Window, tuple[str, str]] = field(default_factory=dict)
    entry: list[str] = field(default_factory=list)
    phis: list[str] = field(default_factory=list)


class Looped(Stage):
    """One stage of ``loop``, of unknown ``k``."""

    def __init__(self, expansion: Expansion, loop: Loop, labels: tuple[str, str]) -> None:
        super().__init__(expansion)
        self.loop, self.labels = loop, labels
        self._known: dict[tuple[str, int], Value] = {}
        self._rows = expansion.emitter.define(f"getelementptr inbounds double, ptr %work, i64 {loop.k}")

    def at(self, index: int, ahead: int) -> Value:
        one = self.expansion.program.series[index]
        if one.degree < self.loop.first + ahead:
            return None
        if ahead == one.level:
            return self.top[index]
        return self._load(index, ahead)

    def _load(self, index: int, ahead: int) -> Value:
        key = (str(index), ahead)
        if key not in self._known:
            slot = self.expansion.layout.slot(index, ahead)
            self._known[key] = self.expansion.emitter.load(self._rows, slot)
        return self._known[key]

    def set_top(self, index: int, value: Value) -> None:
        self.top[index] = value

    def middle(self, a: int, b: int, ahead: int) -> Value:
        series = self.expansion.program.series
        if series[a].degree > SHORT:
            a, b = b, a
        if series[a].degree > SHORT:
            return self._dot(a, b, ahead, None)
        total: Value = None
        for m in range(1, series[a].degree + 1):
            total = self.expansion.emitter.fma(self.expansion.table[a].get(m), self.at(b, ahead - m), total)
        return total

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
        """sum_{m=1}^{n-1} w(m) a[m] b[n-m]; w = 1, or the power rule's weights if an exponent is given.

        These are exponent (n-m) - m, or in m' = n - m: exponent m' - (n - m').
        """
        emitter, table = self.expansion.emitter, self.expansion.table
        newest_a, newest_b = self.at(a, ahead - 1), self.at(b, ahead - 1)
        low_a, low_b = table[a].get(1), table[b].get(1)
        forth: tuple[Value, Value] | None = None
        back: tuple[Value, Value] | None = None
        if exponent is not None:  # weights as (constant, slope) in the index of the vector in memory
            rise = emitter.add(exponent, ONE)
            forth = (emitter.mul(exponent, self.number(ahead)), emitter.neg(rise))
            back = (emitter.neg(self.number(ahead)), rise)
            low_a = emitter.mul(low_a, emitter.add(*forth))
            low_b = emitter.mul(low_b, emitter.add(*back))
        total = self._vectors(None, a, FIRST, Window(b, ahead, FIRST, FIRST), forth)
        if self.loop.last + ahead >= SECOND + FIRST:
            total = self._vectors(total, b, FIRST, Window(a, ahead, FIRST, SECOND), back)
        if self.loop.last + ahead >= 2 * SECOND:
            total = self._vectors(total, a, SECOND, Window(b, ahead, SECOND, SECOND), forth)
        zero = operand(None)
        summed = emitter.define(
            f"call reassoc double @llvm.vector.reduce.fadd.v{LANES}f64(double {zero}, {VECTOR} {total})"
        )
        return emitter.fma(low_a, newest_b, emitter.fma(newest_a, low_b, summed))

    def _vectors(
        self, total: str | None, series: int, index: int, window: Window, weight: tuple[Value, Value] | None
    ) -> str:
        """``total`` + coefficients ``index`` .. of ``series``, times the window, times the weights."""
        emitter = self.expansion.emitter
        slot = self.expansion.layout.slot(series, index)
        place = emitter.define(f"getelementptr inbounds double, ptr %work, i64 {slot}")
        old = emitter.define(f"load {VECTOR}, ptr {place}, align 64")
        if weight is not None:
            constant, slope = (splat(emitter, value) for value in weight)
            steps = ", ".join(f"double {operand(literal(index + lane))}" for lane in range(LANES))
            old = emitter.define(f"fmul {VECTOR} {old}, {vector_fma(emitter, slope, f'<{steps}>', constant)}")
        emitter.operations += LANES
        new = self._window(window)
        if total is None:
            return emitter.define(f"fmul {VECTOR} {old}, {new}")
        return vector_fma(emitter, old, new, total)

    def _window(self, window: Window) -> str:
        """The window's value in this stage; made when first asked for."""
        loop = self.loop
        if window not in loop.windows:
            before, head = self.labels
            name, after = self.expansion.emitter.fresh(), self.expansion.emitter.fresh()
            start = loop.before.get(window) or self._start(window)
            loop.phis.append(f"  {name} = phi {VECTOR} [ {start}, %{before} ], [ {after}, %{head} ]")
            loop.windows[window] = (name, after)
        return loop.windows[window][0]

    def _start(self, window: Window) -> str:
        """Its value in the loop's first stage, from coefficients in memory."""
        emitter = Emitter(prefix=self.expansion.emitter.fresh() + ".")
        value = "zeroinitializer"
        for lane in range(LANES):
            index = self.loop.first + window.ahead - window.lag - lane
            if index >= window.floor:
                one = emitter.load("%work", self.expansion.layout.slot(window.series, index))
                value = emitter.define(f"insertelement {VECTOR} {value}, double {one}, i64 {lane}")
        self.loop.entry += emitter.lines
        return value

    def _move_on(self, window: Window, name: str, after: str) -> None:
        """The window's value in the next stage: everything one lane on, the next coefficient in front."""
        emitter = self.expansion.emitter
        ahead = window.ahead - window.lag + 1
        entering = operand(self._load(window.series, ahead))
        if self.loop.first + ahead < window.floor:
            low = emitter.define(f"icmp uge i64 {self.loop.k}, {window.floor - ahead}")
            entering = emitter.define(f"select i1 {low}, double {entering}, double {operand(None)}")
        first = emitter.define(f"insertelement {VECTOR} poison, double {entering}, i64 0")
        lanes = ", ".join(f"i32 {lane}" for lane in [LANES, *range(LANES - 1)])
        mask = f"<{LANES} x i32> <{lanes}>"
        emitter.line(f"  {after} = shufflevector {VECTOR} {name}, {VECTOR} {first}, {mask}")

    def _tabulated(self, name: str, ahead: int) -> Value:
        key = (name, ahead)
        if key not in self._known:
            emitter = self.expansion.emitter
            place = emitter.define(f"getelementptr inbounds double, ptr @{name}, i64 {self.loop.k}")
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
        moving = [
            (index, one)
            for index, one in enumerate(expansion.program.series)
            if one.degree >= self.loop.first + one.level
        ]
        self.top = dict.fromkeys(range(len(expansion.program.series)))
        for index, _ in moving:
            self.top[index] = self.recur(index)
        self.solve()
        for window, (name, after) in self.loop.windows.items():
            self._move_on(window, name, after)
        for index, one in moving:
            if index in expansion.layout.rows:
                expansion.emitter.store(self.top[index], self._rows, expansion.layout.slot(index, one.level))


def vector_fma(emitter: Emitter, a: str, b: str, c: str) -> str:
    """``a * b + c``, lane by lane."""
    return emitter.define(
        f"call {VECTOR} @llvm.fmuladd.v{LANES}f64({VECTOR} {a}, {VECTOR} {b}, {VECTOR} {c})"
    )


def splat(emitter: Emitter, value: Value) -> str:
    """A vector with ``value`` in every lane."""
    one = emitter.define(f"insertelement {VECTOR} poison, double {operand(value)}, i64 0")
    zeros = f"<{LANES} x i32> zeroinitializer"
    return emitter.define(f"shufflevector {VECTOR} {one}, {VECTOR} poison, {zeros}")
