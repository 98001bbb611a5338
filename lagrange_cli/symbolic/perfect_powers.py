"""Sums that are powers of shorter ones: l^2 + 2 l x + x^2 = (l + x)^2."""

from __future__ import annotations

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
    """Whether the first and the last term, in a lexicographic order, are squares or cubes: those of a power
    are, as they are the products of nothing but the first or the last terms of its base."""
    bases = list({base for monomial in terms for base, _ in monomial})
    ordered = sorted(tuple(dict(monomial).get(base, 0) for base in bases) for monomial in terms)
    ends = ordered[0], ordered[-1]
    return any(all(e % n == 0 for one in ends for e in one) for n in (2, 3))
