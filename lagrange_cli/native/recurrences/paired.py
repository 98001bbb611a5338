"""``@paired_jet``: the Taylor coefficients of one step of eight motions, a lane for each.

What one motion computes with numbers is computed with vectors here, lane by lane: no lane ever sees another.
The first stages are unrolled; the others are a loop over pairs of stages, k and k + 1, whose sums of
products are made together by an inner loop:

    sum_m a[m] b[n-m]    and    sum_m a[m] b[n+1-m]

share what they read, so that two products take two vectors from memory.
"""

from __future__ import annotations

from lagrange_cli.native.llvm.text import Value
from lagrange_cli.native.numbers.lanes import BITS, VECTOR, LaneEmitter
from lagrange_cli.native.recurrences.expansion import Expansion
from lagrange_cli.native.recurrences.layout import Dot
from lagrange_cli.native.recurrences.layout_lanes import LaneLayout
from lagrange_cli.native.recurrences.loop_stage import LoopStage
from lagrange_cli.native.recurrences.unrolled import CAREFUL, Unrolled
from lagrange_cli.records import dataclass
from lagrange_cli.series.program import Op

FIRST = 2
"""The inner loop's first index; terms with an index below are the latest to be known."""
AT_ONCE = 8
"""Sums of one inner loop: three registers each, of 32."""


@dataclass
class Memory:
    """Where the coefficients of the series are, for all stages."""

    expansion: Expansion[str]
    emitter: LaneEmitter
    layout: LaneLayout


def write_paired_jet(memory: Memory) -> str:
    """The function's IR: coefficients of q, v and the integrals into ``%work``; a bit for each lane, not set
    where M is singular."""
    emitter, program = memory.emitter, memory.expansion.program
    last = memory.layout.order - 2
    levels = [one.level for one in program.series if one.op in (Op.MULTIPLY, Op.POWER)]
    first = max(CAREFUL, *(FIRST + 1 - level for level in levels), 0)
    first += (last + 1 - first) % 2
    for k in range(-2, min(first, last + 1)):
        Opening(memory, k).write()
    if first <= last:
        write_pairs(memory, first, last)
    head = f"ptr noalias %constants, {VECTOR} %t, ptr noalias %state, ptr noalias %work"
    body = "\n".join(emitter.lines)
    return (
        f"define internal {BITS} @paired_jet({head}) #0 {{\nentry:\n{body}\n"
        f"  ret {BITS} {memory.expansion.regular}\n}}\n"
    )


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
    emitter, layout = memory.emitter, memory.layout
    emitter.line("  br label %pairs.before\npairs.before:\n  br label %pairs\npairs:")
    place = len(emitter.lines)
    rows = emitter.place("%work", "%k")
    sums: dict[Dot, tuple[Value, Value]] = {}
    label = "pairs"
    for start in range(0, len(layout.dots), AT_ONCE):
        group = layout.dots[start : start + AT_ONCE]
        made = Sums(memory, group, rows, f"sums{start}", label)
        sums |= zip(group, made.write())
        label = made.after
    one = LaneStage(memory, first, rows, None)
    one.write({dot: both[0] for dot, both in sums.items()})
    other = LaneStage(memory, first, rows, one)
    other.write({dot: both[1] for dot, both in sums.items()})
    emitter.lines.insert(place, f"  %k = phi i64 [ {first}, %pairs.before ], [ %k.next, %{label} ]")
    emitter.line(f"  %k.next = add nuw nsw i64 %k, 2\n  %k.more = icmp ult i64 %k.next, {last}")
    emitter.line("  br i1 %k.more, label %pairs, label %pairs.after\npairs.after:")


