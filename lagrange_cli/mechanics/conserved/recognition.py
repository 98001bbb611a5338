"""Coefficients in terms of parameters, recognized from their values modulo a prime.

The values of the parameters are prime numbers. A coefficient is then a fraction of whole numbers, which are
divided by the parameters and by sums of two of them as often as possible, also by moments of inertia such as
A + m*R**2, or A + m*(R**2 + e**2) of few parameters. The quotients have to be small.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from fractions import Fraction
from functools import cached_property
from itertools import combinations, permutations, product

from lagrange_cli.expression.graph import Graph
from lagrange_cli.expression.modular import fraction_of
from lagrange_cli.expression.node import Node
from lagrange_cli.expression.residues import quotient, square_root
from lagrange_cli.records import dataclass

PRIMES = (
    8984771, 19261343, 5376263, 13413637, 16906601, 3198799,
    1441849, 16744829, 9702487, 19481281, 8862877, 7433869,
)  # fmt: skip
"""Values of parameters."""
SMOOTH = 2**8 * 3**4 * 5**2 * 7 * 11 * 13 * 17 * 19 * 23
"""Possible divisors of sums: a + b is even for odd a and b."""
NUMBERS = (1, 2, 3, 4, 8, 9, 16)
"""Numerical coefficients in sums that are recognized."""
SQUARES = (1, 2, 3, 5, 6)
"""Numbers whose roots are recognized."""
MOST_IN_MOMENTS = 6
"""Parameters up to which moments of inertia with two lengths are recognized."""
LARGEST = 10**6
"""Numerators and denominators of numbers."""

POWERS = (0, 1, -1, 2, -2)
"""Exponents of functions of parameters."""

DIVISIONS = 4
"""Divisions that count as one step of work."""

Factor = tuple[tuple[float, tuple[tuple[Node, int], ...]], ...]
"""The terms of a sum: a number, and parameters with their exponents."""
Factored = tuple[Fraction, int, Mapping[Factor, int]]
"""(x, n, exponents): x sqrt(n) times powers of factors."""


@dataclass(frozen=True)
class Recognition:
    """Modulo the prime, and in terms of these ``parameters``."""

    graph: Graph
    parameters: Sequence[Node]
    prime: int

    @property
    def possible(self) -> bool:
        """Whether there are values for all parameters."""
        return len(self.parameters) <= len(PRIMES)

    @cached_property
    def values(self) -> Mapping[str, int]:
        """The values at which coefficients are recognized."""
        return {str(one.data): value for one, value in zip(self.parameters, PRIMES)}

    @cached_property
    def factors(self) -> Mapping[Factor, int]:
        """The parameters, and sums of two terms, with their values."""
        known = dict(zip(self.parameters, PRIMES))
        found: dict[Factor, int] = {((1.0, ((one, 1),)),): value for one, value in known.items()}
        for (one, a), (other, b) in combinations([*known.items(), (self.graph.one, 1)], 2):
            for k in NUMBERS:
                for n in (sign * n for n in NUMBERS if math.gcd(k, n) == 1 for sign in (1, -1)):
                    found[(float(k), ((one, 1),)), (float(n), ((other, 1),))] = k * a + n * b
        for (one, a), (other, b), (size, r) in permutations(known.items(), 3):
            for n in (1, -1):
                found[(1.0, ((one, 1),)), (float(n), ((other, 1), (size, 2)))] = a + n * b * r * r
        few = known.items() if len(known) <= MOST_IN_MOMENTS else ()
        for (one, a), (other, b) in permutations(few, 2):
            for (size, r), (length, s) in combinations(few, 2):
                if not {size, length} & {one, other}:
                    squares = [(1.0, ((other, 1), (x, 2))) for x in (size, length)]
                    moment: Factor = ((1.0, ((one, 1),)), *squares)
                    found[moment] = a + b * (r * r + s * s)
        return found

    @cached_property
    def _roots(self) -> Sequence[tuple[int, int]]:
        """Numbers and their roots."""
        return [(square, square_root(square, self.prime)) for square in SQUARES]

    def _node(self, factor: Factor) -> Node:
        return self.graph.sum([(self.graph.product(powers), number) for number, powers in factor])

    def coefficients(
        self, values: Sequence[int], constants: Mapping[Node, int] | None = None
    ) -> list[Node] | None:
        """The expressions with these values, times one factor that removes denominators; the last one is
        positive. They may contain powers of two of the ``constants``, functions of parameters with their
        values."""
        each, products = list[Factored](), [*self._products(constants or {})]
        for value in values:
            found = next(self._found(value, products), None)
            if found is None:
                return None
            each.append(found)
        factors = dict.fromkeys(factor for _, _, powers in each for factor in powers)
        least = {factor: min(powers.get(factor, 0) for _, _, powers in each) for factor in factors}
        nodes = {one: self._node(one) for one in factors}
        whole = math.lcm(*(number.denominator for number, _, _ in each))
        common = math.gcd(*(int(whole * number) for number, _, _ in each))
        scale = Fraction(whole, common if each[-1][0] > 0 else -common)
        return [
            self.graph.product([(nodes[one], powers.get(one, 0) - least[one]) for one in factors])
            * (float(scale * number) * math.sqrt(square))
            for number, square, powers in each
        ]

    def _products(self, constants: Mapping[Node, int]) -> Iterator[tuple[int, Mapping[Factor, int]]]:
        """Products of powers of one or two constants, simple ones first: their values and exponents."""
        p = self.prime
        given = {((1.0, ((one, 1),)),): value for one, value in constants.items() if value % p}
        for powers in sorted(product(POWERS, repeat=min(len(given), 2)), key=lambda one: sum(map(abs, one))):
            for pair in combinations(given.items(), len(powers)):
                whole = math.prod(pow(value, power, p) for (_, value), power in zip(pair, powers))
                yield whole % p, {factor: power for (factor, _), power in zip(pair, powers) if power}

    def _found(self, value: int, products: Sequence[tuple[int, Mapping[Factor, int]]]) -> Iterator[Factored]:
        """A value as a function of parameters times one of these."""
        for whole, powers in products:
            rest = self._factored(quotient(value, whole, self.prime))
            if rest is not None:
                yield rest[0], rest[1], {**rest[2], **powers}

    def _factored(self, value: int) -> Factored | None:
        p = self.prime
        for square, root in self._roots:
            fraction = fraction_of(quotient(value, root, p), p)
            above, up = self._divided(fraction.numerator * SMOOTH)
            below, down = self._divided(fraction.denominator * SMOOTH)
            number = Fraction(above, below)
            if max(abs(number.numerator), number.denominator) <= LARGEST:
                return number, square, {one: up.get(one, 0) - down.get(one, 0) for one in {**up, **down}}
        return None

    def _divided(self, number: int) -> tuple[int, dict[Factor, int]]:
        """A whole number as a small one times powers of factors."""
        found: dict[Factor, int] = {}
        self.graph.work.charge(len(self.factors) // DIVISIONS)
        for factor, value in self.factors.items():
            if -LARGEST <= number <= LARGEST:
                break
            while abs(number) > LARGEST and number % value == 0:
                number //= value
                found[factor] = found.get(factor, 0) + 1
        return number, found
