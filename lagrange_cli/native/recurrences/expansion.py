"""The series of one step while their code is written: order 0, the mass matrix, what later orders need
of both."""

from __future__ import annotations

from lagrange_cli.expression.node import Kind, Node
from lagrange_cli.mechanics.residual import Residual
from lagrange_cli.native.linear.blocks import Factored, InMemory, factor_block
from lagrange_cli.native.numbers.double import ONE, Emitter, Value, operand
from lagrange_cli.native.recurrences.convolution import Pair
from lagrange_cli.native.recurrences.cyclic_momenta import cyclic_values
from lagrange_cli.native.recurrences.evaluation import Constants, emit_function, emit_power, emit_values
from lagrange_cli.native.recurrences.layout import Group, Layout
from lagrange_cli.records import dataclass, field
from lagrange_cli.series.program import Op, Series, SeriesProgram


@dataclass
class Expansion:
    """The series of one step while their code is being written.

    ``table[i][m]`` is coefficient m of series i where it was written out.
    """

    residual: Residual
    program: SeriesProgram
    layout: Layout
    constants: Constants
    emitter: Emitter = field(default_factory=Emitter)
    table: list[dict[int, Value]] = field(default_factory=list)
    factors: list[Factored] = field(default_factory=list)
    scratch: int = 0
    """Doubles of ``%work`` behind the layout's own."""
    gains: dict[int, tuple[Value, Value]] = field(default_factory=dict)
    low: dict[int, Value] = field(default_factory=dict)
    """What q and q_dot hold beyond their double, as the compensated update leaves it."""
    cyclic_momenta: dict[Node, Value] = field(default_factory=dict)
    """Expressions that are computed when the step begins."""
    unrounded: dict[Node, Value] = field(default_factory=dict)
    """Functions of a coordinate before its low part is added."""
    regular: str = "true"
    recent: dict[Group, dict[int, Pair]] = field(default_factory=dict)
    """The last vectors of each group in stages that are written out, by their indices."""
    newest: dict[tuple[int, int], Value] = field(default_factory=dict)
    """The last coefficients that were written: by series and by how many stages old."""

    def __post_init__(self) -> None:
        self.table = [{} for _ in self.program.series]
        for kind, indices in enumerate((self.program.coordinates, self.program.velocities)):
            for i, index in enumerate(indices):
                row = kind * len(indices) + i
                self.low[index] = self.emitter.load("%state", self.layout.width + row)
        self.cyclic_momenta = cyclic_values(
            self.residual, self.program, self.layout.width, self.low, self.emitter, self.constants
        )

    def constant(self, node: Node) -> Value:
        """What does not change during a step: an expression in parameters and in cyclic momenta."""
        return (
            self.cyclic_momenta[node]
            if node in self.cyclic_momenta
            else self.constants.value(self.emitter, node)
        )

    def start(self, index: int) -> Value:
        """Coefficient 0 of a series whose operation has a closed form at order 0."""
        one, emitter = self.program.series[index], self.emitter
        if one.op is Op.TIME:
            return "%t"
        if one.op is Op.COORDINATE:
            assert isinstance(one.data, int)
            return emitter.load("%state", one.data)
        if one.op is Op.POWER:
            return self._start_power(index, one)
        assert one.op is Op.PRIMITIVE and one.node is not None
        if all(i in self.low for i in one.sources):
            return self._start_function(one, one.node)
        values = {a: self.table[i][0] for a, i in zip(self._moving(one.node), one.sources)}
        if one.node.kind is Kind.POWER:
            return emitter.call("llvm.pow.f64", *(self._operand(a, values) for a in one.node.arguments))
        return emit_function(
            emitter, str(one.node.data), [self._operand(a, values) for a in one.node.arguments]
        )

    def _start_function(self, one: Series, node: Node) -> Value:
        """A function of coordinates, to first order in what they hold beyond their doubles."""
        emitter, moving = self.emitter, self._moving(node)
        partials = [p for a, p in zip(node.arguments, self.residual.graph.partials(node)) if a in moving]
        for argument, index in zip(moving, one.sources):
            self.unrounded[argument] = self.table[index][0]
        emit_values(emitter, [node, *partials], self.unrounded, self.constants)
        value = self.unrounded[node]
        for partial, index in zip(partials, one.sources):
            value = emitter.fma(self.unrounded[partial], self.low[index], value)
        return value

    def _moving(self, node: Node) -> list[Node]:
        return [a for a in node.arguments if a.symbols & self.residual.variables]

    def _operand(self, node: Node, values: dict[Node, Value]) -> Value:
        return values[node] if node in values else self.constants.value(self.emitter, node)

    def _start_power(self, index: int, one: Series) -> Value:
        emitter, base = self.emitter, self.table[one.arguments[0]][0]
        assert isinstance(one.data, Node)
        exponent = self.constants.value(emitter, one.data)
        if one.data.kind is Kind.NUMBER:
            value = emit_power(emitter, base, one.data.data)
        else:
            value = emitter.call("llvm.pow.f64", base, exponent)
        reciprocal = emitter.div(ONE, base)
        slope = emitter.mul(emitter.mul(exponent, value), reciprocal)
        value = emitter.fma(slope, self.low.get(one.arguments[0]), value)
        self.gains[index] = (emitter.mul(emitter.mul(exponent, value), reciprocal), reciprocal)
        return value

    def factor(self) -> None:
        """The mass matrix at order 0, factored block by block."""
        emitter, residual = self.emitter, self.residual
        model = residual.model
        known: dict[Node, Value] = {}
        for index, one in enumerate(self.program.series):
            if one.node is not None and 0 in self.table[index]:
                known[one.node] = self.table[index][0]
        for i, velocity in enumerate(model.v):
            known[velocity] = self.table[self.program.velocities[i]][0]
        entries = [entry for row in residual.mass_matrix for entry in row if not entry.is_zero]
        entries = [*(entry for entry in entries if entry.symbols & residual.variables), *residual.inertias]
        emit_values(emitter, entries, known, self.constants)
        for inertia in residual.inertias:
            good = emitter.define(f"fcmp one double {operand(known[inertia])}, {operand(None)}")
            self.regular = emitter.define(f"and i1 {self.regular}, {good}")
        for block in residual.blocks:
            matrix: list[list[Value]] = [
                [
                    known[entry]
                    if (entry := residual.mass_matrix[j][k]).symbols & residual.variables
                    else self.constants.value(emitter, entry)
                    for k in block
                ]
                for j in block
            ]
            place = self.layout.doubles + self.scratch
            made, good, doubles = factor_block(emitter, matrix, residual.definite, place)
            self.factors.append(made)
            self.scratch += doubles
            self.regular = emitter.define(f"and i1 {self.regular}, {good}")

    @property
    def strides(self) -> set[int]:
        """Rows, as they lie in memory, of the definite blocks that are too large to be written out."""
        return {one.stride for one in self.factors if isinstance(one, InMemory) and one.kind == "definite"}

    def solved(self, residual: list[Value], scale: Value) -> list[Value]:
        """a with M a = ``scale * residual``."""
        result: list[Value] = [None] * len(residual)
        for block, factor in zip(self.residual.blocks, self.factors):
            right = [residual[j] for j in block]
            if any(value is not None for value in right):
                for j, value in zip(block, factor.solve(self.emitter, right, scale)):
                    result[j] = value
        return result

    def linear(self, one: Series, values: list[Value], start: Value = None) -> Value:
        """``start`` + what the ``values`` of a LINEAR series' operands add to it, as they are known."""
        emitter = self.emitter
        assert isinstance(one.data, tuple)
        terms = [(None, start), *zip(one.data[1], values)]
        total: Value = None
        for scale, value in sorted(terms, key=lambda term: emitter.depth(term[1])):
            total = emitter.add(total, value) if scale is None else self.add_scaled(scale, value, total)
        return total

    def add_scaled(self, scale: Node, value: Value, total: Value) -> Value:
        """``total + scale * value``; nothing is loaded for a value of 0."""
        if value is None:
            return total
        if scale.kind is Kind.NUMBER and scale.data == -1.0:
            return self.emitter.sub(total, value)
        return self.emitter.fma(self.constant(scale), value, total)
