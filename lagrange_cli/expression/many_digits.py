"""Arithmetic of hundreds of digits, for numbers that doubles cannot distinguish from 0."""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import cache
from typing import Any

import mpmath

from lagrange_cli.expression.written import as_written

LOST = 20
"""Digits that rounding errors may take."""


class ManyDigits:
    """Real arithmetic with many digits; a double stands for the number that it was rounded from (see
    ``written``)."""

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
        return self.context.mpf(value, prec=self.common)._mpf_


@cache
def many_digits(digits: int) -> ManyDigits:
    """The arithmetic of so many digits, which takes a millisecond to make. Nothing in it changes."""
    return ManyDigits(digits)
