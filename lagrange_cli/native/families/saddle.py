"""The equations of motion with constraints, factored and solved by loops over the rows of tables.

L D L^T as in ``linear.symmetric``, eight unknowns of a round at a time (``model.sparse``). The pattern of
nonzero entries is in tables; so the code is the same for any number of constraints.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import TYPE_CHECKING, Any

from lagrange_cli.native.families.gathering import gathered, place_at, places_at
from lagrange_cli.native.families.saddle_tables import EliminationRounds, RowSums, SaddleTables
from lagrange_cli.native.interface import LANES
from lagrange_cli.native.linear.pivots import FLOOR
from lagrange_cli.native.llvm.flow import Variable
from lagrange_cli.native.llvm.function import Function
from lagrange_cli.native.llvm.text import Operand
from lagrange_cli.native.llvm.vector import Bit, Integer, Pointer, Real
from lagrange_cli.native.numbers.lanes import LaneEmitter

if TYPE_CHECKING:
    from lagrange_cli.expression.index_arrays import Places


class Tabled:
    """What the code of ``@jet`` factors once a step and solves with at every order.

    From ``base[first]`` on are arrays: the unknowns (in factoring, the smallest pivots allowed), 1/D, D,
    L, D L, and L once more as the two passes of a solution read it, row by row and column by column.
    """

    def __init__(
        self, f: Function, emitter: LaneEmitter, tabled: SaddleTables, base: Pointer | str, first: int
    ) -> None:
        self.f, self.emitter, self.base, self.first = f, emitter, base, first
        self.tabled, self.tables = tabled, tabled.tables

    @property
    def end(self) -> int:
        """What is behind the arrays."""
        return self.first + self.tabled.size

    # what depends on the kind of numbers

    def pointer(self, base: Pointer | str, at: Integer | int) -> Pointer:
        """The address of a number."""
        return self.f.place(base, at, "double")

    def row(self, place: Pointer) -> Any:
        """Eight numbers side by side."""
        return self.f.load_row(place, 0, LANES)

    def put_row(self, value: Any, place: Pointer) -> None:
        """The same, stored."""
        self.f.store_row(value, place, 0)

    def gather_from(self, base: Pointer, places: Operand) -> Operand:
        """Eight numbers at these places."""
        return gathered(self.emitter, base.name, places)

    def number(self, value: Operand | None) -> Any:
        """A value in memory's terms."""
        return Real(self.f, self.emitter.written(value), LANES)

    def operand(self, value: Any) -> Operand:
        """The other way."""
        name: Operand = value.name
        return name

    def variable(self, value: Operand) -> Any:
        """A variable with its first value."""
        return self.f.variable(self.number(value))

    # arrays

    def place(self, name: str, at: Integer | int = 0) -> Pointer:
        """A place in one of the arrays."""
        return self.pointer(self.pointer(self.base, self.first + self.tabled.places[name]), at)

    def load(self, name: str, at: Integer | int) -> Operand:
        """Eight of its numbers."""
        return self.operand(self.row(self.place(name, at)))

    def store(self, value: Operand | None, name: str, at: Integer | int) -> None:
        """The same, stored."""
        made = self.number(value)
        self.put_row(made, self.place(name, at))

    def gather(self, name: str, places: Operand) -> Operand:
        """Its numbers at these places."""
        return self.gather_from(self.place(name), places)

    def subtract(
        self, rows: RowSums, start: Callable[[Integer], Operand], factor: Callable[[Integer], Operand],
        other: str, put: Callable[[Operand, Integer], None], span: tuple[Integer, Integer] | None = None,
    ) -> None:  # fmt: skip
        """For each block of ``rows``, or of a ``span`` of these: ``start`` less the sum of ``factor`` times
        what the terms' second places hold."""
        f = self.f
        if not rows.blocks:
            return
        start_at, stop = span or (f.count(0), f.count(rows.blocks))
        with f.loop(start_at, stop) as b:
            first, last, target = (place_at(f, b + table) for table in (rows.starts, rows.ends, rows.targets))
            total = self.variable(start(target * LANES))
            with f.loop(first, last) as t:
                places = places_at(f, t * LANES + rows.second)
                value = self.emitter.fms(factor(t), self.gather(other, places), self.operand(total.get()))
                assert value is not None
                total.set(self.number(value))
            put(self.operand(total.get()), target * LANES)

    def factor(self, base: Pointer, entries: Mapping[str, Places], regular: Variable[Bit]) -> None:
        """L and D from the ``entries``, at these places from ``base`` on, and whether they are regular."""
        for name, places in entries.items():
            if len(places):
                table = self.tables.of_array(places)
                with self.f.loop(0, -(-len(places) // LANES), tested=False) as b:
                    row = self.gather_from(base, places_at(self.f, b * LANES + table))
                    self.store(row, name, b * LANES)
        self._floors(0, self.tabled.begin)
        parts = self.tabled.parts
        self._rounds(parts[0], regular, constrained=False)
        if len(parts) > 1:
            for name, rows in self.tabled.passed_on.items():
                self._take(name, rows)
            self._floors(self.tabled.begin, len(self.tabled.listed))
            self._rounds(parts[1], regular, constrained=True)
        for name, rows in (("rows", self.tabled.forward), ("columns", self.tabled.backward)):
            if rows.length:
                with self.f.loop(0, rows.length, tested=False) as t:
                    these = places_at(self.f, t * LANES + rows.first)
                    self.store(self.gather("lower", these), name, t * LANES)

    def _floors(self, first: int, last: int) -> None:
        """Below which part of their entries pivots are nothing but rounding."""
        unit = self.emitter.number(FLOOR * self.emitter.unit)
        with self.f.loop(first // LANES, last // LANES, tested=False) as b:
            self.store(self.emitter.mul(unit, self.load("diagonal", b * LANES)), "unknowns", b * LANES)

    def _rounds(self, part: EliminationRounds, regular: Variable[Bit], *, constrained: bool) -> None:
        """The rounds of a part, one after the other: what earlier ones give to their entries, 1/D, and L."""
        f = self.f
        with f.loop(0, part.rounds, tested=False) as r:

            def span(table: int) -> tuple[Integer, Integer]:
                """From where to where something is in this round."""
                return place_at(f, r + table), place_at(f, r + (table + 1))

            self._take("diagonal", part.diagonal, span(part.of_diagonal))
            self._pivot(span(part.positions), constrained, regular)
            self._take("lower", part.lower, span(part.of_lower))
            self._scale(span(part.pairs))

    def _take(self, name: str, rows: RowSums, span: tuple[Integer, Integer] | None = None) -> None:
        """Take from entries what earlier pivots give to them."""
        self.subtract(
            rows,
            lambda at: self.load(name, at),
            lambda t: self.gather("lower", places_at(self.f, t * LANES + rows.first)),
            "upper",
            lambda value, at: self.store(value, name, at),
            span,
        )

    def _pivot(self, blocks: tuple[Integer, Integer], constrained: bool, regular: Variable[Bit]) -> None:
        """1/D of a round, and whether the pivots are sound."""
        f, emitter, relation = self.f, self.emitter, "olt" if constrained else "ogt"
        with f.loop(*blocks, tested=False) as b:
            pivot, floor = (self.load(name, b * LANES) for name in ("diagonal", "unknowns"))
            self.store(emitter.div(emitter.one, pivot), "inverse", b * LANES)
            regular.set(regular.get() & f.all(Bit(f, emitter.compare(relation, pivot, floor), LANES)))

    def _scale(self, blocks: tuple[Integer, Integer]) -> None:
        """L from D L."""
        with self.f.loop(*blocks) as b:
            at = b * LANES
            value = self.load("lower", at)
            inverse = self.gather("inverse", places_at(self.f, at + self.tabled.pivots))
            self.store(value, "upper", at)
            self.store(self.emitter.mul(value, inverse), "lower", at)

    def solve(self, base: Pointer, right: Sequence[int], zero: int) -> None:
        """The unknowns with K x = what is at the places ``right`` from ``base`` on, with a 0 at ``zero``."""
        emitter = self.emitter
        table = self.tables.of_places([zero if i is None else right[i] for i in self.tabled.listed])
        with self.f.loop(0, len(self.tabled.listed) // LANES, tested=False) as b:
            row = self.gather_from(base, places_at(self.f, b * LANES + table))
            self.store(row, "unknowns", b * LANES)

        def put(value: Operand, at: Integer) -> None:
            self.store(value, "unknowns", at)

        def scaled(at: Integer) -> Operand:
            made = emitter.mul(self.load("unknowns", at), self.load("inverse", at))
            assert made is not None
            return made

        unknowns = "unknowns"
        self.subtract(
            self.tabled.forward,
            lambda at: self.load(unknowns, at),
            lambda t: self.load("rows", t * LANES),
            unknowns,
            put,
        )
        self.subtract(self.tabled.backward, scaled, lambda t: self.load("columns", t * LANES), unknowns, put)

    def table(self, rows: Iterable[int]) -> int:
        """Where the unknowns of these rows are, in a table of places from ``base`` on."""
        start = self.first + self.tabled.places["unknowns"]
        return self.tables.of_places([start + self.tabled.position[row] for row in rows])
