"""Powers of doubles, and of e, by Python's own decimals: rounded alike everywhere, unlike the C library's."""

from __future__ import annotations

from decimal import Context, Decimal

DIGITS = Context(prec=40)


def power(base: float, exponent: float) -> float:
    """``base ** exponent`` for positive numbers, rounded correctly."""
    return float(DIGITS.power(Decimal(base), Decimal(exponent)))


def exponential(x: float) -> float:
    """e^x, rounded correctly."""
    return float(DIGITS.exp(Decimal(x)))
