"""How much rounding of a state changes a quantity, where it is a small difference of large numbers."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from lagrange_cli.integrate.arrays import Array

if TYPE_CHECKING:
    from lagrange_cli.native.interface import Interface

WAYS, GOLDEN = 5, (math.sqrt(5.0) - 1.0) / 2.0
"""In so many ways a state is changed by rounding, by multiples of the golden ratio, which spread evenly."""


def rounded_otherwise(state: Array, program: Interface) -> Array:
    """A state (rows, 1), and beside it others (rows, 1 + WAYS), whose coordinates and velocities differ by up
    to a unit of rounding."""
    moving, parts = 2 * program.state.degrees, program.parts
    factors = np.outer(np.arange(1, moving + 1), np.arange(1, 1 + WAYS)) * GOLDEN
    shares = 2.0 * (factors - np.floor(factors)) - 1.0
    states, low = np.repeat(state, 1 + WAYS, axis=1), (parts - 1) * program.rows
    states[low : low + moving, 1:] += state[:moving] * shares * 2.0 ** (1 - 53 * parts)
    return states


def change_of(parts: Sequence[Array]) -> float:
    """The change of a quantity, known in ``parts`` (1 + WAYS,), from the first state to the others: the
    median of its magnitudes, as one of them may lie beyond a jump. 0 where it is not finite."""
    with np.errstate(invalid="ignore"):
        change = float(np.median(np.abs(sum(part[1:] - part[0] for part in parts))))
    return change if math.isfinite(change) else 0.0
