"""Loops over many rows, cut into chunks that threads take (see ``sharing``).

Rows next to each other add to the same places. So a chunk has rows that add to places of their own, and at
its ends some that do not: these wait until both chunks are done with the others. That order follows from the
tables of places alone, and so do the sums.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

import numpy as np

from lagrange_cli.expression.index_arrays import distinct
from lagrange_cli.families.arrays import Array
from lagrange_cli.native.board import LINE
from lagrange_cli.native.families.additions import behind, keys
from lagrange_cli.native.families.evaluation import Writer
from lagrange_cli.native.families.loops import Loop
from lagrange_cli.native.families.sharing import STRIP, Part, Parts
from lagrange_cli.native.families.tables import Tables, place_at
from lagrange_cli.native.interface import LANES
from lagrange_cli.native.llvm.function import Function
from lagrange_cli.native.llvm.vector import Integer
from lagrange_cli.records import dataclass

if TYPE_CHECKING:
    from lagrange_cli.expression.index_arrays import Places

CHUNKS = 8
"""How many there are."""
MOST = 2**14
"""Rows that are looked at one by one."""


@dataclass(frozen=True, eq=False)
class Chunks:
    """So many chunks of the rows of a loop, and as many borders, those of chunk i with the one before it.
    Each is a strip: ``order`` has its rows, from ``starts`` on."""

    chunks: int
    order: Places
    starts: Places


def chunks_of(loop: Loop) -> Chunks | None:
    """The chunks of a loop, if neighbours only add to the same places."""
    rows, chunks = loop.rows, CHUNKS
    count = len(rows.starts)
    if not 4 * chunks <= count <= MOST or any(rows.strides[i] is None for _, i in keys(loop)):
        return None
    chunk: Places = np.arange(count) * chunks // count
    spans = touched(loop)
    sizes: dict[Array, int] = {}
    for total, _, last in spans:
        sizes[total] = max(sizes.get(total, 0), 1 + int(last.max()))
    low = {total: np.full(size, chunks) for total, size in sizes.items()}
    high = {total: np.full(size, -1) for total, size in sizes.items()}
    for total, first, last in spans:
        for r in range(count):
            span = slice(first[r], last[r] + 1)
            np.minimum(low[total][span], chunk[r], out=low[total][span])
            np.maximum(high[total][span], chunk[r], out=high[total][span])
    border: Places = np.full(count, -1)
    """The border that a row belongs to, or -1."""
    for total, first, last in spans:
        one, other = low[total], high[total]
        apart = np.where(one < other, np.where((one == 0) & (other == chunks - 1), 0, other), -1)
        if np.any((apart > 0) & (other - one != 1)):
            return None
        for r in range(count):
            found = apart[first[r] : last[r] + 1]
            for b in (int(one) for one in distinct(found[found >= 0])):
                if border[r] not in (-1, b) or chunk[r] not in (b, (b - 1) % chunks):
                    return None
                border[r] = b
    for total in sizes:
        seen = np.full(sizes[total], -1)
        for array, first, last in spans:
            if array is total:
                for r in np.flatnonzero(border >= 0).tolist():
                    span = slice(first[r], last[r] + 1)
                    if np.any((seen[span] >= 0) & (seen[span] != border[r])):
                        return None
                    seen[span] = border[r]
    strip = np.where(border >= 0, chunks + border, chunk)
    order: Places = np.argsort(strip, kind="stable")
    starts: Places = np.searchsorted(strip[order], np.arange(2 * chunks + 1))
    return Chunks(chunks, order, starts)


def touched(loop: Loop) -> list[tuple[Array, Places, Places]]:
    """The first and the last place that each row adds something to, in whole vectors, for each array."""
    rows, tables = loop.rows, loop.numbered[0]
    whole = -(-rows.lengths // LANES) * LANES
    waiting = behind(loop, keys(loop))
    leading = {leader for leader, _ in waiting.values()}
    found = []
    for total, i in keys(loop):
        first = tables[i][rows.starts]
        beyond = whole + LANES * ((total, i) in leading) if rows.strides[i] == 1 else np.ones_like(first)
        found.append((total, first, first + beyond - 1))
    return found


def write_chunk(writer: Writer, chunks: Chunks, tables: Tables, strip: Integer) -> None:
    """The rows of a strip."""
    f = writer.f
    starts = tables.of_places(chunks.starts.tolist())
    first, last = (place_at(f, strip + (starts + i)) for i in range(2))
    order = tables.of_places(chunks.order.tolist())
    with f.when(first < last), f.loop(first, last, tested=False) as i:
        writer.write_row(place_at(f, i + order))


def add_chunks(
    parts: Parts, chunks: Chunks, tables: Tables, within: Callable[[Function], Writer]
) -> tuple[int, int]:
    """A further part: its number, and its operations. ``within`` gives the writer of the loop in a
    function."""
    f = Function(STRIP.format(len(parts.listed)))
    writer, made = within(f), parts.strip(f)
    at, strip, tag = made.at, made.strip, made.tag
    constants, last = f.pointer("%constants"), chunks.chunks - 1
    with f.when(strip > last):
        this = f.place(at, -LINE * chunks.chunks, "double")
        before = f.select(strip.equals(chunks.chunks), f.count(last * LINE), f.count(-LINE))
        for place in (this, f.place(this, before, "double")):
            f.call(None, "wait", constants, place, tag + 1)
    write_chunk(writer, chunks, tables, strip)
    f.publish(tag + 1, at)
    f.give()
    return parts.add(Part(2 * chunks.chunks, chunks.chunks), f.text()), f.operations
