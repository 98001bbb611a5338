"""How an error grows with time."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


def growth_exponent(times: Array, errors: Array) -> float:
    """The slope of the straight line through log error over log time."""
    return float(np.polyfit(np.log(times), np.log(errors), 1)[0])


def binned(times: Array, squares: Array, bins: int) -> tuple[Array, Array]:
    """Times (bins,) and root means of ``squares`` (n,) in bins of equal width in log time; empty ones are
    left out."""
    edges = np.geomspace(times[0], times[-1], bins + 1)
    number = np.clip(np.searchsorted(edges, times, side="right") - 1, 0, bins - 1)
    filled = np.unique(number)
    centres = np.array([np.exp(np.mean(np.log(times[number == k]))) for k in filled])
    roots = np.array([np.sqrt(np.mean(squares[number == k])) for k in filled])
    return centres, roots
