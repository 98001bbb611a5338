"""Where the series of a large system can be computed block by block: wavefronts over members and orders.

An order of a series needs the orders below of members nearby only, in chains and lattices. So a block of
members need not wait until all others have an order: in its round, order k covers as many members as in
order 0, but further back, by what a force reaches. Every operation stays as it is, and coefficients stay in
the processor's cache. (Skewed loops, as in M. Wolfe, Int. J. Parallel Programming 15, 1986.)

In a ring the first members need the last ones. There, order k also begins further on at the front; the rest
around the seam, a trapezoid of as many members as the orders reach, is computed at the end, order by order.
Members that the seam shares with the blocks are computed twice, with the same result.

Positions are places in arrays: coordinates, velocities, and sums that the forces are made of. They are
counted in units, of eight or of a row of a lattice.
"""

from __future__ import annotations

from collections.abc import Collection, Sequence
from typing import Any

import numpy as np

from lagrange_cli.families.arrays import Array
from lagrange_cli.native.families.series import LoopSeries
from lagrange_cli.native.interface import LANES
from lagrange_cli.records import dataclass, replace

Numbers = np.ndarray[Any, np.dtype[np.int64]]
Flags = np.ndarray[Any, np.dtype[np.bool_]]

MANY = 2**14
"""Doubles that fit a processor's nearest cache, or nearly so: systems with fewer have no blocks."""
BLOCK = 2**13
"""Doubles of a block; as many again and more are in use, in several orders."""
STRIDES = 2
"""A block is as many strides at least. In a lattice a stride is a row, and few of them fill a cache."""
MARGIN = 6
"""Strides that the seam of a ring takes beside those of the orders."""
PIECE = 2**12
"""Doubles of a piece of a block, which stay in the nearest cache while orders are computed together."""
SHARED = 2**19
"""Doubles of series from which on threads share them."""
FLIGHT = 4
"""Rounds that they may be at work on."""
LONG = 2**16
"""Doubles of a block then: a thread is not to wait for another one too often."""
FEWEST_ROUNDS = 8
"""And so many rounds there are, or more."""
PART = 2
"""The orders of a chain, or those on both sides of a seam, reach no further than a part of all positions."""


@dataclass(frozen=True, eq=False)
class Cuts:
    """Where the blocks of a loop, of eight members each, can be cut: ``up[y]`` of them touch nothing from
    position y on (in units), those from ``down[y]`` on touch nothing before it. ``reach`` is the number of
    units before y that ``up[y]`` leaves incomplete, or behind it that ``down[y]`` does."""

    up: Numbers
    down: Numbers
    reach: int


