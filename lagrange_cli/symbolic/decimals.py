"""Rational numbers as text: digits, or a fraction."""

from __future__ import annotations

from fractions import Fraction


def digits_of(value: Fraction) -> str:
    """A decimal number with the digits of a double; an integer beyond those with all of its own."""
    try:
        return repr(float(value))
    except OverflowError:
        return str(value.numerator // value.denominator)


def reads_as_fraction(value: Fraction, decimals: bool) -> bool:
    """Whether to write a fraction (1/2, 3/4, 1/3, 1/5), as textbooks do, rather than a decimal number (9.81,
    0.3), which is used only beside other ``decimals``."""
    if not decimals and max(value.numerator, value.denominator) < 1000:
        return True
    rest = value.denominator
    for prime in (2, 5):
        while rest % prime == 0:
            rest //= prime
    if rest != 1:  # no decimal number equals it: a fraction, unless it is very long
        return max(value.numerator, value.denominator) < 10**15
    if value.denominator & (value.denominator - 1) == 0:
        return value.numerator < 10 and value.denominator <= 1024
    return value.numerator < 10 and value.denominator == 5
