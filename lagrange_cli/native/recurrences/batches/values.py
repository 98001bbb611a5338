"""Values of expressions at one state by loops over those of one kind.

As for series (``series.batches``): each batch of nodes is an array behind ``%constants``, ``@scratch``
doubles from its beginning, and takes the operands of its members from other arrays.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from lagrange_cli.expression.graph import Graph
from lagrange_cli.expression.node import Kind, Node, reachable
from lagrange_cli.native.interface import LANES
from lagrange_cli.native.llvm.function import Function
from lagrange_cli.native.llvm.text import Operand, Value
from lagrange_cli.native.llvm.vector import Integer, Pointer, Real
from lagrange_cli.native.numbers.kind import NumberKind
from lagrange_cli.native.numbers.lanes import LaneEmitter
from lagrange_cli.native.recurrences.batches.gathering import gathered, place_at, places_at
from lagrange_cli.native.recurrences.batches.layout import count
from lagrange_cli.native.recurrences.batches.tables import Tables
from lagrange_cli.native.recurrences.compensated import Compensated
from lagrange_cli.native.recurrences.evaluation import emit_node
from lagrange_cli.series.batches import LONG

LEAF, FIXED = 0, -1
"""The kinds of leaves, and of what does not move."""
FEW = 4


class BatchedValues:
    """The values of ``nodes`` from those of ``leaves``, which are at ``base`` when ``write`` is called.

    What contains none of them is a constant of the motion, or a number. The scratch before ``first`` is that
    of others.
    """

    parts = 1
    """Arrays for each batch."""
    few = FEW
    """Long sums up to which each is summed eight terms at a time, instead of eight sums term by term."""

    def __init__(
        self,
        f: Function,
        leaves: Sequence[Node],
        nodes: Sequence[Node],
        tables: Tables,
        emitter: LaneEmitter | None = None,
        first: int = 0,
    ) -> None:
        self.f, self.tables = f, tables
        self.emitter = emitter or LaneEmitter(f)
        self.arithmetic: NumberKind[Any] = self.emitter
        self.base = f.place("%constants", f.load_integer("@scratch") + first, "double")
        self.moving = 0
        for leaf in leaves:
            self.moving |= leaf.symbols
        self.places = {leaf: place for place, leaf in enumerate(leaves)}
        self.doubles = LANES * count(leaves)
        self.names = Graph()
        inner = reachable(nodes, lambda node: node not in self.places and self.moves(node))
        self.kinds = dict.fromkeys(leaves, LEAF)
        batches = self.batched(inner)
        taken = [*nodes, *(a for node in inner for a in node.arguments)]
        self.fixed = [node for node in dict.fromkeys(taken) if not self.moves(node)]
        self.batches = [self.fixed, *batches] if self.fixed else batches
        for batch in self.batches:
            self.places.update((node, self.doubles + i) for i, node in enumerate(batch))
            self.doubles += LANES * count(batch)
        self.roots = 1 + tables.of_places([self.places[node] for node in nodes])
        self.end = first + self.parts * self.doubles
        """The beginning of the scratch behind them."""
        tables.scratch = max(tables.scratch, self.end)

    def batched(self, nodes: Sequence[Node]) -> list[list[Node]]:
        """Nodes, arguments before users, in batches of one kind."""
        seen: dict[object, int] = {}
        found: list[list[Node]] = []
        rank: dict[Node, int] = {}
        for node in nodes:
            rank[node] = 1 + max(rank.get(a, 0) for a in node.arguments)
            if is_long(node):
                key: object = LONG, rank[node], (len(node.arguments) - 1).bit_length()
            else:
                way = self.arranged(node)
                parts = tuple([(part_key(node, p), self.kind(node.arguments[p])) for p in way])
                key = node.kind, parts, node.data if node.kind in (Kind.FUNCTION, Kind.SWITCH) else None
            number = self.kinds[node] = seen.setdefault(key, len(seen) + 1)
            if number > len(found):
                found.append([])
            found[number - 1].append(node)
        return sorted(found, key=lambda batch: rank[batch[0]])

    def kind(self, node: Node) -> int:
        """The kind of an argument; all that do not move are of one kind."""
        return self.kinds.get(node, FIXED)

    def arranged(self, node: Node) -> Sequence[int]:
        """The places of a node's arguments in an order that is the same for all of its batch."""
        places = range(len(node.arguments))
        if node.kind in (Kind.SUM, Kind.PRODUCT):
            return sorted(places, key=lambda p: (part_key(node, p), self.kind(node.arguments[p])))
        return places

    def moves(self, node: Node) -> bool:
        """Whether it depends on the leaves."""
        return bool(node.symbols & self.moving)

    def root(self, row: Integer) -> Real:
        """The value of node number ``row``."""
        f = self.f
        return f.load(self.base, place_at(f, row + (self.roots - 1)))

    def placed(self, nodes: Mapping[str, Sequence[Node]]) -> Mapping[str, Sequence[int]]:
        """The places of listed nodes."""
        return {name: [self.places[node] for node in listed] for name, listed in nodes.items()}

    def write(self) -> None:
        """Compute all batches."""
        for batch in self.batches:
            self.emitter.repeated = count(batch)
            if batch is not self.fixed and is_long(batch[0]) and len(batch) <= self.few:
                for node in batch:
                    self.add_up(node)
                continue
            with self.f.loop(0, count(batch), tested=False) as b:
                fixed = batch is self.fixed
                self.put(batch, b, self.constant(self.fix(b)) if fixed else self.value(batch, b))

    def fix(self, b: Integer) -> Value:
        """Numbers, and constants of the motion."""
        if all(node.kind is Kind.NUMBER for node in self.fixed):
            return self.numbers([float(node.data) for node in self.fixed], b)
        return gathered(self.emitter, "%constants", self.row(self.tables.of_constants(self.fixed), b))

    def put(self, batch: Sequence[Node], b: Integer, value: Any) -> None:
        """Store the values of the ``b``-th eight of a batch."""
        at = b * LANES + self.places[batch[0]]
        for part, one in zip(self.bases, self.split(value)):
            self.f.store_row(Real(self.f, self.emitter.written(one), LANES), part, at)

    @property
    def bases(self) -> Sequence[Pointer]:
        """Where the arrays begin of each part of the numbers."""
        return (self.base,)

    def split(self, value: Any) -> Sequence[Value]:
        """The parts of a number."""
        return (value,)

    def joined(self, parts: Sequence[Value]) -> Any:
        """The number with these parts; a constant has the first one only."""
        return parts[0]

    def operand(self, row: Sequence[Node], b: Integer) -> Any:
        """The values listed in ``row`` for all members of a batch, for the ``b``-th eight."""
        first, f = row[0], self.f
        if not self.moves(first) and all(node is first for node in row):
            number = first.kind is Kind.NUMBER
            return self.constant(self.emitter.number(first.data) if number else self.slot(first))
        at = self.places[first]
        if all(self.places[node] == at + i for i, node in enumerate(row)):
            return self.joined([f.load_row(base, b * LANES + at, LANES).name for base in self.bases])
        places = self.row(self.tables.of_places([self.places[node] for node in row]), b)
        return self.joined([gathered(self.emitter, base.name, places) for base in self.bases])

    def constant(self, value: Value) -> Any:
        """A constant node as a number of the kind."""
        return None if value is None else self.joined([value, *[None] * (self.parts - 1)])

    def slot(self, node: Node) -> Operand:
        """A constant of the motion, in every lane."""
        return self.emitter.everywhere("%constants", "0", self.tables.constants.slot(node))

    def row(self, table: int, b: Integer) -> Operand:
        """Eight places of a table."""
        return places_at(self.f, b * LANES + table)

    def numbers(self, listed: Sequence[float], b: Integer) -> Operand | None:
        """Numbers of the ``b``-th eight members."""
        if all(one == listed[0] for one in listed):
            return self.emitter.number(listed[0])
        table = self.tables.of_numbers(listed)
        return self.f.load_row(self.f.place("@factors", table, "double"), b * LANES, LANES).name

    def value(self, batch: Sequence[Node], b: Integer) -> Any:
        """The values of the ``b``-th eight of a batch."""
        one = batch[0]
        if is_long(one):
            return self.long_sums(batch, b)
        ways = [self.arranged(node) for node in batch]
        rows = [[node.arguments[way[p]] for node, way in zip(batch, ways)] for p in range(len(one.arguments))]
        operands = [self.operand(row, b) for row in rows]
        if one.kind is Kind.SUM:
            total = self.constant(self.numbers([node.data[0] for node in batch], b))
            for p, operand in enumerate(operands):
                scales = [node.data[1][way[p]] for node, way in zip(batch, ways)]
                if scales[0] == -1 and all(scale == -1 for scale in scales):
                    total = self.arithmetic.sub(total, operand)
                else:
                    total = self.arithmetic.fma(self.constant(self.numbers(scales, b)), operand, total)
            return total
        symbols = tuple(self.names.symbol(str(p)) for p in range(len(operands)))
        data = tuple(one.data[p] for p in ways[0]) if one.kind is Kind.PRODUCT else one.data
        known = dict(zip(symbols, operands))
        return emit_node(self.arithmetic, Node(self.names, one.kind, data, symbols, 0), known.__getitem__)

    def long_sums(self, batch: Sequence[Node], b: Integer) -> Any:
        """Eight long sums, term by term."""
        f, emitter, terms = self.f, self.emitter, max(len(node.arguments) for node in batch)
        filled = [*batch, *[batch[-1]] * (-len(batch) % LANES)]
        blocks = [filled[start : start + LANES] for start in range(0, len(filled), LANES)]
        rows = [
            [node.arguments[min(t, len(node.arguments) - 1)] for node in block]
            for block in blocks
            for t in range(terms)
        ]
        scales = [
            node.data[1][t] if t < len(node.arguments) else 0.0
            for block in blocks
            for t in range(terms)
            for node in block
        ]
        start = self.constant(self.numbers([node.data[0] for node in batch], b))
        parts = self.split(start) if start is not None else [None] * self.parts
        totals = [f.variable(Real(f, emitter.written(one), LANES)) for one in parts]
        listed = [node for row in rows for node in row]
        with f.loop(0, terms, tested=False) as t:
            at = b * terms + t
            factor = self.constant(self.numbers(scales, at))
            value = self.arithmetic.fma(
                factor, self.operand(listed, at), self.joined([one.get().name for one in totals])
            )
            for total, one in zip(totals, self.split(value)):
                total.set(Real(f, emitter.written(one), LANES))
        return self.joined([total.get().name for total in totals])

    def add_up(self, node: Node) -> None:
        """One long sum, eight terms at a time."""
        f, emitter = self.f, self.emitter
        total = f.variable(f.zero(LANES))
        rest = -len(node.arguments) % LANES
        scales = [*node.data[1], *[0.0] * rest]
        listed = [*node.arguments, *[node.arguments[-1]] * rest]
        with f.loop(0, count(listed), tested=False) as b:
            value = emitter.fma(self.numbers(scales, b), self.operand(listed, b), total.get().name)
            total.set(Real(f, emitter.written(value), LANES))
        start = f.constant(float(node.data[0]))
        f.store(f.reduce("fadd", total.get(), start), self.base, self.places[node])


