"""The Taylor series of a system of families: order by order, a loop over the members of each domain.

What the forces are made of are series of their own (``series.lowering``), one for each member, eight members
at a time. Coefficient k of a force adds up as the force itself does.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import cached_property
from typing import TYPE_CHECKING

from lagrange_cli.expression.node import Node
from lagrange_cli.families.arrays import Slots
from lagrange_cli.native.families.loops import Loop
from lagrange_cli.native.families.vector_dots import AHEAD, Coefficients, begin_dots
from lagrange_cli.native.interface import LANES
from lagrange_cli.native.llvm.function import Function
from lagrange_cli.native.llvm.vector import Index, Integer, Pointer
from lagrange_cli.records import dataclass
from lagrange_cli.series.lowering import lower_functions
from lagrange_cli.series.program import FREE, Op, SeriesProgram, needs

if TYPE_CHECKING:
    from lagrange_cli.expression.index_arrays import Places

TOGETHER = 2
"""Dot products that are summed up in one loop: several wait less for each other than one."""
SLOPE, INVERSE = -1, -2
"""What stands for coefficients of a power: dp/dx and 1/x where a step begins."""


@dataclass(frozen=True, eq=False)
class LoopSeries:
    """The series that the terms of a loop take, to the ``order`` of q's; ``moving`` are the symbols of slots
    and of t that change."""

    loop: Loop
    slots: Slots
    moving: int
    time: Node
    order: int
    kept: tuple[int, int] | None = None
    """The blocks whose coefficients are kept, if not all are: the first ones, and how many others are in use
    at a time."""

    @cached_property
    def program(self) -> SeriesProgram:
        """The series; coordinates are what slots have."""
        symbols = [one for one in self.loop.used if one.symbols & self.moving]
        nodes = [term.node for term, _ in self.loop.terms]
        return lower_functions(self.slots.graph, self.moving, symbols, self.time, nodes)

    @property
    def terms(self) -> int:
        """How many terms, the first ones, have series; the others are needed of order 0 alone."""
        return len(self.loop.terms)

    @cached_property
    def lasting(self) -> Sequence[int]:
        """The series of these terms."""
        wanted = {*self.program.residual[: self.terms]}
        for index in reversed(range(len(self.program.series))):
            if index in wanted:
                wanted |= {operand for operand, _ in needs(self.program.series[index])}
        return sorted(wanted)

    @cached_property
    def stored(self) -> Mapping[int, int]:
        """The series whose coefficients are needed again, with their places among the vectors of an order."""
        series = self.program.series
        found = {index for index in self.program.residual[: self.terms] if series[index].level > 0}
        for index in self.lasting:
            one = series[index]
            if one.op is Op.POWER:
                found.add(index)
            for operand, ahead in needs(one):
                if operand in one.sources:
                    continue
                if one.op in (Op.MULTIPLY, Op.POWER) or one.level + ahead != series[operand].level:
                    found.add(operand)
        return {index: place for place, index in enumerate(sorted(found))}

    @cached_property
    def besides(self) -> Mapping[tuple[int, int], int]:
        """What is needed again besides, with its place behind all orders: coefficient 0 of what functions are
        of and of what order 0 alone takes, dp/dx and 1/x of powers."""
        series = self.program.series
        again = dict.fromkeys(source for one in series for source in one.sources)
        brief = [index for index in range(len(series)) if index not in self.lasting]
        again |= dict.fromkeys(operand for index in brief for operand, _ in needs(series[index]))
        again |= dict.fromkeys(index for index in self.program.residual if series[index].level > 0)
        found = [(index, 0) for index in again if index not in self.stored]
        powers = [index for index, one in enumerate(series) if one.op is Op.POWER]
        found += [(index, which) for index in powers for which in (SLOPE, INVERSE)]
        return {key: place for place, key in enumerate(found)}

    @property
    def step(self) -> int:
        """Vectors of an order."""
        return len(self.stored)

    def vector(self, index: int, m: Index) -> Index:
        """Which vector of a block coefficient ``m`` of a series is, or what goes with it: what an order needs
        of several series is side by side."""
        if isinstance(m, int) and (index, m) in self.besides:
            return self.besides[index, m] + (self.order + 1) * self.step
        return m * self.step + self.stored[index]

    @cached_property
    def together(self) -> Mapping[int, Sequence[int]]:
        """The series whose dot products are summed up in one loop."""
        program, found = self.program.series, dict[tuple[int, bool], list[int]]()
        for index in self.lasting:
            one = program[index]
            if one.op is Op.MULTIPLY and all(program[part].level != FREE for part in one.arguments):
                a, b = one.arguments
                found.setdefault((one.level, a == b), []).append(index)
        return {
            index: group[i - i % TOGETHER : i - i % TOGETHER + TOGETHER]
            for group in found.values()
            for i, index in enumerate(group)
        }

    @cached_property
    def begun(self) -> Mapping[int, int]:
        """The series whose dot products can be begun for several orders together, with their places: none in
        short loops."""
        if self.short:
            return {}
        program = self.program.series
        found = [
            index
            for index in self.lasting
            if program[index].op is Op.MULTIPLY
            and program[index].level != FREE
            and all(program[part].level != FREE for part in program[index].arguments)
        ]
        return {index: LANES * AHEAD * place for place, index in enumerate(found)}

    def rest(self, index: int, phase: int) -> tuple[int, int]:
        """Of a dot product begun before stage k, in the stage so many later: how many terms are not known
        before, the first ones and the last ones."""
        a, b = (self.program.series[part].level for part in self.program.series[index].arguments)
        at = phase + self.program.series[index].level
        return max(0, at - b), max(0, at - a)

    @property
    def short(self) -> bool:
        """Whether there are no more than eight members. Then what matters is that the code is short."""
        return int(self.blocks[-1]) == 1

    @property
    def size(self) -> int:
        """Doubles of the coefficients of eight members, and of their sums."""
        return self.sums + LANES * AHEAD * len(self.begun)

    @property
    def sums(self) -> int:
        """Where the sums are in a block."""
        return LANES * ((self.order + 1) * self.step + len(self.besides))

    @property
    def unrolled(self) -> int:
        """Stages that are written out: then every series has had its first coefficient, and t two."""
        levels = [(one.level, one.op) for one in self.program.series if one.level > FREE]
        return max((1 - level + (op is Op.TIME) for level, op in levels), default=1)

    @property
    def blocks(self) -> Places:
        """The first block of each row, and their number."""
        return self.loop.rows.blocks

    @property
    def doubles(self) -> int:
        """What all coefficients take."""
        return self.size * (sum(self.kept) if self.kept else int(self.blocks[-1]))

    def place(self, f: Function, block: Integer) -> Integer:
        """Where the coefficients of a block begin."""
        if self.kept:
            first, others = self.kept
            turning = (block - first).operation("urem", others) + first
            block = f.select(block < first, block, turning) if first else turning
        return block * self.size


def begin_sums(
    f: Function,
    series: LoopSeries,
    k: Integer,
    at: int,
    first: Index,
    last: Index,
    base: Pointer | str = "%work",
) -> None:
    """Begin the dot products of some blocks, which are ``at`` a place from ``base`` on, in the stages from
    ``k`` on, ``AHEAD`` of them, with what is known before."""
    if not series.begun:
        return
    with f.loop(first, last) as i:
        block = f.place(base, series.place(f, i) + at, "double")
        for index, place in series.begun.items():
            a, b = (
                Coefficients(f.place(block, LANES * series.stored[part], "double"), series.step)
                for part in series.program.series[index].arguments
            )
            ahead, out = series.program.series[index].level, f.place(block, series.sums + place, "double")
            begin_dots(f, a, b, k + ahead, [series.rest(index, phase) for phase in range(AHEAD)], out)
