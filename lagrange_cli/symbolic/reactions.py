"""Forces of constraint on particles in textbook form: R = m a - F in components of space.

Where the components are a common factor times a direction, as for the tension of a pendulum, they are written
so, and the factor is the size of R except for its sign.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from contextlib import suppress
from math import isqrt

import sympy

from lagrange_cli.expression.symbolic_switches import OfExpressions
from lagrange_cli.expression.vocabulary import COMPONENTS
from lagrange_cli.records import dataclass
from lagrange_cli.symbolic.canonical import contract, multiply, to_terms, without_denominators
from lagrange_cli.symbolic.grouping import multiplied, tidy, with_leading_sign
from lagrange_cli.symbolic.linear import HIGHEST_FRACTION, LARGEST_FRACTION, STEPS_TO_CANCEL, quotient
from lagrange_cli.symbolic.monomials import (
    ONE,
    Monomial,
    Number,
    Terms,
    TooLargeError,
    add_into,
    combine,
    common_factor,
    degree,
    divide,
    raised,
    ratio,
    term,
)
from lagrange_cli.symbolic.order import Order, Role
from lagrange_cli.symbolic.switches import in_one_direction, normal, without_squares
from lagrange_cli.symbolic.work import charge, size_of

LONGEST = 120
"""Terms and factors up to which accelerations are put in, even if that makes a component longer."""


@dataclass(frozen=True)
class Reaction:
    """The force of constraint on a particle. ``size`` is that of its ``components`` or its negative, None
    where it is no simple expression."""

    particle: str
    components: tuple[sympy.Expr, ...]
    size: sympy.Expr | None

    @property
    def symbol(self) -> str:
        """``R_bob``."""
        return f"R_{self.particle}"

    @property
    def names(self) -> tuple[str, ...]:
        """``R_bob_x`` and so on."""
        base, bracket, index = self.particle.partition("[")
        return tuple(f"R_{base}_{axis}{bracket}{index}" for axis, _ in zip(COMPONENTS, self.components))


def reaction(
    particle: str,
    components: Sequence[sympy.Expr],
    known: Sequence[Mapping[sympy.Expr, sympy.Expr]],
    order: Order,
) -> Reaction:
    """The force with these ``components``. The first of the ``known`` accelerations that make it no longer
    than is readable are put in."""
    plain = tuple(tidy(each, order) for each in components)
    for values in known:
        with suppress(TooLargeError):
            fractions = shortest_fractions([each.xreplace(values) for each in plain])
            found = tuple(quotient(above, below, order) for above, below in fractions)
            pairs = zip(found, plain, strict=True)
            if all(size_of(one) <= max(LONGEST, size_of(other)) for one, other in pairs):
                return with_size(particle, fractions, found, order)
    return Reaction(particle, plain, None)


def with_size(
    particle: str, fractions: Sequence[tuple[Terms, Terms]], found: tuple[sympy.Expr, ...], order: Order
) -> Reaction:
    """The force with the components ``found``, which are these ``fractions``; by size and direction where
    that is short."""
    if len(found) < 2:
        return Reaction(particle, found, None)
    try:
        size = size_of_vector(fractions, order)
        if size is not None:
            return directed(particle, fractions, size, order) or Reaction(particle, found, None)
    except TooLargeError:
        pass
    return Reaction(particle, found, None)


def directed(
    particle: str, fractions: Sequence[tuple[Terms, Terms]], size: tuple[Terms, Terms], order: Order
) -> Reaction | None:
    """The components as a factor ``size`` times a direction; None where that is no shorter."""
    whole = quotient(*size, order)
    above, below = size
    parts = [
        quotient(contract(multiply(one, below)), contract(multiply(other, above)), order)
        for one, other in fractions
    ]
    if any(order.role(part) >= Role.VELOCITY for part in parts):
        return None
    return Reaction(particle, tuple(multiplied(part, whole) for part in parts), whole)


def shortest_fractions(expressions: Sequence[sympy.Expr]) -> list[tuple[Terms, Terms]]:
    """The expressions as fractions: as they are written, or with their kinks and jumps in a normal form, if
    that is shorter. Raises ``TooLargeError``."""
    if not any(one.has(OfExpressions) for one in expressions):
        return [as_fraction(one) for one in expressions]
    found = [as_fraction(one) for one in in_one_direction(expressions)]
    for side in (1, -1):
        written = in_one_direction([normal(one, side) for one in expressions])
        others = [(contract(without_squares(one)), other) for one, other in map(as_fraction, written)]
        found = min(found, others, key=complexity)
    return found


def complexity(fractions: Sequence[tuple[Terms, Terms]]) -> tuple[int, int]:
    """How many different kinks and jumps, and how many terms, there are."""
    bases = {base for above, _ in fractions for monomial in above for base, _ in monomial}
    kinks = {kink for base in bases for kink in base.atoms(OfExpressions)}
    return len(kinks) + sum(base.is_Pow for base in bases), sum(len(above) for above, _ in fractions)


def as_fraction(expression: sympy.Expr) -> tuple[Terms, Terms]:
    """Numerator and denominator, both expanded. Raises ``TooLargeError``."""
    terms = contract(to_terms(expression))
    powers: dict[sympy.Expr, Number] = {}
    for monomial in terms:
        for base, exponent in monomial:
            if base.is_Add and exponent < 0 and exponent.denominator == 1:
                powers[base] = max(powers.get(base, 0), -exponent)
    denominator = frozenset(powers.items())
    above: Terms = {}
    for monomial, coefficient in terms.items():
        add_into(above, to_terms(term(combine(monomial, denominator), coefficient)))
    return contract(above), contract(to_terms(term(denominator)))


def size_of_vector(fractions: Sequence[tuple[Terms, Terms]], order: Order) -> tuple[Terms, Terms] | None:
    """Numerator and denominator of the root of the sum of squares; None where that is no such fraction."""
    squares: list[Terms] = []
    below: Terms = {ONE: 1}
    for one, other in fractions:
        squares = [contract(multiply(square, multiply(other, other))) for square in squares]
        squares.append(contract(multiply(multiply(one, one), multiply(below, below))))
        below = contract(multiply(below, other))
    total: Terms = {}
    for square in squares:
        add_into(total, square)
    total = without_denominators(contract(total))
    above = root(total, order) if total else None
    return (above, below) if above else None


def root(terms: Terms, order: Order) -> Terms | None:
    """The root of a sum that is a square, as a polynomial in what it contains; None where it is none."""
    content, number = common_factor(terms)
    polynomial = divide(terms, content, number)
    outside = exact_root(content, number)
    exponents = [e for monomial in polynomial for _, e in monomial]
    if outside is None or any(e.denominator != 1 for e in exponents):
        return None
    if len(polynomial) > LARGEST_FRACTION or degree(polynomial) > HIGHEST_FRACTION:
        return None
    charge(STEPS_TO_CANCEL * len(polynomial) * (1 + degree(polynomial)))
    from sympy.polys.domains import QQ
    from sympy.polys.rings import PolyRing

    bases = sorted({base for monomial in polynomial for base, _ in monomial}, key=str)
    if not bases:
        return outside
    ring = PolyRing([f"x{i}" for i in range(len(bases))], QQ)
    element = ring.from_dict(
        {
            tuple(int(dict(monomial).get(base, 0)) for base in bases): QQ(c.numerator, c.denominator)
            for monomial, c in polynomial.items()
        }
    )
    leading, factors = element.sqf_list()
    rest = exact_root(ONE, ratio(leading))
    if rest is None or any(power % 2 for _, power in factors):
        return None
    product = ring.one
    for factor, power in factors:
        product = product * factor ** (power // 2)
    found: Terms = {
        frozenset((base, e) for base, e in zip(bases, powers, strict=True) if e): ratio(c)
        for powers, c in product.terms()
    }
    whole = multiply(multiply(found, rest), outside)
    return divide(whole, ONE, 1 if with_leading_sign(whole, 1, order) > 0 else -1)


def exact_root(monomial: Monomial, number: Number) -> Terms | None:
    """The root of number times monomial, if it is rational."""
    if number < 0 or any(ratio(e, 2).denominator != 1 for _, e in monomial):
        return None
    above, below = isqrt(number.numerator), isqrt(number.denominator)
    if ratio(above, below) ** 2 != number:
        return None
    return {raised(monomial, ratio(1, 2)): ratio(above, below)}
