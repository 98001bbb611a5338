"""Code for values in twice the precision: a double and what is left over.

Sums and products by transformations without rounding (Dekker, Numerische Mathematik 18, 1971; Knuth, TAOCP 2,
sec. 4.2.2); functions and other powers of such values to first order, with the rounding of a double.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import TypeAlias

from lagrange_cli.expression.graph import Graph
from lagrange_cli.expression.node import Kind, Node, reachable
from lagrange_cli.native.numbers.double import ONE, Emitter, Value, literal
from lagrange_cli.native.recurrences.evaluation import Constants, emit_node, emit_power, emit_values

Compensated: TypeAlias = "tuple[Value, Value]"
"""A value is the sum of these two."""


class Compensation:
    """Computes nodes from ``known`` ones, the symbols that are no constants of the motion among them."""

    def __init__(
        self, graph: Graph, emitter: Emitter, constants: Constants, known: Mapping[Node, Compensated]
    ) -> None:
        self._graph, self._emitter, self._constants = graph, emitter, constants
        self._known = dict(known)

    def set(self, symbol: Node, value: Compensated) -> None:
        """Make a symbol known."""
        self._known[symbol] = value

    def value(self, node: Node) -> Compensated:
        """A node's value, its first part the double nearest to it."""
        moving = 0
        for symbol in self._known:
            moving |= symbol.symbols if symbol.kind is Kind.SYMBOL else 0
        for inner in reachable([node], lambda n: n not in self._known):
            if not inner.symbols & moving:
                self._known[inner] = self._constants.value(self._emitter, inner), None
            elif inner.kind is Kind.SUM:
                self._known[inner] = self._sum(inner)
            elif inner.kind is Kind.PRODUCT:
                self._known[inner] = self._product(inner)
            else:
                self._known[inner] = self._function(inner)
        high, low = self._known[node]
        return self._exact_sum(high, low)

    def _sum(self, node: Node) -> Compensated:
        constant, coefficients = node.data
        total: Value = literal(constant)
        rest: Value = None
        for argument, coefficient in zip(node.arguments, coefficients):
            high, low = self._multiply(self._known[argument], (literal(coefficient), None))
            total, error = self._exact_sum(total, high)
            rest = self._emitter.add(rest, self._emitter.add(error, low))
        return total, rest

    def _product(self, node: Node) -> Compensated:
        above: Compensated = (ONE, None)
        below: Compensated = (ONE, None)
        for argument, exponent in zip(node.arguments, node.data):
            base = self._known[argument]
            if not isinstance(exponent, int):
                above = self._multiply(above, self._power(base, exponent))
                continue
            for _ in range(abs(exponent)):
                if exponent > 0:
                    above = self._multiply(above, base)
                else:
                    below = self._multiply(below, base)
        return above if below[0] == ONE else self._divide(above, below)

    def _power(self, base: Compensated, exponent: float) -> Compensated:
        emitter = self._emitter
        value = emit_power(emitter, base[0], exponent)
        slope = emitter.div(emitter.mul(literal(exponent), value), base[0])
        return value, emitter.mul(slope, base[1])

    def _function(self, node: Node) -> Compensated:
        emitter = self._emitter
        high = {inner: value for inner, (value, _) in self._known.items()}
        value = emit_node(emitter, node, high.__getitem__)
        partials = self._graph.partials(node)
        emit_values(emitter, list(partials), high, self._constants)
        lows = (self._known[argument][1] for argument in node.arguments)
        return value, emitter.total(zip((high[partial] for partial in partials), lows))

    def _multiply(self, a: Compensated, b: Compensated) -> Compensated:
        if a == (ONE, None) or b == (ONE, None):
            return b if a == (ONE, None) else a
        emitter = self._emitter
        value = emitter.mul(a[0], b[0])
        error: Value = None
        if value is not None:
            error = emitter.call("llvm.fma.f64", a[0], b[0], emitter.neg(value))
        return value, emitter.total([(a[0], b[1]), (a[1], b[0])], error)

    def _divide(self, a: Compensated, b: Compensated) -> Compensated:
        emitter = self._emitter
        value = emitter.div(a[0], b[0])
        rest: Value = emitter.call("llvm.fma.f64", emitter.neg(value), b[0], a[0])
        rest = emitter.fms(value, b[1], emitter.add(rest, a[1]))
        return value, emitter.div(rest, b[0])

    def _exact_sum(self, a: Value, b: Value) -> Compensated:
        if a is None or b is None:
            return (b if a is None else a), None
        emitter = self._emitter
        total = emitter.add(a, b)
        back = emitter.sub(total, a)
        return total, emitter.add(emitter.sub(a, emitter.sub(total, back)), emitter.sub(b, back))
