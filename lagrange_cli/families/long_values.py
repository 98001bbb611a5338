"""Numbers of families with many digits, those of mpmath."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from fractions import Fraction
from typing import Any

import numpy as np

from lagrange_cli.expression.exact import context
from lagrange_cli.families.values import FUNCTIONS, Doubles

FULL: Any = object
"""The type of arrays of such numbers."""


def number(value: Any) -> Any:
    """A number of any kind with many digits."""
    if isinstance(value, Fraction):
        return context().mpf(value.numerator) / value.denominator
    return context().mpf(value)


def function(name: str) -> Any:
    """A function of the numbers of arrays, one by one, not a number where that is not real."""
    plain, real = getattr(context(), name), context().mpf

    def found(*x: Any) -> Any:
        value = plain(*x)
        return value if isinstance(value, real) else context().nan

    return np.frompyfunc(found, FUNCTIONS[name].nin, 1)


class LongNumbers(Doubles):
    """``Doubles`` with many digits."""

    functions: Mapping[str, Callable[..., Any]] = {name: function(name) for name in FUNCTIONS}
    exact = context()

    def number(self, value: Any) -> Any:
        return number(value)

    def array(self, values: Any) -> Any:
        listed = np.asarray(values, dtype=FULL)
        return np.frompyfunc(number, 1, 1)(listed) if listed.size else listed

    def zeros(self, *shape: int) -> Any:
        return np.full(shape, number(0), dtype=FULL)

    def add(self, made: Any, targets: Any, values: Any) -> None:
        np.add.at(made, targets, values)
