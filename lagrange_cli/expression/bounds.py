"""An algebra that knows only constants and sizes: it finds shape errors and explosions before any real work.

Every check that needs no mechanics is ``build`` over this algebra: vectors against scalars, a division by a
constant zero, a power whose exponent is out of bounds, definitions that multiply into something enormous.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass

from lagrange_cli.expression.numbers import NumberAlgebra

MAX_EXPONENT = 64
"""Bound on the absolute value of a constant exponent: (1 + x)**64 written out still fits a page."""
MAX_SIZE = 100_000
"""Bound on the nodes of an expression once its definitions and powers are written out."""

_NUMBERS = NumberAlgebra()


def check_exponent(value: float) -> None:
    """Raise ArithmeticError where a constant exponent is out of bounds."""
    if abs(value) > MAX_EXPONENT:
        raise ArithmeticError(f"the exponent {value:g} is out of bounds (-{MAX_EXPONENT} to {MAX_EXPONENT})")


@dataclass(frozen=True)
class Bounds:
    """An element: its value where it is a constant, and how many nodes it has written out."""

    value: float | None = None
    size: int = 1

    def __add__(self, other: Bounds) -> Bounds:
        return _combine(self, other, lambda x, y: x + y)

    def __sub__(self, other: Bounds) -> Bounds:
        return _combine(self, other, lambda x, y: x - y)

    def __mul__(self, other: Bounds) -> Bounds:
        return _combine(self, other, lambda x, y: x * y)

    def __truediv__(self, other: Bounds) -> Bounds:
        if other.value == 0:
            raise ZeroDivisionError
        return _combine(self, other, lambda x, y: x / y)

    def __pow__(self, other: Bounds) -> Bounds:
        if other.value is None:
            return _combine(self, other, pow)
        check_exponent(other.value)
        power = _combine(self, other, pow)
        return _bounded(power.value, power.size * max(1, math.ceil(abs(other.value))))

    def __neg__(self) -> Bounds:
        return Bounds(None if self.value is None else -self.value, self.size)


class BoundsAlgebra:
    """``Algebra[Bounds]``; every symbol is an unknown of size 1."""

    def number(self, text: str) -> Bounds:
        return Bounds(float(text))

    def pi(self) -> Bounds:
        return Bounds(math.pi)

    def symbol(self, name: str) -> Bounds:
        return Bounds()

    def function(self, name: str, arguments: Sequence[Bounds]) -> Bounds:
        size = 1 + sum(argument.size for argument in arguments)
        values = [argument.value for argument in arguments if argument.value is not None]
        if len(values) < len(arguments):
            return _bounded(None, size)
        return _bounded(_NUMBERS.function(name, values), size)

    def diff(self, expression: Bounds, symbol: Bounds) -> Bounds:
        return expression


def _combine(left: Bounds, right: Bounds, operation: Callable[[float, float], float]) -> Bounds:
    size = left.size + right.size + 1
    if left.value is None or right.value is None:
        return _bounded(None, size)
    return _bounded(operation(left.value, right.value), size)


def _bounded(value: float | complex | None, size: int) -> Bounds:
    if isinstance(value, complex):
        raise ArithmeticError("this power is not a real number")
    if value is not None and not math.isfinite(value):
        raise OverflowError
    if size > MAX_SIZE:
        raise ArithmeticError(
            f"the expression has more than {MAX_SIZE} terms once its definitions are written out"
        )
    return Bounds(value, size)
