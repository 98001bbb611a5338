"""``@paired_jet``: the Taylor coefficients of one step of eight motions, a lane for each.

What one motion computes with numbers is computed with vectors here, lane by lane: no lane ever sees another.
The first stages are unrolled; the others are a loop over pairs of stages, k and k + 1, whose sums of
products are made together by an inner loop:

    sum_m a[m] b[n-m]    and    sum_m a[m] b[n+1-m]

share what they read, so that two products take two vectors from memory.
"""

from __future__ import annotations

from collections.abc import Sequence

from lagrange_cli.mechanics.residual import Residual
from lagrange_cli.native.interface import LANES
from lagrange_cli.native.llvm.flow import Variable
from lagrange_cli.native.llvm.function import Function
from lagrange_cli.native.llvm.text import Value
from lagrange_cli.native.llvm.vector import Bit, Integer, Real
from lagrange_cli.native.numbers.lanes import LaneEmitter
from lagrange_cli.native.recurrences.compensated import compensated_expansion
from lagrange_cli.native.recurrences.evaluation import Constants
from lagrange_cli.native.recurrences.expansion import Expansion
from lagrange_cli.native.recurrences.layout import Dot, dot_products, read_alone
from lagrange_cli.native.recurrences.rolled import LoopStage
from lagrange_cli.native.recurrences.unrolled import CAREFUL, Unrolled
from lagrange_cli.records import dataclass
from lagrange_cli.series.program import Op, SeriesProgram


@dataclass(frozen=True)
class LaneLayout:
    """Rows of ``%work``: q, v and the integrals first, then what else is read after its stage.

    ``scaled`` are rows of the coefficients of powers times their index. Coefficients 0 are not stored.
    """

    order: int
    rows: dict[int, int]
    scaled: dict[int, int]
    dots: tuple[Dot, ...]

    @property
    def span(self) -> int:
        """Vectors in a row."""
        return self.order + 1

    @property
    def vectors(self) -> int:
        """Vectors in all."""
        return self.span * (len(self.rows) + len(self.scaled))

    def slot(self, row: int, index: int) -> int:
        """Where a coefficient lies."""
        return self.span * row + index

    def first(self, dot: Dot) -> int:
        """The row of a dot product's first operand."""
        return self.scaled[dot.a] if dot.weighted else self.rows[dot.a]

    def second(self, dot: Dot) -> int:
        """The row of its second operand."""
        return self.rows[dot.b]


def arrange_lanes(program: SeriesProgram, order: int) -> LaneLayout:
    """The layout for ``program`` with q's series to ``order``."""
    dots = tuple(sorted(dot_products(program), key=lambda dot: program.series[dot.index].level))
    together = [i for dot in dots for i in (dot.a, dot.b)]
    alone = [index for index, _ in read_alone(program, list(dots))]
    listed = dict.fromkeys([*program.state, *together, *alone])
    rows = {index: row for row, index in enumerate(listed)}
    scaled = dict.fromkeys(dot.a for dot in dots if dot.weighted)
    return LaneLayout(order, rows, {index: len(rows) + i for i, index in enumerate(scaled)}, dots)


FIRST = 2
"""The inner loop's first index; terms with an index below are the latest to be known."""
AT_ONCE = 8
"""Sums of one inner loop: three registers each, of 32."""


@dataclass
class Memory:
    """Where the coefficients of the series are, for all stages of the function ``f``."""

    f: Function
    expansion: Expansion[str]
    emitter: LaneEmitter
    layout: LaneLayout


