"""Formulas as LLVM IR, written as formulas in Python: over doubles, integers, conditions and vectors.

Each operation is a plain one or an explicit fma, so that its result is defined to the last bit, whatever the
processor and however many lanes. A body has a number of lanes of its own; values may have others.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import ClassVar, TypeAlias, TypeVar

from lagrange_cli.native.llvm.length import allow
from lagrange_cli.native.llvm.text import constant, kind, literal, operand, opposite, suffix

V = TypeVar("V", bound="Value")
Index: TypeAlias = "Integer | int"
"""A whole number that the code computes, or that is known when it is written."""


class Instructions:
    """The instructions of one function of ``lanes`` doubles."""

    cost = 1
    """The relative time that its instructions take to compile."""
    operations = 0
    """The floating-point operations that kinds of numbers have counted, each as often as it is executed."""

    def __init__(self, lanes: int) -> None:
        self.lanes = lanes
        self.real = kind("double", lanes)
        self.lines: list[str] = []
        self._count = 0

    def define(self, text: str) -> str:
        """A new value. Raises ``TooLarge`` where a function has more of them than can be compiled."""
        allow(self._count, self.cost)
        name = f"%v{self._count}"
        self._count += 1
        self.line(f"  {name} = {text}")
        return name

    def line(self, text: str) -> None:
        """One line as it is."""
        self.lines.append(text)

    def of(self, value: Real | float) -> str:
        """The operand's text."""
        return value.name if isinstance(value, Real) else constant("double", self.lanes, value)

    def constant(self, value: float) -> Real:
        """A constant as an operand."""
        return Real(self, self.of(value))

    def count(self, value: int) -> Integer:
        """An integer as an operand."""
        return Integer(self, str(value), 1)

    def function(self, name: str, *arguments: Real | float) -> Real:
        """One of LLVM's functions of doubles."""
        lanes = next((one.lanes for one in arguments if isinstance(one, Real)), self.lanes)
        real = kind("double", lanes)
        listed = ", ".join(f"{real} {operand_of(x, Real, lanes)}" for x in arguments)
        return Real(self, self.define(f"call {real} @llvm.{name}.{suffix(lanes)}({listed})"), lanes)

    def fma(self, a: Real, b: Real | float, c: Real | float) -> Real:
        """``a * b + c`` with one rounding."""
        return self.function("fma", a, b, c)

    def fused(self, a: Real, b: Real | float, c: Real | float) -> Real:
        """``a * b + c``, with one rounding where the processor can."""
        return self.function("fmuladd", a, b, c)

    def magnitude(self, a: Real) -> Real:
        """|a|."""
        return self.function("fabs", a)

    def larger(self, a: Real, b: Real | float) -> Real:
        """The larger one; b where either is not a number."""
        return self.select(a > b, a, b)

    def smaller(self, a: Real, b: Real | float) -> Real:
        """The smaller one; b where either is not a number."""
        other = a.like(b)
        return self.select(other > a, a, other)

    def all(self, condition: Bit) -> Bit:
        """Whether it holds in all lanes."""
        return self._reduced("and", condition)

    def any(self, condition: Bit) -> Bit:
        """Whether it holds in any lane."""
        return self._reduced("or", condition)

    def _reduced(self, operation: str, condition: Bit) -> Bit:
        if condition.lanes == 1:
            return condition
        function = f"llvm.vector.reduce.{operation}.v{condition.lanes}i1"
        return Bit(self, self.define(f"call i1 @{function}({condition.kind} {condition.name})"), 1)

    def reduce(self, operation: str, a: Real, start: Real | None = None) -> Real:
        """The largest lane (``fmax``), the least (``fmin``), or all added to ``start`` (``fadd``)."""
        if a.lanes == 1:
            return a if start is None else start + a
        function, given = f"llvm.vector.reduce.{operation}.{suffix(a.lanes)}", f"{a.kind} {a.name}"
        if start is None:
            return Real(self, self.define(f"call nnan double @{function}({given})"), 1)
        return Real(self, self.define(f"call double @{function}(double {start.name}, {given})"), 1)

    def select(self, condition: Bit, yes: V | float, no: V | float) -> V:
        """One or the other, of which one may be a constant: lane by lane, or all lanes by one condition."""
        one: V = next(x for x in (yes, no) if isinstance(x, Value))
        ways = ", ".join(f"{one.kind} {operand_of(x, type(one), one.lanes)}" for x in (yes, no))
        return one.made(f"select {condition.kind} {condition.name}, {ways}")

    def splat(self, one: V, lanes: int) -> V:
        """A value in every lane."""
        if lanes == one.lanes:
            return one
        if not one.name.startswith("%"):
            return type(one)(self, f"<{', '.join([f'{one.type} {one.name}'] * lanes)}>", lanes)
        vector, zeros = kind(one.type, lanes), f"<{lanes} x i32> zeroinitializer"
        first = self.define(f"insertelement {vector} poison, {one.type} {one.name}, i64 0")
        text = f"shufflevector {vector} {first}, {vector} poison, {zeros}"
        return type(one)(self, self.define(text), lanes)

    def lane(self, vector: V, index: Index) -> V:
        """One lane of a vector."""
        at = index.name if isinstance(index, Integer) else index
        text = f"extractelement {vector.kind} {vector.name}, i64 {at}"
        return type(vector)(self, self.define(text), 1)

    def inserted(self, vector: V, one: V, index: Integer) -> V:
        """A vector with another lane."""
        text = f"insertelement {vector.kind} {vector.name}, {one.kind} {one.name}, i64 {index.name}"
        return vector.made(text)

    def vector(self, values: Sequence[float]) -> Real:
        """A constant vector."""
        return Real(self, f"<{', '.join(f'double {operand(literal(x))}' for x in values)}>", len(values))

    def shuffle(self, a: V, lanes: Sequence[int], b: V | None = None) -> V:
        """Lanes of two vectors, those of the second one behind those of the first."""
        listed, other = ", ".join(f"i32 {lane}" for lane in lanes), "poison" if b is None else b.name
        text = f"shufflevector {a.kind} {a.name}, {a.kind} {other}, <{len(lanes)} x i32> <{listed}>"
        return type(a)(self, self.define(text), len(lanes))

    def joined(self, values: Sequence[V], lanes: int = 0) -> V:
        """Single values as the lanes of a vector, which may have more."""
        lanes = lanes or len(values)
        made, vector = "poison", kind(values[0].type, lanes)
        for i, one in enumerate(values):
            made = self.define(f"insertelement {vector} {made}, {one.kind} {one.name}, i64 {i}")
        return type(values[0])(self, made, lanes)

    def zero(self, lanes: int) -> Real:
        """0 in every lane."""
        return Real(self, constant("double", lanes, 0.0), lanes)

    def never(self, lanes: int) -> Bit:
        """No lane."""
        return Bit(self, constant("i1", lanes, "false"), lanes)


