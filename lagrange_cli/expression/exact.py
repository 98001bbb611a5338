"""The graph's algebra, and that of numbers, for runs in double-double: nothing is rounded to doubles.

A number of the file is what is written there, 9.81 a fraction; what is irrational, pi or sqrt(2), is known to
``DIGITS`` digits. So a coefficient is the same wherever derivation brings it.
"""

from __future__ import annotations

import math
import sys
from collections.abc import Callable, Sequence
from fractions import Fraction
from typing import Any, TypeAlias

import mpmath

from lagrange_cli.decimals import decimal
from lagrange_cli.errors import BeyondDoubles
from lagrange_cli.expression.graph import Graph
from lagrange_cli.expression.graph_algebra import GraphAlgebra
from lagrange_cli.expression.node import Kind, Node
from lagrange_cli.expression.numbers import NumberAlgebra
from lagrange_cli.expression.reals import SMALLEST, TOO_SMALL
from lagrange_cli.expression.syntax import ExpressionError, Tree
from lagrange_cli.expression.vocabulary import NON_SMOOTH

DIGITS = 70
_CONTEXT = mpmath.mp.clone()
_CONTEXT.dps = DIGITS
LARGEST = sys.float_info.max
LARGEST_RATIO = 1e60
"""Sums with numbers that are farther apart are not divided by one of them."""
_MOST_BITS = 2000
"""Numerators and denominators that become longer are rounded to ``DIGITS`` digits."""


def context() -> Any:
    """mpmath's functions and numbers, of ``DIGITS`` digits."""
    return _CONTEXT


class Exact(Fraction):
    """A fraction that stays one where floats are added or multiplied, infinite ones apart."""

    __slots__ = ()

    def __eq__(self, other: object) -> bool:
        if type(other) is float and self.denominator == 1:
            return self.numerator == other
        return Fraction.__eq__(self, other)

    def __hash__(self) -> int:  # type: ignore[override]
        return hash(self.numerator) if self.denominator == 1 else Fraction.__hash__(self)


def _exact(text: str) -> Any:
    """The number a literal stands for; 0 and infinity where a double would be (and not a million digits)."""
    rounded = float(text)
    return Exact(text) if rounded and math.isfinite(rounded) else rounded


Parts: TypeAlias = "Callable[[int, int, int, int], tuple[int, int]]"


def _operation(name: str, idle: float | None, parts: Parts) -> Callable[[Exact, Any], Any]:
    """An operation of ``Exact``, a/b and c/d, whose result has these ``parts``; the number ``idle`` changes
    nothing, and is what most of them are with. (``Fraction`` takes four times as long, most of it to find
    out what the other number is.)"""
    plain, of_floats = getattr(Fraction, name), getattr(float, name)

    def operation(self: Exact, other: Any) -> Any:
        if isinstance(other, float):
            if other == idle:
                return self
            if not math.isfinite(other):
                return of_floats(float(self), other)
            c, d = other.as_integer_ratio()
        elif isinstance(other, (Fraction, int)):
            c, d = other.numerator, other.denominator
        else:
            made = plain(self, other)
            return _bounded(made.numerator, made.denominator) if isinstance(made, Fraction) else made
        return _bounded(*parts(self.numerator, self.denominator, c, d))

    return operation


for _name, _idle, _parts in (
    ("add", 0.0, lambda a, b, c, d: (a * d + c * b, b * d)),
    ("radd", 0.0, lambda a, b, c, d: (a * d + c * b, b * d)),
    ("sub", 0.0, lambda a, b, c, d: (a * d - c * b, b * d)),
    ("rsub", None, lambda a, b, c, d: (c * b - a * d, b * d)),
    ("mul", 1.0, lambda a, b, c, d: (a * c, b * d)),
    ("rmul", 1.0, lambda a, b, c, d: (a * c, b * d)),
    ("truediv", 1.0, lambda a, b, c, d: (a * d, b * c)),
    ("rtruediv", None, lambda a, b, c, d: (c * b, a * d)),
):
    setattr(Exact, f"__{_name}__", _operation(f"__{_name}__", _idle, _parts))
Exact.__neg__ = lambda self: Exact(-self.numerator, self.denominator)  # type: ignore[method-assign]
Exact.__abs__ = lambda self: Exact(abs(self.numerator), self.denominator)  # type: ignore[method-assign]


def _bounded(above: int, below: int) -> Any:
    """above/below, rounded where it is too long."""
    made = Exact(above) if below == 1 else Exact(above, below)  # which are faster than Exact(above/below)
    if made.denominator.bit_length() + made.numerator.bit_length() > _MOST_BITS:
        return _rounded(_real(made))
    return made


def _real(value: Any) -> Any:
    """A number of any kind in mpmath's terms."""
    if isinstance(value, Fraction):
        return _CONTEXT.mpf(value.numerator) / value.denominator
    return _CONTEXT.mpf(value)


