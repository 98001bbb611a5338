"""The first stages of a step, unrolled: coefficient by coefficient."""

from __future__ import annotations

from lagrange_cli.native.numbers.kind import V
from lagrange_cli.native.recurrences.expansion import Expansion
from lagrange_cli.native.recurrences.stage import Stage, reciprocal_rest

CAREFUL = 4
"""Stages whose products include the remainders of q and q_dot."""
ROUNDED = 7
"""The first stage that multiplies with the rounded reciprocal of its index."""


class Unrolled(Stage[V]):
    """Stage ``k`` with every coefficient a value of its own."""

    def __init__(self, expansion: Expansion[V], k: int) -> None:
        super().__init__(expansion, careful=k < CAREFUL)
        self.k = k

    def at(self, index: int, ahead: int) -> V | None:
        return self.expansion.table[index].get(self.k + ahead)

    def set_top(self, index: int, value: V | None) -> None:
        self.expansion.table[index][self.k + self.expansion.program.series[index].level] = value

    def products(self, a: int, b: int, ahead: int) -> list[tuple[V | None, V | None, V | None]]:
        n, table, number = self.k + ahead, self.expansion.table, self.expansion.kind.number
        listed = ((m, table[a].get(m), table[b].get(n - m)) for m in range(1, n))
        return [(number(m), x, y) for m, x, y in listed if x is not None and y is not None]

    def number(self, ahead: int) -> V | None:
        return self.expansion.kind.number(self.k + ahead)

    def reciprocal(self, ahead: int) -> V | None:
        return self.expansion.kind.number(1.0 / (self.k + ahead)) if self.k >= ROUNDED else None

    def divided(self, value: V | None, ahead: int) -> V | None:
        if self.k >= ROUNDED:
            return super().divided(value, ahead)
        n, kind = self.k + ahead, self.expansion.kind
        rest = kind.number(reciprocal_rest(n))
        return kind.fma(value, kind.number(1.0 / n), kind.mul(value, rest))

    def is_index(self, ahead: int, index: int) -> bool:
        return self.k + ahead == index

    def write(self) -> None:
        """Compute, solve (from stage 0 on) and store this stage's coefficients."""
        series = self.expansion.program.series
        self.convolve()
        self.evaluate(index for index, one in enumerate(series) if one.level + self.k >= 0)
        if self.k == 0:
            self.expansion.factor()
        if self.k >= 0:
            self.solve()
        self.store()

    def convolve(self) -> None:
        """Make ``sums`` of dot products."""

    def store(self) -> None:
        """Store this stage's coefficients."""