def write_paired_jet(
    residual: Residual, program: SeriesProgram, constants: Constants, layout: LaneLayout, width: int
) -> str:
    """The function's IR: coefficients of q, v and the integrals into ``%work``; a bit for each lane, not set
    where M is singular."""
    arguments = "ptr noalias %constants, REAL %t, ptr noalias %state, ptr noalias %work"
    f = Function(f"define internal BIT @paired_jet({arguments}) #0", LANES)
    emitter = LaneEmitter(f)
    expansion = compensated_expansion(emitter, residual, program, constants, width, 0)
    memory = Memory(f, expansion, emitter, layout)
    last = layout.order - 2
    levels = [one.level for one in program.series if one.op in (Op.MULTIPLY, Op.POWER)]
    first = max(CAREFUL, *(FIRST + 1 - level for level in levels), 0)
    first += (last + 1 - first) % 2
    for k in range(-2, min(first, last + 1)):
        Opening(memory, k).write()
    if first <= last:
        write_pairs(memory, first, last)
    f.give(Bit(f, expansion.regular))
    return f.text()


class Opening(Unrolled[str]):
    """One of the first stages."""

    def __init__(self, memory: Memory, k: int) -> None:
        super().__init__(memory.expansion, k)
        self._memory = memory

    def store(self) -> None:
        emitter, layout = self._memory.emitter, self._memory.layout
        for index, one in enumerate(self.expansion.program.series):
            m = self.k + one.level
            if m >= 1 and index in layout.rows:
                emitter.store(self.at(index, one.level), "%work", layout.slot(layout.rows[index], m))
            if m >= 1 and index in layout.scaled:
                scaled = emitter.mul(emitter.number(m), self.at(index, one.level))
                emitter.store(scaled, "%work", layout.slot(layout.scaled[index], m))


def write_pairs(memory: Memory, first: int, last: int) -> None:
    """The loop over the pairs of stages from ``first`` on; the number of stages is even."""
    dots = memory.layout.dots
    with memory.f.loop(first, last, 2, tested=False) as k:
        rows = memory.emitter.place("%work", k.name)
        sums: dict[Dot, tuple[Value, Value]] = {}
        for start in range(0, len(dots), AT_ONCE):
            group = dots[start : start + AT_ONCE]
            sums |= zip(group, sums_of_pairs(memory, group, rows, k))
        one = LaneStage(memory, first, k, rows, None)
        one.write({dot: both[0] for dot, both in sums.items()})
        other = LaneStage(memory, first, k, rows, one)
        other.write({dot: both[1] for dot, both in sums.items()})


def sums_of_pairs(memory: Memory, dots: Sequence[Dot], rows: str, k: Integer) -> list[tuple[Value, Value]]:
    """The sums of ``dots`` for two stages, but for their ends; coefficient k of the first row is at ``rows``.

    With n = k + level these are the terms m = 2 .. n-2, of a[m] b[n-m] for stage k, of a[m] b[n+1-m] for
    k + 1. The latter b is what the former was for the m before.
    """
    f, emitter, layout = memory.f, memory.emitter, memory.layout
    places = [(layout.first(dot), layout.second(dot), dot.level) for dot in dots]
    later = {
        (b, level): f.variable(Real(f, emitter.load(rows, layout.slot(b, level - 1))))
        for b, level in dict.fromkeys((b, level) for _, b, level in places)
    }
    totals = [(f.variable(f.zero(LANES)), f.variable(f.zero(LANES))) for _ in dots]
    lowest = min(dot.level for dot in dots)  # as far as all sums go, they go together
    with f.loop(FIRST, k - (FIRST - lowest - 1)) as m:
        before = {key: variable.get().name for key, variable in later.items()}
        sums = [[variable.get().name for variable in both] for both in totals]
        forward = emitter.place("%work", m.name)
        backward = emitter.place(rows, (f.count(0) - m).name)
        old = {a: emitter.load(forward, layout.slot(a, 0)) for a in dict.fromkeys(a for a, _, _ in places)}
        new = {key: emitter.load(backward, layout.slot(*key)) for key in later}
        for (a, b, level), both, variables in zip(places, sums, totals):
            for factor, total, variable in zip((new[b, level], before[b, level]), both, variables):
                variable.set(Real(f, emitter.written(emitter.fma(old[a], factor, total))))
        for key, variable in later.items():
            variable.set(Real(f, new[key]))
    return [beyond(memory, dot, rows, lowest, *both) for dot, both in zip(dots, totals)]


