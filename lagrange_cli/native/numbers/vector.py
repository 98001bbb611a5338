"""Floating-point formulas as LLVM IR, written as formulas in Python: for one double or for a vector.

Each operation is a plain one or an explicit fma, so that its result is defined to the last bit, whatever the
processor and however many lanes.
"""

from __future__ import annotations

from collections.abc import Sequence

from lagrange_cli.native.numbers.double import literal, operand
from lagrange_cli.records import dataclass


class Body:
    """The instructions of one function of ``lanes`` doubles, and the declarations that they need."""

    def __init__(self, lanes: int) -> None:
        self.lanes = lanes
        self.real = kind("double", lanes)
        self.integer = kind("i64", lanes)
        self.bit = kind("i1", lanes)
        self.lines: list[str] = []
        self.declared: dict[str, str] = {}

    def define(self, text: str) -> str:
        """A new value."""
        name = f"%v{len(self.lines)}"
        self.lines.append(f"  {name} = {text}")
        return name

    def splat(self, type: str, one: object) -> str:
        """A constant in every lane."""
        return str(one) if self.lanes == 1 else f"<{', '.join([f'{type} {one}'] * self.lanes)}>"

    def of(self, value: Real | float) -> str:
        """The operand's text."""
        return value.name if isinstance(value, Real) else self.splat("double", operand(literal(value)))

    def constant(self, value: float) -> Real:
        """A constant as an operand."""
        return Real(self, self.of(value))

    def function(self, name: str, *arguments: Real | float) -> Real:
        """One of LLVM's functions of doubles."""
        return self._call(f"llvm.{name}.{suffix(self.lanes)}", "", arguments)

    def library(self, name: str, *arguments: Real) -> Real:
        """One of the C library's functions of one double or two."""
        return self._call(name, " memory(none)", arguments)

    def _call(self, name: str, attributes: str, arguments: Sequence[Real | float]) -> Real:
        kinds = ", ".join([self.real] * len(arguments))
        self.declared[name] = f"declare {self.real} @{name}({kinds}){attributes}\n"
        listed = ", ".join(f"{self.real} {self.of(x)}" for x in arguments)
        return Real(self, self.define(f"call {self.real} @{name}({listed})"))

    def fma(self, a: Real, b: Real | float, c: Real | float) -> Real:
        """``a * b + c`` with one rounding."""
        return self.function("fma", a, b, c)

    def all(self, condition: str) -> str:
        """Whether it holds in all lanes."""
        if self.lanes == 1:
            return condition
        name = f"llvm.vector.reduce.and.v{self.lanes}i1"
        self.declared[name] = f"declare i1 @{name}({self.bit})\n"
        return self.define(f"call i1 @{name}({self.bit} {condition})")

    def below(self, a: Real, b: float) -> str:
        """Whether ``a < b``; no for not-a-number."""
        return self.define(f"fcmp olt {self.real} {a.name}, {self.of(b)}")

    def bits(self, value: Real) -> str:
        """The same bits as an integer."""
        return self.define(f"bitcast {self.real} {value.name} to {self.integer}")

    def integers(self, operation: str, a: str, b: int) -> str:
        """An integer operation with a constant."""
        return self.define(f"{operation} {self.integer} {a}, {self.splat('i64', b)}")

    def number(self, bits: str) -> Real:
        """The number with these bits."""
        return Real(self, self.define(f"bitcast {self.integer} {bits} to {self.real}"))

    def select(self, condition: str, yes: Real, no: Real) -> Real:
        """One or the other, lane by lane."""
        text = f"select {self.bit} {condition}, {self.real} {yes.name}, {self.real} {no.name}"
        return Real(self, self.define(text))

    def polynomial(self, coefficients: Sequence[float], x: Real) -> Real:
        """sum_j coefficients[j] x^j, by pairs, pairs of pairs, .. (G. Estrin 1960): little has to wait."""
        terms: list[Real | float] = list(coefficients)
        while True:
            pairs: list[Real | float] = [self.fma(x, b, a) for a, b in zip(terms[::2], terms[1::2])]
            terms = pairs + terms[2 * len(pairs) :]
            if len(terms) == 1:
                assert isinstance(terms[0], Real)
                return terms[0]
            x = x * x


@dataclass(frozen=True)
class Real:
    """An operand of floating-point operations."""

    body: Body
    name: str

    def _operation(self, name: str, other: Real | float) -> Real:
        body = self.body
        return Real(body, body.define(f"{name} {body.real} {self.name}, {body.of(other)}"))

    def __add__(self, other: Real | float) -> Real:
        return self._operation("fadd", other)

    def __sub__(self, other: Real | float) -> Real:
        return self._operation("fsub", other)

    def __mul__(self, other: Real | float) -> Real:
        return self._operation("fmul", other)

    def __truediv__(self, other: Real | float) -> Real:
        return self._operation("fdiv", other)

    def __neg__(self) -> Real:
        return Real(self.body, self.body.define(f"fneg {self.body.real} {self.name}"))


def kind(type: str, lanes: int) -> str:
    """The type of ``lanes`` of these."""
    return type if lanes == 1 else f"<{lanes} x {type}>"


def suffix(lanes: int) -> str:
    """What LLVM's names for functions of them end in."""
    return "f64" if lanes == 1 else f"v{lanes}f64"


def fast_sum(a: Real, b: Real) -> tuple[Real, Real]:
    """a + b and its rounding error, for |a| >= |b| (T. J. Dekker, Numer. Math. 18, 1971)."""
    total = a + b
    return total, b - (total - a)
