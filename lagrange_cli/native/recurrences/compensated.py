"""Doubles with their rounding errors as a kind of numbers: twice the precision where that is cheap.

Sums and products lose nothing that counts; functions are to first order, with the rounding of a double.
"""

from __future__ import annotations

from typing import TypeAlias

from lagrange_cli.expression.graph import Graph
from lagrange_cli.expression.node import Node
from lagrange_cli.mechanics.residual import Residual
from lagrange_cli.native.linear.blocks import Factorization
from lagrange_cli.native.llvm.text import Operand, Value
from lagrange_cli.native.numbers.double import Emitter
from lagrange_cli.native.numbers.error_free import two_product, two_sum
from lagrange_cli.native.numbers.kind import Number, NumberKind
from lagrange_cli.native.recurrences.cyclic_momenta import cyclic_values
from lagrange_cli.native.recurrences.evaluation import Constants, emit_values
from lagrange_cli.native.recurrences.expansion import Expansion, turning_masses
from lagrange_cli.series.program import SeriesProgram

Sum: TypeAlias = "tuple[Value, Value]"
"""A value is the sum of these two."""


class Compensated(NumberKind[Sum]):
    """Such sums, over the numbers of an ``emitter``."""

    unit = 2.0**-100

    def __init__(self, emitter: Emitter) -> None:
        self.emitter = emitter
        self.one = (emitter.one, None)
        self.true = emitter.true

    def number(self, value: Number) -> Sum | None:
        high = self.emitter.number(value)
        return None if high is None else (high, None)

    def plus(self, a: Sum, b: Sum) -> Sum:
        total, error = two_sum(a[0], b[0], self.emitter)
        return total, self.emitter.add(a[1], self.emitter.add(error, b[1]))

    def minus(self, a: Sum) -> Sum:
        return self.emitter.neg(a[0]), self.emitter.neg(a[1])

    def times(self, a: Sum, b: Sum) -> Sum:
        if self.one in (a, b):
            return b if a == self.one else a
        value, error = two_product(a[0], b[0], self.emitter)
        return value, self.emitter.total([(a[0], b[1]), (a[1], b[0])], error)

    def over(self, a: Sum, b: Sum) -> Sum:
        emitter = self.emitter
        value = emitter.div(a[0], b[0])
        rest: Value = emitter.exact_fma(emitter.neg(value), b[0], a[0])
        rest = emitter.fms(value, b[1], emitter.add(rest, a[1]))
        return value, emitter.div(rest, b[0])

    def function(self, name: str, *arguments: Sum | None) -> Sum:
        emitter, graph = self.emitter, Graph()
        symbols = [graph.symbol(f"argument {i}") for i in range(len(arguments))]
        node = graph.power(*symbols) if name == "pow" else graph.function(name, symbols)
        lows = {graph.diff(node, x): a[1] for x, a in zip(symbols, arguments) if a and a[1] is not None}
        known: dict[Node, Value] = {x: a and a[0] for x, a in zip(symbols, arguments)}
        emit_values(emitter, [node, *lows], known, None)
        return known[node], emitter.total((known[partial], low) for partial, low in lows.items())

    def normalized(self, a: Sum | None) -> Sum | None:
        return a and two_sum(*a, self.emitter)

    def load(self, pointer: str, index: int | str, beyond: int | str = 0) -> Sum:
        place = self.emitter.place(pointer, index)
        return self.emitter.load(place, 0), self.emitter.load(place, beyond) if beyond else None

    def store(self, value: Sum | None, pointer: str, index: int | str, beyond: int | str = 0) -> None:
        place = self.emitter.place(pointer, index)
        for offset, part in zip((0, beyond), value or (None, None)):
            self.emitter.store(part, place, offset)

    def compare(self, relation: str, a: Sum | None, b: Sum | None) -> Operand:
        return self.emitter.compare(relation, a and a[0], b and b[0])

    def both(self, a: Operand, b: Operand) -> Operand:
        return self.emitter.both(a, b)

    def select(self, condition: Operand, yes: Sum | None, no: Sum | None) -> Sum:
        pairs = zip(yes or (None, None), no or (None, None))
        high, low = (self.emitter.select(condition, a, b) for a, b in pairs)
        return high, low


def compensated_expansion(
    emitter: Emitter, residual: Residual, program: SeriesProgram, constants: Constants, width: int, place: int
) -> Expansion[str]:
    """The expansion in doubles of a state with remainders, ``width`` behind its rows. Large blocks of masses
    lie from ``%work[place]`` on."""

    factorization = Factorization(emitter, place)
    expansion = Expansion(residual, program, emitter, constants, factorization, "%t", width)
    expansion.turning = turning_masses(residual)
    series = (*program.coordinates, *program.velocities)
    expansion.remainders = {index: emitter.load("%state", width + row) for row, index in enumerate(series)}
    if residual.cyclic_momenta:
        known: dict[Node, Sum | None] = {residual.model.time: ("%t", None)}
        for row, (symbol, index) in enumerate(zip((*residual.state_q, *residual.state_v), series)):
            known[symbol] = emitter.load("%state", row), expansion.remainders[index]
        kind = Compensated(emitter)
        values, speeds = cyclic_values(kind, residual, program, width, known, constants)
        expansion.cyclic = {node: value and value[0] for node, value in values.items()}
        expansion.remainders.update((index, speed[1]) for index, speed in speeds.items())
    return expansion
