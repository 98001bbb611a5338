"""Lists of some members of a loop, which grow and shrink during a motion: a few pairs of many.

A list has the places that the members have in all tables of the loop, side by side for each table. So their
numbers are gathered eight at a time, whichever members they are.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from functools import partial

from lagrange_cli.expression.node import Node
from lagrange_cli.native.families.evaluation import Writer
from lagrange_cli.native.families.loops import Loop
from lagrange_cli.native.families.tables import Tables, before, place_at
from lagrange_cli.native.families.vectors import Numbers, Operands
from lagrange_cli.native.interface import LANES
from lagrange_cli.native.llvm.function import Function
from lagrange_cli.native.llvm.vector import Bit, Integer, Pointer
from lagrange_cli.native.state import whole_vectors

HALF = 2
"""Places in the room of a double."""


class MemberList:
    """Members of a ``loop``, with their number and their places from ``first`` on."""

    def __init__(self, f: Function, tables: Tables, loop: Loop, first: Pointer) -> None:
        self.f, self.loop, self.first = f, loop, first
        listed, number = loop.numbered
        self.static = [tables.of_array(table) for table in listed]
        self.used, self.targets = number[: len(loop.used)], number[len(loop.used) :]

    @staticmethod
    def room(loop: Loop) -> int:
        """Doubles that a list takes: for all members, and some behind the last one."""
        return LANES + len(loop.numbered[0]) * MemberList.stride(loop)

    @staticmethod
    def stride(loop: Loop) -> int:
        """Doubles from the places in a table to those in the next one."""
        return whole_vectors(-(-loop.domain.count // HALF) + LANES)

    @property
    def count(self) -> Integer:
        """How many members there are."""
        return self.f.load_integer(self._counter)

    @property
    def _counter(self) -> Pointer:
        return self.f.place(self.first, 0, "i64")

    def table(self, i: int) -> Pointer:
        """Where the places in a table begin."""
        return self.f.place(self.first, LANES + i * self.stride(self.loop), "double")

    def at(self, i: int, j: Integer) -> Pointer:
        """Where those of the ``j``-th member and of the next ones are."""
        return self.f.place(self.table(i), j, "i32")

    def place(self, i: int, j: Integer) -> Integer:
        """The place of the ``j``-th member in a table."""
        return place_at(self.f, j, self.table(i))

    def of(self, member: Integer) -> list[Integer]:
        """Where the terms of a member of the loop go."""
        return [place_at(self.f, member + self.static[i]) for i in dict.fromkeys(self.targets)]

    def empty(self) -> None:
        """Begin without members."""
        self.f.store(self.f.count(0), self._counter)

    def add(self, member: Integer) -> None:
        """Add a member of the loop."""
        self._add([place_at(self.f, member + table) for table in self.static])

    def add_from(self, other: MemberList, j: Integer) -> None:
        """Add the ``j``-th member of another list."""
        self._add([other.place(i, j) for i in range(len(self.static))])

    def _add(self, places: Sequence[Integer]) -> None:
        count = self.count
        self._put(places, count)
        self.f.store(count + 1, self._counter)

    def _put(self, places: Sequence[Integer], j: Integer) -> None:
        for i, place in enumerate(places):
            half = self.f.define(f"trunc i64 {place.name} to i32")
            self.f.line(f"  store i32 {half}, ptr {self.at(i, j).name}, align 4")

    def finish(self) -> None:
        """Let the last member stand behind the end as well: vectors go beyond it."""
        count = self.count
        with self.f.when(count > 0):
            last = [self.place(i, count - 1) for i in range(len(self.static))]
            with self.f.loop(0, LANES - 1, tested=False) as more:
                self._put(last, count + more)

    @contextmanager
    def each(self) -> Iterator[Integer]:
        """The members' numbers in the list."""
        with self.f.loop(0, self.count) as j:
            yield j


@contextmanager
def each_of(f: Function, which: Bit) -> Iterator[Integer]:
    """The numbers of those of eight lanes."""
    with f.when(f.any(which)):
        flags = f.select(which, f.vector([1.0] * LANES), f.zero(LANES))
        with f.loop(0, LANES, tested=False) as lane, f.when(f.lane(flags, lane) > 0.0):
            yield lane


class ListWriter(Writer):
    """The code of a loop for the members of a list (``members``)."""

    members: MemberList

    def inside(self, j: Integer) -> Bit:
        """Which of eight members from the ``j``-th one on the list has."""
        return before(self.f, j, self.members.count)

    def gathered(self, j: Integer) -> dict[Node, Operands]:
        """The numbers of eight members."""
        return {
            symbol: self.taken(slot.array, partial(self.gather, places=self.members.at(i, j)))
            for (symbol, slot), i in zip(self.used.items(), self.members.used)
        }

    def gather(self, base: Pointer, places: Pointer) -> Numbers:
        """The numbers at eight places."""
        return self.vectors.gather(base, places)
