"""The members of a domain in rows: within one, a table of places goes up by 1 or stays as it is.

So the numbers of eight members are one load, or one number for all of them, instead of eight places that have
to be looked up: in a sum over pairs of bodies one index stays and the other one goes up.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from lagrange_cli.native.interface import LANES
from lagrange_cli.records import dataclass

if TYPE_CHECKING:
    from lagrange_cli.expression.index_arrays import Places

USUAL = 0.5
"""A table goes up, or stays, if it does so from member to member in more than this part of all cases."""
SHORT = 4
"""Members of a row on average below which places are looked up."""


@dataclass(frozen=True, eq=False)
class Rows:
    """Where rows begin, how long they are, and by how much each table goes up in them: 1, 0 or, where places
    are looked up, None."""

    starts: Places
    lengths: Places
    strides: tuple[int | None, ...]

    @cached_property
    def blocks(self) -> Places:
        """The first block of eight members of each row, and the number of all."""
        blocks: Places = np.concatenate([[0], np.cumsum(-(-self.lengths // LANES))])
        return blocks


def rows_of(tables: Sequence[Places], count: int) -> Rows:
    """The rows of ``count`` members with these tables."""
    breaks = np.zeros(max(count - 1, 0), dtype=bool)
    strides: list[int | None] = []
    for table in tables:
        steps = np.diff(table)
        shares = [(float(np.mean(steps == stride)) if count > 1 else 1.0, stride) for stride in (0, 1)]
        share, stride = max(shares)
        strides.append(stride if share > USUAL else None)
        if strides[-1] is not None:
            breaks |= steps != stride
    starts = np.concatenate([[0], np.flatnonzero(breaks) + 1])
    if count > LANES and count < SHORT * len(starts):
        return Rows(np.zeros(1, np.int64), np.array([count]), (None,) * len(tables))
    return Rows(starts, np.diff(np.append(starts, count)), tuple(strides))