class Value:
    """An operand of instructions: its name, and of how many lanes it is (of the body's if not said)."""

    __slots__ = ("body", "lanes", "name")
    type: ClassVar[str]

    def __init__(self, body: Instructions, name: str, lanes: int = 0) -> None:
        self.body, self.name, self.lanes = body, name, lanes or body.lanes

    @property
    def kind(self) -> str:
        """Its type in LLVM's words."""
        return kind(self.type, self.lanes)

    def made(self: V, text: str) -> V:
        """A new value of its type."""
        return type(self)(self.body, self.body.define(text), self.lanes)

    def like(self: V, other: V | float) -> V:
        """Another value, or a constant as one like this."""
        return type(self)(self.body, operand_of(other, type(self), self.lanes), self.lanes)

    def operation(self: V, instruction: str, other: V | float) -> V:
        """An instruction with two operands: ``udiv``, ``lshr``, .."""
        second = operand_of(other, type(self), self.lanes)
        return self.made(f"{instruction} {self.kind} {self.name}, {second}")

    def compared(self, relation: str, other: Value | float) -> Bit:
        """A relation to another value, or to a constant."""
        word = "fcmp" if self.type == "double" else "icmp"
        text = f"{word} {relation} {self.kind} {self.name}, {operand_of(other, type(self), self.lanes)}"
        return Bit(self.body, self.body.define(text), self.lanes)


