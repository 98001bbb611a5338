"""Sums divided by other sums, where nothing is left."""

from __future__ import annotations

from lagrange_cli.symbolic.monomials import Terms, degree
from lagrange_cli.symbolic.rings import ring_of
from lagrange_cli.symbolic.work import charge

LARGEST, HIGHEST = 60, 16
"""Terms and degree of the largest numerators that are looked at."""
STEPS_TO_DIVIDE = 100
"""The largest work for a division, for each term and degree."""


def divided(terms: Terms, divisor: Terms) -> tuple[Terms, int]:
    """The sum divided by another one as often as that divides it, and how often."""
    size, highest = len(terms) + len(divisor), max(degree(terms), degree(divisor))
    ring = ring_of(terms, divisor)
    if ring is None or not terms or size > LARGEST or highest > HIGHEST:
        return terms, 0
    charge(STEPS_TO_DIVIDE * size * (1 + highest))
    left, by = ring.polynomial(terms), ring.polynomial(divisor)
    times = 0
    while times < highest:
        quotient, remainder = divmod(left, by)
        if remainder:
            break
        left, times = quotient, times + 1
    return (ring.terms(left), times) if times else (terms, 0)
