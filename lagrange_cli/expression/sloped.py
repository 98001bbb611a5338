"""The algebra of numbers with slopes: the value of an expression at a state, and its partial derivatives.

Numbers are doubles, or those of mpmath. A slope by each coordinate, each velocity and t that a value depends
on is carried along (forward differentiation; Griewank and Walther, Evaluating Derivatives, 2nd ed., ch. 3),
and second derivatives by two velocities: all that constraints and masses are about. What does not occur
takes no work, so long chains take linear time.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any

from lagrange_cli.decimals import decimal
from lagrange_cli.expression.algebra import Decided
from lagrange_cli.expression.derivatives import FUNCTIONS, powers
from lagrange_cli.expression.vocabulary import TIME, velocity_name
from lagrange_cli.limits import Work

Slopes = Mapping[int, Any]
"""By slot: 0 is t, k + 1 the k-th coordinate, and -(k + 1) its velocity."""
Curves = Mapping[tuple[int, int], Any]
"""Second derivatives by two velocities, the smaller slot first."""
NONE: dict[Any, Any] = {}


class Sloped:
    """A ``value`` with its ``slopes`` and ``curves``, as far as they are not 0 by structure."""

    __slots__ = ("curves", "slopes", "value", "work")

    def __init__(self, value: Any, work: Work, slopes: Slopes = NONE, curves: Curves = NONE) -> None:
        self.value, self.work, self.slopes, self.curves = value, work, slopes, curves
        if slopes:
            work.charge(len(slopes) + len(curves), "the slopes of the constraints")

    def __neg__(self) -> Sloped:
        return self._scaled(-self.value, -1.0)

    def __add__(self, other: Sloped) -> Sloped:
        return total((self, other))

    def __sub__(self, other: Sloped) -> Sloped:
        return total((self, -other))

    def __mul__(self, other: Sloped) -> Sloped:
        a, b = self.value, other.value
        if not other.slopes:
            return self._scaled(a * b, b)
        if not self.slopes:
            return other._scaled(a * b, a)
        slopes = merged(((self.slopes, b), (other.slopes, a)))
        curves = crossed(self.slopes, other.slopes)
        if self.curves or other.curves or curves:
            curves = merged(((self.curves, b), (other.curves, a), (curves, 1.0)))
        return Sloped(a * b, self.work, slopes, curves)

    def __truediv__(self, other: Sloped) -> Sloped:
        if not other.slopes:
            return self._scaled(self.value / other.value, 1.0 / other.value)
        return self * composed(powers(other.value, -1.0), other)

    def __pow__(self, other: Sloped) -> Sloped:
        if not other.slopes:
            if not self.slopes:
                return Sloped(plain_power(self.value, other.value), self.work)
            return composed(tried(powers, self.value, other.value), self)
        if self.value <= 0:
            raise ArithmeticError("this power has no derivative by its exponent")
        m = self.value.context if hasattr(self.value, "context") else math
        exponent = other * composed(tried(FUNCTIONS["log"], m, self.value), self)
        return composed(FUNCTIONS["exp"](m, exponent.value), exponent)

    def _scaled(self, value: Any, factor: Any) -> Sloped:
        """This ``value``, with all slopes times a factor."""
        return Sloped(
            value,
            self.work,
            {slot: factor * slope for slot, slope in self.slopes.items()},
            {slots: factor * curve for slots, curve in self.curves.items()} if self.curves else NONE,
        )


def plain_power(base: Any, exponent: Any) -> Any:
    """A power of numbers alone; raises ``ArithmeticError`` where it is not real."""
    if base < 0 and exponent % 1:
        raise ArithmeticError("this power is not a real number")
    return base**exponent


def tried(function: Any, *arguments: Any) -> Sequence[Any]:
    """A function's value and derivatives; these are nan where only the value exists."""
    try:
        return function(*arguments)  # type: ignore[no-any-return]
    except (ArithmeticError, ValueError):
        x, n = arguments
        if function is powers and x == 0 and n > 0:
            return [0.0 * x, math.nan, math.nan, math.nan]
        raise


def merged(parts: Sequence[tuple[Mapping[Any, Any], Any]]) -> dict[Any, Any]:
    """The sum of mappings, each times a factor."""
    found: dict[Any, Any] = {}
    for slopes, factor in parts:
        for slot, slope in slopes.items():
            term = factor * slope
            found[slot] = found[slot] + term if slot in found else term
    return found


