"""The equations of motion with constraints, factored and solved by loops over the rows of tables.

L D L^T as in ``linear.saddle``, eight unknowns of a round at a time (``linear.sparse``). Which numbers meet
is in tables; so the code is the same for any number of constraints.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from functools import cached_property

from lagrange_cli.expression.node import Node
from lagrange_cli.mechanics.residual import Residual
from lagrange_cli.native.interface import LANES
from lagrange_cli.native.linear.pivots import FLOOR
from lagrange_cli.native.linear.sparse import Elimination, eliminated
from lagrange_cli.native.llvm.flow import Variable
from lagrange_cli.native.llvm.function import Function
from lagrange_cli.native.llvm.text import Operand
from lagrange_cli.native.llvm.vector import Bit, Integer, Pointer, Real
from lagrange_cli.native.numbers.lanes import LaneEmitter
from lagrange_cli.native.recurrences.gathering import gathered, place_at, places_at
from lagrange_cli.native.recurrences.layout_batches import Blocks, Tables, count
from lagrange_cli.native.recurrences.values_batches import Values
from lagrange_cli.records import dataclass

MOST = 16
"""Numbers of L for each unknown up to which its places are listed."""

Term = tuple[int, int]
"""The places of two factors."""


def elimination_of(residual: Residual) -> Elimination | None:
    """How the matrix of the equations is eliminated; None where it is full, or may not be eliminated in any
    order."""
    firm = residual.definite and not (residual.pushed or residual.weightless)
    if not (firm and residual.multipliers) or residual.inertias or residual.cyclic_momenta:
        return None
    neighbours = [{k for k in row if k != j} for j, row in enumerate(residual.entries)]
    return eliminated(neighbours, len(residual.model.q), MOST * len(neighbours))


@dataclass(frozen=True)
class Rows:
    """Sums of products of so many ``blocks`` of eight, ``length`` terms together; and where their tables are:
    the first and the last term of each block, what it is taken from, and the places of both factors."""

    blocks: int
    length: int
    starts: int
    ends: int
    targets: int
    first: int
    second: int


class Tabled:
    """What the code of ``@jet`` factors once a step and solves with at every order.

    From ``base[first]`` on are arrays: the unknowns (in factoring, the smallest pivots allowed), 1/D, D,
    L, D L, and L once more as the two passes of a solution read it, row by row and column by column.
    """

    def __init__(
        self, f: Function, emitter: LaneEmitter, residual: Residual, tables: Tables, base: str, first: int
    ) -> None:
        elimination = elimination_of(residual)
        assert elimination is not None
        self.f, self.emitter, self.residual, self.tables, self.base = f, emitter, residual, tables, base
        self.elimination = elimination
        self.listed: list[int | None] = []
        """The unknowns by their positions: each round begins a block of eight."""
        self.ends: list[int] = []
        for one in elimination.rounds:
            self.listed += [*one, *[None] * (-len(one) % LANES)]
            self.ends.append(len(self.listed))
        self.position = {i: place for place, i in enumerate(self.listed) if i is not None}
        self.begin = self.ends[elimination.first - 1]
        """Where the constraints begin."""
        self.pairs: list[tuple[int, int] | None] = []
        """The places (i, p) of L, of each round in whole blocks."""
        self.pair_ends: list[int] = []
        for one in elimination.rounds:
            pairs = [(i, p) for p in one for i in elimination.columns[p]]
            self.pairs += [*pairs, *[None] * (-len(pairs) % LANES)]
            self.pair_ends.append(len(self.pairs))
        self.number = {pair: place for place, pair in enumerate(self.pairs) if pair is not None}
        self.forward, self.backward = self._passes()
        sizes = {
            "unknowns": len(self.listed) + LANES,
            "inverse": len(self.listed),
            "diagonal": len(self.listed),
            "lower": len(self.pairs) + LANES,
            "upper": len(self.pairs) + LANES,
            "rows": LANES * self.forward.length,
            "columns": LANES * self.backward.length,
        }
        self.end, self.places = first, dict[str, int]()
        for name, size in sizes.items():
            self.places[name] = self.end
            self.end += size

    # tables

    def _passes(self) -> tuple[Rows, Rows]:
        """The tables of both passes of a solution: the unknowns that each one takes from, and how much."""
        rows, columns = self.elimination.rows, self.elimination.columns
        zero = len(self.pairs), len(self.listed)

        def of(unknown: int | None, forward: bool) -> list[Term]:
            if unknown is None:
                return []
            if forward:
                return [(self.number[unknown, p], self.position[p]) for p in rows[unknown]]
            return [(self.number[i, unknown], self.position[i]) for i in columns[unknown]]

        size = len(self.listed) // LANES
        order = [*range(size)], [*reversed(range(size))]
        return (
            self._rows([[of(i, True) for i in self._eight(b)] for b in order[0]], order[0], zero),
            self._rows([[of(i, False) for i in self._eight(b)] for b in order[1]], order[1], zero, True),
        )

    def _eight(self, block: int) -> Sequence[int | None]:
        return self.listed[LANES * block : LANES * (block + 1)]

    def _rows(
        self, terms: Sequence[Sequence[list[Term]]], targets: Sequence[int], zero: Term, all: bool = False
    ) -> Rows:
        """Tables of the ``terms`` of blocks of eight; blocks without terms are left out unless ``all``
        stay."""
        first, second = list[int](), list[int]()
        starts, ends, kept = list[int](), list[int](), list[int]()
        for eight, target in zip(terms, targets):
            longest = max(map(len, eight))
            if not longest and not all:
                continue
            starts.append(len(first) // LANES)
            kept.append(target)
            for t in range(longest):
                row = [one[t] if t < len(one) else zero for one in eight]
                first += [a for a, _ in row]
                second += [b for _, b in row]
            ends.append(len(first) // LANES)
        made = (starts, ends, kept, first, second)
        tables = [self.tables.of_places(one) if one else 0 for one in made]
        return Rows(len(kept), len(first) // LANES, *tables)

    # code

    def place(self, name: str, at: Integer | int = 0) -> Pointer:
        """A place in one of the arrays."""
        return self.f.place(self.f.place(self.base, self.places[name], "double"), at, "double")

    def load(self, name: str, at: Integer | int) -> Operand:
        """Eight of its numbers."""
        return self.f.load_row(self.place(name, at), 0, LANES).name

    def store(self, value: Operand | None, name: str, at: Integer | int) -> None:
        """The same, stored."""
        made = Real(self.f, self.emitter.written(value), LANES)
        self.f.store_row(made, self.place(name, at), 0)

    def gather(self, name: str, places: Operand) -> Operand:
        """Its numbers at these places."""
        return gathered(self.emitter, self.place(name).name, places)

    def subtract(
        self, rows: Rows, start: Callable[[Integer], Operand], factor: Callable[[Integer], Operand],
        other: str, put: Callable[[Operand, Integer], None],
    ) -> None:  # fmt: skip
        """For each block of ``rows``: ``start`` less the sum of ``factor`` times what the terms' second
        places hold."""
        f = self.f
        if not rows.blocks:
            return
        with f.loop(0, rows.blocks, tested=False) as b:
            first, last, target = (place_at(f, b + table) for table in (rows.starts, rows.ends, rows.targets))
            total = f.variable(Real(f, start(target * LANES), LANES))
            with f.loop(first, last) as t:
                places = places_at(f, t * LANES + rows.second)
                value = self.emitter.fms(factor(t), self.gather(other, places), total.get().name)
                assert value is not None
                total.set(Real(f, value, LANES))
            put(total.get().name, target * LANES)

    @cached_property
    def nodes(self) -> Mapping[str, Sequence[Node]]:
        """The entries of the matrix by the arrays that they are factored in."""
        graph, entries = self.residual.graph, self.residual.entries
        signs = [graph.one if place < self.begin else -graph.one for place in range(len(self.listed))]
        diagonal = [
            sign if i is None else entries[i].get(i, graph.zero) for i, sign in zip(self.listed, signs)
        ]
        lower = [
            graph.zero if pair is None else entries[pair[0]].get(pair[1], graph.zero) for pair in self.pairs
        ]
        return {"diagonal": diagonal, "lower": lower}

    def factor(self, values: Values, regular: Variable[Bit]) -> None:
        """L and D from the ``values`` of the ``nodes``, and whether they are regular."""
        for name, nodes in self.nodes.items():
            if nodes:
                table = self.tables.of_places([values.places[node] for node in nodes])
                with self.f.loop(0, count(nodes), tested=False) as b:
                    row = gathered(self.emitter, values.base.name, places_at(self.f, b * LANES + table))
                    self.store(row, name, b * LANES)
        self._floors(0, self.begin)
        pairs = 0
        start = 0
        for number, (end, pair_end) in enumerate(zip(self.ends, self.pair_ends)):
            constrained = number >= self.elimination.first
            if number == self.elimination.first:
                self._update(range(self.begin, len(self.listed)), range(pairs, len(self.pairs)), False)
                self._floors(self.begin, len(self.listed))
            self._update(range(start, end), range(0), constrained)
            self._pivot(range(start, end), constrained, regular)
            self._update(range(0), range(pairs, pair_end), constrained)
            self._scale(range(pairs, pair_end))
            start, pairs = end, pair_end
        for name, rows in (("rows", self.forward), ("columns", self.backward)):
            if rows.length:
                with self.f.loop(0, rows.length, tested=False) as t:
                    places = places_at(self.f, t * LANES + rows.first)
                    self.store(self.gather("lower", places), name, t * LANES)

    def _floors(self, first: int, last: int) -> None:
        """Below which part of their entries pivots are nothing but rounding."""
        unit = self.emitter.number(FLOOR * self.emitter.unit)
        with self.f.loop(first // LANES, last // LANES, tested=False) as b:
            self.store(self.emitter.mul(unit, self.load("diagonal", b * LANES)), "unknowns", b * LANES)

    def _update(self, positions: range, pairs: range, constrained: bool) -> None:
        """Take from entries what earlier pivots give to them: those of coordinates, or of constraints."""
        rows, zero = self.elimination.rows, (len(self.pairs), len(self.pairs))
        limit = self.begin if not constrained else len(self.listed)
        least = self.begin if constrained else 0

        def terms(i: int, j: int) -> list[Term]:
            common = set(rows[i]).intersection(rows[j])
            earlier = [p for p in rows[j] if p in common and least <= self.position[p] < limit]
            return [(self.number[i, p], self.number[j, p]) for p in earlier]

        def in_blocks(name: str, places: range, of: Callable[[int], list[Term]]) -> None:
            listed = [[of(at) for at in places[b : b + LANES]] for b in range(0, len(places), LANES)]
            made = self._rows(listed, [at // LANES for at in places[::LANES]], zero)
            self.subtract(
                made,
                lambda at: self.load(name, at),
                lambda t: self.gather("lower", places_at(self.f, t * LANES + made.first)),
                "upper",
                lambda value, at: self.store(value, name, at),
            )

        def of_position(at: int) -> list[Term]:
            i = self.listed[at]
            return [] if i is None else terms(i, i)

        def of_pair(at: int) -> list[Term]:
            pair = self.pairs[at]
            return [] if pair is None else terms(*pair)

        in_blocks("diagonal", positions, of_position)
        in_blocks("lower", pairs, of_pair)

    def _pivot(self, positions: range, constrained: bool, regular: Variable[Bit]) -> None:
        """1/D of a round, and whether the pivots are sound."""
        f, emitter, relation = self.f, self.emitter, "olt" if constrained else "ogt"
        with f.loop(positions.start // LANES, positions.stop // LANES, tested=False) as b:
            pivot, floor = (self.load(name, b * LANES) for name in ("diagonal", "unknowns"))
            self.store(emitter.div(emitter.one, pivot), "inverse", b * LANES)
            regular.set(regular.get() & f.all(Bit(f, emitter.compare(relation, pivot, floor), LANES)))

    def _scale(self, pairs: range) -> None:
        """L from D L."""
        if not pairs:
            return
        pivots = [
            self.position[pair[1]] if pair is not None else 0 for pair in map(self.pairs.__getitem__, pairs)
        ]
        table = self.tables.of_places(pivots)
        with self.f.loop(0, len(pairs) // LANES, tested=False) as b:
            at = b * LANES + pairs.start
            value = self.load("lower", at)
            inverse = self.gather("inverse", places_at(self.f, b * LANES + table))
            self.store(value, "upper", at)
            self.store(self.emitter.mul(value, inverse), "lower", at)

    def solve(self, base: Pointer, right: Sequence[int], zero: int) -> None:
        """The unknowns with K x = what is at the places ``right`` from ``base`` on, with a 0 at ``zero``."""
        emitter = self.emitter
        table = self.tables.of_places([zero if i is None else right[i] for i in self.listed])
        with self.f.loop(0, len(self.listed) // LANES, tested=False) as b:
            row = gathered(emitter, base.name, places_at(self.f, b * LANES + table))
            self.store(row, "unknowns", b * LANES)

        def put(value: Operand, at: Integer) -> None:
            self.store(value, "unknowns", at)

        def scaled(at: Integer) -> Operand:
            made = emitter.mul(self.load("unknowns", at), self.load("inverse", at))
            assert made is not None
            return made

        unknowns = "unknowns"
        self.subtract(
            self.forward,
            lambda at: self.load(unknowns, at),
            lambda t: self.load("rows", t * LANES),
            unknowns,
            put,
        )
        self.subtract(self.backward, scaled, lambda t: self.load("columns", t * LANES), unknowns, put)

    def table(self, rows: Iterable[int]) -> int:
        """Where the unknowns of these rows are, in a table of places from ``base`` on."""
        return self.tables.of_places([self.places["unknowns"] + self.position[row] for row in rows])


def at_the_start(
    f: Function, emitter: LaneEmitter, residual: Residual, blocks: Blocks, nodes: Sequence[Node],
    tables: Tables, time: Operand,
) -> Values:  # fmt: skip
    """The values of ``nodes`` where a step begins, from the series' first coefficients."""
    program = blocks.program
    known = {
        one.node: blocks.offsets[i]
        for i, one in enumerate(program.series)
        if one.node is not None and one.level >= 1 and one.node is not residual.model.time
    }
    known |= {v: blocks.offsets[i] for v, i in zip(residual.model.v, program.velocities)}
    leaves = read(residual, nodes, known)
    values = Values(f, [*leaves, residual.model.time], nodes, tables, emitter)
    if leaves:
        table = tables.of_places([known[node] for node in leaves])
        with f.loop(0, count(leaves), tested=False) as b:
            row = gathered(emitter, "%work", places_at(f, b * LANES + table))
            f.store_row(Real(f, row, LANES), values.base, b * LANES)
    f.store(f.lane(Real(f, time, LANES), 0), values.base, len(leaves))
    values.write()
    emitter.repeated = 1
    return values


def read(residual: Residual, nodes: Sequence[Node], known: dict[Node, int]) -> list[Node]:
    """Which of the ``known`` nodes are read where ``nodes`` are computed."""
    found: dict[Node, None] = {}
    pending, seen = [*nodes], set[Node]()
    while pending:
        node = pending.pop()
        if node in known:
            found[node] = None
        elif node not in seen and node.symbols & residual.variables:
            seen.add(node)
            pending += node.arguments
    return sorted(found, key=lambda node: known[node])
