"""Powers of doubles by Python's own decimals: rounded alike everywhere, as the C library's need not be."""

from __future__ import annotations

from decimal import Context, Decimal

DIGITS = Context(prec=40)


def power(base: float, exponent: float) -> float:
    """``base ** exponent`` for positive numbers, rounded correctly."""
    return float(DIGITS.power(Decimal(base), Decimal(exponent)))