def crossed(a: Slopes, b: Slopes) -> dict[tuple[int, int], Any]:
    """a_i b_j + a_j b_i for any two velocities."""
    left, right = ([(i, x) for i, x in slopes.items() if i < 0] for slopes in (a, b))
    found: dict[tuple[int, int], Any] = {}
    for i, x in left:
        for j, y in right:
            slots, term = (i, j) if i < j else (j, i), (x * y if i != j else 2.0 * x * y)
            found[slots] = found[slots] + term if slots in found else term
    return found


def total(terms: Sequence[Sloped]) -> Sloped:
    """The sum of one or more."""
    value = terms[0].value
    for term in terms[1:]:
        value = value + term.value
    curved = any(term.curves for term in terms)
    return Sloped(
        value,
        terms[0].work,
        merged([(term.slopes, 1.0) for term in terms]),
        merged([(term.curves, 1.0) for term in terms]) if curved else NONE,
    )


def composed(derivatives: Sequence[Any], x: Sloped) -> Sloped:
    """f(x), from f and its derivatives there."""
    f, first, second = derivatives[:3]
    made = x._scaled(f, first)
    curves = crossed(x.slopes, x.slopes)
    if not curves:
        return made
    return Sloped(f, x.work, made.slopes, merged(((made.curves, 1.0), (curves, second / 2))))


class SlopedAlgebra(Decided):
    """``Algebra[Sloped]`` at a state.

    ``parameters`` are numbers of one kind; ``q`` and ``v`` are by coordinate. ``m`` has the functions of such
    numbers, and ``read`` makes one of a literal. ``work`` counts what has been done.
    """

    def __init__(
        self,
        parameters: Mapping[str, Any],
        names: Sequence[str],
        state: tuple[Any, Sequence[Any], Sequence[Any]],
        work: Work,
        m: Any = math,
        read: Any = float,
    ) -> None:
        t, q, v = state
        self.m, self.read, self.work = m, read, work
        one = read("1")
        self.known = {name: Sloped(x, work) for name, x in parameters.items()}
        self.slots = {0: Sloped(t, work, {0: one})}
        self.known[TIME] = self.slots[0]
        for k, name in enumerate(names):
            for slot, called, x in ((k + 1, name, q[k]), (-k - 1, velocity_name(name), v[k])):
                self.slots[slot] = self.known[called] = Sloped(x, work, {slot: one})

    def number(self, text: str) -> Sloped:
        return Sloped(self.read(text), self.work)

    def pi(self) -> Sloped:
        return Sloped(+self.m.pi, self.work)

    def symbol(self, name: str) -> Sloped:
        """One that has no value, such as a multiplier, is nothing."""
        return self.known.get(name) or Sloped(math.nan, self.work)

    def function(self, name: str, arguments: Sequence[Sloped]) -> Sloped:
        x = arguments[0]
        if name == "atan2":
            return self._angle(*arguments)
        if name in ("min", "max"):
            return (min if name == "min" else max)(arguments, key=lambda one: one.value)
        if name in ("abs", "sign"):
            side = self.side(x, 0) or 0
            return x._scaled(abs(x.value), float(side)) if name == "abs" else Sloped(float(side), self.work)
        if name == "sqrt":
            return composed(tried(powers, x.value, 0.5), x)
        if (name == "log" and x.value <= 0) or (name in ("asin", "acos") and abs(x.value) > 1):
            raise ArithmeticError(f"{name}({decimal(float(x.value))}) is not a real number")
        try:
            return composed(FUNCTIONS[name](self.m, x.value), x)
        except ValueError as error:
            raise ArithmeticError(f"{name}({decimal(float(x.value))}) is not a real number") from error

    def _angle(self, y: Sloped, x: Sloped) -> Sloped:
        square = x.value * x.value + y.value * y.value
        slopes = merged(((y.slopes, x.value / square), (x.slopes, -y.value / square)))
        return Sloped(self.m.atan2(y.value, x.value), self.work, slopes)

    def side(self, u: Sloped, at: int) -> int | None:
        return super().side(u.value, at)

    def total(self, terms: Sequence[Sloped]) -> Sloped:
        return total(terms)

    def symbols(self, expression: Sloped) -> list[Sloped]:
        return [self.slots[slot] for slot in expression.slopes]

    def diff(self, expression: Sloped, symbol: Sloped) -> Sloped:
        """The slope as a number, whose own slopes are not known."""
        (slot,) = symbol.slopes
        return Sloped(expression.slopes[slot], self.work)
