"""Where the coefficients of eight motions lie: a row of vectors for each series, a lane for each motion."""

from __future__ import annotations

from lagrange_cli.native.recurrences.layout import Dot, dot_products, read_alone
from lagrange_cli.records import dataclass
from lagrange_cli.series.program import SeriesProgram


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
