"""Polynomials with complex coefficients, which may be fractions, and their roots."""

from __future__ import annotations

import math
from collections.abc import Mapping
from fractions import Fraction
from types import MappingProxyType
from typing import Any, Generic, TypeAlias, TypeVar

from lagrange_cli.limits import Work

MOST_TERMS = 40
"""Longer polynomials are not examined."""
HIGHEST = 16
"""Nor are higher powers of sums."""
NOISE, LONG_NOISE = 2.0**-46, Fraction(1, 10**60)
"""Coefficients below this fraction of the largest one are rounding errors: of doubles, and of fractions."""
ABSORBED = 2.0**-20
"""A term that is so small beside others would not be known well."""

Complex: TypeAlias = tuple[Any, Any]
Monomial: TypeAlias = frozenset[tuple[int, int]]
"""Numbers of what it is a product of, with their exponents."""
Polynomial: TypeAlias = dict[Monomial, Complex]


class TooLarge(Exception):
    """A polynomial that is not examined."""


M = TypeVar("M")


class Total(Generic[M]):
    """A sum of terms, which knows how large those were that may have cancelled."""

    def __init__(self, given: Mapping[M, Complex] = MappingProxyType({})) -> None:
        self.values = dict(given)
        self.sizes = {monomial: size_of(value) for monomial, value in given.items()}
        self.least = dict(self.sizes)

    def add(self, monomial: M, value: Complex) -> None:
        """Add one term."""
        re, im = self.values.get(monomial, (0, 0))
        self.values[monomial] = (re + value[0], im + value[1])
        size = size_of(value)
        self.sizes[monomial] = self.sizes.get(monomial, 0) + size
        self.least[monomial] = min(size or math.inf, self.least.get(monomial, math.inf))

    def absorbs(self) -> bool:
        """Whether a term is negligible beside others, as 1 in 1 + (x - 1e6)**2 when expanded."""
        return any(least < ABSORBED * self.sizes[at] for at, least in self.least.items())

    def cleaned(self, noise: Any) -> dict[M, Complex]:
        """The terms without those that cancel, up to rounding."""
        return {
            at: value for at, value in self.values.items() if not size_of(value) <= noise * self.sizes[at]
        }


class Arithmetic:
    """Sums and products of polynomials, without what is rounding only; coefficients may be ``exact``.

    Raises ``TooLarge`` where there are too many terms, or one is lost beside others. Products take ``work``.
    """

    def __init__(self, exact: bool, work: Work) -> None:
        self.noise: Any = LONG_NOISE if exact else NOISE
        self._exact, self._work = exact, work

    def constant(self, value: Any) -> Polynomial:
        """A number."""
        return {frozenset(): (value, 0)} if value != 0 else {}

    def plus(self, one: Polynomial, other: Polynomial, scale: Complex) -> Polynomial:
        """The first one and ``scale`` times the other."""
        total = Total(one)
        for monomial, value in other.items():
            total.add(monomial, times(value, scale))
        return self._bounded(total)

    def times(self, one: Polynomial, other: Polynomial) -> Polynomial:
        """Their product."""
        if len(one) * len(other) > MOST_TERMS**2:
            raise TooLarge
        self._work.charge(len(one) * len(other))
        total: Total[Monomial] = Total()
        for first, x in one.items():
            for second, y in other.items():
                total.add(multiplied(first, second), times(x, y))
        return self._bounded(total)

    def raised(self, given: Polynomial, exponent: int) -> Polynomial:
        """A power with an exponent that is not negative."""
        if exponent > HIGHEST and len(given) > 1:
            raise TooLarge
        if len(given) == 1:
            ((monomial, (re, im)),) = given.items()
            if im == 0:
                return {raised(monomial, exponent): (re**exponent, 0)}
        whole = self.constant(1)
        for _ in range(exponent):
            whole = self.times(whole, given)
        return whole

    def _bounded(self, total: Total[Monomial]) -> Polynomial:
        found = total.cleaned(self.noise)
        if not self._exact and total.absorbs():
            raise TooLarge
        if len(found) > MOST_TERMS or not all(math.isfinite(x) for value in found.values() for x in value):
            raise TooLarge
        return found


def root_of(
    given: Mapping[tuple[int, ...], Complex], noise: Any, order: int
) -> tuple[Complex, dict[tuple[int, ...], Complex]] | None:
    """A number and a polynomial with the number times its power of that ``order`` ``given``; None where there
    is none.

    It is found term by term from the leading one, as by long division.
    """
    lead = max(given)
    if any(e % order for e in lead):
        return None
    first = tuple(e // order for e in lead)
    least = [min(one[k] for one in given) for k in range(len(lead))]
    scale, start = scaled_square(given[lead]) if order == 2 else (given[lead], (1, 0))
    root, total = {first: start}, Total(given)
    total.add(lead, (-given[lead][0], -given[lead][1]))
    while rest := total.cleaned(noise):
        place = max(rest)
        monomial = tuple(a - (order - 1) * b for a, b in zip(place, first))
        if any(order * e < low for e, low in zip(monomial, least)) or monomial >= min(root):
            return None
        slope = power_of(start, order - 1)
        value = over(rest[place], times(scale, (order * slope[0], order * slope[1])))
        lower: Mapping[tuple[int, ...], Complex] = {tuple(0 for _ in lead): (1, 0)}
        for k in range(order):  # (root + value)**order - root**order
            count, factor = math.comb(order, k), times(scale, power_of(value, order - k))
            for one, other in lower.items():
                re, im = times(factor, other)
                at = tuple(a + (order - k) * b for a, b in zip(one, monomial))
                total.add(at, (-count * re, -count * im))
            if k + 1 < order:
                lower = product_of(lower, root) if k else root
        root[monomial] = value
        if len(root) > len(given):
            return None
    return scale, root


def product_of(
    one: Mapping[tuple[int, ...], Complex], other: Mapping[tuple[int, ...], Complex]
) -> dict[tuple[int, ...], Complex]:
    """The product of two polynomials."""
    total: Total[tuple[int, ...]] = Total()
    for first, x in one.items():
        for second, y in other.items():
            total.add(tuple(a + b for a, b in zip(first, second)), times(x, y))
    return total.values


def scaled_square(value: Complex) -> tuple[Complex, Complex]:
    """A leading coefficient as a number and the square of one, which is exact."""
    number, rest = value
    if rest == 0 and number > 0:
        root: Any = math.sqrt(number)
        if isinstance(number, Fraction):
            root = type(number)(math.isqrt(number.numerator), math.isqrt(number.denominator))
        if root * root == number:
            return (1, 0), (root, 0)
    return value, (1, 0)


def multiplied(one: Monomial, other: Monomial) -> Monomial:
    total = dict(one)
    for generator, exponent in other:
        total[generator] = total.get(generator, 0) + exponent
    return frozenset(item for item in total.items() if item[1])


def raised(one: Monomial, exponent: int) -> Monomial:
    return frozenset((generator, e * exponent) for generator, e in one if exponent)


def times(one: Complex, other: Complex) -> Complex:
    (a, b), (c, d) = one, other
    return (a * c - b * d, a * d + b * c)


def over(one: Complex, other: Complex) -> Complex:
    c, d = other
    if d == 0:
        return (one[0] / c, one[1] / c)
    size = c * c + d * d
    re, im = times(one, (c, -d))
    return (re / size, im / size)


def power_of(one: Complex, exponent: int) -> Complex:
    whole: Complex = (1, 0)
    for _ in range(exponent):
        whole = times(whole, one)
    return whole


def size_of(value: Complex) -> Any:
    return max(abs(value[0]), abs(value[1]))
