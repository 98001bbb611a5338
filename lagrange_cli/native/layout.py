"""Where the coefficients lie in memory, a row for each series that is read again.

Index 2 of every row starts a vector: a convolution takes its indices 0 and 1 by themselves.
"""

from __future__ import annotations

from lagrange_cli.mechanics.series import SHORT, Op, SeriesProgram, needs
from lagrange_cli.native.interface import LANES as LANES
from lagrange_cli.records import dataclass

ZERO_SLOT = LANES - 2
"""Slot of index 0 (not stored) in a row."""


@dataclass(frozen=True)
class Layout:
    """Rows of ``%work`` by series: q, v and the integrals first, then what convolutions read."""

    order: int
    rows: dict[int, int]

    @property
    def span(self) -> int:
        """Doubles in a row: whole vectors."""
        return LANES * -(-(self.order + 1 + ZERO_SLOT) // LANES)

    @property
    def doubles(self) -> int:
        """Size of ``%work``."""
        return self.span * len(self.rows)

    def slot(self, series: int, index: int = 0) -> int:
        """Where a coefficient lies."""
        return self.span * self.rows[series] + ZERO_SLOT + index


def arrange(program: SeriesProgram, order: int) -> Layout:
    """A row for each series of which something is read after its stage."""
    series = program.series
    listed = [*program.coordinates, *program.velocities, *program.integrals]
    listed += [index for index in program.residual if series[index].level > 0]
    for index, one in enumerate(series):
        if one.op is Op.MULTIPLY:
            listed += one.arguments
        elif one.op is Op.POWER:
            listed += [index, *one.arguments]
        listed += [i for i, ahead in needs(one) if series[i].level > one.level + ahead]
    stored = {index for index, one in enumerate(series) if one.degree > SHORT}
    for one in series:  # short ones whose product is not: a loop may begin where both still count
        if one.op is Op.MULTIPLY and one.degree > SHORT and stored.isdisjoint(one.arguments):
            stored |= {*one.arguments}
    rows: dict[int, int] = {}
    for index in listed:
        if index not in rows and (index in stored or len(rows) < len(program.coordinates) * 2):
            rows[index] = len(rows)
    return Layout(order, rows)