class CarefulValues(BatchedValues):
    """The same with twice as many digits; ``base`` and, ``doubles`` behind it, what the leaves are more."""

    parts, few = 2, 0

    def __init__(
        self, f: Function, leaves: Sequence[Node], nodes: Sequence[Node], tables: Tables, emitter: LaneEmitter
    ) -> None:
        super().__init__(f, leaves, nodes, tables, emitter)
        self.arithmetic = Compensated(emitter)
        self.low = f.place(self.base, self.doubles, "double")

    @property
    def bases(self) -> Sequence[Pointer]:
        return self.base, self.low

    def split(self, value: Any) -> Sequence[Value]:
        return (None, None) if value is None else (value[0], value[1])

    def joined(self, parts: Sequence[Value]) -> Any:
        return parts[0], parts[1]


def is_long(node: Node) -> bool:
    """Whether it is a sum of many terms."""
    return node.kind is Kind.SUM and len(node.arguments) > LONG


def part_key(node: Node, p: int) -> float:
    """What the code of a sum or a product has of the p-th argument: the sign of 1 or -1, or the exponent."""
    if node.kind is Kind.SUM:
        scale = node.data[1][p]
        return float(scale) if scale in (1, -1) else 0.0
    return float(node.data[p]) if node.kind is Kind.PRODUCT else 0.0
