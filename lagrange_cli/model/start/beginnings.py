"""Places from which Newton's method is started, the same ones in every run."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from itertools import islice
from random import Random

from lagrange_cli.model.start.equations import Row
from lagrange_cli.model.start.linear import DENSE
from lagrange_cli.model.start.nearest import NEAR, Surface

STARTS, FEW, MOST_ENTRIES = 96, 4, 400_000
"""Places to start from, few of them for large matrices; entries of other matrices in all of them together."""
LOOKS, FEW_LOOKS = 6, 3
"""Places at which it is looked whether equations are linear, or quadratic: of one unknown, and of more."""


def beginnings(
    surface: Surface, x: Sequence[float], sizes: Sequence[float], found: list[list[float]]
) -> Iterator[list[float]]:
    """Places from which all points of a surface are found, or many: linear equations need one, a quadratic
    equation its roots."""
    unknown = surface.unknown
    seen: list[tuple[list[float], list[float], list[Row]]] = []
    looks = LOOKS if len(unknown) == 1 else FEW_LOOKS
    for place in islice(starts(x, unknown, sizes, len(surface.kept), []), looks):
        try:
            values, rows = surface.at(place)
        except ArithmeticError:
            break
        seen.append((place, [float(values[i]) for i in surface.kept], [rows[i] for i in surface.kept]))
    if len(seen) == looks:
        inner = {*unknown}
        first = seen[0][2]
        if all(alike(row, other, inner) for _, _, rows in seen for row, other in zip(rows, first)):
            return iter([seen[0][0]])
        if len(unknown) == 1:
            (k,) = unknown
            roots = roots_of_square([(p[k], f[0], float(rows[0].get(k, 0.0))) for p, f, rows in seen])
            if roots is not None:
                return ([*x[:k], root, *x[k + 1 :]] for root in roots)
    return starts(x, unknown, sizes, len(surface.kept), found)


def alike(row: Row, other: Row, inner: set[int]) -> bool:
    """Whether slopes are the same."""
    sizes = [abs(a) for row in (row, other) for k, a in row.items() if k in inner]
    off = NEAR * max(sizes, default=0.0)
    return all(abs(row.get(k, 0.0) - other.get(k, 0.0)) <= off for k in {*row, *other} if k in inner)


def roots_of_square(seen: Sequence[tuple[float, float, float]]) -> list[float] | None:
    """The roots of a polynomial of second degree, from some of its arguments, values and slopes: its turning
    point where two of them are close. None where these are those of another function."""
    (x, f, slope), (other, _, steep), *_ = seen
    curve = (steep - slope) / (other - x)
    for y, value, steep in seen:
        d = y - x
        terms = f, slope * d, curve * d * d / 2
        if abs(slope + curve * d - steep) > NEAR * (abs(slope) + abs(curve * d)):
            return None
        if abs(sum(terms) - value) > NEAR * sum(map(abs, terms)):
            return None
    square = slope * slope - 2 * curve * f
    if not math.isfinite(square) or slope == curve == 0.0:
        return None
    if abs(curve * (other - x)) <= NEAR * abs(slope):
        return [x - f / slope]
    if abs(square) <= NEAR * (slope * slope + abs(curve * f)):
        return [x - slope / curve]
    if square < 0.0:
        return []
    far = -(slope + math.copysign(math.sqrt(square), slope))
    return sorted([x + far / curve, x + 2 * f / far])


def starts(
    x: Sequence[float], unknown: Sequence[int], sizes: Sequence[float], rows: int, found: list[list[float]]
) -> Iterator[list[float]]:
    """Places to start from: some are small, some large, all are spread over both signs.

    Every other one keeps some of the values of a closure that has been ``found``: of several loops, each may
    close in more than one way, whatever the others do.
    """
    inner = {*unknown}
    known = [abs(one) for k, one in enumerate(x) if k not in inner and one]
    lengths = list(dict.fromkeys([*known, *(abs(one) for one in sizes if one), 1.0, math.pi]))[:12]
    count = max(FEW, min(STARTS, MOST_ENTRIES // max(1, rows * len(unknown))))
    if len(unknown) > DENSE:
        count = FEW
    numbers = Random(0)  # from which every run draws the same
    for i in range(count):
        kept = found[i // 2 % len(found)] if found and i % 2 else None
        size = lengths[i // 2 % len(lengths)] if kept is None else max(abs(kept[k]) for k in unknown)
        begin = list(x)
        for k in unknown:
            place = 1.5 * size * numbers.uniform(-1.0, 1.0)
            begin[k] = place if kept is None or numbers.random() < 0.5 else kept[k]
        yield begin
