"""The series of one step while their code is written: order 0, the mass matrix, and values for later orders.
For any kind of numbers."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Generic, cast

from lagrange_cli.expression.node import Kind, Node
from lagrange_cli.mechanics.residual import Residual
from lagrange_cli.native.linear.blocks import Factored, Factorization
from lagrange_cli.native.numbers.error_free import two_product, two_sum
from lagrange_cli.native.numbers.kind import Condition, NumberKind, V, Written
from lagrange_cli.native.recurrences.evaluation import (
    Constants,
    add_scaled,
    emit_power,
    emit_switch,
    emit_values,
)
from lagrange_cli.native.recurrences.matrix import factored, solved
from lagrange_cli.records import dataclass, field
from lagrange_cli.series.program import Op, Series, SeriesProgram

MULTIPLIERS = "multipliers_at"
"""The function that gives multipliers at a state, where Newton's method finds them."""


@dataclass
class Expansion(Generic[V]):
    """The series of one step while their code is being written.

    ``table[i][m]`` is coefficient m of series i where it was unrolled. ``time`` is t, and ``width`` the
    number of doubles from the state's numbers to their low parts.
    """

    residual: Residual
    program: SeriesProgram
    kind: NumberKind[V]
    constants: Constants
    factorization: Factorization[V]
    time: V
    width: int
    table: list[dict[int, V | None]] = field(default_factory=list)
    factors: list[Factored[V]] = field(default_factory=list)
    sensitivities: dict[int, tuple[V | None, V | None]] = field(default_factory=dict)
    """For powers p of x: dp/dx, and 1/x."""
    remainders: dict[int, V | None] = field(default_factory=dict)
    """The remainders of q and q_dot, as the compensated update leaves them."""
    cyclic: dict[Node, V | None] = field(default_factory=dict)
    """Constants of a step that contain cyclic momenta."""
    unrounded: dict[Node, V | None] = field(default_factory=dict)
    """Functions of a coordinate before its remainder is added."""
    turning: frozenset[Node] = frozenset()
    """Masses of whose sums every digit counts (see ``turning_masses``)."""
    regular: Condition = None
    found: str = ""
    """The place of multipliers that Newton's method has found."""
    followed: dict[int, int] = field(default_factory=dict)
    """The rows of the state that follow from others, by their series."""

    def __post_init__(self) -> None:
        self.table = [{} for _ in self.program.series]
        self.regular = self.kind.true
        both = self.program.coordinates, self.program.velocities
        for place in self.program.dependent:
            for first, series in zip((0, len(both[0])), both):
                self.followed[series[place]] = first + place

    def constant(self, node: Node) -> V | None:
        """A constant of the step: an expression in parameters and in cyclic momenta."""
        return self.cyclic[node] if node in self.cyclic else self.constants.value(self.kind, node)

    def select(self, one: Series, above: V | None, below: V | None) -> V | None:
        """The weights of the branches of a SELECT series."""
        if above is None and below is None:
            return None
        assert isinstance(one.data, tuple)
        (node, at), kind = one.data, self.kind
        decides = self.table[one.sources[0]][0] if one.sources else self.constant(node)
        if at == 0:
            return emit_switch(kind, at, decides, above, below)
        if at > 0:
            return kind.select(kind.compare("olt", decides, None), below, above)
        return kind.select(kind.compare("ogt", decides, None), above, below)

    def coordinate(self, i: int) -> V:
        """q_i where the step begins."""
        return self.kind.load("%state", i, self.width)

    def velocity(self, i: int) -> V:
        """q_dot_i there."""
        return self.kind.load("%state", i + len(self.program.coordinates), self.width)

    def start(self, index: int) -> V | None:
        """Coefficient 0 of a series that is no derivative."""
        one, kind = self.program.series[index], self.kind
        if index in self.followed:
            return kind.load("%state", self.followed[index], self.width)
        first, low = [self.table[i].get(0) for i in one.arguments], self.remainders
        if one.op is Op.TIME:
            return self.time
        if one.op is Op.COORDINATE:
            assert isinstance(one.data, int)
            return self.coordinate(one.data)
        if one.op is Op.MULTIPLIER:
            return self.multiplier(self.program.multipliers.index(index)) if self.residual.bent else None
        if one.op is Op.LINEAR:
            assert isinstance(one.data, tuple)
            constant, scales = one.data
            lows = [(scale, low.get(index)) for index, scale in zip(one.arguments, scales)]
            values = list(zip(scales, first))
            if self.is_of_masses(one):
                rest: V | None = None
                for scale, value in lows:
                    rest = self.add_scaled(scale, value, rest)
                return self.exactly([(None, rest), *values])
            total: V | None = None
            if not constant.is_zero:  # which a coordinate may all but cancel; low parts would be lost in it
                total, lows, values = self.constant(constant), values, lows
            for scale, value in (*lows, *values):
                total = self.add_scaled(scale, value, total)
            return total
        if one.op is Op.MULTIPLY:
            a, b = one.arguments
            rest = kind.fma(first[0], low.get(b), kind.mul(first[1], low.get(a)))
            return kind.fma(first[0], first[1], rest)
        if one.op is Op.SELECT:
            if any(i in low for i in one.arguments):
                low[index] = self.select(one, *(low.get(i) for i in one.arguments))
            return self.select(one, *first)
        if one.op is Op.POWER:
            return self._start_power(index, one)
        assert one.op is Op.PRIMITIVE
        return None if one.node is None else self._start_function(one, one.node)

    def multiplier(self, i: int) -> V | None:
        """The multiplier of constraint i at the start of the step, if the equations are not linear in it."""
        kind, count = cast("Written[V]", self.kind), len(self.program.multipliers)
        if not self.found:
            place = kind.body.define(f"alloca double, i64 {kind.parts * (count + 1)}, align 8")
            kind.store(self.time, place, kind.parts * count, 1)
            time = kind.body.define(f"getelementptr inbounds double, ptr {place}, i64 {kind.parts * count}")
            given = f"ptr %constants, ptr {time}, ptr %state, ptr {place}, i64 1, i64 1"
            kind.body.line(f"  call void @{MULTIPLIERS}({given})")
            self.found = place
        return kind.load(self.found, i, count)

    def _start_function(self, one: Series, node: Node) -> V | None:
        """A function; one of coordinates alone, to first order in their remainders."""
        kind = self.kind
        moving = [a for a in node.arguments if a.symbols & self.residual.variables]
        values = {a: self.table[i][0] for a, i in zip(moving, one.sources)}
        if not all(i in self.remainders and self.program.series[i].op is not Op.SELECT for i in one.sources):
            name = "pow" if node.kind is Kind.POWER else str(node.data)
            return kind.function(
                name, *(values[a] if a in values else self.constant(a) for a in node.arguments)
            )
        partials = [p for a, p in zip(node.arguments, self.residual.graph.partials(node)) if a in moving]
        self.unrounded.update(values)
        emit_values(kind, [node, *partials], self.unrounded, self.constants)
        value = self.unrounded[node]
        for partial, index in zip(partials, one.sources):
            value = kind.fma(self.unrounded[partial], self.remainders[index], value)
        return value

    def _start_power(self, index: int, one: Series) -> V | None:
        kind, (argument,), power = self.kind, one.arguments, one.data
        assert isinstance(power, Node)
        base, low, exponent = self.table[argument][0], self.remainders.get(argument), self.constant(power)
        if power.kind is Kind.NUMBER:
            value = emit_power(kind, base, power.data)
        else:
            value = kind.function("pow", base, exponent)
        reciprocal = kind.div(kind.one, base)
        if low is not None:
            slope = kind.mul(kind.mul(exponent, value), reciprocal)
            if any(other.op is Op.SELECT for other in self.program.series):  # it may begin at a zero of x
                slope = kind.select(kind.compare("one", base, None), slope, None)
            value = kind.fma(slope, low, value)
        self.sensitivities[index] = kind.mul(kind.mul(exponent, value), reciprocal), reciprocal
        return value

    def factor(self) -> None:
        """The mass matrix at order 0, factored block by block."""
        kind, residual = self.kind, self.residual
        known: dict[Node, V | None] = {}
        for index, one in enumerate(self.program.series):
            if one.node is not None and 0 in self.table[index]:
                known[one.node] = self.table[index][0]
        for velocity, index in zip(residual.state_v, self.program.velocities):
            known[velocity] = self.table[index][0]
        entries = [entry for row in residual.entries for entry in row.values()]
        entries = [*(entry for entry in entries if entry.symbols & residual.variables), *residual.inertias]
        emit_values(kind, entries, known, self.constants)
        for inertia in residual.inertias:
            self.regular = kind.both(self.regular, kind.compare("one", known[inertia], None))
        self.factors, good = factored(residual, self.factorization, known, self.constants)
        self.regular = kind.both(self.regular, good)

    def solved(self, residual: list[V | None], scale: V | None) -> list[V | None]:
        """The accelerations, and the multipliers behind them, that make up for ``scale * residual``."""
        return solved(self.residual, self.factors, residual, scale)

    def linear(
        self, one: Series, values: list[V | None], start: V | None = None, careful: bool = False
    ) -> V | None:
        """``start`` + what the ``values`` of a LINEAR series' operands add to it, as they are known."""
        assert isinstance(one.data, tuple)
        terms = [(None, start), *zip(one.data[1], values)]
        if careful and self.is_of_masses(one):
            return self.exactly(terms)
        total: V | None = None
        for scale, value in sorted(terms, key=lambda term: self.kind.depth(term[1])):
            total = self.kind.add(total, value) if scale is None else self.add_scaled(scale, value, total)
        return total

    def is_of_masses(self, one: Series) -> bool:
        """Whether a LINEAR series is a sum with such masses."""
        assert isinstance(one.data, tuple)
        constant, scales = one.data
        if not self.turning or not self.kind.fused or not constant.is_zero:
            return False
        return not self.turning.isdisjoint(map(without_powers_of_two, scales))

    def exactly(self, terms: Sequence[tuple[Node | None, V | None]]) -> V | None:
        """A sum of products, rounded once or nearly so."""
        kind = self.kind
        total: V | None = None
        rest: V | None = None
        for scale, value in terms:
            product, lost = (value, None) if scale is None else two_product(self.constant(scale), value, kind)
            total, error = two_sum(total, product, kind)
            rest = kind.add(kind.add(rest, lost), error)
        return kind.add(total, rest)

    def add_scaled(self, scale: Node, value: V | None, total: V | None) -> V | None:
        """``total + scale * value``; nothing is loaded for a value of 0."""
        if value is None:
            return total
        if scale.kind is Kind.NUMBER:
            return add_scaled(self.kind, total, value, scale.data)
        return self.kind.fma(self.constant(scale), value, total)


def turning_masses(residual: Residual) -> frozenset[Node]:
    """The masses that stand for the rotation of bodies, but for powers of two.

    Particles' masses are divided out of the equations, these are not. They are often simple numbers but for
    their last digits, as (1.1 + 1.6 - 1.7)/2 is. Then products with them are not rounded up as often as down,
    and the energy would drift.
    """
    masses = [one.mass for one in residual.model.particles if one.body]
    return frozenset(without_powers_of_two(mass) for mass in masses if mass.kind is not Kind.NUMBER)


def without_powers_of_two(node: Node) -> Node:
    """Parameters without a factor that rounds nothing."""
    return node.graph.split_coefficient(node)[1]
