"""``Quantity``: what is known of the unit of an expression, and arithmetic over it.

Only certain units are used: a parameter without a unit has an unknown one, and so has a number such as 9.81,
which may stand for a quantity. Only numbers that are plain factors in formulas, 2 or 0.5, are
pure.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import Any

from lagrange_cli.model.unit import ONE, RADIAN, Unit
from lagrange_cli.model.units import is_pure, same, without_angle
from lagrange_cli.records import dataclass, replace

FACTORS = 10
"""Numbers below this that are multiples of 1/8 are plain factors; 9.81, 180 or 1000 may be quantities or turn
one unit into another."""


class Contradiction(ArithmeticError):
    """Raised where an operation makes no sense with these units; its text says why. ``units`` are the two
    that should be the same, ``hint`` is a way out."""

    def __init__(self, text: str, found: Unit, expected: Unit, hint: str = "") -> None:
        super().__init__(text)
        self.units = found, expected
        self.hint = hint


@dataclass(frozen=True)
class Quantity:
    """What is known of an expression's unit.

    ``unit`` is None where it is not known. ``number`` is the value of an expression that is made of numbers
    alone (nan where it varies); its unit is that of a factor, and in a sum it may stand for anything.
    A sum of such a number and a quantity is ``loose``: as a term it has a unit, as a factor it may not have.
    ``broken`` is what contains a contradiction.
    """

    unit: Unit | None = None
    number: float | None = None
    loose: bool = False
    broken: bool = False

    def __add__(self, other: Quantity) -> Quantity:
        return total((self, other))

    __sub__ = __add__

    def __neg__(self) -> Quantity:
        return self if self.number is None else replace(self, number=-self.number)

    def __mul__(self, other: Quantity) -> Quantity:
        return product(self, other, lambda x, y: x * y, Unit.__mul__)

    def __truediv__(self, other: Quantity) -> Quantity:
        return product(self, other, lambda x, y: x / y, Unit.__truediv__)

    def __pow__(self, other: Quantity) -> Quantity:
        if self.broken or other.broken:
            return BROKEN
        if self.number is not None and other.number is not None:
            return Quantity(self.unit, computed(lambda x, y: x**y, self.number, other.number))
        if other.number is None and other.unit is not None and not is_pure(other.unit):
            raise Contradiction(f"an exponent is in {other.unit}", other.unit, ONE)
        unit = self.factor
        if unit is None or is_pure(unit):
            return UNKNOWN if unit is None else PURE
        if other.number is None or not math.isfinite(other.number):
            return UNKNOWN
        return Quantity(unit.power(other.number))

    @property
    def factor(self) -> Unit | None:
        """The unit that it brings into a product."""
        return None if self.unit is None or self.loose else without_angle(self.unit)


UNKNOWN = Quantity()
BROKEN = Quantity(broken=True)
PURE = Quantity(ONE)
COUNT = Quantity(ONE, math.nan)
"""A size, or an index."""


def computed(operation: Callable[..., Any], *numbers: float) -> float:
    """The value of an operation; nan where it has none."""
    try:
        value = operation(*numbers)
    except (ArithmeticError, ValueError):
        return math.nan
    return value if isinstance(value, float) else math.nan


def product(
    one: Quantity,
    other: Quantity,
    operation: Callable[[float, float], float],
    combine: Callable[[Unit, Unit], Unit],
) -> Quantity:
    """The product or the quotient of two quantities."""
    if one.broken or other.broken:
        return BROKEN
    number = None
    if one.number is not None and other.number is not None:
        number = computed(operation, one.number, other.number)
    elif one.number == 0 or other.number == 0:
        return one if one.number == 0 else other
    first, second = one.factor, other.factor
    return Quantity(None if first is None or second is None else combine(first, second), number)


def compared(*terms: Quantity) -> Quantity:
    """The common quantity of compared terms; a number in it varies."""
    return varying(total(terms, "compared"))


def alternative(*terms: Quantity) -> Quantity:
    """The common quantity of the branches of ``where``."""
    return varying(total(terms, "branches of one 'where'"))


def varying(quantity: Quantity) -> Quantity:
    """A quantity whose number is not always the same."""
    return quantity if quantity.number is None else replace(quantity, number=math.nan)


def total(terms: Sequence[Quantity], what: str = "added") -> Quantity:
    """The sum of quantities: known units must agree, and what is not known has the same."""
    terms = [term for term in terms if term.number != 0] or terms
    if any(term.broken for term in terms):
        return BROKEN
    known = [term.unit for term in terms if term.number is None and term.unit is not None]
    numbers = [term.number for term in terms if term.number is not None]
    if not known:
        if len(numbers) < len(terms):
            return UNKNOWN
        pure = all(term.unit is not None for term in terms)
        return Quantity(ONE if pure else None, computed(lambda *x: math.fsum(x), *numbers))
    for unit in known:
        if not same(unit, known[0]):
            raise Contradiction(f"{shown(known[0])} and {shown(unit)} are {what}", known[0], unit)
    unit = next((unit for unit in known if "rad" in unit.symbols), known[0])
    loose = any(term.loose for term in terms) or (bool(numbers) and not is_pure(unit))
    return Quantity(unit, None, loose)


class QuantityAlgebra:
    """``Algebra[Quantity]`` except derivatives."""

    def function(self, name: str, arguments: Sequence[Quantity]) -> Quantity:
        """Raises ``Contradiction`` where an argument that must be a number has a unit."""
        if any(argument.broken for argument in arguments):
            return BROKEN
        if name == "abs":
            return arguments[0] if arguments[0].number is None else varying(arguments[0])
        if name in ("min", "max"):
            return compared(*arguments)
        if name == "sign":
            return PURE
        if name == "sqrt":
            return arguments[0] ** Quantity(ONE, 0.5)
        if all(argument.number is not None for argument in arguments):
            pure = all(argument.unit is not None for argument in arguments)
            return Quantity(ONE if pure else None, math.nan)
        if name == "atan2":
            total(arguments)
            return Quantity(RADIAN)
        unit = arguments[0].unit
        if unit is not None and not is_pure(unit) and name != "log":  # log(r) is log(r/r0) up to a constant
            angle = name in ("sin", "cos", "tan") and "deg" in unit.symbols
            hint = f"{name} takes radians: multiply by pi/180" if angle else ""
            raise Contradiction(f"{name} is taken of a quantity in {unit}", unit, ONE, hint=hint)
        return Quantity(RADIAN) if name in ("asin", "acos", "atan") else PURE


def shown(unit: Unit) -> str:
    """A unit as messages call it."""
    return str(unit) if unit.powers else "a plain number"


def number(value: float) -> Quantity:
    """A number of the file: a plain factor, or one that may stand for a quantity."""
    return Quantity(ONE if abs(value) < FACTORS and (8 * value).is_integer() else None, value)


def rate(quantity: Quantity, time: Quantity) -> Quantity:
    """The derivative of a coordinate by t: of an angle in rad it is in rad/s."""
    if quantity.unit is None or time.unit is None:
        return replace(quantity, unit=None)
    return replace(quantity, unit=quantity.unit / time.unit)


def named(quantity: Quantity) -> Quantity:
    """The quantity as one with a name of its own: numbers alone may stand for anything."""
    return quantity if quantity.number is None else UNKNOWN


def joined(quantities: Sequence[Quantity]) -> Quantity:
    """What the members of a family, or the components of a position, have in common: the unit of those that
    have one. Where they differ nothing is known."""
    try:
        return total([named(one) for one in quantities])
    except Contradiction:
        return UNKNOWN