@dataclass
class Sums:
    """The inner loop over m that makes the sums of ``group`` for two stages, but for their ends.

    With n = k + level these are the terms m = 2 .. n-2, of a[m] b[n-m] for stage k, of a[m] b[n+1-m] for
    k + 1. The latter b is what the former was for the m before.
    """

    memory: Memory
    group: tuple[Dot, ...]
    rows: str
    """Where coefficient k of the first row is."""
    head: str
    before: str

    @property
    def after(self) -> str:
        """The label behind it."""
        return f"{self.head}.after"

    def write(self) -> list[tuple[Value, Value]]:
        """The sums for both stages."""
        emitter, layout, head = self.memory.emitter, self.memory.layout, self.head
        m, last = f"%{head}.m", f"%{head}.last"
        places = [(layout.first(dot), layout.second(dot), self._level(dot)) for dot in self.group]
        shifted = {(b, level): f"%{head}.b{i}" for i, (_, b, level) in enumerate(places)}
        starts = {key: emitter.load(self.rows, layout.slot(key[0], key[1] - 1)) for key in shifted}
        emitter.line(
            f"  {last} = sub i64 %k, {FIRST - self._lowest}\n  %{head}.any = icmp uge i64 {last}, {FIRST}"
        )
        emitter.line(f"  br i1 %{head}.any, label %{head}, label %{self.after}\n{head}:")
        place = len(emitter.lines)
        forward = emitter.place("%work", m)
        backward = emitter.place(self.rows, f"%{head}.back")
        old = {
            row: emitter.load(forward, layout.slot(row, 0)) for row in dict.fromkeys(a for a, _, _ in places)
        }
        new = {key: emitter.load(backward, layout.slot(*key)) for key in shifted}
        phis: list[tuple[str, str, Value]] = [(name, starts[key], new[key]) for key, name in shifted.items()]
        made: list[Value] = []
        for i, (a, b, level) in enumerate(places):
            for j, factor in enumerate((new[b, level], shifted[b, level])):
                made.append(emitter.fma(old[a], factor, f"%{head}.s{i}.{j}"))
                phis.append((f"%{head}.s{i}.{j}", "zeroinitializer", made[-1]))
        emitter.line(f"  {m}.next = add nuw nsw i64 {m}, 1\n  %{head}.more = icmp ult i64 {m}, {last}")
        emitter.line(f"  br i1 %{head}.more, label %{head}, label %{self.after}\n{self.after}:")
        counter = f"  {m} = phi i64 [ {FIRST}, %{self.before} ], [ {m}.next, %{head} ]"
        lines = [f"  {x} = phi {VECTOR} [ {a}, %{self.before} ], [ {b}, %{head} ]" for x, a, b in phis]
        emitter.lines[place:place] = [counter, *lines, f"  %{head}.back = sub i64 0, {m}"]
        ends: list[Value] = []
        for value in made:
            ends.append(emitter.fresh())
            either = f"[ zeroinitializer, %{self.before} ], [ {value}, %{head} ]"
            emitter.line(f"  {ends[-1]} = phi {VECTOR} {either}")
        return [self._beyond(*each) for each in zip(self.group, ends[::2], ends[1::2])]

    @property
    def _lowest(self) -> int:
        """The lowest level: as far as all sums go, they go together."""
        return min(map(self._level, self.group))

    def _level(self, dot: Dot) -> int:
        return self.memory.expansion.program.series[dot.index].level

    def _beyond(self, dot: Dot, one: Value, other: Value) -> tuple[Value, Value]:
        """With the terms up to n-2 of a level that is not the lowest."""
        emitter, layout, above = self.memory.emitter, self.memory.layout, self._level(dot) - self._lowest
        for more in range(above):  # the index of a is k + lowest - 1 + more
            a = emitter.load(self.rows, layout.slot(layout.first(dot), self._lowest - 1 + more))
            place = layout.slot(layout.second(dot), above + 1 - more)
            one = emitter.fma(a, emitter.load("%work", place), one)
            other = emitter.fma(a, emitter.load("%work", place + 1), other)
        return one, other


class LaneStage(LoopStage):
    """Stage k of a pair or, with the ``earlier`` one, stage k + 1; ``first`` is the first k."""

    def __init__(self, memory: Memory, first: int, rows: str, earlier: LaneStage | None) -> None:
        super().__init__(memory.expansion)
        self._emitter, self._layout = memory.emitter, memory.layout
        self.first, self._rows, self._earlier = first, rows, earlier
        self._second = int(earlier is not None)
        self._known: dict[tuple[str, int], Value] = {}
        self._scaled: dict[int, Value] = {}

    def at(self, index: int, ahead: int) -> Value:
        one = self.expansion.program.series[index]
        if one.degree < self.first + ahead:
            return None
        if ahead == one.level:
            return self.top[index]
        if ahead == one.level - 1 and self._earlier is not None:
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
            self._known[name, ahead] = self._emitter.everywhere(table, "%k", ahead + self._second)
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
