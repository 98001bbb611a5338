"""Sums that are squares: sqrt(1 - sin(u)) has a kink where cos(u/2) = sin(u/2), and no other singularity.

A sum is written as a polynomial in its symbols, in e^(iu/2) for sines and cosines of u, and in e^(u/2) for
exponentials. If it has a square root there, this is found term by term from the leading one, as by long
division. With whole exponents and the rational arithmetic of complex numbers no identity between
trigonometric functions is needed: cos(2u), 1 - 2 sin(u)^2 and cos(u)^2 - sin(u)^2 are one polynomial. Roots
of higher order are found in the same way.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from fractions import Fraction
from types import MappingProxyType
from typing import Any, Generic, TypeAlias, TypeVar

from lagrange_cli.expression.node import Kind, Node, Table, reachable
from lagrange_cli.records import dataclass

MOST_TERMS = 40
"""Longer polynomials are not looked at."""
HIGHEST = 16
"""Nor are higher powers of sums."""
FINEST = 12
"""Frequencies of one angle are multiples of such a part of one of them."""
NOISE, LONG_NOISE = 2.0**-46, Fraction(1, 10**60)
"""What is left of the largest coefficient of doubles, and of fractions, is rounding."""
ABSORBED = 2.0**-20
"""A term that is so small beside others would not be known well."""
TRIGONOMETRIC, EXPONENTIAL = ("sin", "cos", "tan"), ("sinh", "cosh", "tanh", "exp")

ATOM, TURN, GROWTH = range(3)
"""What polynomials are in: a node u itself, e^(iku) or e^(ku), with a unit k."""

Complex: TypeAlias = tuple[Any, Any]
Monomial: TypeAlias = frozenset[tuple[int, int]]
"""Numbers of what it is a product of, with their exponents."""
Polynomial: TypeAlias = dict[Monomial, Complex]


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
    except _TooLarge:
        return None


def _apart(node: Node) -> bool:
    """Whether no two of its terms have a symbol in common, as those of the square of a sum have."""
    seen = 0
    for argument in node.arguments:
        if argument.symbols & seen:
            return False
        seen |= argument.symbols
    return len(node.arguments) > 1


class _TooLarge(Exception):
    """A polynomial that is not looked at."""


M = TypeVar("M")


class _Total(Generic[M]):
    """A sum of terms, which knows how large those were that may have cancelled."""

    def __init__(self, given: Mapping[M, Complex] = MappingProxyType({})) -> None:
        self.values = dict(given)
        self.sizes = {monomial: _size(value) for monomial, value in given.items()}
        self.least = dict(self.sizes)

    def add(self, monomial: M, value: Complex) -> None:
        """Add one term."""
        re, im = self.values.get(monomial, (0, 0))
        self.values[monomial] = (re + value[0], im + value[1])
        size = _size(value)
        self.sizes[monomial] = self.sizes.get(monomial, 0) + size
        self.least[monomial] = min(size or math.inf, self.least.get(monomial, math.inf))

    def absorbs(self) -> bool:
        """Whether a term has hardly been felt beside others, as 1 in 1 + (x - 1e6)**2 when multiplied out."""
        return any(least < ABSORBED * self.sizes[at] for at, least in self.least.items())

    def cleaned(self, noise: Any) -> dict[M, Complex]:
        """The terms but for those that cancel, up to rounding."""
        return {at: value for at, value in self.values.items() if not _size(value) <= noise * self.sizes[at]}


class _Polynomials:
    """Expressions as polynomials."""

    def __init__(self, graph: Table, node: Node) -> None:
        self.graph = graph
        self.numbers: dict[tuple[int, Node], int] = {}
        self.below: dict[int, Polynomial] = {}
        """What denominators are."""
        below = reachable([node])
        exact = any(isinstance(x, Fraction) for one in below for x in _numbers(one))
        self.noise: Any = LONG_NOISE if exact else NOISE
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
                raise _TooLarge
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
            return self._constant(node.data)
        if node.kind is Kind.SUM:
            constant, coefficients = node.data
            total = self._constant(constant)
            for argument, c in zip(node.arguments, coefficients):
                total = self._plus(total, self.made[argument], (c, 0))
            return total
        if node.kind is Kind.PRODUCT:
            whole = self._constant(1)
            for base, exponent in zip(node.arguments, node.data):
                whole = self._times(whole, self._power(base, exponent))
            return whole
        return self._function(str(node.data), node.arguments[0])

    def _constant(self, value: Any) -> Polynomial:
        return {frozenset(): (value, 0)} if value != 0 else {}

    def _power(self, base: Node, exponent: Any) -> Polynomial:
        if not isinstance(exponent, int):
            return self._atom(self.graph.product([(base, exponent)]))
        given = self.made[base]
        if exponent < 0:
            return self._reciprocal(given, base, -exponent)
        return self._raised(given, exponent)

    def _raised(self, given: Polynomial, exponent: int) -> Polynomial:
        if exponent > HIGHEST and len(given) > 1:
            raise _TooLarge
        if len(given) == 1:
            ((monomial, (re, im)),) = given.items()
            if im == 0:
                return {_raised(monomial, exponent): (re**exponent, 0)}
        whole = self._constant(1)
        for _ in range(exponent):
            whole = self._times(whole, given)
        return whole

    def _reciprocal(self, given: Polynomial, base: Node, exponent: int) -> Polynomial:
        if len(given) == 1:
            ((monomial, value),) = given.items()
            return {_raised(monomial, -exponent): _power(_over((1, 0), value), exponent)}
        self.below[self._number(ATOM, base)] = given
        return self._atom(base, -exponent)

    def _function(self, name: str, argument: Node) -> Polynomial:
        if name in ("tan", "tanh"):
            sine, cosine = ("sin", "cos") if name == "tan" else ("sinh", "cosh")
            below = self._function(cosine, argument)
            base = self.graph.function(cosine, (argument,))
            return self._times(self._function(sine, argument), self._reciprocal(below, base, 1))
        kind = TURN if name in TRIGONOMETRIC else GROWTH
        constant, parts = _linear(argument)
        exponents = ((self._number(kind, part), round(c / self.units[kind, part])) for part, c in parts)
        up = frozenset(exponents)
        down = _raised(up, -1)
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

    # ------------------------------------------------------------------ arithmetic

    def _plus(self, one: Polynomial, other: Polynomial, scale: Complex) -> Polynomial:
        total = _Total(one)
        for monomial, value in other.items():
            total.add(monomial, _times(value, scale))
        return self._bounded(total)

    def _times(self, one: Polynomial, other: Polynomial) -> Polynomial:
        if len(one) * len(other) > MOST_TERMS**2:
            raise _TooLarge
        self.graph.work.charge(len(one) * len(other))
        total: _Total[Monomial] = _Total()
        for first, x in one.items():
            for second, y in other.items():
                total.add(_multiplied(first, second), _times(x, y))
        return self._bounded(total)

    def _bounded(self, total: _Total[Monomial]) -> Polynomial:
        found = total.cleaned(self.noise)
        if self.noise is NOISE and total.absorbs():
            raise _TooLarge
        if len(found) > MOST_TERMS or not all(map(_finite, found.values())):
            raise _TooLarge
        return found

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
                given = {_multiplied(one, frozenset({(number, -least)})): x for one, x in given.items()}
        names = sorted({number for monomial in given for number, _ in monomial})
        dense = {tuple(dict(one).get(name, 0) for name in names): value for one, value in given.items()}
        found = _root(dense, self.noise, order)
        if found is None:
            return None
        scale, root = found
        turn = self._turn(root, [nodes[name][0] == TURN for name in names])
        if turn is None:
            return None
        factor, rest = _over(scale, _power(turn, order))
        if not abs(rest) <= self.noise * abs(factor):
            return None
        root = {monomial: _times(value, turn) for monomial, value in root.items()}
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
            total = self._plus(total, self._times(rest, self._raised(below, exponent)), (1, 0))
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
        re, im = _over((re, -im), root[lead])
        return (0, 1) if abs(re + 1) + abs(im) <= self.noise else (1 + re, im)

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
                terms = [one for one in terms if abs(one[1]) > self.noise * max(abs(re), abs(im))]
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
        """That of a function."""
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


def _root(
    given: Mapping[tuple[int, ...], Complex], noise: Any, order: int
) -> tuple[Complex, dict[tuple[int, ...], Complex]] | None:
    """A number and a polynomial with the number times its power of that ``order`` ``given``."""
    lead = max(given)
    if any(e % order for e in lead):
        return None
    first = tuple(e // order for e in lead)
    least = [min(one[k] for one in given) for k in range(len(lead))]
    scale, start = _scale(given[lead]) if order == 2 else (given[lead], (1, 0))
    root, total = {first: start}, _Total(given)
    total.add(lead, (-given[lead][0], -given[lead][1]))
    while rest := total.cleaned(noise):
        place = max(rest)
        monomial = tuple(a - (order - 1) * b for a, b in zip(place, first))
        if any(order * e < low for e, low in zip(monomial, least)) or monomial >= min(root):
            return None
        slope = _power(start, order - 1)
        value = _over(rest[place], _times(scale, (order * slope[0], order * slope[1])))
        lower: Mapping[tuple[int, ...], Complex] = {tuple(0 for _ in lead): (1, 0)}
        for k in range(order):  # (root + value)**order - root**order
            times, factor = math.comb(order, k), _times(scale, _power(value, order - k))
            for one, other in lower.items():
                re, im = _times(factor, other)
                at = tuple(a + (order - k) * b for a, b in zip(one, monomial))
                total.add(at, (-times * re, -times * im))
            if k + 1 < order:
                lower = _product(lower, root) if k else root
        root[monomial] = value
        if len(root) > len(given):
            return None
    return scale, root


def _product(
    one: Mapping[tuple[int, ...], Complex], other: Mapping[tuple[int, ...], Complex]
) -> dict[tuple[int, ...], Complex]:
    """The product of two polynomials."""
    total: _Total[tuple[int, ...]] = _Total()
    for first, x in one.items():
        for second, y in other.items():
            total.add(tuple(a + b for a, b in zip(first, second)), _times(x, y))
    return total.values


def _scale(value: Complex) -> tuple[Complex, Complex]:
    """A leading coefficient as a number and the square of one, which is exact."""
    number, rest = value
    if rest == 0 and number > 0:
        root: Any = math.sqrt(number)
        if isinstance(number, Fraction):
            root = type(number)(math.isqrt(number.numerator), math.isqrt(number.denominator))
        if root * root == number:
            return (1, 0), (root, 0)
    return value, (1, 0)


def _multiplied(one: Monomial, other: Monomial) -> Monomial:
    total = dict(one)
    for generator, exponent in other:
        total[generator] = total.get(generator, 0) + exponent
    return frozenset(item for item in total.items() if item[1])


def _raised(one: Monomial, exponent: int) -> Monomial:
    return frozenset((generator, e * exponent) for generator, e in one if exponent)


def _times(one: Complex, other: Complex) -> Complex:
    (a, b), (c, d) = one, other
    return (a * c - b * d, a * d + b * c)


def _over(one: Complex, other: Complex) -> Complex:
    c, d = other
    if d == 0:
        return (one[0] / c, one[1] / c)
    size = c * c + d * d
    re, im = _times(one, (c, -d))
    return (re / size, im / size)


def _power(one: Complex, exponent: int) -> Complex:
    whole: Complex = (1, 0)
    for _ in range(exponent):
        whole = _times(whole, one)
    return whole


def _size(value: Complex) -> Any:
    return max(abs(value[0]), abs(value[1]))


def _finite(value: Complex) -> bool:
    return all(map(math.isfinite, value))
