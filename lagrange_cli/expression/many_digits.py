"""Arithmetic of hundreds of digits, for numbers that doubles cannot distinguish from 0."""

from __future__ import annotations

import math
from collections.abc import Sequence
from fractions import Fraction
from functools import lru_cache
from typing import Any

import mpmath

LOST = 20
"""Digits that rounding errors may take."""
WRITTEN = 12
"""Significant digits of a number in a file."""
LARGEST_DENOMINATOR = 10_000
RARE = 1e-12
"""Within so little of a number there is hardly ever a fraction with such a denominator by chance."""
ULPS = 4
"""Errors of the last place that constants collect where they are combined."""


class ManyDigits:
    """Real arithmetic with so many digits; a number stands for its value before rounding (see
    ``as_written``)."""

    def __init__(self, digits: int) -> None:
        self.context = mpmath.mp.clone()
        self.context.dps = digits
        self.rounding = self.context.mpf(10) ** (LOST - digits)
        self.common = self.context.prec // 2
        """The bits that equal values have in common."""

    def number(self, value: Any) -> Any:
        """The number that ``value`` stands for."""
        if isinstance(value, self.context.mpf):
            return value
        if not math.isfinite(value):
            return self.context.mpf(value)
        if value < 0:
            return -self.number(-value)
        fraction, square, turns = as_written(value)
        found = self.context.mpf(fraction.numerator) / fraction.denominator
        return (self.context.sqrt(found) if square else found) * self.context.pi**turns

    def power(self, base: Any, exponent: int) -> Any:
        """``base ** exponent``, infinite for a division by 0."""
        if base == 0 and exponent < 0:
            return self.context.inf
        return self.context.power(base, exponent)

    def function(self, name: str, arguments: Sequence[Any]) -> Any:
        """An elementary function."""
        if not abs(arguments[0]) < 1 / self.rounding:
            return self.context.nan
        return getattr(self.context, name)(*arguments)

    def finite(self, value: Any) -> bool:
        return bool(self.context.isfinite(value))

    def rounded(self, value: Any) -> Any:
        """The common key of values that differ by rounding errors at most."""
        with self.context.workprec(self.common):
            return self.context.mpf(value)._mpf_


@lru_cache(maxsize=4096)
def as_written(value: float | Fraction) -> tuple[Fraction, bool, int]:
    """(x, root, n) for the number x*pi^n, or sqrt(x)*pi^n, that a double (not negative) was rounded from.

    That is a short decimal, a simple fraction or one of these times pi or a root; where none is near enough,
    the number itself. Coefficients of which 0.1 + 0.2 - 0.3 is one then vanish where they should. A fraction
    that is no double has not been rounded, unless it is made of doubles: it is no decimal by chance.
    """
    number = float(value)
    near, digits = ULPS * math.ulp(number), WRITTEN if value == number else 0
    for turns in (0, 1, 2, -1):
        part = number / math.pi**turns
        found = simple(part, near * part / number if number else 0.0, digits)
        if found is not None:
            return found, False, turns
    square = simple(number * number, 2 * number * near, digits)
    return (Fraction(value), False, 0) if square is None else (square, True, 0)


def simple(number: float, near: float, digits: int) -> Fraction | None:
    """A decimal of so many digits or a simple fraction that is so near to a number."""
    exact = Fraction(number)
    if digits:
        found = Fraction(f"{number:.{digits}g}")
        if abs(found - exact) <= near:
            return found
    found = exact.limit_denominator(LARGEST_DENOMINATOR)
    return found if near < RARE and abs(found - exact) <= near else None
