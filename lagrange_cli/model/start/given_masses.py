"""The metric in which a state is near to given values: that of the masses, for the given coordinates alone.

The others have no values to be near to. Given coordinates without a mass count by their scale.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping, Sequence
from typing import Any

from lagrange_cli.model.start.equations import Matter, Solver


class GivenMasses:
    """``Matter`` in which the ``free`` coordinates have no mass; ``scale`` is that of each coordinate."""

    def __init__(self, masses: Matter, free: Collection[int], scale: Sequence[float]) -> None:
        self.masses, self.free = masses, {*free}
        diagonal = [float(m) for m in masses.diagonal(len(scale))]
        whole = max((m * size**2 for m, size in zip(diagonal, scale)), default=0.0) or 1.0
        self.lent = {
            k: whole / size**2
            for k, (m, size) in enumerate(zip(diagonal, scale))
            if not m and k not in self.free
        }
        """Masses of those that have none, with which they count as much as the whole system."""

    @property
    def rows(self) -> Mapping[int, Mapping[int, Any]]:
        own = {
            j: {k: m for k, m in row.items() if k not in self.free}
            for j, row in self.masses.rows.items()
            if j not in self.free
        }
        return own | {k: {k: m} for k, m in self.lent.items()}

    @property
    def extent(self) -> float:
        return self.masses.extent

    def diagonal(self, count: int) -> list[Any]:
        own = enumerate(self.masses.diagonal(count))
        return [0.0 if k in self.free else self.lent.get(k, m) for k, m in own]

    def times(self, way: Sequence[Any], chosen: Iterable[int]) -> dict[int, Any]:
        alone = [0 * x if k in self.free else x for k, x in enumerate(way)]
        found = self.masses.times(alone, chosen)
        for k in found:
            found[k] = 0 * found[k] if k in self.free else found[k] + self.lent.get(k, 0.0) * alone[k]
        return found

    def solver(self, chosen: Sequence[int]) -> Solver | None:
        return None
