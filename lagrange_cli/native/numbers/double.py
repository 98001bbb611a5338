"""Doubles as a kind of numbers.

A value is the text of an operand (``%v12`` or a hexadecimal constant), or None for a number known to be 0, so
that additions and multiplications with 0 are never written.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from lagrange_cli.native.interface import LANES
from lagrange_cli.native.llvm.declarations import INTRINSICS
from lagrange_cli.native.llvm.function import Function
from lagrange_cli.native.llvm.text import ONE, ZERO, Operand, Value, literal, opposite
from lagrange_cli.native.numbers.kind import Number, Written


class Emitter(Written[str]):
    """Doubles as a kind that writes into a function's ``body``: values are operands' texts.

    What is written for another type differs in the class's constants only.
    """

    REAL, BIT, TAG, ALIGN = "double", "i1", "f64", 8
    one, zero, true = ONE, ZERO, "true"
    unit, fused = 2.0**-53, True

    def __init__(self, body: Function) -> None:
        self.body, self.define, self.line = body, body.define, body.line
        self.repeated = 1
        """The number of times that the present code is executed."""
        self._depth: dict[str, int] = {}

    @property
    def operations(self) -> int:
        """Floating-point operations of the function so far."""
        return self.body.operations

    def _arithmetic(self, text: str, *operands: Value) -> Operand:
        self.body.operations += self.repeated
        name = self.define(text)
        self._depth[name] = 1 + max(map(self.depth, operands), default=0)
        return name

    def depth(self, value: Value) -> int:
        """The number of operations in a row until ``value`` is known."""
        return self._depth.get(value, 0) if value else 0

    def set_depth(self, value: Operand, depth: int) -> None:
        """Say so of a value that was not made by this class's arithmetic."""
        self._depth[value] = depth

    def forget_depths(self) -> None:
        """Everything that was made so far has long been known: a loop begins."""
        self._depth.clear()

    def number(self, value: Number) -> Value:
        return literal(value)

    def written(self, value: Value) -> Operand:
        """A value as an instruction needs it: 0 written out."""
        return self.zero if value is None else value

    def plus(self, a: Operand, b: Operand) -> Operand:
        return self._arithmetic(f"fadd {self.REAL} {a}, {b}", a, b)

    def sub(self, a: Value, b: Value) -> Value:
        if a is None or b is None:
            return self.neg(b) if a is None else a
        return self._arithmetic(f"fsub {self.REAL} {a}, {b}", a, b)

    def minus(self, a: Operand) -> Operand:
        return self._arithmetic(f"fneg {self.REAL} {a}", a) if a.startswith("%") else self.opposite(a)

    def opposite(self, vector: Operand) -> Operand:
        """A constant with the other sign."""
        return opposite(vector)

    def times(self, a: Operand, b: Operand) -> Operand:
        if self.one in (a, b):
            return b if a == self.one else a
        return self._arithmetic(f"fmul {self.REAL} {a}, {b}", a, b)

    def div(self, a: Value, b: Value) -> Value:
        if a is None:
            return None
        return self._arithmetic(f"fdiv {self.REAL} {a}, {self.written(b)}", a, b)

    def fma(self, a: Value, b: Value, c: Value) -> Value:
        """``a * b + c``, with one rounding where the processor can."""
        if a is None or b is None:
            return c
        if c is None:
            return self.mul(a, b)
        if a == self.one:
            return self.add(b, c)
        if b == self.one:
            return self.add(a, c)
        return self.intrinsic("fmuladd", a, b, c)

    def fms(self, a: Value, b: Value, c: Value) -> Value:
        """``c - a * b``, likewise."""
        if a is None or b is None:
            return c
        return self.fma(self.neg(a), b, c)

    def exact_fma(self, a: Value, b: Value, c: Value) -> Operand:
        """``a * b + c`` with one rounding."""
        return self.intrinsic("fma", a, b, c)

    def total(self, terms: Iterable[tuple[Value, Value]], start: Value = None) -> Value:
        """``start`` + sum of products, what is known last added last: so nothing waits for long."""
        known = [(a, b) for a, b in [(start, self.one), *terms] if a is not None and b is not None]
        known.sort(key=lambda term: max(self.depth(term[0]), self.depth(term[1])))
        result: Value = None
        for a, b in known:
            result = self.fma(a, b, result)
        return result

    def call(self, function: str, *arguments: Value) -> Operand:
        """A call of a declared function of such numbers."""
        listed = ", ".join([f"{self.REAL} {self.written(a)}" for a in arguments])
        return self._arithmetic(f"call {self.REAL} @{function}({listed})", *arguments)

    def intrinsic(self, name: str, *arguments: Value) -> Operand:
        """One of LLVM's functions."""
        return self.call(f"llvm.{name}.{self.TAG}", *arguments)

    def function(self, name: str, *arguments: Value) -> Operand:
        return self.intrinsic(name, *arguments) if name in INTRINSICS else self.call(name, *arguments)

    def magnitude(self, a: Value) -> Value:
        return self.intrinsic("fabs", a)

    def larger(self, a: Value, b: Value) -> Value:
        return self.intrinsic("maxnum", a, b)

    def compare(self, relation: str, a: Value, b: Value) -> Operand:
        return self.define(f"fcmp {relation} {self.REAL} {self.written(a)}, {self.written(b)}")

    def both(self, a: Operand, b: Operand) -> Operand:
        return self.define(f"and {self.BIT} {a}, {b}")

    def select(self, condition: Operand, yes: Value, no: Value) -> Operand:
        real = self.REAL
        return self.define(
            f"select {self.BIT} {condition}, {real} {self.written(yes)}, {real} {self.written(no)}"
        )

    def place(self, pointer: str, index: int | str) -> Operand:
        """The address of ``pointer[index]``."""
        return self.body.place(pointer, index, self.REAL).name

    def load(self, pointer: str, index: int | str, beyond: int | str = 0) -> Operand:
        return self.define(f"load {self.REAL}, ptr {self.place(pointer, index)}, align {self.ALIGN}")

    def store(self, value: Value, pointer: str, index: int | str, beyond: int | str = 0) -> None:
        place = self.place(pointer, index)
        self.line(f"  store {self.REAL} {self.written(value)}, ptr {place}, align {self.ALIGN}")

    def store_rows(self, width: int, values: Sequence[Value], pointer: str, index: int) -> None:
        """Store ``values``, and 0 after them, as whole vectors: of ``width`` lanes, or of 8 if it is more.

        (What is stored one by one cannot be loaded as a vector until it has reached memory.)
        """
        lanes = min(width, LANES)
        vector = f"<{lanes} x double>"
        for start in range(0, width, lanes):
            whole = "zeroinitializer"
            for lane, value in enumerate(values[start : start + lanes]):
                if value is not None:
                    whole = self.define(f"insertelement {vector} {whole}, double {value}, i64 {lane}")
            place = self.place(pointer, index + start)
            self.line(f"  store {vector} {whole}, ptr {place}, align {8 * lanes}")
