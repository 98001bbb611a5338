"""The series of one motion in doubles: stages unrolled, then a loop over k; dot products side by side."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TypeAlias

from lagrange_cli.native.llvm.flow import Variable
from lagrange_cli.native.llvm.function import Function
from lagrange_cli.native.llvm.text import Value
from lagrange_cli.native.llvm.vector import Integer, Pointer, Real
from lagrange_cli.native.numbers.double import Emitter
from lagrange_cli.native.recurrences.convolution import (
    TOGETHER,
    Vectors,
    moved,
    store,
    sum_in_loop,
    sum_unrolled,
    take,
    vectors,
)
from lagrange_cli.native.recurrences.expansion import Expansion
from lagrange_cli.native.recurrences.layout import CARRIED, FIRST, DotGroup, SeriesLayout
from lagrange_cli.native.recurrences.stage import Stage
from lagrange_cli.native.recurrences.unrolled import Unrolled
from lagrange_cli.records import dataclass, field
from lagrange_cli.series.program import SHORT


class LoopStage(Stage[str]):
    """A stage of a loop over k from ``first`` on."""

    first: int

    def at(self, index: int, ahead: int) -> Value:
        one = self.expansion.program.series[index]
        if one.degree < self.first + ahead:
            return None
        return self.top[index] if ahead == one.level else self.older(index, ahead)

    def older(self, index: int, ahead: int) -> Value:
        """Coefficient k + ahead of a series that goes on so far, of an earlier stage."""
        raise NotImplementedError

    def set_top(self, index: int, value: Value) -> None:
        self.top[index] = value

    def products(self, a: int, b: int, ahead: int) -> list[tuple[Value, Value, Value]]:
        series, table = self.expansion.program.series, self.expansion.table
        if series[a].degree <= SHORT:
            number, reach = self.expansion.kind.number, range(1, series[a].degree + 1)
            return [(number(m), table[a].get(m), self.at(b, ahead - m)) for m in reach]
        reach = range(1, series[b].degree + 1)
        return [(self.number(ahead - m), self.at(a, ahead - m), table[b].get(m)) for m in reach]

    def tabulated(self, name: str, ahead: int) -> Value:
        """Number k + ahead of a table: ``numbers`` or ``reciprocals``."""
        raise NotImplementedError

    def number(self, ahead: int) -> Value:
        return self.tabulated("numbers", ahead)

    def reciprocal(self, ahead: int) -> Value:
        return self.tabulated("reciprocals", ahead)

    def compute(self) -> list[int]:
        """Compute and solve; the series that go on so far."""
        series = self.expansion.program.series
        moving = [i for i, one in enumerate(series) if one.degree >= self.first + one.level]
        self.top = dict.fromkeys(range(len(series)))
        self.evaluate(moving)
        self.solve()
        return moving


SIDE_BY_SIDE = 4
"""The lowest sum of their vectors' indices from which on dot products are summed in lanes."""
RECENT = 4
"""Vectors that the next stages take from registers: from memory they would come later."""

Age: TypeAlias = "tuple[int, int]"
"""A series, and by how many stages a coefficient of it is older than the newest."""


@dataclass
class Memory:
    """Where the coefficients of the series are, for all stages of the function ``f``."""

    f: Function
    expansion: Expansion[str]
    emitter: Emitter
    layout: SeriesLayout
    recent: dict[DotGroup, dict[int, Vectors]] = field(default_factory=dict)
    """The last vectors of each group in stages that are unrolled, by their indices."""
    newest: dict[Age, Value] = field(default_factory=dict)
    """The last coefficients that were written."""

    def state(self, stage: Stage[str]) -> list[Value]:
        """Coefficients k + 1 of q, v and the integrals."""
        return [stage.at(index, 1) for index in self.layout.state]


