"""Eight doubles from places that tables list.

They are loaded one by one. Instructions that gather take longer on many processors: on Zen 4 twenty cycles.
"""

from __future__ import annotations

from lagrange_cli.native.interface import LANES
from lagrange_cli.native.llvm.function import Function
from lagrange_cli.native.llvm.text import Operand
from lagrange_cli.native.llvm.vector import Integer, Pointer
from lagrange_cli.native.numbers.lanes import VECTOR


def places_at(f: Function, at: Integer) -> Pointer:
    """Where eight places of the table are, from the ``at``-th on."""
    return f.place("@places", at, "i32")


def place_at(f: Function, at: Integer | int, table: Pointer | str = "@places") -> Integer:
    """One of them, or of another ``table``."""
    place = f.place(table, at, "i32")
    index = f.define(f"load i32, ptr {place.name}, align 4")
    return Integer(f, f.define(f"zext i32 {index} to i64"), 1)


def gathered(f: Function, base: Operand, places: Pointer) -> Operand:
    """The doubles at these places from ``base`` on."""
    found = "poison"
    for lane in range(LANES):
        at = f.place(base, place_at(f, lane, places), "double")
        one = f.define(f"load double, ptr {at.name}, align 8")
        found = f.define(f"insertelement {VECTOR} {found}, double {one}, i64 {lane}")
    return found


def lanes(f: Function) -> Integer:
    """0, 1, .. 7."""
    return Integer(f, f"<{', '.join(f'i64 {lane}' for lane in range(LANES))}>", LANES)
