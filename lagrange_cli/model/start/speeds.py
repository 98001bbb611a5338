"""Velocities that satisfy the rates of the constraints at a place."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

from lagrange_cli.model.start.closures import determined
from lagrange_cli.model.start.equations import Masses, Matter, Rates
from lagrange_cli.model.start.linear import scales, steepness
from lagrange_cli.model.start.moved import moved, tried
from lagrange_cli.model.start.nearest import Surface, Values
from lagrange_cli.model.start.search import Search
from lagrange_cli.records import replace


def speeds(
    search: Search, q: Sequence[Any], scale: Sequence[float], masses: Matter, kept: Sequence[int]
) -> list[Any]:
    """Consistent velocities."""
    given, v = search.given, list(search.given.v)
    rates = search.rates(q, v)

    def at(x: Sequence[Any]) -> Values:
        values = [
            drift + sum((a * x[k] for k, a in row.items()), 0 * drift)
            for row, drift in zip(rates.rows, rates.drifts)
        ]
        return values, rates.rows

    def surface(kept: Sequence[int], unknown: Sequence[int], size: Sequence[float]) -> Surface:
        """They are linear functions: however long, the first step leads there."""
        return Surface(at, kept, unknown, masses, size, search.unit, far=math.inf)

    everything = [*range(len(v))]
    whole = tried(surface(kept, everything, scale).reach, v) or v
    size = scales(masses, [max(abs(float(a)), abs(float(b))) for a, b in zip(v, whole)])
    unknown = sorted(given.open_v)
    if unknown and off_by(at(v), size, rates) > 0.0:
        some = determined([rates.rows[i] for i in kept], unknown, scale)
        own = masses.diagonal(len(v))  # none moves because others do
        if not all(own[k] > 0 for k in unknown):
            own = [1.0 / size**2 for size in scale]
        alone = Masses({k: {k: own[k]} for k in unknown})
        free = replace(surface([kept[i] for i in some], unknown, size), masses=alone)
        found = tried(free.nearest, v)
        v = v if found is None else found
    return moved(
        search, surface(kept, everything, size), v, lambda x: off_by(at(x), size, rates), speeds=True
    )


def off_by(values: Values, size: Sequence[float], rates: Rates) -> float:
    """The largest rate of a constraint, relative to its terms."""
    found = 0.0
    for value, steep, drift in zip(values[0], steepness(values[1], size), rates.drifts):
        whole = max(steep, abs(float(drift)))
        if value:
            found = max(found, abs(float(value)) / whole if whole else math.inf)
    return found
