"""Which series are computed in batches: how these are arranged, and which of them one loop may compute.

Operands of products stand beside them: where they do not, a copy of them does.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from lagrange_cli.expression.graph import Graph
from lagrange_cli.mechanics.residual import Residual
from lagrange_cli.native.interface import LANES
from lagrange_cli.native.recurrences.batches.layout import Blocks, count
from lagrange_cli.records import replace
from lagrange_cli.series.batches import Batch, batches
from lagrange_cli.series.program import Op, Series, SeriesProgram

FARTHEST = 2**31 - 1
"""The largest place that a table can hold."""
FEWEST = 8
"""Series that a batch must have on average: straight code is shorter than a loop over fewer."""


class Misfit(Exception):
    """The system is not of the kind that is computed in batches."""


def arrange(residual: Residual, program: SeriesProgram, order: int) -> Blocks:
    """The batches of the series ``program``, with copies of what products do not have beside them.

    Raises ``Misfit`` where they would be too many, or too much.
    """
    listed = batches(program, residual.variables)
    if len(listed) * FEWEST > len(program.series):
        raise Misfit
    blocks = Blocks(*with_copies(program, listed, residual.graph), order)
    if blocks.doubles > FARTHEST:
        raise Misfit
    return blocks


def with_copies(
    program: SeriesProgram, listed: Sequence[Batch], graph: Graph
) -> tuple[SeriesProgram, Sequence[Batch]]:
    """The same with a batch of copies for each operand of a product that is not stored beside it."""
    series, found = list(program.series), list[Batch]()
    where = places_of(listed)
    made: dict[tuple[int, tuple[int, ...]], tuple[int, ...]] = {}

    def beside(row: tuple[int, ...], level: int) -> tuple[int, ...]:
        if aligned(where, row):
            return row
        if (level, row) not in made:
            copies = made[level, row] = tuple(range(len(series), len(series) + len(row)))
            data = graph.zero, (graph.one,)
            series.extend(Series(Op.LINEAR, (i,), data, level=level, order=series[i].order) for i in row)
            zeros = (graph.zero,) * len(row)
            ones = ((graph.one,) * len(row),)
            found.append(Batch(copies, series[copies[0]], (row,), ones, zeros, copy=True))
        return made[level, row]

    for batch in listed:
        if batch.one.op in (Op.MULTIPLY, Op.POWER):
            operands = tuple(beside(row, batch.one.level) for row in batch.operands)
            batch = replace(batch, operands=operands)
        found.append(batch)
    return replace(program, series=tuple(series)), found


def places_of(listed: Sequence[Batch]) -> dict[int, tuple[int, int]]:
    """The batch of each series, and its place there."""
    return {
        index: (number, place)
        for number, batch in enumerate(listed)
        for place, index in enumerate(batch.members)
    }


def aligned(where: Mapping[int, tuple[int, int]], row: Sequence[int]) -> bool:
    """Whether these series are side by side in one batch, the first one at the beginning of a block."""
    batch, first = where[row[0]]
    return first % LANES == 0 and all(where[i] == (batch, first + j) for j, i in enumerate(row))


def grouped(blocks: Blocks) -> list[list[int]]:
    """Batches that one loop may compute, in the order of the loops.

    They have the same number of members, and each member takes from other batches only its own values: eight
    of them are finished, one batch after the other, while their coefficients are in the cache.
    """
    where, series = places_of(blocks.batches), blocks.program.series
    groups: list[list[int]] = []
    place: dict[int, int] = {}
    for number, batch in enumerate(blocks.batches):
        least, one = 0, batch.one
        ahead = {Op.DERIVATIVE: 1, Op.PRIMITIVE: -1}.get(one.op, 0)
        rows = [(ahead, row) for row in batch.operands]
        for p in range(len(one.sources)):
            rows.append((0, tuple(series[i].sources[p] for i in batch.members)))
        for ahead, row in rows:
            fresh = [place[where[i][0]] for i in row if series[i].level == one.level + ahead]
            beside = not batch.long and where[row[0]][1] == 0 and aligned(where, row)
            least = max(least, max(fresh, default=-1) + (0 if beside and fresh else 1))
        size = count(batch.members)
        fits = (g for g in range(least, len(groups)) if count(blocks.batches[groups[g][0]].members) == size)
        place[number] = chosen = next(fits, len(groups))
        if chosen == len(groups):
            groups.append([])
        groups[chosen].append(number)
    return groups
