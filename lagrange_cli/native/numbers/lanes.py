"""Instructions over vectors, a lane for each of eight motions."""

from __future__ import annotations

import re

from lagrange_cli.native.functions import elementary
from lagrange_cli.native.interface import LANES
from lagrange_cli.native.numbers.double import Emitter, Operand, Value, operand

VECTOR = f"<{LANES} x double>"
BITS = f"<{LANES} x i1>"
OWN = frozenset({"sin", "cos", *elementary.FUNCTIONS})
"""Functions of ``elementary``; what else is called are intrinsics that vectors have too."""
_SCALAR = re.compile(r"<[^<>]*>|\b(?:double|i1)\b|\b0x[0-9A-F]{16}\b|\btrue\b|\.f64\b|\balign 8\b")


class LaneEmitter(Emitter):
    """Writes what ``Emitter`` writes for one double for all lanes: an index counts vectors."""

    def __init__(self, prefix: str = "%v") -> None:
        super().__init__(prefix)
        self._angles: dict[Operand, tuple[Operand, Operand]] = {}

    def define(self, text: str) -> Operand:
        return super().define(in_lanes(text))

    def store(self, value: Value, pointer: str, index: int | str) -> None:
        address = self.define(f"getelementptr inbounds double, ptr {pointer}, i64 {index}")
        self.line(in_lanes(f"  store double {operand(value)}, ptr {address}, align 8"))

    def call(self, function: str, *arguments: Value) -> Operand:
        """A function of doubles, of all lanes; sine and cosine of one angle are computed together."""
        name = function.removeprefix("llvm.").removesuffix(".f64")
        if name not in OWN:
            return super().call(function, *arguments)
        self.operations += 1
        if name in ("sin", "cos"):
            angle = operand(arguments[0])
            if angle not in self._angles:
                self._angles[angle] = elementary.sin_cos(self, angle, lanes=LANES)
            return self._angles[angle][name == "cos"]
        return elementary.emit_function(self, name, arguments, LANES)

    def everywhere(self, table: str, first: str, index: int) -> Operand:
        """The one double ``table[first + index]`` in every lane."""
        row = super().define(f"getelementptr inbounds double, ptr {table}, i64 {first}")
        place = super().define(f"getelementptr inbounds double, ptr {row}, i64 {index}")
        one = super().define(f"load double, ptr {place}, align 8")
        lane = super().define(f"insertelement {VECTOR} poison, double {one}, i64 0")
        zeros = f"<{LANES} x i32> zeroinitializer"
        return super().define(f"shufflevector {VECTOR} {lane}, {VECTOR} poison, {zeros}")


def in_lanes(text: str) -> str:
    """The same instruction for vectors."""
    return _SCALAR.sub(_vector, text)


def _vector(found: re.Match[str]) -> str:
    one = found[0]
    if one[0] == "<":  # for vectors already
        return one
    if one == "double":
        return VECTOR
    if one == "i1":
        return BITS
    if one == ".f64":
        return f".v{LANES}f64"
    if one == "align 8":
        return f"align {8 * LANES}"
    return splat("i1" if one == "true" else "double", one)


def splat(kind: str, one: object) -> str:
    """A constant in every lane."""
    return f"<{', '.join([f'{kind} {one}'] * LANES)}>"
