"""The later stages of a step, as the body of a loop over k."""

from __future__ import annotations

from lagrange_cli.native.numbers.double import Value, literal
from lagrange_cli.native.recurrences.convolution import (
    TOGETHER,
    moved,
    store,
    store_rows,
    sum_in_loop,
    sum_unrolled,
)
from lagrange_cli.native.recurrences.expansion import Expansion
from lagrange_cli.native.recurrences.layout import CARRIED, FIRST
from lagrange_cli.native.recurrences.stage import Stage
from lagrange_cli.series.program import SHORT


class Rolled(Stage):
    """One stage of a loop over ``k`` from ``first`` to ``last``.

    Where they are ``padded``, dot products are written out with as many terms as the last stage needs: before
    that, what is too many meets zeros. (A loop would end each time where the processor does not expect it.)
    """

    def __init__(self, expansion: Expansion, k: str, first: int, last: int, padded: bool) -> None:
        super().__init__(expansion)
        self.k, self.first, self.last = k, first, last
        self.padded = padded
        self.carried: dict[tuple[int, int], str] = {}
        """Coefficients k + level - 1 of series, those before, ..: by series and by how many stages old."""
        self._known: dict[tuple[str, int], Value] = {}
        self._bases: dict[int, str] = {}

    def at(self, index: int, ahead: int) -> Value:
        one = self.expansion.program.series[index]
        if one.degree < self.first + ahead:
            return None
        if ahead == one.level:
            return self.top[index]
        if one.level - ahead <= CARRIED:
            return self._carry(index, one.level - ahead)
        return self._load(index, ahead)

    def _carry(self, index: int, age: int) -> Value:
        for one in range(1, age + 1):
            if (index, one) not in self.carried:
                self.carried[index, one] = self.expansion.emitter.fresh()
                self.expansion.emitter.set_depth(self.carried[index, one], int(one == 1))
        return self.carried[index, age]

    def newest(self, index: int, age: int) -> Value:
        """Coefficient k + level - ``age`` when the stage is done; it must have been read."""
        return self.carried[index, age] if age else self.top[index]

    def _load(self, index: int, ahead: int) -> Value:
        key = (str(index), ahead)
        if key not in self._known:
            layout = self.expansion.layout
            base = self._base(layout.stride(index))
            self._known[key] = self.expansion.emitter.load(base, layout.slot(index, ahead))
        return self._known[key]

    def _base(self, width: int) -> str:
        """``%work`` moved on by k vectors of that width."""
        if width not in self._bases:
            self._bases[width] = moved(self.expansion.emitter, self.k, width)
        return self._bases[width]

    def set_top(self, index: int, value: Value) -> None:
        self.top[index] = value

    def products(self, a: int, b: int, ahead: int) -> list[tuple[Value, Value, Value]]:
        series, table = self.expansion.program.series, self.expansion.table
        if series[a].degree <= SHORT:
            reach = range(1, series[a].degree + 1)
            return [(literal(m), table[a].get(m), self.at(b, ahead - m)) for m in reach]
        reach = range(1, series[b].degree + 1)
        return [(self.number(ahead - m), self.at(a, ahead - m), table[b].get(m)) for m in reach]

    def _tabulated(self, name: str, ahead: int) -> Value:
        key = (name, ahead)
        if key not in self._known:
            emitter = self.expansion.emitter
            place = emitter.define(f"getelementptr inbounds double, ptr @{name}, i64 {self.k}")
            self._known[key] = emitter.load(place, ahead)
        return self._known[key]

    def number(self, ahead: int) -> Value:
        return self._tabulated("numbers", ahead)

    def reciprocal(self, ahead: int) -> Value:
        return self._tabulated("reciprocals", ahead)

    def write(self, label: str) -> str:
        """Compute, solve and store one stage's coefficients.

        It begins in the block ``label``; returns the label of the last block.
        """
        expansion, emitter, layout = self.expansion, self.expansion.emitter, self.expansion.layout
        groups = layout.groups
        if self.padded:
            for group in groups:
                last = self.last + group.level - FIRST
                base = self._base(group.width)
                self.take(group, sum_unrolled(emitter, group, last, base, group.level, {}))
        else:
            for start in range(0, len(groups), TOGETHER):
                some = groups[start : start + TOGETHER]
                sums, label = sum_in_loop(emitter, some, self.k, range(self.first, self.last + 1), label)
                for group, total in zip(some, sums):
                    self.take(group, total)
        moving = [
            (index, one)
            for index, one in enumerate(expansion.program.series)
            if one.degree >= self.first + one.level
        ]
        self.top = dict.fromkeys(range(len(expansion.program.series)))
        for index, _ in moving:
            self.top[index] = self.recur(index)
        self.solve()
        for group in groups:
            store(emitter, group, self.vectors(group), self._base(group.width), group.level)
        for index, one in moving:
            if index in layout.rows:
                emitter.store(self.top[index], self._base(1), layout.slot(index, one.level))
        store_rows(emitter, layout.width, self.state(), self._base(layout.width), layout.width)
        return label
