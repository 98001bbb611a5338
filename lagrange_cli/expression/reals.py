"""Real arithmetic that never raises: nan or inf where Python would raise or turn complex."""

from __future__ import annotations

import math
from collections.abc import Sequence

TOO_SMALL, SMALLEST = "number too small", "the smallest is about 4.9e-324"

FADED = 2.0**-1000
"""Exponentials below this may be 0 where they fade, as tails of bumps do."""


class Underflow(ArithmeticError):
    """A product, a quotient or a power that is so small that it would be 0."""


def underflows(text: str) -> bool:
    """Whether the number that is written is not 0, but its double is."""
    return float(text) == 0.0 and any(digit in "123456789" for digit in text.lower().partition("e")[0])


def tidy(exponent: float) -> int | float:
    """A whole exponent as an int, any other as a float."""
    if type(exponent) is int:
        return exponent
    return int(exponent) if math.isfinite(exponent) and exponent == int(exponent) else float(exponent)


def real_power(base: float, exponent: float) -> float:
    """``base ** exponent`` in real arithmetic: nan or inf where Python would raise or turn complex."""
    try:
        return math.pow(base, exponent)
    except ZeroDivisionError:
        return math.inf
    except ValueError:
        return math.inf if base == 0.0 else math.nan
    except OverflowError:
        return math.inf


def real_function(name: str, arguments: Sequence[float]) -> float:
    """An elementary function of floats: nan or inf where ``math`` would raise."""
    try:
        return float(getattr(math, name)(*arguments))
    except ValueError:
        return -math.inf if name == "log" and arguments[0] == 0.0 else math.nan
    except OverflowError:
        return -math.inf if name == "sinh" and arguments[0] < 0.0 else math.inf
