"""Values of expressions in a finite field: numbers modulo a prime.

An identity of functions holds modulo a prime, too, and there nothing is rounded. What does not vanish
identically vanishes at random arguments with a probability of about its degree divided by the prime (J. T.
Schwartz, J. ACM 27, 701, 1980; R. Zippel, EUROSAM 1979). Powers with fractions as exponents are roots modulo
the prime; exp, sin and cos have random values that obey exp(a + b) = exp(a) exp(b). Every other function with
branches is a variable of its own, as in ``expression.zero``: what vanishes then, vanishes on each branch.
"""

from __future__ import annotations

import math
import random
from collections.abc import Callable, Iterable, Mapping, Sequence
from fractions import Fraction
from functools import lru_cache
from typing import Any

from lagrange_cli.expression.node import Kind, Node
from lagrange_cli.expression.written import as_written

SMALL, LARGE = 2**30 - 425, 2**521 - 5553
"""Primes p with p = 3 modulo 4 (square roots are powers) modulo which 2, 3 and 5 have square roots, and p - 1
without the factors 3, 5, 7, 11 and 13 (each number has one root of such a degree)."""
PARTS = 12
"""Values of exp, sin and cos are powers of the value at this fraction of the argument."""
MOST_PARTS = 60
"""Multiples of that part that are recognized."""
ADDED = (1, 2, PARTS, 2 * PARTS)
"""Multiples of two arguments whose sums are recognized."""

BITS, BITS_OF_INVERSES, INVERSES = 100, 20, 3
"""A value takes one step of work for each so many bits of the prime, and an inverse for each so many; sines
and the like take so many inverses."""
ROOTS = 50
"""Roots take the power 3/2 of the number of bits, divided by this."""

NOTHING: Mapping[Node, int] = {}

Element = tuple[int, ...]
Step = tuple[Node, Kind, Sequence[int]]
"""A node, its kind, and the number that it is, or its coefficients and its constant."""


class NoValue(Exception):
    """There is no value at these arguments: a division by 0, or a root that does not exist modulo the
    prime."""


