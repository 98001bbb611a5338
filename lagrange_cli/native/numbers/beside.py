"""The numbers of a companion's program (see ``integrate.certify``), which are rounded differently.

A companion shows the effect of rounding. Where the run has c for an exact value c - d, a companion has c - k
d, with a k so large that this is another double, and so small that the motion responds in proportion. It is
the ``factor`` of the companion for numbers in expressions, and ``CONSTANTS`` for values that are computed
from numbers and parameters before the motion begins.

What is computed from a state alone, such as reactions, has the same rounding errors in all of them where
their states agree. There the result of every operation is changed by a unit in the last place (Monte Carlo
arithmetic: D. S. Parker, UCLA report CSD-970002, 1997), so that small differences of large numbers differ.
"""

from __future__ import annotations

import math
from fractions import Fraction

from lagrange_cli.native.interface import CONSTANTS
from lagrange_cli.native.llvm.function import Function
from lagrange_cli.native.llvm.text import Operand, Value
from lagrange_cli.native.numbers.double import Emitter
from lagrange_cli.native.numbers.double_double import DDReal, DoubleDouble
from lagrange_cli.native.numbers.kind import Number
from lagrange_cli.native.numbers.lanes import LaneEmitter

UNIT = 2.0**-52
"""The part of a result that it is changed by."""
TURNS = math.sqrt(5.0) / 2, math.sqrt(2.0)
"""Multiples of these, which spread evenly, say which results are larger and which are smaller: other ones
in each companion."""
EXACT = "fneg", "@llvm.fabs.", "@llvm.maxnum.", "@llvm.floor."
"""Operations whose results are not rounded."""


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
        return super().number(beside(value, self._factor))


class BesideLanes(BesideEmitter, LaneEmitter):
    """Vectors of doubles, likewise."""


class _Rounded(Emitter):
    """Numbers each of which is a unit in the last place away from what is computed."""

    _factor: int
    _count = 0
    """How many results there are."""

    def _arithmetic(self, text: str, *operands: Value) -> Operand:
        name = super()._arithmetic(text, *operands)
        return name if any(one in text for one in EXACT) else self._moved(name)

    def _moved(self, name: Operand) -> Operand:
        """Another number, at the same depth."""
        self._count += 1
        larger = self._count * TURNS[self._factor > 0] % 1.0 < 0.5
        moved = self.define(f"fmul {self.REAL} {name}, {self.number(1.0 + UNIT if larger else 1.0 - UNIT)}")
        self.set_depth(moved, self.depth(name))
        return moved


class RoundedEmitter(_Rounded, BesideEmitter):
    """Doubles of a companion, where its rounding errors differ, too."""


class RoundedLanes(_Rounded, BesideLanes):
    """Vectors of doubles, likewise."""

    def function(self, name: str, *arguments: Value) -> Operand:
        made = super().function(name, *arguments)
        return self._moved(made) if name in ("sin", "cos") else made


class BesideDoubleDouble(DoubleDouble):
    """Double-double numbers, likewise; ``CONSTANTS`` times their difference is that of ``BesideEmitter``."""

    def __init__(self, body: Function, factor: int) -> None:
        super().__init__(body)
        self._factor = factor // CONSTANTS

    def number(self, value: Number) -> DDReal | None:
        return super().number(beside(value, self._factor))