@dataclass(frozen=True, eq=False)
class Tiling:
    """Blocks of so many units, of ``count`` in all, each of ``unit`` positions.

    Order k is ``k * stride`` units behind order 0; in each order, loops are ``lags`` behind its beginning. In
    a ``ring`` the last round is the seam, and ``full`` counts whole units. So many rounds may be in
    ``flight`` together, in several threads. Orders that are computed together go through a block by pieces of
    ``piece`` units.
    """

    unit: int
    count: int
    full: int
    block: int
    stride: int
    lags: Sequence[int]
    cuts: Sequence[Cuts]
    orders: int
    ring: bool
    flight: int = 1
    piece: int = 1

    @property
    def pieces(self) -> int:
        """How many pieces a block has."""
        return -(-self.block // self.piece)

    @property
    def rounds(self) -> int:
        """How many blocks there are, but for the seam."""
        last = self.full - self.stride if self.ring else self.count + self.orders * self.stride
        return -(-last // self.block)

    def kept(self, loop: int) -> tuple[int, int]:
        """The blocks of a loop whose series are kept till the end, the first ones, and how many others are in
        use together: a power of 2, unless there are many."""
        cuts, reach = self.cuts[loop], (self.orders + MARGIN) * self.stride
        first = int(cuts.down[min(reach, self.count)]) if self.ring else 0
        ends = np.minimum(np.arange(self.count + 1) + reach + self.flight * self.block, self.count)
        most = int(np.max(cuts.up[ends] - cuts.up)) + 1
        return first, most if self.flight > 1 else 1 << most.bit_length()


def tiling_of(
    series: Sequence[LoopSeries], moving: Collection[Array], degrees: int, order: int, *, shared: bool = False
) -> Tiling | None:
    """How the orders of these series, of ``degrees`` coordinates, are computed in blocks, if they are many
    and need neighbours only. ``moving`` are the arrays that change from order to order. Threads may have
    ``shared`` them."""
    doubles = sum(one.doubles for one in series) + degrees * order
    if doubles < MANY or not series:
        return None
    bounds = [extents(one, moving) for one in series]
    count = max(int(high.max()) + 1 for _, high in bounds)
    ring = any(bool(np.any(high - low > count // 2)) for low, high in bounds)
    found = [tiled(series, bounds, unit, count, order - 1, ring) for unit in units(series, moving)]
    usable = [one for one in found if one is not None]
    if not usable:
        return None
    best = min(usable, key=lambda one: one.stride * one.unit)
    shared = shared and doubles >= SHARED and best.stride > 0
    fitting = round((LONG if shared else BLOCK) / (best.unit * doubles / count))
    if shared:
        fitting, best = min(fitting, best.count // FEWEST_ROUNDS), replace(best, flight=FLIGHT)
    block, piece = max(1, STRIDES * best.stride, fitting), round(PIECE / (best.unit * doubles / count))
    return replace(best, block=block, piece=piece or block)


def extents(series: LoopSeries, moving: Collection[Array]) -> tuple[Numbers, Numbers]:
    """The first and the last position that each member reads or adds something to."""
    loop = series.loop
    tables = [slot.table for slot in loop.used.values() if slot.array in moving]
    tables += [term.targets for term, _ in loop.terms]
    return np.minimum.reduce(tables), np.maximum.reduce(tables)


def units(series: Sequence[LoopSeries], moving: Collection[Array]) -> list[int]:
    """Numbers of positions that a unit may have: eight, or the usual distances of two that a member takes."""
    found = {LANES}
    for one in series:
        low, high = extents(one, moving)
        values, counts = np.unique(high - low, return_counts=True)
        found.add(max(LANES, int(values[np.argmax(counts)])))
    return sorted(found)


def tiled(
    series: Sequence[LoopSeries],
    bounds: Sequence[tuple[Numbers, Numbers]],
    unit: int,
    positions: int,
    orders: int,
    ring: bool,
) -> Tiling | None:
    """The blocks for one unit; None where orders reach too far."""
    count, full = -(-positions // unit), positions // unit
    far = [high - low > positions // 2 for low, high in bounds]
    cuts = [cuts_of(one, *b, away, unit, count) for one, b, away in zip(series, bounds, far)]
    lags = np.cumsum([0, *(one.reach for one in cuts)]).tolist()
    stride = lags.pop()
    reach = (orders + MARGIN) * stride
    if PART * (2 if ring else 1) * reach > count:
        return None
    for one, cut, away in zip(series, cuts, far):
        at = np.searchsorted(firsts(one), np.flatnonzero(away), "right") - 1
        if np.any((at >= cut.down[min(stride, count)]) & (at < cut.up[max(0, full - stride)])):
            return None
    return Tiling(unit, count, full, 1, stride, lags, cuts, orders, ring)


def cuts_of(series: LoopSeries, low: Numbers, high: Numbers, far: Flags, unit: int, count: int) -> Cuts:
    """The cuts of one loop. What members read that is ``far`` away does not count: they are in the seam."""
    at = firsts(series)
    nowhere = count * unit
    highest = np.maximum.accumulate(np.maximum.reduceat(np.where(far, -1, high), at))
    lowest = np.minimum.reduceat(np.where(far, nowhere, low), at)
    lowest = np.append(np.minimum.accumulate(lowest[::-1])[::-1], nowhere)
    places = np.arange(count + 1) * unit
    up = np.searchsorted(highest, places, "left")
    down = np.searchsorted(lowest[:-1], places, "left")
    behind = np.append(-1, highest)[down] + 1
    reach = max(0, int(np.max(places - lowest[up])), int(np.max(behind - places)))
    return Cuts(up, down, -(-reach // unit))


def firsts(series: LoopSeries) -> Numbers:
    """The first member of each block."""
    rows, numbers = series.loop.rows, np.diff(series.blocks)
    inside = np.arange(int(series.blocks[-1])) - np.repeat(series.blocks[:-1], numbers)
    found: Numbers = np.repeat(rows.starts, numbers) + LANES * inside
    return found
