"""Double-double numbers in LLVM IR: the unevaluated sum of two doubles, some 106 bits.

Sums and products by transformations without rounding (Dekker, Numer. Math. 18, 1971; Knuth, TAOCP 2, sec.
4.2.2), put together as by Joldes, Muller and Popescu (ACM TOMS 44, 2017), who bound their errors by a
few units of 2^-106. Each operation is a function of its own, called where it is needed.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from fractions import Fraction

from lagrange_cli.native.llvm.text import ONE, Operand, Value, literal
from lagrange_cli.native.numbers.double import Emitter
from lagrange_cli.native.numbers.error_free import fast_sum, two_product, two_sum
from lagrange_cli.native.numbers.kind import Composed, Number
from lagrange_cli.records import dataclass

TYPE = "{ double, double }"
MINUS_ONE = "0xBFF0000000000000"


@dataclass(frozen=True)
class Pair:
    """A number: ``high`` is the double nearest to it, ``low`` what is left. Has operators, for formulas."""

    body: DoubleDoubleBody
    high: Value
    low: Value

    def __add__(self, other: Pair) -> Pair:
        return self.body.apply("add", self, other)

    def __sub__(self, other: Pair) -> Pair:
        return self + -other

    def __neg__(self) -> Pair:
        return Pair(self.body, self.body.neg(self.high), self.body.neg(self.low))

    def __mul__(self, other: Pair) -> Pair:
        return self.body.apply("mul", self, other)

    def __truediv__(self, other: Pair) -> Pair:
        return self.body.apply("div", self, other)

    def scaled(self, factor: Value) -> Pair:
        """Its product with a double."""
        return self.body.apply("scale", self, factor)

    def divided(self, by: Value) -> Pair:
        """Its quotient by a double."""
        return self.body.apply("divide", self, by)


class DoubleDoubleBody(Emitter):
    """The body of one function over such numbers and doubles; its own arithmetic is that of doubles."""

    COST = 2

    def pair(self, value: Number) -> Pair:
        """A constant, rounded to a double-double."""
        high, low = split(Fraction(value)) if math.isfinite(value) else (float(value), 0.0)
        return Pair(self, literal(high), literal(low))

    def apply(self, name: str, *arguments: Pair | Value) -> Pair:
        """``@pair_name`` of numbers and doubles."""
        flat = [x for one in arguments for x in ((one.high, one.low) if isinstance(one, Pair) else (one,))]
        self.operations += self.repeated
        listed = ", ".join([f"double {self.written(x)}" for x in flat])
        return self.unpacked(self.define(f"call {TYPE} @pair_{name}({listed})"))

    def unpacked(self, made: Operand) -> Pair:
        """The number that a function has returned."""
        return Pair(self, *(self.define(f"extractvalue {TYPE} {made}, {i}") for i in (0, 1)))

    def integer(self, operation: str, a: int | str, b: int | str) -> str:
        """An operation on two integers."""
        return self.define(f"{operation} i64 {a}, {b}")

    def compare(self, relation: str, a: Value, b: Value | float) -> Operand:
        return super().compare(relation, a, b if b is None or isinstance(b, str) else literal(b))

    def choose(self, condition: str, yes: Pair, no: Pair) -> Pair:
        """One of two numbers."""
        high, low = (self.select(condition, a, b) for a, b in ((yes.high, no.high), (yes.low, no.low)))
        return Pair(self, high, low)

    def returned(self, value: Pair) -> None:
        """Return a number."""
        half = self.define(f"insertvalue {TYPE} poison, double {self.written(value.high)}, 0")
        whole = self.define(f"insertvalue {TYPE} {half}, double {self.written(value.low)}, 1")
        self.line(f"  ret {TYPE} {whole}")


class DoubleDouble(Composed[Pair]):
    """Such numbers as a ``NumberKind``, written into ``body``."""

    parts, unit, products = 2, 2.0**-106, 64
    true = "true"

    def __init__(self) -> None:
        self.body = DoubleDoubleBody()
        self.one = self.body.pair(1)

    def number(self, value: Number) -> Pair | None:
        return None if value == 0 else self.body.pair(value)

    def times(self, a: Pair, b: Pair) -> Pair:
        for one, other in ((a, b), (b, a)):
            if one.low is None:
                if one.high in (ONE, MINUS_ONE):
                    return other if one.high == ONE else -other
                return other.scaled(one.high)
        return a * b

    def function(self, name: str, *arguments: Pair | None) -> Pair:
        return self.body.apply(name, *(self.body.pair(0) if a is None else a for a in arguments))

    def load(self, pointer: str, index: int | str, beyond: int | str = 0) -> Pair:
        body, place = self.body, self.body.place(pointer, index)
        return Pair(body, body.load(place, 0), body.load(place, beyond) if beyond else None)

    def store(self, value: Pair | None, pointer: str, index: int | str, beyond: int | str = 0) -> None:
        place = self.body.place(pointer, index)
        for offset, part in zip((0, beyond), (value.high, value.low) if value else (None, None)):
            self.body.store(part, place, offset)

    def compare(self, relation: str, a: Pair | None, b: Pair | None) -> Operand:
        """Whether the nearest doubles are in a relation."""
        return self.body.compare(relation, *(None if x is None else x.high for x in (a, b)))

    def both(self, a: Operand, b: Operand) -> Operand:
        return self.body.both(a, b)

    def select(self, condition: Operand, yes: Pair | None, no: Pair | None) -> Pair:
        zero = self.body.pair(0)
        return self.body.choose(condition, yes or zero, no or zero)


def split(value: Fraction) -> tuple[float, float]:
    """The nearest double, and the one nearest to what is left."""
    try:
        high = float(value)
    except OverflowError:
        return (float("inf") if value > 0 else float("-inf")), 0.0
    return high, float(value - Fraction(high))


def function(head: str, body: DoubleDoubleBody) -> str:
    """A function's text."""
    lines = "\n".join(body.lines)
    return f"define internal {head} #0 {{\nentry:\n{lines}\n}}\n"


