"""Eight doubles from places that tables list."""

from __future__ import annotations

from lagrange_cli.native.interface import LANES
from lagrange_cli.native.llvm.function import Function
from lagrange_cli.native.llvm.text import Operand, constant
from lagrange_cli.native.llvm.vector import Integer
from lagrange_cli.native.numbers.lanes import VECTOR, LaneEmitter


def places_at(f: Function, at: Integer, *, aligned: bool = True) -> Operand:
    """Eight places of the table, from the ``at``-th on."""
    place = f.place("@places", at, "i32")
    return f.define(f"load <{LANES} x i32>, ptr {place.name}, align {4 * LANES if aligned else 4}")


def place_at(f: Function, at: Integer) -> Integer:
    """One of them."""
    place = f.place("@places", at, "i32")
    index = f.define(f"load i32, ptr {place.name}, align 4")
    return Integer(f, f.define(f"zext i32 {index} to i64"), 1)


def gathered(emitter: LaneEmitter, base: Operand, places: Operand) -> Operand:
    """The doubles at these places from ``base`` on."""
    return gathered_from(emitter.body, base, places)


def gathered_from(f: Function, base: Operand, places: Operand) -> Operand:
    """The same in a function."""
    many, true = f"<{LANES} x ptr>", constant("i1", LANES, "true")
    listed = f.define(f"getelementptr inbounds double, ptr {base}, <{LANES} x i32> {places}")
    given = f"{many} {listed}, i32 8, <{LANES} x i1> {true}, {VECTOR} poison"
    return f.define(f"call {VECTOR} @llvm.masked.gather.v{LANES}f64.v{LANES}p0({given})")
