"""Vectors as a kind of numbers: a lane for each of eight motions."""

from __future__ import annotations

from lagrange_cli.native.interface import LANES
from lagrange_cli.native.llvm.declarations import LIBRARY
from lagrange_cli.native.llvm.function import Function
from lagrange_cli.native.llvm.text import Operand, Value, constant, kind, literal, suffix
from lagrange_cli.native.llvm.vector import Real
from lagrange_cli.native.numbers.double import Emitter
from lagrange_cli.native.numbers.kind import Number

VECTOR = kind("double", LANES)
BITS = kind("i1", LANES)


class LaneEmitter(Emitter):
    """The counterpart of ``Emitter`` for all lanes: an index counts vectors."""

    REAL, BIT, TAG, ALIGN = VECTOR, BITS, suffix(LANES), 8 * LANES
    one, zero = constant("double", LANES, 1.0), constant("double", LANES, 0.0)
    true = constant("i1", LANES, "true")

    def __init__(self, body: Function) -> None:
        super().__init__(body)
        self._angles: dict[Operand, list[Operand]] = {}

    def number(self, value: Number) -> Value:
        one = literal(value)
        return None if one is None else constant("double", LANES, one)

    def opposite(self, vector: Operand) -> Operand:
        return constant("double", LANES, super().opposite(vector.rpartition(" ")[2].rstrip(">")))

    def function(self, name: str, *arguments: Value) -> Operand:
        """A function, of all lanes (``functions.elementary``); sine and cosine of one angle together."""
        if name in ("sin", "cos"):
            self.body.operations += 1
            return self._turned(self.written(arguments[0]))[name == "cos"]
        if name == "exp":
            return self.call(f"exp.{LANES}", *arguments, None)
        if name in ("log", "pow", *LIBRARY):
            return self.call(f"{name}.{LANES}", *arguments)
        return super().function(name, *arguments)

    def _turned(self, angle: Operand) -> list[Operand]:
        """Its sine and cosine."""
        if angle not in self._angles:
            given = (Real(self.body, one, LANES) for one in (angle, self.zero))
            both = self.body.parts((Real, Real), f"sin_cos.{LANES}", *given, lanes=LANES)
            self._angles[angle] = [one.name for one in both]
        return self._angles[angle]

    def everywhere(self, table: str, first: str, index: int) -> Operand:
        """The one double ``table[first + index]`` in every lane."""
        row = self.body.place(table, first, "double")
        return self.body.splat(self.body.load_row(row, index, 1), LANES).name
