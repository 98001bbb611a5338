"""``Probe``: values of expressions at a few random states, which show what does not depend on the state.

The form of an expression does not show whether a distance is constant, since products of sums are not
expanded. Its values at eight random states near the start do.
"""

from __future__ import annotations

import random
from collections.abc import Mapping, Sequence

import numpy as np

from lagrange_cli.drawing.drawing import FREE
from lagrange_cli.expression.arrays import Array, evaluate
from lagrange_cli.expression.node import Node
from lagrange_cli.expression.vocabulary import TIME, velocity_name
from lagrange_cli.spec.spec import Spec
from lagrange_cli.spec.values import Values

STATES = 8
NEEDED = 3
"""The number of states at which there must be a value."""
ROUNDING = 1e-9
"""Numbers that differ by less, relatively, are equal."""


class Probe:
    """The values of expressions at random states."""

    def __init__(self, spec: Spec, values: Values, start: float) -> None:
        drawn = random.Random(0)
        self.symbols: dict[str, Array | float] = dict(values.parameters)
        for one, q, v in zip(spec.coordinates, values.q, values.v):
            around = [q + (0.2 + 0.4 * abs(q)) * drawn.uniform(-1, 1) for _ in range(STATES)]
            rates = [v + (0.2 + 0.4 * abs(v)) * drawn.uniform(-1, 1) for _ in range(STATES)]
            self.symbols[one.name] = np.array(around)
            self.symbols[velocity_name(one.name)] = np.array(rates)
        self.symbols[TIME] = np.array([start + 3 * drawn.random() for _ in range(STATES)])
        self.symbols |= {name: np.array([drawn.random() for _ in range(STATES)]) for name in FREE}
        self._known: dict[Node, Array] = {}

    def __call__(self, nodes: Sequence[Node], given: Mapping[str, Array | float] | None = None) -> Array:
        """Their values (nodes, STATES); ``given`` are those of some symbols, in place of random ones."""
        if given is None:
            new = [one for one in dict.fromkeys(nodes) if one not in self._known]
            self._known |= zip(new, self._evaluated(new, self.symbols))
            rows = [self._known[one] for one in nodes]
        else:
            rows = self._evaluated(nodes, {**self.symbols, **given})
        return np.array(rows).reshape(len(nodes), STATES)

    def _evaluated(self, nodes: Sequence[Node], symbols: Mapping[str, Array | float]) -> list[Array]:
        return [np.broadcast_to(one, (STATES,)) for one in evaluate(nodes, symbols)] if nodes else []


def steady(values: Array, scale: float = 0.0) -> bool:
    """Whether all values (STATES,) that there are equal one another, as seen beside ``scale``."""
    there = values[np.isfinite(values)]
    if len(there) < NEEDED:
        return False
    return bool(np.ptp(there) <= ROUNDING * max(scale, float(np.abs(there).max())))


def equal(a: Array, b: Array, scale: float = 0.0) -> bool:
    """Whether two rows of values, (STATES,) or (components, STATES), are equal where both are there."""
    both = np.isfinite(a) & np.isfinite(b)
    if both.sum() < NEEDED:
        return False
    scale = max(scale, float(np.abs(a[both]).max()), float(np.abs(b[both]).max()))
    return bool(np.all(np.abs(a[both] - b[both]) <= ROUNDING * scale))
