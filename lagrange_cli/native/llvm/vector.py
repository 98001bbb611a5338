"""Values of LLVM IR with operators: doubles, integers, conditions and places, one or a vector of them.

Each operation is a plain one, so that its result is defined to the last bit, whatever the processor and
however many lanes.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, ClassVar, TypeVar

from lagrange_cli.native.llvm.text import literal, operand, opposite

if TYPE_CHECKING:
    from lagrange_cli.native.llvm.body import Body

V = TypeVar("V", bound="Value")


class Value:
    """An operand of instructions: its name, and of how many lanes it is (of the body's if not said)."""

    __slots__ = ("body", "lanes", "name")
    type: ClassVar[str]

    def __init__(self, body: Body, name: str, lanes: int = 0) -> None:
        self.body, self.name, self.lanes = body, name, lanes or body.lanes

    @property
    def kind(self) -> str:
        """Its type in LLVM's words."""
        return kind(self.type, self.lanes)

    def made(self: V, text: str) -> V:
        """A new value of its type."""
        return type(self)(self.body, self.body.define(text), self.lanes)

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

    def equals(self, other: Integer | int) -> Bit:
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


def kind(type: str, lanes: int) -> str:
    """The type of ``lanes`` of these."""
    return type if lanes == 1 else f"<{lanes} x {type}>"


def constant(type: str, lanes: int, value: object) -> str:
    """A constant in every lane."""
    one = operand(literal(value)) if isinstance(value, (int, float)) and type == "double" else str(value)
    return one if lanes == 1 else f"<{', '.join([f'{type} {one}'] * lanes)}>"


def operand_of(value: Value | float, type: type[Value], lanes: int) -> str:
    """The text of an operand of that type: a value's name, or a constant in every lane."""
    return value.name if isinstance(value, Value) else constant(type.type, lanes, value)


def suffix(lanes: int) -> str:
    """The suffix of LLVM's names for functions of them."""
    return "f64" if lanes == 1 else f"v{lanes}f64"