def beyond(
    memory: Memory, dot: Dot, rows: str, lowest: int, first: Variable[Real], second: Variable[Real]
) -> tuple[Value, Value]:
    """Both sums with the terms up to n-2 of a level that is not the lowest."""
    emitter, layout, above = memory.emitter, memory.layout, dot.level - lowest
    one: Value = first.get().name
    other: Value = second.get().name
    for more in range(above):  # the index of a is k + lowest - 1 + more
        a = emitter.load(rows, layout.slot(layout.first(dot), lowest - 1 + more))
        place = layout.slot(layout.second(dot), above + 1 - more)
        one = emitter.fma(a, emitter.load("%work", place), one)
        other = emitter.fma(a, emitter.load("%work", place + 1), other)
    return one, other


class LaneStage(LoopStage):
    """Stage k of a pair or, with the ``earlier`` one, stage k + 1; ``first`` is the first k."""

    def __init__(self, memory: Memory, first: int, k: Integer, rows: str, earlier: LaneStage | None) -> None:
        super().__init__(memory.expansion)
        self._k = k.name
        self._emitter, self._layout = memory.emitter, memory.layout
        self.first, self._rows, self._earlier = first, rows, earlier
        self._second = int(earlier is not None)
        self._known: dict[tuple[str, int], Value] = {}
        self._scaled: dict[int, Value] = {}

    def older(self, index: int, ahead: int) -> Value:
        if self._earlier is not None and ahead == self.expansion.program.series[index].level - 1:
            return self._earlier.top[index]
        return self._load(self._layout.rows[index], ahead)

    def _load(self, row: int, ahead: int) -> Value:
        """Coefficient k + ahead of a row."""
        place = self._layout.slot(row, ahead + self._second)
        if ("", place) not in self._known:
            self._known["", place] = self._emitter.load(self._rows, place)
        return self._known["", place]

    def _total(self, dot: Dot, total: Value) -> Value:
        """``total`` with the terms m = 1 and n - 1 and, of a second stage, n - 2: its b[2] comes too late."""
        emitter, layout = self._emitter, self._layout
        newest = self.expansion.program.series[dot.index].level - 1
        a, b = layout.first(dot), layout.second(dot)
        if self._second:
            low = emitter.load("%work", layout.slot(b, 2))
            total = emitter.fma(self._load(a, newest - 1), low, total)
        total = emitter.fma(emitter.load("%work", layout.slot(a, 1)), self.at(dot.b, newest), total)
        return emitter.fma(self._newest(dot, newest), emitter.load("%work", layout.slot(b, 1)), total)

    def _newest(self, dot: Dot, ahead: int) -> Value:
        if not dot.weighted:
            return self.at(dot.a, ahead)
        if self._earlier is not None:
            return self._earlier._scaled[dot.a]
        return self._load(self._layout.scaled[dot.a], ahead)

    def tabulated(self, name: str, ahead: int) -> Value:
        if (name, ahead) not in self._known:
            table = f"@lane_{name}"
            self._known[name, ahead] = self._emitter.everywhere(table, self._k, ahead + self._second)
        return self._known[name, ahead]

    def write(self, sums: dict[Dot, Value]) -> None:
        """Compute, solve and store this stage's coefficients from the ``sums`` without their ends."""
        layout, series = self._layout, self.expansion.program.series
        self.sums = {(dot.index, dot.weighted): (self._total(dot, one), []) for dot, one in sums.items()}
        for index in self.compute():
            level = series[index].level
            if index in layout.rows:
                self._store(self.top[index], layout.rows[index], level)
            if index in layout.scaled:
                self._scaled[index] = self._emitter.mul(self.number(level), self.top[index])
                self._store(self._scaled[index], layout.scaled[index], level)

    def _store(self, value: Value, row: int, ahead: int) -> None:
        self._emitter.store(value, self._rows, self._layout.slot(row, ahead + self._second))
