"""Events that rounding may have decided: grazing ones, and multiple zeros, whose times are less certain."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from lagrange_cli.integrate.arrays import Array

GRAZING = 2.0**-46
"""An argument that goes beyond 0 by at most this fraction of its terms may not cross 0 at all."""
FLAT = 2.0**-12
"""The zero of an argument whose rate is this part of what bends it along a step may be a multiple one."""
ULP = {1: 2.0**-52, 2: 2.0**-104}
"""The rounding of numbers of so many parts."""
ALIKE, BLURRED = 8.0, 2.0**-37
"""Errors up to this ratio do not tell how many zeros there are in one; those up to this part of the time are
of no account."""


def doubts(
    rates: Array, lengths: Array, t: Array, reached: Array, ulp: float, size_of: Callable[[int], float]
) -> tuple[NDArray[np.bool_], Array]:
    """Which events at times ``t`` graze 0, and the errors of the times of others. Their series have
    these ``rates`` (3, k), in steps of these ``lengths``, at states that have ``reached`` so far; ``size_of``
    gives the size of the terms of one."""
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        beyond = rates[0] * rates[0] / (4.0 * np.abs(rates[1]))
        square = lengths * lengths
        along = np.abs(rates) * [lengths, square, square * lengths]  # what cancels along the step
    reached = np.fmax(1.0, reached)
    flat = ~(along[0] > FLAT * (along[1] + along[2])) | (beyond <= GRAZING * np.fmax(along[1], reached))
    grazing, errors = np.zeros(len(t), dtype=bool), np.zeros(len(t))
    for k in np.flatnonzero(flat):
        size = float(np.fmax(along[1, k], size_of(int(k))))
        order, error = blur(ulp * np.fmax(size, along[2, k]), rates[:, k])
        if order < 3:
            grazing[k] = beyond[k] <= GRAZING * size
        elif error > BLURRED * max(abs(t[k]), lengths[k]):
            errors[k] = error
    return grazing, errors


def blur(noise: float, rates: Array) -> tuple[int, float]:
    """How many zeros rounding may not tell from one, up to 3, and by how much it may move them: where
    coefficient k alone stands against the ``noise``, by (noise/|c_k|)^(1/k)."""
    with np.errstate(divide="ignore", invalid="ignore"):
        moved = np.where(rates == 0.0, np.inf, noise / np.abs(rates))
    moved **= 1.0 / np.arange(1.0, 1.0 + len(rates))
    error = float(np.min(moved))
    return 1 + int(np.flatnonzero(moved <= ALIKE * error)[-1]), error