def _operator(instruction: str) -> Callable[[V, V | float], V]:
    """An operator, the second operand of which may be a constant."""
    return lambda a, b: a.operation(instruction, b)


def _relation(word: str) -> Callable[[V, V | float], Bit]:
    return lambda a, b: a.compared(word, b)


class Real(Value):
    """A double. Relations do not hold for not-a-number."""

    __slots__ = ()
    type = "double"
    __add__, __sub__, __mul__, __truediv__ = map(_operator, ("fadd", "fsub", "fmul", "fdiv"))
    __lt__, __le__, __gt__, __ge__ = map(_relation, ("olt", "ole", "ogt", "oge"))

    def __rsub__(self, other: float) -> Real:
        return self.like(other) - self

    def __rtruediv__(self, other: float) -> Real:
        return self.like(other) / self

    def __neg__(self) -> Real:
        if self.name.startswith("0x"):
            return Real(self.body, opposite(self.name), self.lanes)
        return self.made(f"fneg {self.kind} {self.name}")

    def equals(self, other: Real | float) -> Bit:
        """Whether both are the same number."""
        return self.compared("oeq", other)

    def bits(self) -> Integer:
        """The same bits as an integer."""
        return cast(self, "bitcast", Integer)


class Integer(Value):
    """An integer of 64 bits. Relations are those of integers that are not negative."""

    __slots__ = ()
    type = "i64"

    __add__, __sub__, __mul__, __lshift__ = map(_operator, ("add", "sub", "mul", "shl"))
    __and__, __or__, __xor__ = map(_operator, ("and", "or", "xor"))
    __lt__, __le__, __gt__, __ge__ = map(_relation, ("ult", "ule", "ugt", "uge"))

    def odd(self) -> Bit:
        """Whether it is odd."""
        return cast(self, "trunc", Bit)

    def equals(self, other: Index) -> Bit:
        """Whether both are the same."""
        return self.compared("eq", other)

    def flags(self, lanes: int) -> Bit:
        """Whether each of the lowest bits is 1, a lane for each."""
        bits = self.body.define(f"trunc i64 {self.name} to i{lanes}")
        return Bit(self.body, self.body.define(f"bitcast i{lanes} {bits} to {kind('i1', lanes)}"), lanes)

    def number(self) -> Real:
        """The number with these bits."""
        return cast(self, "bitcast", Real)

    def to_real(self) -> Real:
        """It as a double."""
        return cast(self, "sitofp", Real)


class Bit(Value):
    """A condition."""

    __slots__ = ()
    type = "i1"

    __and__, __or__ = map(_operator, ("and", "or"))

    def __invert__(self) -> Bit:
        return self.made(f"xor {self.kind} {self.name}, {constant('i1', self.lanes, 'true')}")

    def to_real(self) -> Real:
        """1 or 0."""
        return cast(self, "uitofp", Real)

    def to_integer(self) -> Integer:
        """1 or 0."""
        return cast(self, "zext", Integer)

    def mask(self) -> Integer:
        """A bit for each lane."""
        mask = self.body.define(f"bitcast {self.kind} {self.name} to i{self.lanes}")
        return Integer(self.body, self.body.define(f"zext i{self.lanes} {mask} to i64"), 1)

    def count(self) -> Integer:
        """In how many lanes it holds."""
        body, one = self.body, f"i{self.lanes}"
        mask = body.define(f"bitcast {self.kind} {self.name} to {one}")
        ones = body.define(f"call {one} @llvm.ctpop.{one}({one} {mask})")
        return Integer(body, body.define(f"zext {one} {ones} to i64"), 1)


class Pointer(Value):
    """A place in memory."""

    __slots__ = ()
    type = "ptr"


def cast(value: Value, instruction: str, to: type[V]) -> V:
    """The same in another type, by an instruction: ``bitcast``, ``zext``, .."""
    text = f"{instruction} {value.kind} {value.name} to {kind(to.type, value.lanes)}"
    return to(value.body, value.body.define(text), value.lanes)


def operand_of(value: Value | float, type: type[Value], lanes: int) -> str:
    """The text of an operand of that type: a value's name, or a constant in every lane."""
    return value.name if isinstance(value, Value) else constant(type.type, lanes, value)
