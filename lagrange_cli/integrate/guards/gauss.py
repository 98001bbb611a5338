"""Gauss's rule for integrals. (numpy's has other bits on other machines.)"""

from __future__ import annotations

from functools import cache
from math import cos, pi


@cache
def gauss(count: int) -> list[tuple[float, float]]:
    """The nodes and weights of Gauss's rule on [0, 1] (M. Abramowitz and I. A. Stegun, 25.4.30), by Newton's
    method."""
    found = []
    for k in range(1, count + 1):
        x = cos(pi * (k - 0.25) / (count + 0.5))
        for _ in range(6):
            before, value = 1.0, x  # Legendre's polynomials
            for n in range(2, count + 1):
                before, value = value, ((2 * n - 1) * x * value - (n - 1) * before) / n
            slope = count * (x * value - before) / (x * x - 1)
            x -= value / slope
        found.append(((1 - x) / 2, 1 / ((1 - x * x) * slope**2)))
    return found
