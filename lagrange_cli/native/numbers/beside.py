"""The numbers of a companion's program (see ``integrate.certify``), which are rounded differently.

A companion shows the effect of rounding. Where the run has c for an exact value c - d, a companion has c - k
d, with a k so large that this is another double, and so small that the motion responds in proportion. It is
the ``factor`` of the companion for numbers in expressions, and ``CONSTANTS`` for values that are computed
from numbers and parameters before the motion begins.
"""

from __future__ import annotations

from fractions import Fraction

from lagrange_cli.native.interface import CONSTANTS
from lagrange_cli.native.llvm.function import Function
from lagrange_cli.native.llvm.text import Value, literal
from lagrange_cli.native.numbers.double import Emitter
from lagrange_cli.native.numbers.double_double import DDReal, DoubleDouble
from lagrange_cli.native.numbers.kind import Number
from lagrange_cli.native.numbers.lanes import LaneEmitter


def beside(value: Number, factor: int) -> Number:
    """A number rounded to a double, less a rounding error that is larger by a factor."""
    if not isinstance(value, Fraction):
        return value
    rounded = Fraction(float(value))
    return rounded + factor * (value - rounded)


class BesideEmitter(Emitter):
    """Doubles, with numbers in expressions that are beside those of the run; for functions that have none of
    these, no ``factor`` is needed."""

    def __init__(self, body: Function, factor: int = 0) -> None:
        super().__init__(body)
        self._factor = factor

    def number(self, value: Number) -> Value:
        return literal(beside(value, self._factor))


class BesideLanes(LaneEmitter):
    """Vectors of doubles, likewise."""

    def __init__(self, body: Function, factor: int) -> None:
        super().__init__(body)
        self._factor = factor

    def number(self, value: Number) -> Value:
        return super().number(beside(value, self._factor))


class BesideDoubleDouble(DoubleDouble):
    """Double-double numbers, likewise; ``CONSTANTS`` times their difference is that of ``BesideEmitter``."""

    def __init__(self, body: Function, factor: int) -> None:
        super().__init__(body)
        self._factor = factor // CONSTANTS

    def number(self, value: Number) -> DDReal | None:
        return super().number(beside(value, self._factor))