def _rounded(value: Any) -> Any:
    """What mpmath has computed: nan where it is not real, inf where no double is as large."""
    if not isinstance(value, _CONTEXT.mpf):
        return math.nan
    if not _CONTEXT.isfinite(value) or abs(value) > LARGEST:
        return float(value)
    sign, mantissa, exponent, _ = value._mpf_
    scaled = Fraction(int(mantissa)) * Fraction(2) ** exponent
    return Exact(-scaled if sign else scaled)


class ExactGraph(Graph):
    """A graph whose numbers are exact, or nearly so."""

    rounding = 10.0 ** (5 - DIGITS)

    def check_numbers(self) -> None:
        for node in self.nodes:
            numbers = (node.data[0], *node.data[1]) if node.kind is Kind.SUM else ()
            if any(isinstance(one, Fraction) and abs(one) > LARGEST for one in numbers):
                raise BeyondDoubles

    @staticmethod
    def number(value: Any) -> Any:  # type: ignore[override]
        if type(value) is Exact:
            return value
        return Exact(value) if isinstance(value, Fraction) or math.isfinite(value) else value

    @staticmethod
    def divides(first: Any, constant: Any, others: Sequence[Any]) -> bool:
        """So a linear function (x - a)/w has the same zero to the last bit in all its powers, which it would
        not if x/w - a/w and x/w**2 - a/w**2 were rounded. (Other sums are not made longer.)"""
        if others or not (isinstance(first, Fraction) and isinstance(constant, Fraction)):
            return False
        return bool(abs(first) < LARGEST_RATIO and abs(constant) < LARGEST_RATIO * abs(first))

    @staticmethod
    def tidy(exponent: Any) -> Any:
        return int(exponent) if math.isfinite(exponent) and exponent == int(exponent) else exponent

    @staticmethod
    def power_of(base: Any, exponent: Any) -> Any:
        if base == 0 and exponent < 0:
            return math.inf
        if isinstance(base, Fraction) and exponent == int(exponent) and abs(exponent) < 100:
            return _bounded(*(Fraction(base) ** int(exponent)).as_integer_ratio())
        return _rounded(_real(base) ** _real(exponent))

    @staticmethod
    def function_of(name: str, arguments: Sequence[Any]) -> Any:
        if name == "log" and arguments[0] == 0:
            return -math.inf
        return _rounded(getattr(_CONTEXT, name)(*map(_real, arguments)))


class PortableGraph(Graph):
    """A graph of doubles whose functions of numbers are not the C library's but rounded correctly."""

    @staticmethod
    def power_of(base: float, exponent: float) -> float:
        return float(ExactGraph.power_of(base, exponent))

    @staticmethod
    def function_of(name: str, arguments: Sequence[float]) -> float:
        return float(ExactGraph.function_of(name, arguments))


class PortableGraphAlgebra(GraphAlgebra):
    """``Algebra[Node]`` over such a graph."""

    def __init__(self) -> None:
        self.graph = PortableGraph()


class ExactGraphAlgebra(GraphAlgebra):
    """``Algebra[Node]`` over such a graph."""

    def __init__(self) -> None:
        self.graph = ExactGraph()

    def number(self, text: str) -> Node:
        return self.graph.constant(_exact(text))

    def pi(self) -> Node:
        return self.graph.constant(_rounded(+_CONTEXT.pi))


class LongNumberAlgebra(NumberAlgebra):
    """Parameters and initial values with ``DIGITS`` digits (numbers of mpmath)."""

    def number(self, text: str) -> Any:
        return _real(_exact(text))

    def pi(self) -> Any:
        return +_CONTEXT.pi

    def function(self, name: str, arguments: Sequence[Any]) -> Any:
        """Raises ArithmeticError outside the function's domain, OverflowError beyond the largest double."""
        if name == "log" and arguments[0] == 0:
            raise ArithmeticError("log(0) is not a real number")
        if name in NON_SMOOTH:
            return super().function(name, arguments)
        if any(abs(argument) > LARGEST for argument in arguments):  # more digits than can be computed
            raise OverflowError
        value = getattr(_CONTEXT, name)(*map(_CONTEXT.mpf, arguments))
        if not isinstance(value, _CONTEXT.mpf):
            shown = ", ".join(decimal(float(argument)) for argument in arguments)
            raise ArithmeticError(f"{name}({shown}) is not a real number")
        return value

    def finite(self, tree: Tree, value: Any, *, fades: bool = False) -> Any:
        if isinstance(value, _CONTEXT.mpc):  # a power of a negative number
            value = math.nan
        rounded = super().finite(tree, value)
        if rounded == 0 and value != 0:
            if fades:
                return _CONTEXT.mpf(0)
            raise ExpressionError(tree.span, TOO_SMALL, SMALLEST)
        return value if isinstance(value, _CONTEXT.mpf) else _CONTEXT.mpf(rounded)


def less(value: Any, rounded: float) -> float:
    """By how much a number of ``LongNumberAlgebra`` exceeds another one."""
    return float(_CONTEXT.mpf(value) - rounded)


def in_two_parts(value: Any) -> tuple[float, float]:
    """The double nearest to a number of ``LongNumberAlgebra``, and the one nearest to what is left."""
    high = float(value)
    return high, float(_CONTEXT.mpf(value) - high)
