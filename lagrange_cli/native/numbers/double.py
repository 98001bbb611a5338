"""Text of LLVM IR, one instruction at a time, in static single assignment form.

A value is the text of an operand (``%12`` or a hexadecimal constant), or None for a number known to be 0, so
that additions and multiplications with 0 are never written.
"""

from __future__ import annotations

import struct
from collections.abc import Iterable
from typing import TypeAlias

from lagrange_cli.errors import TooLarge
from lagrange_cli.limits import way_out, whole

Operand: TypeAlias = str
Value: TypeAlias = str | None

MOST_INSTRUCTIONS = whole("instructions")

ONE: Operand = "0x3FF0000000000000"


def literal(value: float) -> Value:
    """A floating-point constant in LLVM's exact notation; None for 0."""
    if value == 0.0:
        return None
    return "0x" + struct.pack(">d", value).hex().upper()


def operand(value: Value) -> Operand:
    """A value as an instruction needs it: 0 written out."""
    return "0x0000000000000000" if value is None else value


def fused(text: str) -> str:
    """``text`` with every ``fmuladd`` an ``fma``, which is rounded once."""
    lines = text.replace("@llvm.fmuladd.", "@llvm.fma.").split("\n")
    declared = dict.fromkeys(line for line in lines if line.startswith("declare"))
    return "\n".join([*declared, *(line for line in lines if not line.startswith("declare"))])


class Emitter:
    """Collects the body of one function."""

    COST = 1
    """How much longer than others its instructions take to compile."""
    WAY_OUT = "write a smaller system, choose a method whose code is shorter: --method DOP853, " + way_out(
        "instructions"
    )

    def __init__(self, prefix: str = "%v") -> None:
        self._prefix = prefix
        self.lines: list[str] = []
        self.operations = 0
        """Floating-point operations, each as often as it is executed."""
        self.repeated = 1
        """How often what is being written is executed."""
        self._count = 0
        self._depth: dict[str, int] = {}

    def fresh(self) -> str:
        """A new name. Raises ``TooLarge`` where a function has more of them than can be compiled."""
        self._count += 1
        if self._count * self.COST > MOST_INSTRUCTIONS:
            raise TooLarge(
                f"the machine code has more than {MOST_INSTRUCTIONS // self.COST} instructions", self.WAY_OUT
            )
        return f"{self._prefix}{self._count}"

    def line(self, text: str) -> None:
        """One line as it is: a label, a branch, a store."""
        self.lines.append(text)

    def define(self, text: str) -> Operand:
        """A new value defined by ``text``."""
        name = self.fresh()
        self.lines.append(f"  {name} = {text}")
        return name

    def _arithmetic(self, text: str, *operands: Value) -> Operand:
        self.operations += self.repeated
        name = self.define(text)
        self._depth[name] = 1 + max(map(self.depth, operands), default=0)
        return name

    def depth(self, value: Value) -> int:
        """How many operations follow one another until ``value`` is known."""
        return self._depth.get(value, 0) if value else 0

    def set_depth(self, value: Operand, depth: int) -> None:
        """Say so of a value that was not made by this class's arithmetic."""
        self._depth[value] = depth

    def forget_depths(self) -> None:
        """Everything that was made so far has long been known: a loop begins."""
        self._depth.clear()

    def add(self, a: Value, b: Value) -> Value:
        if a is None:
            return b
        if b is None:
            return a
        return self._arithmetic(f"fadd double {a}, {b}", a, b)

    def sub(self, a: Value, b: Value) -> Value:
        if b is None:
            return a
        if a is None:
            return self.neg(b)
        return self._arithmetic(f"fsub double {a}, {b}", a, b)

    def neg(self, a: Value) -> Value:
        if a is not None and a.startswith("0x"):
            return f"0x{int(a, 16) ^ 1 << 63:016X}"
        return None if a is None else self._arithmetic(f"fneg double {a}", a)

    def mul(self, a: Value, b: Value) -> Value:
        if a is None or b is None:
            return None
        if a == ONE:
            return b
        if b == ONE:
            return a
        return self._arithmetic(f"fmul double {a}, {b}", a, b)

    def div(self, a: Value, b: Value) -> Value:
        if a is None:
            return None
        return self._arithmetic(f"fdiv double {a}, {operand(b)}", a, b)

    def fma(self, a: Value, b: Value, c: Value) -> Value:
        """``a * b + c``, fused where the processor can."""
        if a is None or b is None:
            return c
        if c is None:
            return self.mul(a, b)
        if a == ONE:
            return self.add(b, c)
        if b == ONE:
            return self.add(a, c)
        return self._arithmetic(f"call double @llvm.fmuladd.f64(double {a}, double {b}, double {c})", a, b, c)

    def fms(self, a: Value, b: Value, c: Value) -> Value:
        """``c - a * b``, fused where the processor can."""
        if a is None or b is None:
            return c
        return self.fma(self.neg(a), b, c)

    def total(self, terms: Iterable[tuple[Value, Value]], start: Value = None) -> Value:
        """``start`` + sum of products, what is known last added last: so nothing waits for long."""
        known = [(a, b) for a, b in [(start, ONE), *terms] if a is not None and b is not None]
        known.sort(key=lambda term: max(self.depth(term[0]), self.depth(term[1])))
        result: Value = None
        for a, b in known:
            result = self.fma(a, b, result)
        return result

    def call(self, function: str, *arguments: Value) -> Operand:
        """A call of a declared function of doubles."""
        listed = ", ".join(f"double {operand(a)}" for a in arguments)
        return self._arithmetic(f"call double @{function}({listed})", *arguments)

    def load(self, pointer: str, index: int | str) -> Operand:
        """``pointer[index]``."""
        address = self.define(f"getelementptr inbounds double, ptr {pointer}, i64 {index}")
        return self.define(f"load double, ptr {address}, align 8")

    def store(self, value: Value, pointer: str, index: int | str) -> None:
        """``pointer[index] = value``."""
        address = self.define(f"getelementptr inbounds double, ptr {pointer}, i64 {index}")
        self.line(f"  store double {operand(value)}, ptr {address}, align 8")
