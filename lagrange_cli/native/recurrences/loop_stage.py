"""The common parts of stages in loops, for any layout of their lanes."""

from __future__ import annotations

from lagrange_cli.native.llvm.text import Value
from lagrange_cli.native.recurrences.stage import Stage
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
