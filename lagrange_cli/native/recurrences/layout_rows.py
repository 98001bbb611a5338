"""Where the coefficients of double-double series lie in memory.

Every series has a row: coefficients' high parts behind zeros, then the low parts, again behind zeros.
"""

from __future__ import annotations

from lagrange_cli.native.interface import LANES
from lagrange_cli.native.state import whole_vectors
from lagrange_cli.records import dataclass
from lagrange_cli.series.program import Op, SeriesProgram, reciprocal


@dataclass(frozen=True)
class RowLayout:
    """Where things are in ``%work`` and in the state, whose low parts are ``width`` doubles behind.

    ``places`` are the numbers of rows, those of the state first. ``weighted`` are further rows for m p[m] of
    powers; behind all rows come the factored blocks of masses.
    """

    program: SeriesProgram
    order: int
    width: int
    places: dict[int, int]
    weighted: dict[int, int]

    @property
    def state(self) -> tuple[int, ...]:
        """The series of q, v and the integrals."""
        return self.program.state

    @property
    def beyond(self) -> int:
        """Doubles from a high part in a row to its low part."""
        return LANES + whole_vectors(self.order + 1 + LANES)

    def row(self, index: int) -> int:
        """Where coefficient 0 of a series is."""
        return 2 * self.beyond * self.places.get(index, index) + LANES

    @property
    def blocks(self) -> int:
        """Where the factors of large blocks are."""
        return 2 * self.beyond * (len(self.program.series) + len(self.weighted))


def arrange(program: SeriesProgram, order: int, width: int) -> RowLayout:
    """The places for ``program`` with q's series to ``order``."""
    weighted = [i for i, one in enumerate(program.series) if one.op is Op.POWER and not reciprocal(one.data)]
    places = {index: len(program.series) + i for i, index in enumerate(weighted)}
    listed = dict.fromkeys([*program.state, *range(len(program.series))])
    return RowLayout(program, order, width, {index: row for row, index in enumerate(listed)}, places)
