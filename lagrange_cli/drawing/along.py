"""``Along``: the parameters along a motion, where actions of events set some of them."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from itertools import pairwise
from typing import Any

import numpy as np

Array = np.ndarray


class Along(Mapping[str, float]):
    """The parameters with which a motion begins, and what some of them are from later ``times`` on.

    ``times`` (k,) ascend, ``changed`` has values (k,) by name. Of several changes at once the last one holds.
    (No action sets anything in a motion backward in time.)
    """

    def __init__(self, first: Mapping[str, float], times: Array, changed: Mapping[str, Array]) -> None:
        self.first, self.times, self.changed = first, times, changed

    def __getitem__(self, name: str) -> float:
        return self.first[name]

    def __iter__(self) -> Iterator[str]:
        return iter(self.first)

    def __len__(self) -> int:
        return len(self.first)

    def at(self, t: Array) -> dict[str, Any]:
        """The parameters at the times ``t`` (n,): arrays (n,) of those that change, numbers of others."""
        places = self.places(t)
        steps = {name: np.r_[self.first[name], values][places] for name, values in self.changed.items()}
        return {**self.first, **steps}

    def places(self, t: Array) -> Array:
        """How many changes there have been up to the times ``t`` (n,)."""
        return np.searchsorted(self.times, t, side="right")

    def pieces(self, t: Array) -> Iterator[tuple[slice, dict[str, float]]]:
        """Stretches of the times ``t`` (n,), and the parameters that do not change within each of them."""
        places = self.places(t)
        edges = [0, *(np.flatnonzero(np.diff(places)) + 1).tolist(), len(t)]
        for first, last in pairwise(edges):
            if last > first:
                own = self.at(t[first : first + 1])
                yield slice(first, last), {name: float(np.squeeze(value)) for name, value in own.items()}
