"""Double-double numbers in LLVM IR: the unevaluated sum of two doubles, some 106 bits.

Sums and products by transformations without rounding (Dekker, Numer. Math. 18, 1971; Knuth, TAOCP 2, sec.
4.2.2), put together as by Joldes, Muller and Popescu (ACM TOMS 44, 2017), who bound their errors by a
few units of 2^-106. Each operation is a function of its own, called where it is needed.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from fractions import Fraction

from lagrange_cli.native.llvm.function import Function
from lagrange_cli.native.llvm.text import Operand, constant, kind
from lagrange_cli.native.llvm.vector import Bit, Instructions, Real, Value
from lagrange_cli.native.numbers.error_free import fast_sum, two_product, two_sum
from lagrange_cli.native.numbers.kind import Number, Written
from lagrange_cli.records import dataclass

TYPE = "{ double, double }"


def pair_type(lanes: int) -> str:
    """The type of so many numbers side by side."""
    return f"{{ {kind('double', lanes)}, {kind('double', lanes)} }}"


@dataclass(frozen=True)
class DDReal:
    """A double-double number: ``high`` is the double nearest to it, ``low`` what is left (None: nothing)."""

    high: Real
    low: Real | None = None

    @property
    def parts(self) -> tuple[Real, Real]:
        """Both, 0 written out."""
        return self.high, self.high.body.zero(self.high.lanes) if self.low is None else self.low

    def __add__(self, other: DDReal) -> DDReal:
        return apply("add", self, other)

    def __sub__(self, other: DDReal) -> DDReal:
        return self + -other

    def __neg__(self) -> DDReal:
        return DDReal(-self.high, None if self.low is None else -self.low)

    def __mul__(self, other: DDReal) -> DDReal:
        return apply("mul", self, other)

    def __truediv__(self, other: DDReal) -> DDReal:
        return apply("div", self, other)

    def scaled(self, factor: Real | float) -> DDReal:
        """Its product with a double."""
        return apply("scale", self, factor)

    def divided(self, by: Real) -> DDReal:
        """Its quotient by a double."""
        return apply("divide", self, by)


def apply(name: str, first: DDReal | Real, *others: DDReal | Real | float) -> DDReal:
    """``@pair_name`` of numbers and doubles."""
    leader, flat = first.high if isinstance(first, DDReal) else first, list[Real]()
    body = leader.body
    for one in (first, *others):
        flat += one.parts if isinstance(one, DDReal) else [Real(body, body.of(one), leader.lanes)]
    body.operations += 1
    return called(body, f"pair_{name}", *flat)


def called(body: Instructions, name: str, *arguments: Value) -> DDReal:
    """A call of ``@name``, which gives a number, or that of vectors of these where they are given."""
    listed, lanes = ", ".join(f"{one.kind} {one.name}" for one in arguments), arguments[0].lanes
    type = pair_type(lanes)
    made = body.define(f"call {type} @{name}{suffix_of(lanes)}({listed})")
    return DDReal(*(Real(body, body.define(f"extractvalue {type} {made}, {i}"), lanes) for i in (0, 1)))


def suffix_of(lanes: int) -> str:
    """What the names of functions of vectors end with."""
    return "" if lanes == 1 else f".{lanes}"


def pair(body: Instructions, value: Number, lanes: int = 0) -> DDReal:
    """A constant, rounded to a double-double, in every lane: of the body's, if not said."""
    high, low = split(Fraction(value)) if math.isfinite(value) else (float(value), 0.0)
    lanes = lanes or body.lanes
    return DDReal(
        *(Real(body, constant("double", lanes, x), lanes) for x in ((high, low) if low else (high,)))
    )


def choose(condition: Bit, yes: DDReal, no: DDReal) -> DDReal:
    """One of two numbers."""
    return DDReal(*(condition.body.select(condition, a, b) for a, b in zip(yes.parts, no.parts)))


