"""Samples for a plot: read in parts, and no more of them than a picture can show."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from lagrange_cli.run.plots.quantities import Quantity
from lagrange_cli.store.result import Result

BUCKETS = 3000
"""A longer series is drawn by the least and the greatest of so many parts: what a printer can resolve."""
POINTS = 200_000
"""Samples of a curve that is not over time."""
PIECE = 2**20
"""Rows that are read at a time."""

Array = np.ndarray


def rows_of(result: Result, quantity: Quantity) -> int:
    """The number of samples."""
    return result.held[quantity.path].shape[0]


def pieces(result: Result, wanted: Sequence[Quantity], piece: int) -> Iterator[list[Array]]:
    """Some quantities along the motion, so many rows at a time."""
    count = rows_of(result, wanted[0])
    for start in range(0, count, piece):
        rows = slice(start, min(start + piece, count))
        yield [result.read(one.path, (rows, *one.index)) for one in wanted]


def over_time(result: Result, time: Quantity, quantity: Quantity) -> tuple[Array, Array]:
    """Times and values for a curve: all of them, or of each part of a long motion the least and greatest."""
    count = rows_of(result, quantity)
    if count <= 2 * BUCKETS:
        return result.read(time.path), result.read(quantity.path, (slice(None), *quantity.index))
    width = -(-count // BUCKETS)
    times, values = [], []
    for t, x in pieces(result, (time, quantity), max(PIECE // width, 1) * width):
        short = -len(x) % width
        filled = np.concatenate([x, np.full(short, np.nan)]) if short else x
        parts = filled.reshape(-1, width)
        known = np.isfinite(parts)
        low = np.where(known, parts, np.inf).argmin(axis=1)
        high = np.where(known, parts, -np.inf).argmax(axis=1)
        picked = np.sort(np.stack([low, high], axis=1), axis=1) + width * np.arange(len(parts))[:, None]
        rows = np.minimum(picked.reshape(-1), len(x) - 1)
        times.append(t[rows])
        values.append(x[rows])
    return np.concatenate(times), np.concatenate(values)


def together(result: Result, wanted: Sequence[Quantity]) -> tuple[list[Array], int]:
    """Several quantities at the same samples: every k-th, and k."""
    step = max(1, -(-rows_of(result, wanted[0]) // POINTS))
    parts = [
        [each[::step].copy() for each in piece]  # which does not keep all that was read
        for piece in pieces(result, wanted, max(PIECE // step, 1) * step)
    ]
    return [np.concatenate(each) for each in zip(*parts)], step


def extremes(result: Result, quantity: Quantity) -> tuple[float, float]:
    """The first value, and the greatest absolute value, of all samples."""
    first, largest = np.nan, 0.0
    for (x,) in pieces(result, (quantity,), PIECE):
        first = float(x[0]) if np.isnan(first) else first
        largest = max(largest, float(np.nanmax(np.abs(x), initial=0.0)))
    return first, largest
