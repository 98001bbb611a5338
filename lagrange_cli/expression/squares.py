"""Sums that are squares: sqrt(1 - sin(u)) has a kink where cos(u/2) = sin(u/2), and no other singularity.

A sum is written as a polynomial in its symbols, in e^(iu/2) for sines and cosines of u, and in e^(u/2) for
exponentials (``polynomials``). It is a square if it has a square root there. With whole exponents and the
rational arithmetic of complex numbers no identity between trigonometric functions is needed: cos(2u),
1 - 2 sin(u)^2 and cos(u)^2 - sin(u)^2 are one polynomial. Roots of higher order are found in the same way.
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
    multiplied,
    over,
    power_of,
    raised,
    root_of,
    times,
)
from lagrange_cli.records import dataclass

FINEST = 12
"""Frequencies of one angle are multiples of such a part of one of them."""
TRIGONOMETRIC, EXPONENTIAL = ("sin", "cos", "tan"), ("sinh", "cosh", "tanh", "exp")

ATOM, TURN, GROWTH = range(3)
"""What polynomials are in: a node u itself, e^(iku) or e^(ku), with a unit k."""


@dataclass(frozen=True)
class Power:
    """``factor`` times the product of ``denominators``, with their exponents, which are multiples of
    ``order``, times ``root`` to that power."""

    order: int
    factor: Node
    root: Node
    denominators: Sequence[tuple[Node, int]] = ()


def square(graph: Table, node: Node) -> Power | None:
    """A sum as a square and what else is its factor, if it is one."""
    found = power(graph, node, 2)
    if found is None or (found.factor.kind is Kind.NUMBER and found.factor.data < 0):
        return None
    return found


def power(graph: Table, node: Node, *orders: int) -> Power | None:
    """A sum as the power of one of these ``orders``, the first that is right, and what else is its factor, if
    it is one."""
    if _apart(node):
        return None
    try:
        made = _Polynomials(graph, node)
        polynomial = made.of(node)
        tried = (made.power(polynomial, order) for order in orders)
        return next((found for found in tried if found is not None), None)
    except TooLarge:
        return None


def _apart(node: Node) -> bool:
    """Whether no two of its terms have a symbol in common, as those of the square of a sum have."""
    seen = 0
    for argument in node.arguments:
        if argument.symbols & seen:
            return False
        seen |= argument.symbols
    return len(node.arguments) > 1


class _Polynomials:
    """Expressions as polynomials."""

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

    # ------------------------------------------------------------------ from nodes

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

    # ------------------------------------------------------------------ the root

    def power(self, given: Polynomial, order: int) -> Power | None:
        """A polynomial as a power and other factors."""
        nodes = [*self.numbers]
        denominators = []
        for number, below in self.below.items():
            least = min((dict(one).get(number, 0) for one in given), default=0)
            if least < 0:
                shift = -least + least % order
                denominators.append((nodes[number][1], -shift))
                given = self._over_one(given, number, shift, below)
        if not given:
            return None
        outside: list[tuple[Node, int]] = []
        for (kind, node), number in self.numbers.items():
            least = min(dict(one).get(number, 0) for one in given)
            if kind == ATOM and least:
                outside.append((node, least))
                given = {multiplied(one, frozenset({(number, -least)})): x for one, x in given.items()}
        names = sorted({number for monomial in given for number, _ in monomial})
        dense = {tuple(dict(one).get(name, 0) for name in names): value for one, value in given.items()}
        found = root_of(dense, self.ring.noise, order)
        if found is None:
            return None
        scale, root = found
        turn = self._turn(root, [nodes[name][0] == TURN for name in names])
        if turn is None:
            return None
        factor, rest = over(scale, power_of(turn, order))
        if not abs(rest) <= self.ring.noise * abs(factor):
            return None
        root = {monomial: times(value, turn) for monomial, value in root.items()}
        size, inner = self.graph.split_coefficient(self._node(root, [nodes[name] for name in names]))
        if inner.kind is Kind.SUM and inner.data[0] == 0 and len(inner.arguments) == 1:
            size, inner = size * inner.data[1][0], inner.arguments[0]
        factor = factor * size**order
        odd = [(node, least % order) for node, least in outside if least % order]
        even = [(node, least // order) for node, least in outside]
        whole = self.graph.product([(inner, 1), *even])
        if whole is self.graph.one and not denominators:
            return None
        return Power(order, factor * self.graph.product(odd), whole, denominators)

    def _over_one(self, given: Polynomial, number: int, shift: int, below: Polynomial) -> Polynomial:
        """A polynomial times ``below``, which has this number, to the power ``shift``."""
        total: Polynomial = {}
        for monomial, value in given.items():
            exponents = dict(monomial)
            exponent = exponents.pop(number, 0) + shift
            rest: Polynomial = {frozenset(exponents.items()): value}
            total = self.ring.plus(total, self.ring.times(rest, self.ring.raised(below, exponent)), (1, 0))
        return total

    def _turn(self, root: Mapping[tuple[int, ...], Complex], turns: Sequence[bool]) -> Complex | None:
        """A number that makes a root real when multiplied with it: e^(iu) of real u is the reciprocal of its
        conjugate."""
        if not any(turns):
            return (1, 0)
        lead = max(root)
        opposite = tuple(-e if turned else e for e, turned in zip(lead, turns))
        if opposite not in root:
            return None
        re, im = root[opposite]
        re, im = over((re, -im), root[lead])
        return (0, 1) if abs(re + 1) + abs(im) <= self.ring.noise else (1 + re, im)

    # ------------------------------------------------------------------ back to nodes

    def _node(self, root: Mapping[tuple[int, ...], Complex], names: Sequence[tuple[int, Node]]) -> Node:
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
