"""Batches of series as a program of their own: one series for each batch, one for each way its operands lie.

A *view* is an operand of all members of a batch: in blocks beside theirs, or at places that a table lists. A
*column* is a factor of each member: one number for all, or a table.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import chain

from lagrange_cli.expression.graph import Graph
from lagrange_cli.expression.node import Kind, Node
from lagrange_cli.mechanics.residual import Residual
from lagrange_cli.native.interface import LANES
from lagrange_cli.native.recurrences.batches.arrangement import Misfit, aligned, places_of
from lagrange_cli.native.recurrences.batches.layout import Blocks, count
from lagrange_cli.native.recurrences.batches.tables import Tables
from lagrange_cli.records import dataclass, field, replace
from lagrange_cli.series.batches import Batch
from lagrange_cli.series.program import Op, Series, SeriesProgram


@dataclass(frozen=True)
class OperandView:
    """Where an operand of a batch's members is: in blocks from ``block`` on, or at the places of a table.
    Coordinates and velocities, which are ``moving``, have remainders."""

    block: int | None
    table: int
    moving: bool


@dataclass(frozen=True)
class FactorColumn:
    """A factor of each member: the one ``node``, in a slot of ``%constants`` if it is no number, a table of
    ``numbers``, or one of slots."""

    node: Node | None
    table: int = 0
    numbers: bool = False


@dataclass(frozen=True)
class LongSum:
    """The terms of a batch of long sums: as many for each member, some of them 0. Those ``changing`` depend
    on the newest accelerations; ``remainders`` are those of coordinates or velocities."""

    terms: int
    places: int
    factors: FactorColumn
    changing: FactorColumn
    remainders: bool


@dataclass(frozen=True)
class Moving:
    """A batch of coordinates and that of their velocities, with the view of the residuals and the masses.
    With constraints the ``rows`` of the equations say which unknowns the accelerations are."""

    coordinate: int
    velocity: int
    root: int
    masses: FactorColumn | None
    rows: tuple[int, ...]


@dataclass(frozen=True)
class Quotient:
    """``program`` has a series for each batch, then those of views; ``views`` are where each of them is.

    ``columns`` are factors that differ between members, by what stands for them in the program, ``given`` the
    tables of rows of the state by batches of coordinates and of velocities, ``low`` is where their remainders
    begin. ``multipliers`` has the batches of multipliers with their rows of the equations. ``read`` are those
    that another one, or the state, reads.
    """

    program: SeriesProgram
    views: Sequence[OperandView]
    columns: Mapping[Node, FactorColumn]
    given: Mapping[int, int]
    sums: Mapping[int, LongSum]
    low: int
    motion: Sequence[Moving]
    multipliers: Sequence[tuple[int, tuple[int, ...]]]
    read: frozenset[int]


def quotient(residual: Residual, blocks: Blocks, tables: Tables, low: int) -> Quotient:
    """The program of the batches."""
    maker = _Maker(residual, blocks, tables)
    series: list[Series] = []
    for number, batch in enumerate(blocks.batches):
        series.append(maker.series(number, batch))
    motion = [maker.motion(number) for number, one in enumerate(series) if one.op is Op.COORDINATE]
    coordinates = tuple(one.coordinate for one in motion)
    program = SeriesProgram((*series, *maker.further), coordinates, (), (), ())
    own = [
        OperandView(first, 0, maker.is_moving(batch.members[0]))
        for first, batch in zip(blocks.first, blocks.batches)
    ]
    read = {i for batch in blocks.batches for row in batch.operands for i in row} | {*blocks.program.state}
    return Quotient(
        program, (*own, *maker.views), maker.columns, maker.given, maker.sums, low, motion,
        [maker.multipliers(number) for number, one in enumerate(series) if one.op is Op.MULTIPLIER],
        frozenset(maker.where[i][0] for i in read),
    )  # fmt: skip


@dataclass
class _Maker:
    residual: Residual
    blocks: Blocks
    tables: Tables
    further: list[Series] = field(default_factory=list)
    views: list[OperandView] = field(default_factory=list)
    seen: dict[tuple[int, ...], int] = field(default_factory=dict)
    columns: dict[Node, FactorColumn] = field(default_factory=dict)
    given: dict[int, int] = field(default_factory=dict)
    sums: dict[int, LongSum] = field(default_factory=dict)
    names: Graph = field(default_factory=Graph)
    moving: set[int] = field(default_factory=set)

    def __post_init__(self) -> None:
        program = self.blocks.program
        self.moving = {*program.coordinates, *program.velocities}
        self.where = places_of(self.blocks.batches)

    def is_moving(self, index: int) -> bool:
        """Whether a series is a coordinate, a velocity, or a copy of one."""
        one = self.blocks.program.series[index]
        copied = self.blocks.batches[self.where[index][0]].copy
        return (one.arguments[0] if copied else index) in self.moving

    def series(self, number: int, batch: Batch) -> Series:
        """The series that stands for a batch."""
        one = batch.one
        if one.op is Op.SELECT:
            raise Misfit
        if batch.members[0] in self.moving and one.op in (Op.COORDINATE, Op.DERIVATIVE):
            program = self.blocks.program
            rows = {i: row for row, i in enumerate(program.coordinates)}
            rows |= {i: row for row, i in enumerate(program.velocities)}
            self.given[number] = self.tables.of_places([rows[i] for i in batch.members])
        if batch.long:
            self.sums[number] = self.long_sum(batch)
            return replace(one, arguments=(), data=(self.column(batch.constants), ()))
        arguments = tuple(map(self.view, batch.operands))
        data = one.data
        if one.op is Op.LINEAR:
            data = self.column(batch.constants), tuple(map(self.column, batch.scales))
        sources = tuple(
            self.view([self.blocks.program.series[i].sources[p] for i in batch.members])
            for p in range(len(one.sources))
        )
        return replace(one, arguments=arguments, sources=sources, data=data)

    def view(self, row: Sequence[int]) -> int:
        """The number of the view of these series."""
        key = tuple(row)
        if key not in self.seen:
            batch, first = self.where[row[0]]
            beside = aligned(self.where, row)
            block = self.blocks.first[batch] + first // LANES if beside else None
            table = 0 if beside else self.tables.of_places([self.blocks.offsets[i] for i in row])
            self.seen[key] = len(self.blocks.batches) + len(self.views)
            self.views.append(OperandView(block, table, self.is_moving(row[0])))
            self.further.append(self.blocks.program.series[row[0]])
        return self.seen[key]

    def column(self, nodes: Sequence[Node]) -> Node:
        """A column for the factors ``nodes`` of all members."""
        if all(node is nodes[0] for node in nodes):
            return nodes[0]
        found = self.table(nodes)
        symbol = self.names.symbol(f"column {len(self.columns)}")
        self.columns[symbol] = found
        return symbol

    def table(self, nodes: Sequence[Node]) -> FactorColumn:
        if all(node is nodes[0] for node in nodes):
            number = nodes[0].kind is Kind.NUMBER
            return FactorColumn(nodes[0], 0 if number else self.tables.constants.slot(nodes[0]))
        if all(node.kind is Kind.NUMBER for node in nodes):
            return FactorColumn(
                None, self.tables.of_numbers([float(node.data) for node in nodes]), numbers=True
            )
        return FactorColumn(None, self.tables.of_constants(nodes))

    def long_sum(self, batch: Batch) -> LongSum:
        """Its tables, block after block, term after term."""
        series, zero = self.blocks.program.series, self.residual.graph.zero
        terms, size = max(map(len, batch.operands)), count(batch.members)
        offsets = self.blocks.offsets
        places: list[int] = []
        factors: list[Node] = []
        changing: list[Node] = []
        level = batch.one.level
        for block in range(size):
            members = range(LANES * block, LANES * (block + 1))
            rows = [min(i, len(batch.members) - 1) for i in members]
            for t in range(terms):
                for row in rows:
                    there = t < len(batch.operands[row])
                    operand = batch.operands[row][t] if there else -1
                    places.append(offsets[operand] if there else self.blocks.zero)
                    factors.append(batch.scales[row][t] if there else zero)
                    changes = there and series[operand].corrected and series[operand].level == level
                    changing.append(factors[-1] if changes else zero)
        remainders = any(i in self.moving for i in chain(*batch.operands))
        first = self.tables.of_places(places)
        return LongSum(terms, first, self.table(factors), self.table(changing), remainders)

    def multipliers(self, number: int) -> tuple[int, tuple[int, ...]]:
        """A batch of multipliers with its rows of the equations."""
        program = self.blocks.program
        rows = {i: len(program.coordinates) + row for row, i in enumerate(program.multipliers)}
        return number, tuple(rows[i] for i in self.blocks.batches[number].members)

    def motion(self, number: int) -> Moving:
        """A batch of coordinates with its velocities, residuals and masses."""
        program, residual = self.blocks.program, self.residual
        rows = [self.blocks.program.series[i].data for i in self.blocks.batches[number].members]
        numbers = [row for row in rows if isinstance(row, int)]
        velocities = self.blocks.batches[self.where[program.velocities[numbers[0]]][0]].members
        if velocities != tuple(program.velocities[row] for row in numbers):
            raise Misfit
        velocity, own = self.where[velocities[0]][0], tuple(numbers)
        if program.multipliers:
            return Moving(number, velocity, 0, None, own)
        masses = self.table([residual.mass_matrix[row][row] for row in numbers])
        return Moving(number, velocity, self.view([program.residual[row] for row in numbers]), masses, own)
