"""Constant tables of the code: places, eight side by side, and the numbers that are there."""

from __future__ import annotations

from array import array
from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from lagrange_cli.native.interface import LANES
from lagrange_cli.native.llvm.function import Function
from lagrange_cli.native.llvm.text import Operand
from lagrange_cli.native.llvm.vector import Bit, Index, Integer, Pointer
from lagrange_cli.native.numbers.lanes import VECTOR
from lagrange_cli.native.recurrences.evaluation import Constants
from lagrange_cli.native.state import whole_vectors
from lagrange_cli.records import dataclass, field

if TYPE_CHECKING:
    from lagrange_cli.expression.index_arrays import Places


def places_at(f: Function, at: Integer) -> Pointer:
    """Where eight places of the table are, from the ``at``-th on."""
    return f.place("@places", at, "i32")


def place_at(f: Function, at: Index, table: Pointer | str = "@places") -> Integer:
    """One of them, or of another ``table``."""
    place = f.place(table, at, "i32")
    index = f.define(f"load i32, ptr {place.name}, align 4")
    return Integer(f, f.define(f"zext i32 {index} to i64"), 1)


def gathered(f: Function, base: Operand, places: Pointer) -> Operand:
    """The doubles at these places from ``base`` on, which are loaded one by one: instructions that gather
    take longer on many processors, on Zen 4 twenty cycles."""
    found = "poison"
    for lane in range(LANES):
        at = f.place(base, place_at(f, lane, places), "double")
        one = f.define(f"load double, ptr {at.name}, align 8")
        found = f.define(f"insertelement {VECTOR} {found}, double {one}, i64 {lane}")
    return found


def before(f: Function, j: Integer, last: Integer | int) -> Bit:
    """Which of eight numbers from ``j`` on are below the ``last`` one."""
    lanes = Integer(f, f"<{', '.join(f'i64 {lane}' for lane in range(LANES))}>", LANES)
    return f.splat(j, LANES) + lanes < (f.splat(last, LANES) if isinstance(last, Integer) else last)


@dataclass
class Tables:
    """A constant table of places in ``%work`` and ``%constants``."""

    constants: Constants
    places: array[int] = field(default_factory=lambda: array("i"))
    seen: dict[bytes, int] = field(default_factory=dict)

    @property
    def scalars(self) -> int:
        """The doubles of constants that are no arrays, in whole vectors."""
        return whole_vectors(len(self.constants.slots))

    def of_places(self, listed: Sequence[int]) -> int:
        """Where the table has these places, in whole vectors: the last one is repeated."""
        return self.of_array(np.array(listed, dtype=np.int64))

    def of_array(self, listed: Places) -> int:
        """The same for an array of places."""
        if not len(listed):
            return 0
        whole = np.append(listed, np.repeat(listed[-1:], -len(listed) % LANES)).astype(np.int32).tobytes()
        if whole not in self.seen:
            self.seen[whole] = len(self.places)
            self.places.frombytes(whole)
        return self.seen[whole]

    def text(self) -> str:
        """The table."""
        content = self.places.tobytes() or bytes(8)
        text = "\\" + content.hex("\\").upper()
        return f'@places = private constant [{len(content)} x i8] c"{text}", align 64\n'
