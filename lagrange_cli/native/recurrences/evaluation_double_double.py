"""Values of graph nodes as double-double numbers: parameters' constants once a run, anything at one state."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from fractions import Fraction

from lagrange_cli.expression.node import Kind, Node, reachable
from lagrange_cli.native.numbers.double import operand
from lagrange_cli.native.numbers.double_double import DoubleDoubleBody, Pair
from lagrange_cli.native.recurrences.evaluation import Constants


class Values:
    """Computes nodes from ``known`` ones, the symbols among them.

    What no known symbol moves is a constant of the motion, and comes from its place in ``%constants`` if
    there are ``constants``.
    """

    def __init__(
        self, body: DoubleDoubleBody, known: Mapping[Node, Pair], constants: Constants | None
    ) -> None:
        self._body, self._constants = body, constants
        self._known = dict(known)
        self._moving = 0
        for node in known:
            self._moving |= node.symbols if node.kind is Kind.SYMBOL else 0

    def set(self, node: Node, value: Pair) -> None:
        """Make a node known."""
        self._known.setdefault(node, value)
        self._moving |= node.symbols if node.kind is Kind.SYMBOL else 0

    def constant(self, node: Node) -> Pair:
        """A constant of the motion."""
        if node.kind is Kind.NUMBER:
            return self._body.number(node.data)
        assert self._constants is not None
        slots = self._constants.slots
        return self._body.get("%constants", 2 * slots.setdefault(node, len(slots)), 1)

    def fixed(self, node: Node) -> bool:
        """Whether a node is a constant of the motion."""
        return node.kind is Kind.NUMBER or (self._constants is not None and not node.symbols & self._moving)

    def value(self, node: Node) -> Pair:
        """A node's value."""
        if self.fixed(node) and node not in self._known:
            return self.constant(node)
        for inner in reachable([node], lambda n: n not in self._known and not self.fixed(n)):
            self._known[inner] = self._compute(inner)
        return self._known[node]

    def _inner(self, node: Node) -> Pair:
        return self._known[node] if node in self._known else self.constant(node)

    def _compute(self, node: Node) -> Pair:
        arguments = [self._inner(argument) for argument in node.arguments]
        if node.kind is Kind.SUM:
            constant, coefficients = node.data
            total = None if constant == 0 else self._body.number(constant)
            for argument, coefficient in zip(arguments, coefficients):
                total = add_scaled(total, argument, coefficient)
            assert total is not None
            return total
        if node.kind is Kind.PRODUCT:
            return self._product(arguments, node.data)
        if node.kind is Kind.POWER:
            return self._body.function("pow", *arguments)
        if node.kind is Kind.FUNCTION:
            return self._body.function(node.data, *arguments)
        raise ValueError(f"{node.kind} has no value at a single state")

    def _product(self, bases: list[Pair], exponents: Sequence[int | float | Fraction]) -> Pair:
        sides: list[Pair | None] = [None, None]
        for base, exponent in zip(bases, exponents):
            side = int(exponent < 0)
            factor, so_far = power(base, -exponent if exponent < 0 else exponent), sides[side]
            sides[side] = factor if so_far is None else so_far * factor
        above, below = sides
        if below is None:
            assert above is not None
            return above
        return (self._body.number(1) if above is None else above) / below


def power(base: Pair, exponent: int | float | Fraction) -> Pair:
    """``base ** exponent``: by products and square roots where that can be."""
    body = base.body
    if exponent < 0:
        return body.number(1) / power(base, -exponent)
    if exponent == int(exponent) and exponent <= 64:
        count, square, result = int(exponent), base, None
        while count:
            if count & 1:
                result = square if result is None else result * square
            count >>= 1
            if count:
                square = square * square
        return body.number(1) if result is None else result
    if 2 * exponent == int(2 * exponent) and exponent <= 32:
        return power(body.function("sqrt", base), int(2 * exponent))
    return body.function("pow", base, body.number(exponent))


def add_scaled(total: Pair | None, value: Pair, coefficient: float | Fraction) -> Pair:
    """``total + coefficient * value``, without a product for 1 and -1."""
    if total is not None and coefficient == -1:
        return total - value
    scaled = value
    if coefficient == -1:
        scaled = -value
    elif coefficient != 1:
        number = value.body.number(coefficient)
        simple = number.low == operand(None)
        scaled = value.scaled(number.high) if simple else value * number
    return scaled if total is None else total + scaled
