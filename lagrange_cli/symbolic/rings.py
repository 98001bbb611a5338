"""Sums of monomials as polynomials in all the bases that they contain."""

from __future__ import annotations

from collections.abc import Sequence
from functools import reduce
from typing import Any

import sympy

from lagrange_cli.records import dataclass
from lagrange_cli.symbolic.monomials import Terms, common_factor, degree, divide, ratio
from lagrange_cli.symbolic.work import charge


@dataclass(frozen=True)
class Ring:
    """Polynomials in ``bases`` with rational coefficients; ``ring`` is sympy's."""

    bases: tuple[sympy.Expr, ...]
    ring: Any

    def polynomial(self, terms: Terms) -> Any:
        """A sum as an element of the ring."""
        rational = self.ring.domain
        return self.ring.from_dict(
            {
                tuple(int(dict(monomial).get(base, 0)) for base in self.bases): rational(
                    c.numerator, c.denominator
                )
                for monomial, c in terms.items()
            }
        )

    def terms(self, element: Any) -> Terms:
        """The sum that an element is."""
        return {
            frozenset((base, e) for base, e in zip(self.bases, powers, strict=True) if e): ratio(c)
            for powers, c in element.terms()
        }


def ring_of(*sums: Terms) -> Ring | None:
    """The ring of some sums, or None where they are no polynomials: of roots, or of negative powers."""
    factors = {item for terms in sums for monomial in terms for item in monomial}
    if not factors or any(e.denominator != 1 or e < 0 for _, e in factors):
        return None
    from sympy.polys.domains import QQ
    from sympy.polys.rings import PolyRing

    bases = sorted({base for base, _ in factors}, key=str)
    return Ring(tuple(bases), PolyRing([f"x{i}" for i in range(len(bases))], QQ))


def without_shared_factor(sums: Sequence[Terms]) -> tuple[Terms, list[Terms]]:
    """The longest sum that divides all of these, which have several terms each, and what they are divided by
    it; none where they share no more than a product."""
    size, highest = sum(map(len, sums)), max(map(degree, sums))
    ring = ring_of(*sums) if size <= LARGEST and highest <= HIGHEST else None
    if ring is None:
        return {}, []
    charge(STEPS_TO_DIVIDE * size * (1 + highest))
    polynomials = [ring.polynomial(terms) for terms in sums]
    shared = reduce(lambda a, b: a.gcd(b), polynomials)
    shared = shared.quo_ground(shared.content()).primitive()[1] if shared else shared
    terms = ring.terms(shared)
    content, _ = common_factor(terms)
    terms = divide(terms, content)
    if len(terms) < 2:
        return {}, []
    divisor = ring.polynomial(terms)
    return terms, [ring.terms(one.exquo(divisor)) for one in polynomials]


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
