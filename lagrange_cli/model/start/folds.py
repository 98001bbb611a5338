"""Places at which two closures meet, such as rods that lie in a line.

There the slopes J of the constraints by the unknown coordinates have a rank too small, and rounding of the
constraints leaves half of the digits of these coordinates open. Let u and n be the directions with u^T J = 0
and J n = 0. The equations u^T J n = 0 and the constraints along the other directions determine the place to
all digits (A. Griewank and G. W. Reddien, SIAM J. Numer. Anal. 21, 176, 1984).
"""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, TypeAlias

import numpy as np

from lagrange_cli.model.start.linear import least_squares
from lagrange_cli.model.start.nearest import NEAR, ROUND

if TYPE_CHECKING:
    from numpy.typing import NDArray

Array: TypeAlias = "NDArray[np.float64]"

FLAT = 1e-3
"""Directions in which the slopes are smaller are looked at."""
FAR = 1e-3
"""The largest step, as a part of the size of the coordinates."""
STEPS = 12
APART = 2.0**-17
"""The distance at which slopes are compared, as a part of the same."""


def meeting_place(values: Callable[[Array], tuple[Array, Array]], begin: Array, size: float) -> Array | None:
    """The place near ``begin`` where two closures meet, if there is one. ``values`` are the slopes of the
    constraints by the unknown coordinates, a row for each, and the constraints, where the slopes of each by
    all coordinates are a vector of length 1."""
    x = begin
    try:
        slopes, _ = values(x)
        left, steepness, right = np.linalg.svd(slopes)
        steep = int((steepness > FLAT).sum())
        rest, flat, along = left[:, :steep], left[:, steep:], right[steep:]
        if not len(along):
            return None
        for _ in range(STEPS):
            slopes, f = values(x)
            bends = [(values(x + APART * size * n)[0] - slopes) / (APART * size) for n in np.eye(len(x))]
            curved = [[u @ bend @ n for bend in bends] for u in flat.T for n in along]
            level = [u @ slopes @ n for u in flat.T for n in along]
            matrix = np.vstack([rest.T @ slopes, np.reshape(curved, (-1, len(x)))])
            step = least_squares(matrix, -np.concatenate([rest.T @ f, level]))
            x, length = x + step, float(np.abs(step).max()) / size
            if not length <= FAR:
                return None
            if length <= ROUND:
                break
    except (ArithmeticError, np.linalg.LinAlgError):
        return None
    return x if length <= NEAR else None
