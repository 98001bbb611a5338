"""``@project`` of large systems (see ``projection``) by loops over constraints and coordinates."""

from __future__ import annotations

from collections.abc import Sequence

from lagrange_cli.expression.node import Node
from lagrange_cli.mechanics.constraints import Constraints
from lagrange_cli.mechanics.residual import Residual
from lagrange_cli.native.interface import LANES
from lagrange_cli.native.llvm.flow import Variable
from lagrange_cli.native.llvm.function import Function
from lagrange_cli.native.llvm.vector import Bit, Integer, Pointer, Real
from lagrange_cli.native.numbers.error_free import two_sum
from lagrange_cli.native.numbers.lanes import LaneEmitter
from lagrange_cli.native.recurrences.batches.gathering import gathered, place_at, places_at
from lagrange_cli.native.recurrences.batches.layout import count
from lagrange_cli.native.recurrences.batches.saddle import Tabled, entries_of
from lagrange_cli.native.recurrences.batches.saddle_tables import SaddleTables, elimination_of
from lagrange_cli.native.recurrences.batches.tables import Tables
from lagrange_cli.native.recurrences.batches.values import BatchedValues, CarefulValues
from lagrange_cli.native.state import StateLayout
from lagrange_cli.native.stepping.projection import LOOSE, afterwards, places_of


