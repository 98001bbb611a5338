"""The numbers that doubles were rounded from."""

from __future__ import annotations

import math
from fractions import Fraction
from functools import lru_cache

WRITTEN = 12
"""Significant digits of a number as people write it."""
LARGEST_DENOMINATOR = 10_000
RARE = 1e-12
"""So close to a number there is hardly ever a fraction with such a denominator by chance."""
ULPS = 4
"""Errors of the last place that constants collect where they are combined."""

LEAST = 1e-150
"""Squares of smaller numbers, and of the inverse of smaller ones, are no doubles."""


@lru_cache(maxsize=4096)
def as_written(value: float | Fraction) -> tuple[Fraction, bool, int]:
    """(x, root, n) for the number x*pi^n, or sqrt(x)*pi^n, that a double (not negative) was rounded from.

    That is a short decimal, a simple fraction or one of these times pi or a root; where none is near enough,
    the number itself. Coefficients such as 0.1 + 0.2 - 0.3 then vanish as they should. A fraction
    that is no double has not been rounded, unless it is made of doubles: it is no decimal by chance.
    """
    number = float(value)
    near, digits = ULPS * math.ulp(number), WRITTEN if value == number else 0
    for turns in (0, 1, 2, -1):
        part = number / math.pi**turns
        found = simple(part, near * (part / number) if number else 0.0, digits)
        if found is not None:
            return found, False, turns
    square = None
    if LEAST < number < 1 / LEAST:
        square = simple(number * number, 2 * number * near, digits)
    return (Fraction(value), False, 0) if square is None else (square, True, 0)


def difference(one: float, other: float) -> float:
    """The sum of two doubles of opposite signs, as that of the numbers that they were rounded from: 0 for
    0.30000000000000004 - 0.3."""
    total, largest = one + other, max(abs(one), abs(other))
    parts = [(as_written(abs(x)), x < 0) for x in (one, other)]
    if any(root or turns for (_, root, turns), _ in parts):
        return total
    plainly = float(sum(-x if negative else x for (x, _, _), negative in parts))
    return plainly if abs(plainly - total) <= 2 * ULPS * math.ulp(largest) else total


def simple(number: float, near: float, digits: int) -> Fraction | None:
    """A decimal of so many digits or a simple fraction that is so near to a number."""
    exact = Fraction(number)
    if digits:
        found = Fraction(f"{number:.{digits}g}")
        if abs(found - exact) <= near:
            return found
    found = exact.limit_denominator(LARGEST_DENOMINATOR)
    return found if near < RARE and abs(found - exact) <= near else None
