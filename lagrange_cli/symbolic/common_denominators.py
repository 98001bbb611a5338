"""Sums of fractions over one denominator, where their numerators cancel or become shorter.

1/D - x^2/D^3 with D = x^2 + y^2 under a root, say, is y^2/D^3.
"""

from __future__ import annotations

import sympy

from lagrange_cli.symbolic.canonical import contract, multiply, to_terms
from lagrange_cli.symbolic.monomials import Monomial, Number, Terms, add_into, combine
from lagrange_cli.symbolic.rings import divided
from lagrange_cli.symbolic.squares import COSINES, in_squares_of


def over_one_denominator(terms: Terms) -> tuple[Terms, Monomial] | None:
    """A numerator and the powers of sums that it is multiplied by; None where the powers of no sum differ by
    whole numbers, or the numerator is much longer. Raises ``TooLargeError``."""
    exponents: dict[sympy.Expr, set[Number]] = {}
    for monomial in terms:
        for base, exponent in monomial:
            if base.is_Add:
                exponents.setdefault(base, set()).add(exponent)
    common: dict[sympy.Expr, Number] = {}
    for base, known in exponents.items():
        everywhere = all(any(base == other for other, _ in monomial) for monomial in terms)
        powers = known if everywhere else {*known, 0}
        least = min(powers)
        if least < 0 and all((e - least).denominator == 1 for e in powers):
            common[base] = least
    if not common:
        return None
    factor = frozenset((base, -e) for base, e in common.items())
    numerator: Terms = {}
    for monomial, coefficient in terms.items():
        left = combine(monomial, factor)
        sums = [(base, e) for base, e in left if base in common]
        product: Terms = {left - frozenset(sums): coefficient}
        for base, exponent in sums:
            for _ in range(int(exponent)):
                product = multiply(product, to_terms(base))
        add_into(numerator, product)
    numerator = in_squares_of(COSINES, numerator)
    for base in sorted(common, key=str):
        numerator, times = divided(numerator, in_squares_of(COSINES, to_terms(base)))
        common[base] += times
    numerator = contract(numerator)
    if len(numerator) > 2 * len(terms):
        return None
    return numerator, frozenset(item for item in common.items() if item[1])