class Residues:
    """The numbers modulo ``prime``, with random values of functions at one state."""

    def __init__(self, prime: int, source: random.Random) -> None:
        self.prime, self.source = prime, source
        self._known: dict[tuple[Any, ...], int] = {}
        self._exponentials: list[tuple[int, Element]] = []
        self._angles: list[tuple[int, Element]] = []

    def again(self) -> Residues:
        """Other random values, except of functions that have values already."""
        other = Residues(self.prime, self.source)
        other._known, other._exponentials = {**self._known}, [*self._exponentials]
        other._angles = [*self._angles]
        return other

    def random(self) -> int:
        """Any number but 0."""
        return self.source.randrange(1, self.prime)

    def number(self, value: Any) -> int:
        """The number that ``value`` was rounded from (see ``written.as_written``)."""
        return residue(value, self.prime)

    def root(self, value: int, degree: int) -> int:
        """A root of ``value``, always the same for the same value."""
        p, key = self.prime, ("root", value % self.prime, degree)
        if key not in self._known:
            left = value % p
            odd = degree // (degree & -degree)
            if odd > 1:
                try:
                    left = pow(left, pow(odd, -1, p - 1), p)
                except ValueError as error:
                    raise NoValue from error
            while degree % 2 == 0:
                left, degree = square_root(left, p), degree // 2
            self._known[key] = left if odd == key[2] or self.source.random() < 0.5 else -left % p
        return self._known[key]

    def power(self, base: int, exponent: float) -> int:
        """``base ** exponent``."""
        if isinstance(exponent, int) or exponent == int(exponent):
            whole, part = int(exponent), Fraction(0)
        else:
            written, root, turns = as_written(abs(exponent))
            if root or turns:
                return self.exponential(self.number(exponent) * self.logarithm(base))
            whole, part = 0, written if exponent > 0 else -written
        if whole >= 0 and not part:
            return pow(base, whole, self.prime)
        if base % self.prime == 0:
            raise NoValue
        if not part:
            return pow(base, whole, self.prime)
        return pow(self.root(base, part.denominator), part.numerator, self.prime)

    def logarithm(self, value: int) -> int:
        """A random number whose exponential is ``value``."""
        new = ("log", value % self.prime) not in self._known
        found = self._variable(("log", value % self.prime))
        if new:
            self._exponentials.append((found, (value % self.prime,)))
        return found

    def exponential(self, argument: int) -> int:
        return self._multiple(self._exponentials, argument, self._multiplied, lambda: (self.random(),))[0]

    def angle(self, argument: int) -> Element:
        """cos and sin of it."""
        return self._multiple(self._angles, argument, self._turned, self._direction)

    def function(self, name: str, arguments: Sequence[int]) -> int:
        """A function's value."""
        p, (x, *_) = self.prime, arguments
        if name == "exp":
            return self.exponential(x)
        if name in ("sin", "cos", "tan"):
            cos, sin = self.angle(x)
            return sin if name == "sin" else cos if name == "cos" else quotient(sin, cos, p)
        if name in ("sinh", "cosh", "tanh"):
            up = self.exponential(x)
            down, half = pow(up, -1, p), (p + 1) // 2
            sinh, cosh = (up - down) * half % p, (up + down) * half % p
            return sinh if name == "sinh" else cosh if name == "cosh" else quotient(sinh, cosh, p)
        if name == "log":
            return self.logarithm(x)
        return self._variable((name, *(argument % p for argument in arguments)))

    def values(self, nodes: Iterable[Node], given: Mapping[str, int]) -> dict[Node, int]:
        """The values of nodes, in an order with arguments first, from the values of symbols; raises
        ``NoValue``."""
        return self.evaluated(self.prepared(nodes), given)

    def prepared(self, nodes: Iterable[Node]) -> list[Step]:
        """The nodes with their numbers modulo the prime, for many ``given``; raises ``NoValue``."""
        found: list[Step] = []
        for node in nodes:
            numbers: Sequence[int] = ()
            if node.kind is Kind.NUMBER:
                numbers = [self.number(node.data)]
            elif node.kind is Kind.SUM:
                numbers = [*map(self.number, node.data[1]), self.number(node.data[0])]
            found.append((node, node.kind, numbers))
        return found

    def evaluated(
        self, steps: Iterable[Step], given: Mapping[str, int], known: Mapping[Node, int] = NOTHING
    ) -> dict[Node, int]:
        """The values of nodes that are ``prepared``, likewise, in addition to ``known`` ones."""
        p, value = self.prime, {**known}
        for node, kind, numbers in steps:
            a = node.arguments
            if kind is Kind.NUMBER:
                (value[node],) = numbers
            elif kind is Kind.SYMBOL:
                value[node] = given[node.data]
            elif kind is Kind.SUM:
                value[node] = (numbers[-1] + sum([c * value[x] for c, x in zip(numbers, a)])) % p
            elif kind is Kind.PRODUCT:
                result = 1
                for x, exponent in zip(a, node.data):
                    result = result * (value[x] if exponent == 1 else self.power(value[x], exponent)) % p
                value[node] = result
            elif kind is Kind.POWER:
                value[node] = self.exponential(value[a[1]] * self.logarithm(value[a[0]]))
            elif kind is Kind.FUNCTION:
                value[node] = self.function(node.data, [value[x] for x in a])
            else:
                raise NoValue
        return value

    def _variable(self, key: tuple[Any, ...]) -> int:
        if key not in self._known:
            self._known[key] = self.random()
        return self._known[key]

    def _direction(self) -> Element:
        """cos and sin of an angle: with random t, (1 - t^2)/(1 + t^2) and 2t/(1 + t^2)."""
        t = self.random()
        below = pow(1 + t * t, -1, self.prime)
        return (1 - t * t) * below, 2 * t * below

    def _multiple(
        self,
        known: list[tuple[int, Element]],
        argument: int,
        combine: Callable[[Element, Element], Element],
        fresh: Callable[[], Element],
    ) -> Element:
        """The element of a group for an argument: a product of known ones, or a power of a ``fresh`` one."""
        p, argument = self.prime, argument % self.prime
        for part, element in known:
            times = argument * pow(part, -1, p) % p
            times -= p * (times > MOST_PARTS)
            if abs(times) <= MOST_PARTS:
                return self._repeated(element, times, combine)
        several = [*known] if len(known) <= PARTS else []
        for i, (part, element) in enumerate(several):
            for times in (sign * n for n in ADDED for sign in (1, -1)):
                rest = (argument - times * part) % p
                for other, second in several[:i]:
                    for again in (sign * n for n in ADDED for sign in (1, -1)):
                        if (rest - again * other) % p == 0:
                            first = self._repeated(element, times, combine)
                            return combine(first, self._repeated(second, again, combine))
        new = fresh()
        if argument == 0:
            return self._repeated(new, 0, combine)
        known.append((argument * pow(PARTS, -1, p) % p, new))
        return self._repeated(new, PARTS, combine)

    def _repeated(
        self, element: Element, times: int, combine: Callable[[Element, Element], Element]
    ) -> Element:
        if len(element) == 1:
            return (pow(element[0], times, self.prime),)
        if times < 0:
            element, times = (element[0], -element[1] % self.prime), -times
        result: Element = (1, 0)
        while times:
            if times % 2:
                result = combine(result, element)
            element, times = combine(element, element), times // 2
        return result

    def _multiplied(self, one: Element, other: Element) -> Element:
        return (one[0] * other[0] % self.prime,)

    def _turned(self, one: Element, other: Element) -> Element:
        (c, s), (a, b) = one, other
        return (c * a - s * b) % self.prime, (s * a + c * b) % self.prime


def effort(nodes: Iterable[Node], prime: int) -> int:
    """The steps of work that the values of nodes take (see ``limits.Work``)."""
    bits, total = prime.bit_length(), 0
    inverse, root = bits // BITS_OF_INVERSES, int(bits**1.5) // ROOTS
    for node in nodes:
        kind = node.kind
        total += 2 + bits // BITS
        if kind is Kind.FUNCTION or kind is Kind.POWER:
            total += INVERSES * inverse
        elif kind is Kind.PRODUCT:
            broken = sum(exponent != int(exponent) for exponent in node.data)
            total += broken * root + sum(exponent < 0 for exponent in node.data) * inverse
    return total


@lru_cache(maxsize=4096)
def residue(value: float | Fraction, p: int) -> int:
    """The number that ``value`` was rounded from, modulo p, with some number in place of pi."""
    if value < 0:
        return -residue(-value, p) % p
    if not isinstance(value, Fraction) and not math.isfinite(value):
        raise NoValue
    if value == int(value):
        return int(value) % p
    fraction, root, turns = as_written(value)
    found = quotient(fraction.numerator, fraction.denominator, p)
    if root:
        found = square_root(found, p)
    return found * pow(random.Random("pi").randrange(1, p), turns, p) % p


def quotient(above: int, below: int, p: int) -> int:
    """The quotient of two numbers modulo p."""
    if below % p == 0:
        raise NoValue
    return above * pow(below, -1, p) % p


def square_root(value: int, p: int) -> int:
    """The one that has a square root itself."""
    root = pow(value, (p + 1) // 4, p)
    if (root * root - value) % p:
        raise NoValue
    return root
