"""Directions of quasi-Newton steps, from how slopes have changed along earlier ones."""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Callable
from typing import TypeAlias

from lagrange_cli.model.start.linear import Array

Pair: TypeAlias = tuple[Array, Array, Array, Array, float]
"""A step s, the change y of the slope along it, M s, M y, and s^T M y."""
CONVEX = 1e-8
"""The cosine of the angle between a step and the change of the slope is larger."""
REMEMBERED = 30
"""Steps that are remembered."""


class Curvature:
    """The limited-memory BFGS method in the metric of the masses, whose products with a vector
    (coordinates,) are ``weighted`` (J. Nocedal and S. J. Wright, Numerical Optimization, 2006, algorithm
    7.4)."""

    def __init__(self, weighted: Callable[[Array], Array]) -> None:
        self._weighted = weighted
        self._pairs: deque[Pair] = deque(maxlen=REMEMBERED)

    def __bool__(self) -> bool:
        return bool(self._pairs)

    def learn(self, step: Array, change: Array) -> None:
        """Remember a step and the change of the slope, unless the function is not clearly convex along it."""
        heavy, turned = self._weighted(step), self._weighted(change)
        bent, sizes = float(heavy @ change), [float(heavy @ step), float(turned @ change)]
        if min(sizes) > 0.0 and bent > CONVEX * math.sqrt(sizes[0]) * math.sqrt(sizes[1]):
            self._pairs.append((step, change, heavy, turned, bent))

    def forget(self) -> None:
        """Begin anew, as at another place."""
        self._pairs.clear()

    def direction(self, descent: Array) -> Array:
        """The step to where the slope is likely to be 0, from the direction of steepest ``descent``."""
        found, parts = descent, []
        for _, change, heavy, _, bent in reversed(self._pairs):
            parts.append(float(heavy @ found) / bent)
            found = found - parts[-1] * change
        if self._pairs:
            _, change, _, turned, bent = self._pairs[-1]
            found = found * (bent / float(turned @ change))
        for step, _, _, turned, bent in self._pairs:
            found = found + (parts.pop() - float(turned @ found) / bent) * step
        return found