class DoubleDouble(Written[DDReal]):
    """Such numbers as a kind that writes into ``body``."""

    parts, unit, products = 2, 2.0**-106, 64
    true = "true"
    lanes = 1
    """Numbers side by side."""

    def __init__(self, body: Function) -> None:
        self.body, self.one, self._minus_one = body, *(pair(body, x, self.lanes) for x in (1, -1))
        body.cost = self.parts

    def number(self, value: Number) -> DDReal | None:
        return None if value == 0 else pair(self.body, value, self.lanes)

    def written(self, value: DDReal | None) -> DDReal:
        """A number, 0 written out."""
        return pair(self.body, 0, self.lanes) if value is None else value

    def times(self, a: DDReal, b: DDReal) -> DDReal:
        minus_one = self._minus_one.high.name
        for one, other in ((a, b), (b, a)):
            if one.low is None:
                if one.high.name in (self.one.high.name, minus_one):
                    return -other if one.high.name == minus_one else other
                return other.scaled(one.high)
        return a * b

    def function(self, name: str, *arguments: DDReal | None) -> DDReal:
        return apply(name, *map(self.written, arguments))

    def load(self, pointer: str, index: int | str, beyond: int | str = 0) -> DDReal:
        place = self.body.place(pointer, index, "double")
        return DDReal(*(self.body.load_row(place, at, 1) for at in ((0, beyond) if beyond else (0,))))

    def store(self, value: DDReal | None, pointer: str, index: int | str, beyond: int | str = 0) -> None:
        place = self.body.place(pointer, index, "double")
        for at, part in zip((0, beyond), self.written(value).parts):
            self.body.store_row(part, place, at)

    def compare(self, relation: str, a: DDReal | None, b: DDReal | None) -> Operand:
        """Whether the nearest doubles are in a relation."""
        return self.written(a).high.compared(relation, self.written(b).high).name

    def both(self, a: Operand, b: Operand) -> Operand:
        return (Bit(self.body, a, self.lanes) & Bit(self.body, b, self.lanes)).name

    def select(self, condition: Operand, yes: DDReal | None, no: DDReal | None) -> DDReal:
        return choose(Bit(self.body, condition, self.lanes), self.written(yes), self.written(no))


def split(value: Fraction) -> tuple[float, float]:
    """The nearest double, and the one nearest to what is left."""
    try:
        high = float(value)
    except OverflowError:
        return (float("inf") if value > 0 else float("-inf")), 0.0
    return high, float(value - Fraction(high))


def define(name: str, kinds: str, formula: Callable[..., DDReal], lanes: int = 1) -> str:
    """The text of ``@pair_name``; ``kinds``: p for an argument that is a number, d for one double."""
    f = Function(f"define internal {pair_type(lanes)} {head_of(name, kinds, lanes)} #0", lanes)
    f.cost = DoubleDouble.parts
    given = [DDReal(Real(f, f"%a{i}"), Real(f, f"%b{i}")) for i in range(len(kinds))]
    f.give(*formula(*(one.high if kind == "d" else one for one, kind in zip(given, kinds))).parts)
    return f.text()


def head_of(name: str, kinds: str, lanes: int) -> str:
    """The name and the arguments of ``@pair_name``."""
    real = kind("double", lanes)
    heads = ", ".join(f"{real} %a{i}" + (f", {real} %b{i}" if k == "p" else "") for i, k in enumerate(kinds))
    return f"@pair_{name}{suffix_of(lanes)}({heads})"


def _add(a: DDReal, b: DDReal) -> DDReal:
    (high, a_low), (other, b_low) = a.parts, b.parts
    high, error = two_sum(high, other)
    low, rest = two_sum(a_low, b_low)
    high, error = fast_sum(high, error + low)
    return DDReal(*fast_sum(high, error + rest))


def _mul(a: DDReal, b: DDReal) -> DDReal:
    (high, low), (other, lower), fma = a.parts, b.parts, a.high.body.fma
    product, error = two_product(high, other)
    cross = fma(low, other, fma(high, lower, low * lower))
    return DDReal(*fast_sum(product, error + cross))


def _scale(a: DDReal, b: Real) -> DDReal:
    high, low = a.parts
    product, error = two_product(high, b)
    return DDReal(*fast_sum(product, b.body.fma(low, b, error)))


def _div(a: DDReal, b: DDReal) -> DDReal:
    first = a.high / b.high
    rest = a - b.scaled(first)
    second = rest.high / b.high
    rest = rest - b.scaled(second)
    third = rest.high / b.high
    return DDReal(*fast_sum(first, second)) + DDReal(third)


def _rest(a: DDReal, b: Real, c: Real) -> Real:
    """What is left of a beside b c."""
    (high, low), (product, error) = a.parts, two_product(b, c)
    return ((high - product) - error) + low


def _divide(a: DDReal, b: Real) -> DDReal:
    first = a.high / b
    return DDReal(*fast_sum(first, _rest(a, first, b) / b))


def _sqrt(a: DDReal) -> DDReal:
    first = a.high.body.function("sqrt", a.high)
    root = DDReal(*fast_sum(first, _rest(a, first, first) / (first + first)))
    return choose(a.high.equals(0.0), pair(a.high.body, 0), root)


OPERATIONS: Mapping[str, tuple[str, Callable[..., DDReal]]] = {
    "add": ("pp", _add), "mul": ("pp", _mul), "scale": ("pd", _scale),
    "div": ("pp", _div), "divide": ("pd", _divide), "sqrt": ("p", _sqrt),
}  # fmt: skip
"""The functions that ``DDReal`` calls."""


def operations() -> Sequence[str]:
    """Their texts."""
    return [define(name, *one) for name, one in OPERATIONS.items()]