class BatchProjection:
    """Writes ``@project(constants, state)``. All it needs besides is scratch: the residuals with all digits
    and their slopes, the matrix of the equations, right sides, and what depends on the moves."""

    def __init__(self, residual: Residual, layout: StateLayout, tables: Tables) -> None:
        self.f = Function("define void @project(ptr %constants, ptr %state) #0")
        self.emitter = LaneEmitter(self.f)
        self.residual, self.tables, self.at = residual, tables, places_of(layout)
        model = residual.model
        self.size, self.constraints = len(model.q), Constraints(model)
        self.named = [*model.q, *model.v, model.time]
        zero = residual.graph.zero
        self.places = [one.expression if one.holonomic else zero for one in model.constraints]
        self.speeds = self.constraints.speeds

    def text(self) -> str:
        """The function's text."""
        f, tables, residual = self.f, self.tables, self.residual
        zero = residual.graph.zero
        given = f, self.named, [*self.places, *self.speeds, zero], tables, self.emitter
        off = CarefulValues(*given)
        self._fill(off.base, off.low)
        off.write()
        slopes = [slope for row in self.constraints.slopes for slope in row.values()]
        known = BatchedValues(f, self.named, [*slopes, zero], tables, self.emitter, off.end)
        self._fill(known.base)
        known.write()
        fine = f.variable(Bit(f, "true", 1))
        self._compare(off, known, self.places, 0, fine)
        self._compare(off, known, self.speeds, self.size, fine)
        with f.when(~fine.get()):
            self._move(off, known.end)
        f.give()
        return f.text()

    def _fill(self, values: Pointer, low: Pointer | None = None) -> None:
        """The state as leaves."""
        f, at, last = self.f, self.at, 2 * self.size
        for base, state, time in ((values, at.q, at.time), (low, at.q + at.width, at.time_low)):
            if base is not None:
                with f.loop(0, last) as row:
                    f.store(f.load("%state", row + state), base, row)
                f.store(f.load("%state", time), base, last)

    def _residuals(self, off: CarefulValues, nodes: Sequence[Node], b: Integer) -> Real:
        """The ``b``-th eight of what should be 0."""
        places = places_at(self.f, b * LANES + self.tables.of_places([off.places[node] for node in nodes]))
        high, low = (Real(self.f, gathered(self.emitter, base.name, places), LANES) for base in off.bases)
        return high + low

    def _compare(
        self, off: CarefulValues, known: BatchedValues, nodes: Sequence[Node], first: int, fine: Variable[Bit]
    ) -> None:
        """Whether they are only rounding errors of their terms: slopes times the leaves from ``first`` on."""
        f, tables, zero = self.f, self.tables, known.places[self.residual.graph.zero]
        rows = [
            [(known.places[slope], first + k) for k, slope in row.items()] for row in self.constraints.slopes
        ]
        terms = max(map(len, rows))
        rows += rows[-1:] * (-len(rows) % LANES)
        padded = [[*row, *[(zero, zero)] * (terms - len(row))] for row in rows]
        blocks = [padded[start : start + LANES] for start in range(0, len(padded), LANES)]
        tabled = [
            tables.of_places([row[t][side] for block in blocks for t in range(terms) for row in block])
            for side in (0, 1)
        ]
        with f.loop(0, len(blocks), tested=False) as b:
            total = f.variable(f.zero(LANES))
            with f.loop(0, terms, tested=False) as t:
                at = (b * terms + t) * LANES
                slope, amount = (
                    Real(f, gathered(self.emitter, known.base.name, places_at(f, at + table)), LANES)
                    for table in tabled
                )
                total.set(total.get() + f.magnitude(slope * amount))
            small = f.magnitude(self._residuals(off, nodes, b)) <= total.get() * (LOOSE * self.emitter.unit)
            fine.set(fine.get() & f.all(small))

    def _move(self, off: CarefulValues, first: int) -> None:
        """The projection, first of coordinates, then of velocities."""
        f, tables, residual, emitter = self.f, self.tables, self.residual.unpushed, self.emitter
        many, scratch = len(residual.entries), f.load_integer("@scratch")
        symbols, kicks, later = afterwards(residual, self.constraints, many)
        matrix = BatchedValues(f, self.named, self._entries(residual), tables, emitter, first)
        self._fill(matrix.base)
        matrix.write()
        elimination = elimination_of(residual)
        assert elimination is not None
        base = f.place("%constants", scratch, "double").name
        saddle = Tabled(f, emitter, SaddleTables(elimination, tables), base, matrix.end)
        tables.scratch = max(tables.scratch, saddle.end)
        regular = f.variable(Bit(f, "true", 1))
        saddle.factor(matrix.base, matrix.placed(entries_of(saddle.tabled, residual)), regular)
        with f.when(regular.get()):
            moves = BatchedValues(f, [*symbols, *self.named], [*kicks, *later], tables, emitter, saddle.end)
            right = moves.end
            tables.scratch = max(tables.scratch, right + LANES * (count(range(many)) + 1))
            sides = f.place("%constants", scratch + right, "double")
            zero = LANES * count(range(many))
            nothing = f.constant(0.0)
            f.store(nothing, sides, zero)
            with f.loop(0, self.size) as row:
                f.store(nothing, sides, row)
            self._put(off, self.places, sides)
            saddle.solve(sides, range(many), zero)
            self._changes(saddle, moves.base)
            self._fill(f.place(moves.base, many, "double"))
            moves.write()
            self._add(moves.base, self.at.q)
            places = [moves.places[node] for node in kicks]
            self._copied(moves.base, places, sides, 0)
            self._put(off, self.speeds, sides)
            self._copied(moves.base, [moves.places[node] for node in later], sides, self.size, adding=True)
            saddle.solve(sides, range(many), zero)
            self._changes(saddle, moves.base)
            self._add(moves.base, self.at.v)
            if self.at.count is not None:
                f.store(f.load("%state", self.at.count) + 1.0, "%state", self.at.count)

    def _entries(self, residual: Residual) -> list[Node]:
        zero, one = residual.graph.zero, residual.graph.one
        return [zero, one, -one, *(entry for row in residual.entries for entry in row.values())]

    def _put(self, off: CarefulValues, nodes: Sequence[Node], to: Pointer) -> None:
        """What should be 0 as the right side of the constraints."""
        f = self.f
        table = self.tables.of_places([off.places[node] for node in nodes])
        with f.loop(0, len(nodes)) as i:
            at = place_at(f, i + table)
            f.store(f.load(off.base, at) + f.load(off.low, at), to, i + self.size)

    def _copied(
        self, values: Pointer, places: Sequence[int], to: Pointer, first: int, *, adding: bool = False
    ) -> None:
        """Values at these places, to where the right side begins with them, or added to it."""
        f, table = self.f, self.tables.of_places(places)
        with f.loop(0, len(places)) as i:
            value = f.load(values, place_at(f, i + table))
            f.store(value + f.load(to, i + first) if adding else value, to, i + first)

    def _changes(self, saddle: Tabled, to: Pointer) -> None:
        """The unknowns in the order of the equations."""
        f, many = self.f, saddle.tabled.many
        table = saddle.table(range(many))
        with f.loop(0, many) as row:
            f.store(f.load(saddle.base, place_at(f, row + table)), to, row)

    def _add(self, changes: Pointer, first: int) -> None:
        """The ``changes`` to the rows of the state from ``first`` on."""
        f, width = self.f, self.at.width
        with f.loop(0, self.size) as row:
            high, low = f.load("%state", row + first), f.load("%state", row + (first + width))
            total, error = two_sum(high, f.load(changes, row))
            total, error = two_sum(total, error + low)
            f.store(total, "%state", row + first)
            f.store(error, "%state", row + (first + width))
