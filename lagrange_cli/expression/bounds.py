"""An algebra that knows only constants and sizes: it finds shape errors and explosions before any real work.

Every check that needs no mechanics is ``build`` over this algebra: vectors against scalars, a division by a
constant zero, a power whose exponent is out of bounds, definitions that multiply into something enormous.
"""

from __future__ import annotations

import math
import operator
from collections.abc import Callable, Sequence
from functools import reduce

from lagrange_cli.decimals import decimal
from lagrange_cli.expression.algebra import Undecided
from lagrange_cli.expression.numbers import NumberAlgebra
from lagrange_cli.limits import whole

MAX_EXPONENT = whole("exponent")
"""Bound on the absolute value of a constant exponent: (1 + x)**64 expanded still fits a page."""
MAX_SIZE = whole("size")
"""Bound on the nodes of an expression after expansion of its definitions and powers."""

MAX_DEPTH = 100
"""Bound on how deep it is nested then, a sum of sums or a product of products counting once."""

MERGED = "sum", "product"
"""Operations that are written as one with those of their kind within them."""

_NUMBERS = NumberAlgebra()


def check_exponent(value: float) -> None:
    """Raise ArithmeticError where a constant exponent is out of bounds."""
    if abs(value) > MAX_EXPONENT:
        raise ArithmeticError(
            f"the exponent {decimal(value)} is out of bounds (-{MAX_EXPONENT} to {MAX_EXPONENT}; "
            "limit 'exponent')"
        )


class Bounds:
    """An element: its value where it is a constant, and its number of nodes after expansion.

    ``depth`` is how deep it is nested, and ``kind`` its outermost operation, which the same one around it
    would be merged with.
    """

    __slots__ = ("depth", "kind", "size", "value")

    def __init__(self, value: float | None = None, size: int = 1, depth: int = 0, kind: str = "") -> None:
        if size > MAX_SIZE:
            raise ArithmeticError(
                f"the expression has more than {MAX_SIZE} terms with its definitions expanded (limit 'size')"
            )
        if depth > MAX_DEPTH:
            raise ArithmeticError(
                f"the expression is nested more than {MAX_DEPTH} deep with its definitions expanded"
            )
        self.value, self.size, self.depth, self.kind = value, size, depth, kind

    def __add__(self, other: Bounds) -> Bounds:
        return _combined("sum", operator.add, self, other)

    def __sub__(self, other: Bounds) -> Bounds:
        return _combined("sum", operator.sub, self, other)

    def __mul__(self, other: Bounds) -> Bounds:
        return _combined("product", operator.mul, self, other)

    def __truediv__(self, other: Bounds) -> Bounds:
        if other.value == 0:
            raise ZeroDivisionError
        return _combined("product", operator.truediv, self, other)

    def __pow__(self, other: Bounds) -> Bounds:
        if other.value is None or self.value is not None:  # nothing, or a number, to be written out
            return _combined("power", pow, self, other)
        check_exponent(other.value)
        power = _combined("power", pow, self, other)
        size = power.size * max(1, math.ceil(abs(other.value)))
        return Bounds(power.value, size, power.depth, power.kind)

    def __neg__(self) -> Bounds:
        value = None if self.value is None else -self.value
        return Bounds(value, self.size, self.depth, self.kind)


class BoundsAlgebra(Undecided):
    """``Algebra[Bounds]``; every symbol is an unknown of size 1."""

    def number(self, text: str) -> Bounds:
        return Bounds(float(text))

    def pi(self) -> Bounds:
        return Bounds(math.pi)

    def symbol(self, name: str) -> Bounds:
        return Bounds()

    def function(self, name: str, arguments: Sequence[Bounds]) -> Bounds:
        return _combined("function", lambda *values: _NUMBERS.function(name, values), *arguments)

    def switch(self, u: Bounds, above: Bounds, below: Bounds, at: int) -> Bounds:
        if u.value is None:
            whole = _combined("function", lambda *_: 0.0, u, above, below)
            return Bounds(None, whole.size, whole.depth, whole.kind)
        return above if _NUMBERS.side(u.value, at) == 1 else below

    def total(self, terms: Sequence[Bounds]) -> Bounds:
        return reduce(operator.add, terms)

    def symbols(self, expression: Bounds) -> tuple[Bounds, ...]:
        """It may contain any symbol, unless it is a constant."""
        return () if expression.value is not None else (Bounds(),)

    def diff(self, expression: Bounds, symbol: Bounds) -> Bounds:
        return expression


def _combined(kind: str, operation: Callable[..., float | complex], *operands: Bounds) -> Bounds:
    size, depth, constant = 1, 0, True
    for one in operands:  # a loop, as this is most of what reading a large system takes
        size += one.size
        inner = one.depth if one.kind == kind and kind in MERGED else one.depth + 1
        if inner > depth:
            depth = inner
        if one.value is None:
            constant = False
    if not constant:
        return Bounds(None, size, depth, kind)
    value = operation(*(one.value for one in operands))
    if isinstance(value, complex):  # Python's floats leave the real line for (-1)**0.5
        raise ArithmeticError("this power is not a real number")
    if not math.isfinite(value):
        raise OverflowError
    return Bounds(value, size, depth, kind)
