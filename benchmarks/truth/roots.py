"""Roots of functions of numbers with many digits."""

from __future__ import annotations

from collections.abc import Callable

from benchmarks.truth.case import MP, Number


def bracketed(f: Callable[[Number], Number], low: Number, high: Number) -> Number:
    """The root between two places, where f falls from above 0 (or 0 itself) to below: bisection, then the
    secant rule as long as it stays within."""
    for _ in range(40):
        middle = (low + high) / 2
        low, high = (middle, high) if f(middle) > 0 else (low, middle)
    a, b = f(low), f(high)
    for _ in range(200):
        if b == a:
            break
        x = high - b * (high - low) / (b - a)
        if not low <= x <= high:
            x = (low + high) / 2
        y = f(x)
        if min(x - low, high - x) < MP.mpf(10) ** (-MP.dps + 3) * (1 + abs(x)) or not y:
            return x
        if y > 0:
            a, low = y, x
            b /= 2  # the Illinois rule
        else:
            b, high = y, x
            a /= 2
        if high - low < MP.mpf(10) ** (-MP.dps + 3) * (1 + abs(x)):
            break
    return (low + high) / 2


def root_of(f: Callable[[Number], Number], low: Number, high: Number) -> Number:
    """The root of f between two places of opposite signs, with more digits than others have: a turning
    point."""
    with MP.workdps(2 * MP.dps + 10):
        low, high = MP.mpf(low), MP.mpf(high)
        sign = 1 if f(low) > 0 else -1
        if sign * f(high) >= 0:
            raise ArithmeticError("no change of sign")
        return bracketed(lambda x: sign * f(x), low, high)
