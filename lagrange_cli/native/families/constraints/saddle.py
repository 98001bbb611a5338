"""The equations of motion with constraints, factored and solved by loops over the rows of tables.

L D L^T as in ``linear.symmetric``, eight unknowns of a round at a time (``model.sparse``). The pattern of
nonzero entries is in tables; so the code is the same for any number of constraints.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING

from lagrange_cli.native.families.constraints.saddle_tables import (
    FLOORS,
    EliminationRounds,
    RowSums,
    SaddleTables,
)
from lagrange_cli.native.families.tables import place_at, places_at
from lagrange_cli.native.families.vectors import Operands, Vectors
from lagrange_cli.native.interface import LANES
from lagrange_cli.native.linear.pivots import FLOOR
from lagrange_cli.native.llvm.flow import Variable
from lagrange_cli.native.llvm.vector import Bit, Index, Integer, Pointer
from lagrange_cli.native.state import vectors_of

if TYPE_CHECKING:
    from lagrange_cli.expression.index_arrays import Places


class Tabled:
    """What the code of ``@jet`` factors once a step and solves with at every order, in numbers of any kind.

    From ``base[first]`` on are arrays: the unknowns (in factoring, the smallest pivots allowed), 1/D, D,
    L, D L, and L once more as the two passes of a solution read it, row by row and column by column. The last
    unknowns depend on one another in a chain of rounds. They take the inverse of their part of L: products
    that do not wait for each other (F. L. Alvarado, A. Pothen and R. Schreiber, Highly Parallel Sparse
    Triangular Solution, 1993).
    """

    def __init__(self, vectors: Vectors, tabled: SaddleTables, base: Pointer | str, first: int) -> None:
        self.vectors, self.f, self.emitter = vectors, vectors.f, vectors.kind
        self.base, self.first, self.tabled, self.tables = base, first, tabled, tabled.tables

    # arrays

    def place(self, name: str, at: Index = 0) -> Pointer:
        """A place in one of the arrays."""
        return self.vectors.place(self.vectors.place(self.base, self.first + self.tabled.places[name]), at)

    def load(self, name: str, at: Index) -> Operands:
        """Eight of its numbers."""
        return self.vectors.operand(self.vectors.load_row(self.place(name, at), 0, LANES))

    def store(self, value: Operands, name: str, at: Index) -> None:
        """The same, stored."""
        made = self.vectors.number(value)
        self.vectors.store_row(made, self.place(name, at), 0)

    def gather(self, name: str, places: Pointer) -> Operands:
        """Its numbers at these places."""
        return self.gather_from(self.place(name), places)

    def gather_from(self, base: Pointer, places: Pointer) -> Operands:
        """Eight numbers at these places from ``base`` on."""
        return self.vectors.operand(self.vectors.gather(base, places))

    def subtract(
        self, rows: RowSums, start: Callable[[Integer], Operands], factor: Callable[[Integer], Operands],
        other: str, put: Callable[[Operands, Integer], None], span: tuple[Integer, Integer] | None = None,
    ) -> None:  # fmt: skip
        """For each block of ``rows``, or of a ``span`` of these: ``start`` less the sum of ``factor`` times
        what the terms' second places hold."""
        f = self.f
        if not rows.blocks:
            return
        start_at, stop = span or (f.count(0), f.count(rows.blocks))
        with f.loop(start_at, stop) as b:
            first, last, target = (place_at(f, b + table) for table in (rows.starts, rows.ends, rows.targets))
            total = self.vectors.variable(self.vectors.number(start(target * LANES)))
            with f.loop(first, last) as t:
                places = places_at(f, t * LANES + rows.second)
                value = self.emitter.fms(
                    factor(t), self.gather(other, places), self.vectors.operand(total.get())
                )
                total.set(self.vectors.number(value))
            put(self.vectors.operand(total.get()), target * LANES)

    definite = True
    """Whether pivots have to be positive; else they have not to be 0."""
    left_out: Variable[Bit]
    """Whether there are such unknowns."""
    compared = False
    """Whether it is said what pivots are compared with. Where that is negative, an unknown may depend on
    others: it is 0 if its pivot is nothing but rounding."""

    def factor(self, base: Pointer, entries: Mapping[str, Places], regular: Variable[Bit]) -> None:
        """L and D from the ``entries``, at these places from ``base`` on, and whether they are regular."""
        for name, places in entries.items():
            if len(places):
                table = self.tables.of_array(places)
                with self.f.loop(0, vectors_of(len(places)), tested=False) as b:
                    row = self.gather_from(base, places_at(self.f, b * LANES + table))
                    self.store(row, name, b * LANES)
        self.compared = FLOORS in entries
        self.left_out = self.f.variable(Bit(self.f, "false", 1))
        self._floors(FLOORS if self.compared else "diagonal")
        self._rounds(self.tabled.factoring, regular)
        for name, rows in (("rows", self.tabled.forward), ("columns", self.tabled.backward)):
            if rows.length:
                with self.f.loop(0, rows.length, tested=False) as t:
                    these = places_at(self.f, t * LANES + rows.first)
                    self.store(self.gather("lower", these), name, t * LANES)

        if self.tabled.tail:
            self._invert()

    def _invert(self) -> None:
        """W, the inverse of what L has of the last unknowns, column by column, and D^-1 W, row by row."""
        vectors, emitter, tail = self.vectors, self.emitter, self.tabled.tail
        rows: list[Operands] = []
        for b, i in enumerate(tail):
            self.store(None, "tail_rows", b * LANES)
            vectors.store(vectors.constant(1.0), self.place("tail_rows"), b * LANES + b)
            row = self.load("tail_rows", b * LANES)
            for p, other in zip(tail, rows):
                if (i, p) in self.tabled.within:
                    row = emitter.fms(self.everywhere("lower", self.tabled.within[i, p]), other, row)
            self.store(row, "tail_rows", b * LANES)
            rows.append(row)
        for a, _ in enumerate(tail):
            table = self.tables.of_places([LANES * b + a for b in range(LANES)])
            column = self.gather("tail_rows", places_at(self.f, self.f.count(table)))
            self.store(column, "tail_columns", a * LANES)
        for b, i in enumerate(tail):
            inverse = self.everywhere("inverse", self.tabled.pivot[i])
            self.store(emitter.mul(inverse, rows[b]), "tail_rows", b * LANES)

    def everywhere(self, name: str, at: int) -> Operands:
        """A number of an array, eight times."""
        return self.vectors.operand(self.vectors.splat(self.vectors.load(self.place(name), at), LANES))

    def _floors(self, sizes: str) -> None:
        """Below which part of their entries, or of other ``sizes``, pivots are nothing but rounding."""
        unit = self.emitter.number(FLOOR * self.emitter.unit)
        with self.f.loop(0, len(self.tabled.listed) // LANES, tested=False) as b:
            self.store(self.emitter.mul(unit, self.load(sizes, b * LANES)), FLOORS, b * LANES)

    def _rounds(self, part: EliminationRounds, regular: Variable[Bit]) -> None:
        """All rounds, one after the other: what earlier ones give to their entries, 1/D, and L."""
        f = self.f
        with f.loop(0, len(self.tabled.elimination.rounds), tested=False) as r:

            def span(table: int) -> tuple[Integer, Integer]:
                """From where to where something is in this round."""
                return place_at(f, r + table), place_at(f, r + (table + 1))

            self._take("diagonal", part.diagonal, span(part.of_diagonal))
            self._pivot(span(part.positions), regular)
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

    def _pivot(self, blocks: tuple[Integer, Integer], regular: Variable[Bit]) -> None:
        """1/D of a round, and whether the pivots are sound."""
        f, emitter = self.f, self.emitter
        with f.loop(*blocks, tested=False) as b:
            pivot, floor = (self.load(name, b * LANES) for name in ("diagonal", FLOORS))
            inverse, size = emitter.div(emitter.one, pivot), emitter.magnitude(floor)
            if not self.definite:
                pivot = emitter.magnitude(pivot)
            if self.compared:
                more = emitter.compare("ogt", pivot, size)
                inverse = emitter.select(more, inverse, None)
                self.left_out.set(self.left_out.get() | ~f.all(Bit(f, more, LANES)))
            elif not self.definite:
                floor = size
            self.store(inverse, "inverse", b * LANES)
            regular.set(regular.get() & f.all(Bit(f, emitter.compare("ogt", pivot, floor), LANES)))

    def release(self) -> None:
        """Let unknowns that are left out be what is on their right side: with 0 on all others, solutions are
        combinations of unknowns that vanish in the equations."""
        emitter = self.emitter
        with self.f.loop(0, len(self.tabled.listed) // LANES, tested=False) as b:
            inverse = self.load("inverse", b * LANES)
            made = emitter.select(emitter.compare("oeq", inverse, None), emitter.one, inverse)
            self.store(made, "inverse", b * LANES)
        if self.tabled.tail:
            self._invert()

    def _scale(self, blocks: tuple[Integer, Integer]) -> None:
        """L from D L."""
        with self.f.loop(*blocks) as b:
            at = b * LANES
            value = self.load("lower", at)
            inverse = self.gather("inverse", places_at(self.f, at + self.tabled.pivots))
            self.store(value, "upper", at)
            self.store(self.emitter.mul(value, inverse), "lower", at)

    def solve(self, right: Pointer) -> None:
        """The unknowns with K x = what is at ``right``, with a 0 behind it."""
        emitter = self.emitter
        table = self.tables.of_places([self.tabled.count if i is None else i for i in self.tabled.solved])
        with self.f.loop(0, len(self.tabled.solved) // LANES, tested=False) as b:
            row = self.gather_from(right, places_at(self.f, b * LANES + table))
            self.store(row, "unknowns", b * LANES)

        unknowns = "unknowns"

        def put(value: Operands, at: Integer) -> None:
            self.store(value, unknowns, at)

        def plain(at: Integer) -> Operands:
            return self.load(unknowns, at)

        def scaled(at: Integer) -> Operands:
            return emitter.mul(plain(at), self.load("inverse", at))

        self.subtract(self.tabled.forward, plain, lambda t: self.load("rows", t * LANES), unknowns, put)
        if self.tabled.tail:
            self._multiply("tail_columns")
            self._multiply("tail_rows")
        self.subtract(self.tabled.backward, scaled, lambda t: self.load("columns", t * LANES), unknowns, put)

    def _multiply(self, name: str) -> None:
        """The last unknowns times the vectors of an array."""
        totals: list[Operands] = [None, None]
        for a, _ in enumerate(self.tabled.tail):
            factor = self.everywhere("unknowns", self.tabled.tail_at + a)
            totals[a % 2] = self.emitter.fma(factor, self.load(name, a * LANES), totals[a % 2])
        self.store(self.emitter.add(*totals), "unknowns", self.tabled.tail_at)

    @property
    def solution(self) -> int:
        """A table of the places of the unknowns from ``base`` on."""
        start = self.first + self.tabled.places["unknowns"]
        return self.tables.of_array(start + self.tabled.in_solution)