class Opening(Unrolled[str]):
    """One of the first stages, which leaves what loops read."""

    def __init__(self, memory: Memory, k: int) -> None:
        super().__init__(memory.expansion, k)
        self.memory = memory

    def convolve(self) -> None:
        emitter = self.memory.emitter
        for group in self.memory.layout.groups:
            n = self.k + group.level
            if n >= SIDE_BY_SIDE:
                recent = self.memory.recent[group]
                take(emitter, self, group, sum_unrolled(emitter, group, n - FIRST, "%work", n, recent))

    def store(self) -> None:
        memory, emitter, layout = self.memory, self.memory.emitter, self.memory.layout
        for group in layout.groups:
            m, recent = self.k + group.level, memory.recent.setdefault(group, {})
            if m >= FIRST:
                recent[m] = vectors(emitter, self, group)
                store(emitter.body, group, recent[m], "%work", m)
                recent.pop(m - RECENT, None)
        if self.k >= 0:
            emitter.store_rows(layout.width, memory.state(self), "%work", layout.width * (self.k + 1))
        for index, one in enumerate(self.expansion.program.series):
            m = self.k + one.level
            if m >= 1 and index in layout.rows:
                emitter.store(self.at(index, one.level), "%work", layout.slot(index, m))


class Rolled(LoopStage):
    """One stage of a loop over ``k`` in ``stages``; ``before`` are coefficients of earlier ones.

    Where they are ``padded``, dot products are unrolled with as many terms as the last stage needs: before
    that, what is too many meets zeros. (A loop would end each time where the processor does not expect it.)
    """

    def __init__(
        self, memory: Memory, k: Integer, stages: range, padded: bool, before: Mapping[Age, Variable[Real]]
    ) -> None:
        super().__init__(memory.expansion)
        self.memory, self.emitter = memory, memory.emitter
        self.k, self.first, self.stages = k, stages[0], stages
        self.padded = padded
        self.carried: dict[Age, str] = {}
        """Coefficients k + level - 1 of series, those before, ..: those of ``before`` that are read."""
        self._before, self._start = before, memory.f.here
        self._known: dict[tuple[str, int], Value] = {}
        self._bases: dict[int, Pointer] = {}

    def older(self, index: int, ahead: int) -> Value:
        age = self.expansion.program.series[index].level - ahead
        return self._carry(index, age) if age <= CARRIED else self._load(index, ahead)

    def _carry(self, index: int, age: int) -> Value:
        for one in range(1, age + 1):
            if (index, one) not in self.carried:
                self.carried[index, one] = self._before[index, one].get(self._start).name
                self.emitter.set_depth(self.carried[index, one], int(one == 1))
        return self.carried[index, age]

    def newest(self, index: int, age: int) -> Value:
        """Coefficient k + level - ``age`` when the stage is done; it must have been read."""
        return self.carried[index, age] if age else self.top[index]

    def _load(self, index: int, ahead: int) -> Value:
        key = (str(index), ahead)
        if key not in self._known:
            layout = self.memory.layout
            base = self._base(layout.stride(index)).name
            self._known[key] = self.emitter.load(base, layout.slot(index, ahead))
        return self._known[key]

    def _base(self, width: int) -> Pointer:
        """``%work`` moved on by k vectors of that width."""
        if width not in self._bases:
            self._bases[width] = moved(self.emitter.body, self.k, width)
        return self._bases[width]

    def tabulated(self, name: str, ahead: int) -> Value:
        key = (name, ahead)
        if key not in self._known:
            self._known[key] = self.emitter.load(self.emitter.place(f"@{name}", self.k.name), ahead)
        return self._known[key]

    def write(self) -> None:
        """Compute, solve and store one stage's coefficients."""
        emitter, layout, groups = self.emitter, self.memory.layout, self.memory.layout.groups
        if self.padded:
            for group in groups:
                last = self.stages[-1] + group.level - FIRST
                base = self._base(group.width)
                take(emitter, self, group, sum_unrolled(emitter, group, last, base, group.level, {}))
        else:
            for part in (groups[: layout.motion], groups[layout.motion :]):
                for start in range(0, len(part), TOGETHER):
                    some = part[start : start + TOGETHER]
                    sums = sum_in_loop(emitter, some, self.k, self.stages)
                    for group, total in zip(some, sums):
                        take(emitter, self, group, total)
        moving = self.compute()
        for group in groups:
            store(emitter.body, group, vectors(emitter, self, group), self._base(group.width), group.level)
        for index in moving:
            if index in layout.rows:
                level = self.expansion.program.series[index].level
                emitter.store(self.top[index], self._base(1).name, layout.slot(index, level))
        emitter.store_rows(layout.width, self.memory.state(self), self._base(layout.width).name, layout.width)
