"""Observed quantities that follow one another in one array, which a loop copies."""

from __future__ import annotations

from collections.abc import Iterable

from lagrange_cli.families.arrays import Total
from lagrange_cli.records import dataclass


@dataclass(frozen=True)
class Run:
    """``count`` observed quantities, every ``step``-th one from number ``row`` on: those from ``start`` on
    in a total."""

    row: int
    step: int
    total: Total
    start: int
    count: int


def runs_of(observed: Iterable[tuple[Total, int]]) -> list[Run]:
    """The runs of quantities, given where each of them is."""
    found: list[tuple[Total, list[int]]] = []
    latest: dict[Total, list[int]] = {}
    for row, (total, index) in enumerate(observed):
        if total in latest:
            first, step, start, count = latest[total]
            step = step if count > 1 else row - first
            if start + count == index and first + count * step == row:
                latest[total][1:] = step, start, count + 1
                continue
        latest[total] = [row, 1, index, 1]
        found.append((total, latest[total]))
    return [Run(row, step, total, start, count) for total, (row, step, start, count) in found]