def define(name: str, kinds: str, formula: Callable[..., Pair | tuple[Value, Value]]) -> str:
    """The text of ``@pair_name``; ``kinds``: p for an argument that is a number, d for one double."""
    body = DoubleDoubleBody()
    given: list[Pair | Operand] = [
        f"%a{i}" if kind == "d" else Pair(body, f"%a{i}", f"%b{i}") for i, kind in enumerate(kinds)
    ]
    made = formula(body, *given)
    body.returned(made if isinstance(made, Pair) else Pair(body, *made))
    heads = ", ".join(f"double %a{i}" + (f", double %b{i}" if k == "p" else "") for i, k in enumerate(kinds))
    return function(f"{TYPE} @pair_{name}({heads})", body)


def _add(e: DoubleDoubleBody, a: Pair, b: Pair) -> tuple[Value, Value]:
    high, error = two_sum(e, a.high, b.high)
    low, rest = two_sum(e, a.low, b.low)
    high, error = fast_sum(e, high, e.add(error, low))
    return fast_sum(e, high, e.add(error, rest))


def _mul(e: DoubleDoubleBody, a: Pair, b: Pair) -> tuple[Value, Value]:
    product, error = two_product(e, a.high, b.high)
    cross = e.exact_fma(a.low, b.high, e.exact_fma(a.high, b.low, e.mul(a.low, b.low)))
    return fast_sum(e, product, e.add(error, cross))


def _scale(e: DoubleDoubleBody, a: Pair, b: Operand) -> tuple[Value, Value]:
    product, error = two_product(e, a.high, b)
    return fast_sum(e, product, e.exact_fma(a.low, b, error))


def _div(e: DoubleDoubleBody, a: Pair, b: Pair) -> Pair:
    first = e.div(a.high, b.high)
    rest = a - b.scaled(first)
    second = e.div(rest.high, b.high)
    rest = rest - b.scaled(second)
    third = e.div(rest.high, b.high)
    return Pair(e, *fast_sum(e, first, second)) + Pair(e, third, None)


def _divide(e: DoubleDoubleBody, a: Pair, b: Operand) -> tuple[Value, Value]:
    first = e.div(a.high, b)
    product, error = two_product(e, first, b)
    rest = e.add(e.sub(e.sub(a.high, product), error), a.low)
    return fast_sum(e, first, e.div(rest, b))


def _sqrt(e: DoubleDoubleBody, a: Pair) -> Pair:
    first = e.intrinsic("sqrt", a.high)
    square, error = two_product(e, first, first)
    rest = e.add(e.sub(e.sub(a.high, square), error), a.low)
    root = Pair(e, *fast_sum(e, first, e.div(rest, e.add(first, first))))
    return e.choose(e.compare("oeq", a.high, None), e.pair(0), root)


def operations() -> Sequence[str]:
    """The functions that ``Pair`` calls."""
    return (
        define("add", "pp", _add),
        define("mul", "pp", _mul),
        define("scale", "pd", _scale),
        define("div", "pp", _div),
        define("divide", "pd", _divide),
        define("sqrt", "p", _sqrt),
    )
