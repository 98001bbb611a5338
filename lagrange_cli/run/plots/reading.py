"""Samples for a plot: read in parts, and no more of them than a picture can show."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from math import prod
from typing import Any

import numpy as np

from lagrange_cli.run.plots.quantities import Quantity
from lagrange_cli.store.result import Result

BUCKETS = 3000
"""A longer series is drawn by the least and the greatest of so many parts: what a printer can resolve."""
POINTS = 200_000
"""Samples of a curve that is not over time."""
NUMBERS = 2**24
"""Numbers of all curves of a panel."""
PIECE = 2**20
"""Numbers of a dataset that are read at a time."""

Array = np.ndarray


def rows_of(result: Result, quantity: Quantity) -> int:
    """The number of samples."""
    return result.held[quantity.path].shape[0]


def rows_at(quantity: Quantity) -> tuple[Any, ...]:
    """What all samples have of a quantity in its dataset."""
    return slice(None), *quantity.index


def pieces(result: Result, wanted: Sequence[Quantity], step: int = 1) -> Iterator[list[Array]]:
    """Some quantities along the motion, so many rows at a time: a multiple of ``step``. Rows that are not too
    long are read whole. (To read one column of 400 takes eight times as long as to read all of them.)"""
    count = rows_of(result, wanted[0])
    sizes = {one.path: prod(result.held[one.path].shape[1:]) for one in wanted}
    sizes = {path: size for path, size in sizes.items() if size * step <= PIECE}
    piece = max(PIECE // (step * max(sizes.values(), default=1)), 1) * step
    for start in range(0, max(count, 1), piece):
        rows = slice(start, min(start + piece, count))
        whole = {path: result.read(path, rows) for path in sizes}
        yield [
            whole[one.path][rows_at(one)] if one.path in whole else result.read(one.path, (rows, *one.index))
            for one in wanted
        ]


def over_time(result: Result, time: Quantity, wanted: Sequence[Quantity]) -> list[tuple[Array, Array]]:
    """Times and values for curves: all of them, or of each part of a long motion the least and greatest."""
    width = max(1, -(-rows_of(result, time) // BUCKETS))
    parts = [
        [(t, x.copy()) if width <= 2 else least_and_greatest(t, x, width) for x in values]
        for t, *values in pieces(result, [time, *wanted], width)
    ]
    curves = (zip(*curve) for curve in zip(*parts))
    return [(np.concatenate(times), np.concatenate(values)) for times, values in curves]


def least_and_greatest(t: Array, x: Array, width: int) -> tuple[Array, Array]:
    """Where x is least and greatest in each part of so many samples."""
    short = -len(x) % width
    filled = np.concatenate([x, np.full(short, np.nan)]) if short else x
    parts = filled.reshape(-1, width)
    known = np.isfinite(parts)
    low = np.where(known, parts, np.inf).argmin(axis=1)
    high = np.where(known, parts, -np.inf).argmax(axis=1)
    picked = np.sort(np.stack([low, high], axis=1), axis=1) + width * np.arange(len(parts))[:, None]
    rows = np.minimum(picked.reshape(-1), len(x) - 1)
    return t[rows], x[rows]


def together(result: Result, wanted: Sequence[Quantity]) -> tuple[list[Array], int]:
    """Several quantities at the same samples: every k-th, and k."""
    step = max(1, -(-rows_of(result, wanted[0]) // min(POINTS, NUMBERS // len(wanted))))
    parts = [
        [each[::step].copy() for each in piece]  # which does not keep all that was read
        for piece in pieces(result, wanted, step)
    ]
    return [np.concatenate(each) for each in zip(*parts)], step


def extremes(result: Result, quantity: Quantity) -> tuple[float, float]:
    """The first value, and the greatest absolute value, of all samples."""
    first, largest = np.nan, 0.0
    for (x,) in pieces(result, (quantity,)):
        first = float(x[0]) if np.isnan(first) else first
        largest = max(largest, float(np.nanmax(np.abs(x), initial=0.0)))
    return first, largest
