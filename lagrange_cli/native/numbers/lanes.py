"""Vectors as a kind of numbers: a lane for each of eight motions."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, Protocol

from lagrange_cli.native.interface import LANES
from lagrange_cli.native.llvm.text import ONE, ZERO, Operand, Value, literal
from lagrange_cli.native.llvm.vector import kind, suffix
from lagrange_cli.native.numbers.double import Emitter
from lagrange_cli.native.numbers.kind import Number

VECTOR = kind("double", LANES)
BITS = kind("i1", LANES)


def splat(type: str, one: object) -> str:
    """A constant in every lane."""
    return f"<{', '.join([f'{type} {one}'] * LANES)}>"


class LaneFunctions(Protocol):
    """The elementary functions of all lanes: ``native.functions.elementary``."""

    @property
    def FUNCTIONS(self) -> Mapping[str, Any]: ...

    def sin_cos(
        self, emitter: Emitter, x: Value, low: Value = None, lanes: int = 1
    ) -> tuple[Operand, Operand]: ...
    def emit_function(
        self, emitter: Emitter, name: str, arguments: Sequence[Value], lanes: int = 1
    ) -> Operand: ...


class LaneEmitter(Emitter):
    """What ``Emitter`` is for one double, for all lanes: an index counts vectors.

    ``functions`` writes those that are no intrinsics of LLVM, which vectors have too.
    """

    REAL, BIT, TAG, ALIGN = VECTOR, BITS, suffix(LANES), 8 * LANES
    one, zero, true = splat("double", ONE), splat("double", ZERO), splat("i1", "true")

    def __init__(self, functions: LaneFunctions, prefix: str = "%v") -> None:
        super().__init__(prefix)
        self._functions = functions
        self._angles: dict[Operand, tuple[Operand, Operand]] = {}

    def number(self, value: Number) -> Value:
        one = literal(value)
        return None if one is None else splat("double", one)

    def opposite(self, constant: Operand) -> Operand:
        return splat("double", super().opposite(constant.rpartition(" ")[2].rstrip(">")))

    def function(self, name: str, *arguments: Value) -> Operand:
        """A function, of all lanes; sine and cosine of one angle are computed together."""
        if name not in ("sin", "cos", *self._functions.FUNCTIONS):
            return super().function(name, *arguments)
        self.operations += 1
        if name in ("sin", "cos"):
            angle = self.written(arguments[0])
            if angle not in self._angles:
                self._angles[angle] = self._functions.sin_cos(self, angle, lanes=LANES)
            return self._angles[angle][name == "cos"]
        return self._functions.emit_function(self, name, arguments, LANES)

    def everywhere(self, table: str, first: str, index: int) -> Operand:
        """The one double ``table[first + index]`` in every lane."""
        row = self.define(f"getelementptr inbounds double, ptr {table}, i64 {first}")
        place = self.define(f"getelementptr inbounds double, ptr {row}, i64 {index}")
        one = self.define(f"load double, ptr {place}, align 8")
        lane = self.define(f"insertelement {VECTOR} poison, double {one}, i64 0")
        zeros = f"<{LANES} x i32> zeroinitializer"
        return self.define(f"shufflevector {VECTOR} {lane}, {VECTOR} poison, {zeros}")


def declared() -> Mapping[str, str]:
    """The declarations of LLVM's functions of vectors and bits that programs may call, by name."""
    counts = {"fma": 3, "fmuladd": 3, "maxnum": 2, "fabs": 1, "floor": 1}
    heads = {f"llvm.{name}.{suffix(LANES)}": (VECTOR, [VECTOR] * count) for name, count in counts.items()}
    heads |= {f"llvm.cttz.{kind}": (kind, [kind, "i1"]) for kind in ("i8", "i64")}
    return {name: f"declare {kind} @{name}({', '.join(given)})" for name, (kind, given) in heads.items()}


DECLARATIONS = declared()
