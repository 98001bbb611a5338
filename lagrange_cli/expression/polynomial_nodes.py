"""Expressions as polynomials, and back: in their symbols, in e^(iu/2) for sines and cosines of u, and in
e^(u/2) for exponentials.

With whole exponents and the rational arithmetic of complex numbers no identity between trigonometric
functions is needed: cos(2u), 1 - 2 sin(u)^2 and cos(u)^2 - sin(u)^2 are one polynomial.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from fractions import Fraction
from typing import Any

from lagrange_cli.expression.node import Kind, Node, Table, reachable
from lagrange_cli.expression.polynomials import (
    NOISE,
    Arithmetic,
    Complex,
    Polynomial,
    TooLarge,
    over,
    power_of,
    raised,
)

FINEST = 12
"""Frequencies of one angle are multiples of such a part of one of them."""
TRIGONOMETRIC, EXPONENTIAL = ("sin", "cos", "tan"), ("sinh", "cosh", "tanh", "exp")

ATOM, TURN, GROWTH = range(3)
"""What polynomials are in: a node u itself, e^(iku) or e^(ku), with a unit k."""


class PolynomialNodes:
    """The polynomials of a node and of what is below it, over the same numbers: ``numbers`` has which of them
    stands for what."""

    def __init__(self, graph: Table, node: Node) -> None:
        self.graph = graph
        self.numbers: dict[tuple[int, Node], int] = {}
        self.below: dict[int, Polynomial] = {}
        """What denominators are."""
        below = reachable([node])
        exact = any(isinstance(x, Fraction) for one in below for x in _numbers(one))
        self.ring = Arithmetic(exact, graph.work)
        self.units = self._units(below)
        self.made: dict[Node, Polynomial] = {}

    def _units(self, nodes: Sequence[Node]) -> dict[tuple[int, Node], Any]:
        """Of every part of an argument of sines, or exponentials, what its coefficients are multiples of."""
        given: dict[tuple[int, Node], list[Any]] = {}
        for one in nodes:
            kind = _kind(one)
            if kind != ATOM:
                for part, coefficient in _linear(one.arguments[0])[1]:
                    given.setdefault((kind, part), []).append(coefficient)
        found = {}
        for key, coefficients in given.items():
            least = min(map(abs, coefficients))
            for fine in range(1, FINEST + 1):
                unit = least / fine
                if all(abs(c / unit - round(c / unit)) <= NOISE * abs(c / unit) for c in coefficients):
                    found[key] = unit / 2
                    break
            else:
                raise TooLarge
        return found

    def _number(self, kind: int, node: Node) -> int:
        return self.numbers.setdefault((kind, node), len(self.numbers))

    def _atom(self, node: Node, exponent: int = 1) -> Polynomial:
        return {frozenset({(self._number(ATOM, node), exponent)}): (1, 0)}

    def of(self, node: Node) -> Polynomial:
        """The polynomial of a node."""
        for one in reachable([node], lambda inner: inner not in self.made):
            if one.kind in (Kind.SUM, Kind.PRODUCT, Kind.NUMBER) or _kind(one) != ATOM:
                self.made[one] = self._of(one)
            else:
                self.made[one] = self._atom(one)
        return self.made[node]

    def _of(self, node: Node) -> Polynomial:
        if node.kind is Kind.NUMBER:
            return self.ring.constant(node.data)
        if node.kind is Kind.SUM:
            constant, coefficients = node.data
            total = self.ring.constant(constant)
            for argument, c in zip(node.arguments, coefficients):
                total = self.ring.plus(total, self.made[argument], (c, 0))
            return total
        if node.kind is Kind.PRODUCT:
            whole = self.ring.constant(1)
            for base, exponent in zip(node.arguments, node.data):
                whole = self.ring.times(whole, self._power(base, exponent))
            return whole
        return self._function(str(node.data), node.arguments[0])

    def _power(self, base: Node, exponent: Any) -> Polynomial:
        if not isinstance(exponent, int):
            return self._atom(self.graph.product([(base, exponent)]))
        given = self.made[base]
        if exponent < 0:
            return self._reciprocal(given, base, -exponent)
        return self.ring.raised(given, exponent)

    def _reciprocal(self, given: Polynomial, base: Node, exponent: int) -> Polynomial:
        if len(given) == 1:
            ((monomial, value),) = given.items()
            return {raised(monomial, -exponent): power_of(over((1, 0), value), exponent)}
        self.below[self._number(ATOM, base)] = given
        return self._atom(base, -exponent)

    def _function(self, name: str, argument: Node) -> Polynomial:
        if name in ("tan", "tanh"):
            sine, cosine = ("sin", "cos") if name == "tan" else ("sinh", "cosh")
            below = self._function(cosine, argument)
            base = self.graph.function(cosine, (argument,))
            return self.ring.times(self._function(sine, argument), self._reciprocal(below, base, 1))
        kind = TURN if name in TRIGONOMETRIC else GROWTH
        constant, parts = _linear(argument)
        exponents = ((self._number(kind, part), round(c / self.units[kind, part])) for part, c in parts)
        up = frozenset(exponents)
        down = raised(up, -1)
        half = Fraction(1, 2) if isinstance(constant, Fraction) else 0.5
        if kind == TURN:
            cosine, sine = self._values(("cos", "sin"), constant)
            if name == "cos":
                return {up: (half * cosine, half * sine), down: (half * cosine, -half * sine)}
            return {up: (half * sine, -half * cosine), down: (half * sine, half * cosine)}
        if name == "exp":
            return {up: (self._values(("exp",), constant)[0], 0)}
        first, last = self._values(("exp",), constant)[0], self._values(("exp",), -constant)[0]
        return {up: (half * first, 0), down: ((half if name == "cosh" else -half) * last, 0)}

    def _values(self, names: Sequence[str], constant: Any) -> list[Any]:
        return [self.graph.function(name, (self.graph.lift(constant),)).data for name in names]

    def node(self, root: Mapping[tuple[int, ...], Complex], names: Sequence[tuple[int, Node]]) -> Node:
        """The node of a polynomial that is real."""
        graph = self.graph
        grouped: dict[tuple[tuple[int, ...], tuple[int, ...]], list[tuple[Node, Any]]] = {}
        for monomial, (re, im) in root.items():
            atoms, turn, growth = (
                tuple(e if kind == one else 0 for e, (one, _) in zip(monomial, names))
                for kind in (ATOM, TURN, GROWTH)
            )
            terms = [(graph.one, re)]
            if any(turn):  # twice the real part, since that of -turn is its conjugate
                angle = self._argument(turn, names)
                terms = [
                    (graph.function("cos", (angle,)), 2 * re),
                    (graph.function("sin", (angle,)), -2 * im),
                ]
                terms = [one for one in terms if abs(one[1]) > self.ring.noise * max(abs(re), abs(im))]
            if turn >= tuple(-e for e in turn):
                grouped.setdefault((atoms, growth), []).extend(terms)
        sums = {key: graph.sum(terms) for key, terms in grouped.items()}
        total: list[tuple[Node, Any]] = []
        for (atoms, growth), inner in sums.items():
            against = tuple(-e for e in growth)
            other, factor = sums.get((atoms, against)), graph.one
            if any(growth) and other is not None and (other is inner or other is -inner):
                if growth < against:
                    continue
                name = "cosh" if other is inner else "sinh"
                factor = 2 * graph.function(name, (self._argument(growth, names),))
            elif any(growth):
                factor = graph.function("exp", (self._argument(growth, names),))
            powers = [(node, e) for e, (_, node) in zip(atoms, names)]
            total.append((graph.product([(inner, 1), (factor, 1), *powers]), 1))
        return graph.sum(total)

    def _argument(self, exponents: Sequence[int], names: Sequence[tuple[int, Node]]) -> Node:
        """The argument of a function."""
        return self.graph.sum([(key[1], e * self.units[key]) for e, key in zip(exponents, names) if e])


def _kind(node: Node) -> int:
    """Whether it is a function that turns, or one that grows, or neither."""
    if node.kind is not Kind.FUNCTION:
        return ATOM
    return TURN if node.data in TRIGONOMETRIC else GROWTH if node.data in EXPONENTIAL else ATOM


def _linear(argument: Node) -> tuple[Any, list[tuple[Node, Any]]]:
    """An argument as a constant and multiples of nodes."""
    if argument.kind is Kind.SUM:
        constant, coefficients = argument.data
        return constant, [*zip(argument.arguments, coefficients)]
    if argument.kind is Kind.NUMBER:
        return argument.data, []
    return 0.0, [(argument, 1)]


def _numbers(node: Node) -> Iterator[Any]:
    """The numbers in a node."""
    if node.kind is Kind.NUMBER:
        yield node.data
    if node.kind is Kind.SUM:
        yield node.data[0]
        yield from node.data[1]
