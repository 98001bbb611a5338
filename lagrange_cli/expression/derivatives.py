"""The elementary functions of numbers with their first three derivatives."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

from lagrange_cli.decimals import decimal


def tangent(f: Any, sign: int) -> list[Any]:
    """tan (sign 1) and tanh (sign -1) with their derivatives: f' = 1 + sign f^2."""
    slope = 1 + sign * f * f
    return [f, slope, 2 * sign * f * slope, 2 * sign * slope * (1 + 3 * sign * f * f)]


def arc(m: Any, x: Any) -> list[Any]:
    """The derivatives of asin; raises ``ArithmeticError`` where it has none."""
    if abs(x) == 1:
        raise ArithmeticError(f"asin and acos have no slope at {decimal(float(x))}")
    root = 1 / m.sqrt(1 - x * x)
    return [root, x * root**3, (1 + 2 * x * x) * root**5]


def arc_tangent(m: Any, x: Any) -> list[Any]:
    """atan with its derivatives."""
    slope = 1 / (1 + x * x)
    return [m.atan(x), slope, -2 * x * slope**2, (6 * x * x - 2) * slope**3]


FUNCTIONS: dict[str, Callable[[Any, Any], Sequence[Any]]] = {
    "sin": lambda m, x: [m.sin(x), m.cos(x), -m.sin(x), -m.cos(x)],
    "cos": lambda m, x: [m.cos(x), -m.sin(x), -m.cos(x), m.sin(x)],
    "tan": lambda m, x: tangent(m.tan(x), 1),
    "tanh": lambda m, x: tangent(m.tanh(x), -1),
    "sinh": lambda m, x: [m.sinh(x), m.cosh(x)] * 2,
    "cosh": lambda m, x: [m.cosh(x), m.sinh(x)] * 2,
    "exp": lambda m, x: [m.exp(x)] * 4,
    "log": lambda m, x: [m.log(x), 1 / x, -1 / x**2, 2 / x**3],
    "atan": arc_tangent,
    "asin": lambda m, x: [m.asin(x), *arc(m, x)],
    "acos": lambda m, x: [m.acos(x), *(-slope for slope in arc(m, x))],
}
"""Each function with its first three derivatives; ``m`` has those of numbers: ``math``, or ``mpmath``."""


def powers(x: Any, n: Any) -> list[Any]:
    """x**n with its first three derivatives.

    Raises ``ArithmeticError`` where one of them does not exist.
    """
    falling = (1.0, n, n * (n - 1), n * (n - 1) * (n - 2))
    if x < 0 and n % 1:
        raise ArithmeticError("a fractional power of a negative number")
    return [c * x ** (n - k) if c else 0.0 for k, c in enumerate(falling)]
