"""Sums that are powers of shorter ones: l^2 + 2 l x + x^2 = (l + x)^2."""

from __future__ import annotations

import sympy

from lagrange_cli.symbolic.monomials import Number, Terms, degree, ratio
from lagrange_cli.symbolic.rings import ring_of
from lagrange_cli.symbolic.work import charge

LARGEST, HIGHEST = 60, 16
"""Terms and degree of the largest sums that are looked at."""
STEPS_TO_SPLIT = 100
"""The largest work for that, for each term and degree."""


def powers(terms: Terms) -> tuple[Number, list[tuple[Terms, int]]] | None:
    """A number and sums with their exponents, some of them above 1, whose product this is; None where there
    are none, or it is no power as a whole. ``terms`` have no common factor."""
    size, highest = len(terms), degree(terms)
    if size > LARGEST or not 2 <= highest <= HIGHEST or not may_be_power(terms):
        return None
    ring = ring_of(terms)
    if ring is None:
        return None
    charge(STEPS_TO_SPLIT * size * (1 + highest))
    number, factors = ring.polynomial(terms).sqf_list()
    if all(exponent == 1 for _, exponent in factors):
        return None
    found: list[tuple[Terms, int]] = []
    for factor, exponent in factors:
        scale, whole = factor.clear_denoms()
        if (number / scale**exponent).denominator == 1:  # (2 a + x)^2, not 4 (a + x/2)^2
            number, factor = number / scale**exponent, whole
        found.append((ring.terms(factor), exponent))
    return ratio(number), found


def may_be_power(terms: Terms) -> bool:
    """Whether the highest powers of all bases, and the first and the last term in a lexicographic order, are
    squares or cubes. Those of a power are: these terms are products of nothing but the first or the last
    terms of its base."""
    highest: dict[sympy.Expr, Number] = {}
    for monomial in terms:
        for base, exponent in monomial:
            highest[base] = max(exponent, highest.get(base, 0))
    possible = [n for n in (2, 3) if all(e % n == 0 for e in highest.values())]
    if not possible:
        return False
    bases = sorted(highest, key=sympy.default_sort_key)
    ordered = sorted(tuple(dict(monomial).get(base, 0) for base in bases) for monomial in terms)
    ends = ordered[0], ordered[-1]
    return any(all(e % n == 0 for one in ends for e in one) for n in possible)
