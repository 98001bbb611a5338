"""Vectors as a kind of numbers: a lane for each of eight motions."""

from __future__ import annotations

from collections.abc import Mapping

from lagrange_cli.native.functions import elementary
from lagrange_cli.native.interface import LANES
from lagrange_cli.native.numbers.double import ONE, ZERO, Emitter, Operand, Value, literal
from lagrange_cli.native.numbers.kind import Number
from lagrange_cli.native.numbers.vector import kind, suffix

VECTOR = kind("double", LANES)
BITS = kind("i1", LANES)
OWN = frozenset({"sin", "cos", *elementary.FUNCTIONS})
"""Functions of ``elementary``; the others are intrinsics that vectors have too."""


def splat(type: str, one: object) -> str:
    """A constant in every lane."""
    return f"<{', '.join([f'{type} {one}'] * LANES)}>"


class LaneEmitter(Emitter):
    """What ``Emitter`` is for one double, for all lanes: an index counts vectors."""

    REAL, BIT, TAG, ALIGN = VECTOR, BITS, suffix(LANES), 8 * LANES
    one, zero, true = splat("double", ONE), splat("double", ZERO), splat("i1", "true")

    def __init__(self, prefix: str = "%v") -> None:
        super().__init__(prefix)
        self._angles: dict[Operand, tuple[Operand, Operand]] = {}

    def number(self, value: Number) -> Value:
        one = literal(value)
        return None if one is None else splat("double", one)

    def opposite(self, constant: Operand) -> Operand:
        return splat("double", super().opposite(constant.rpartition(" ")[2].rstrip(">")))

    def function(self, name: str, *arguments: Value) -> Operand:
        """A function, of all lanes; sine and cosine of one angle are computed together."""
        if name not in OWN:
            return super().function(name, *arguments)
        self.operations += 1
        if name in ("sin", "cos"):
            angle = self.written(arguments[0])
            if angle not in self._angles:
                self._angles[angle] = elementary.sin_cos(self, angle, lanes=LANES)
            return self._angles[angle][name == "cos"]
        return elementary.emit_function(self, name, arguments, LANES)

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
