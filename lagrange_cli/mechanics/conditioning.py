"""Whether a matrix is singular, or only so ill-conditioned that it cannot be solved: by singular values.

Those of a singular matrix end with rounding errors, far below all others. Those of an ill-conditioned one,
such as Hilbert's, fall step by step.
"""

from __future__ import annotations

import math
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from lagrange_cli.records import dataclass

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Values = NDArray[np.float64]

NOTHING, BALANCED = 1e-14, 8
"""The part of the largest singular value of a matrix that is rounding, and rounds in which the largest
numbers of its rows and columns become 1."""
ROUNDING = 1e-17
"""The part of it that rounding errors are at least."""
GAP = 1e4
"""How many times smaller than all others those are that are rounding errors."""


@dataclass(frozen=True, eq=False)
class Conditioning:
    """The singular ``values`` of a matrix, the largest first, and the ``ways`` that they belong to."""

    values: Values
    ways: Values

    @cached_property
    def lost(self) -> int:
        """How many of them are no larger than rounding errors."""
        return int(np.sum(self.values <= NOTHING * max(1.0, float(self.values[0]))))

    @property
    def graded(self) -> bool:
        """Whether these follow the others without a gap."""
        last = len(self.values) - self.lost
        if not self.lost or not last:
            return False
        least = max(float(self.values[last]), ROUNDING * float(self.values[0]))
        return float(self.values[last - 1]) < GAP * least

    @property
    def condition(self) -> float:
        """The condition of the matrix, as far as doubles tell."""
        return float(self.values[0]) / max(float(self.values[-1]), ROUNDING * float(self.values[0]))


def conditioning(matrix: Values) -> Conditioning | None:
    """That of a matrix, whatever the units; None where a number is not finite."""
    if not np.isfinite(matrix).all():
        return None
    for _ in range(BALANCED):
        for axis in 0, 1:
            sizes = np.sqrt(np.abs(matrix).max(axis=axis, keepdims=True))
            matrix = matrix / np.where(sizes > 0.0, sizes, 1.0)
    _, values, ways = np.linalg.svd(matrix)
    return Conditioning(values, ways)


def told(condition: float) -> str:
    """A condition in words."""
    return f"about 1e+{math.floor(math.log10(condition))}" if condition < 1e16 else "1e+16 or more"
