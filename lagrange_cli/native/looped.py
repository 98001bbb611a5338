"""The later stages of a step, as the body of a loop over k."""

from __future__ import annotations

from lagrange_cli.mechanics.series import SHORT
from lagrange_cli.native.emitter import Value, literal
from lagrange_cli.native.expansion import Expansion
from lagrange_cli.native.groups import (
    TOGETHER,
    Ends,
    Pair,
    dots,
    kept,
    moved,
    store,
    store_rows,
    sum_in_loop,
    sum_written_out,
)
from lagrange_cli.native.layout import FIRST, Group
from lagrange_cli.native.stage import Stage
from lagrange_cli.records import replace


class Looped(Stage):
    """One stage of a loop over ``k`` from ``first`` to ``last``.

    Where they are ``padded``, dot products are written out with as many terms as the last stage needs: before
    that, what is too many meets zeros. (A loop would end each time where the processor does not expect it.)
    """

    def __init__(self, expansion: Expansion, k: str, first: int, last: int, padded: bool) -> None:
        super().__init__(expansion)
        self.k, self.first, self.last = k, first, last
        self.padded = padded
        self.before = {group: self._before(group) for group in expansion.layout.groups}
        """The ends of dot products when the stage begins."""
        self.coordinates = {index: expansion.emitter.fresh() for index in expansion.program.coordinates}
        """Coefficients k + 1 of q: the newest ones when the stage begins."""
        self._known: dict[tuple[str, int], Value] = {}
        self._bases: dict[int, str] = {}

    def _before(self, group: Group) -> Ends:
        emitter = self.expansion.emitter
        newest = Pair(emitter.fresh(), emitter.fresh())
        first, second = (
            emitter.fresh() if lags else same
            for lags, same in zip(group.lagging, (newest.first, newest.second))
        )
        return replace(self.expansion.ends[group], newest=newest, kept=Pair(first, second))

    def at(self, index: int, ahead: int) -> Value:
        one = self.expansion.program.series[index]
        if one.degree < self.first + ahead:
            return None
        if ahead == one.level:
            return self.top[index]
        if index in self.coordinates and ahead == 1:
            return self.coordinates[index]
        return self._load(index, ahead)

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

    def divided(self, value: Value, ahead: int) -> Value:
        return self.expansion.emitter.mul(value, self._tabulated("reciprocals", ahead))

    def write(self, label: str) -> str:
        """Compute, solve and store one stage's coefficients.

        It begins in the block ``label``; returns the label of the last block.
        """
        expansion, emitter, layout = self.expansion, self.expansion.emitter, self.expansion.layout
        groups = layout.groups
        totals: list[str | None] = []
        if self.padded:
            for group in groups:
                last = self.last + group.level - FIRST
                totals.append(sum_written_out(emitter, group, last, self._base(group.width), group.level))
        else:
            for start in range(0, len(groups), TOGETHER):
                sums, label = sum_in_loop(emitter, groups[start : start + TOGETHER], self.k, label)
                totals += sums
        for group, total in zip(groups, totals):
            self.sums |= dots(emitter, group, total, self.before[group])
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
            before, newest = self.before[group], self.gather(group)
            store(emitter, group, before.kept, self._base(group.width), group.level - 1)
            vectors = kept(emitter, group, newest, before.newest)
            expansion.ends[group] = replace(before, newest=newest, kept=vectors)
        for index, one in moving:
            if index in layout.rows:
                emitter.store(self.top[index], self._base(1), layout.slot(index, one.level))
        store_rows(emitter, layout.width, self.state(), self._base(layout.width), layout.width)
        return label
