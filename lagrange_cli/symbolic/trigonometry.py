"""Trigonometric identities that shorten sums of monomials.

    sin^2 + cos^2 = 1        1 - sin^2 = cos^2        1 - cos^2 = sin^2
    cosh^2 - sinh^2 = 1
    cos a cos b + sin a sin b = cos(a - b)            cos a cos b - sin a sin b = cos(a + b)
    sin a cos b - cos a sin b = sin(a - b)            sin a cos b + cos a sin b = sin(a + b)

Each is applied only where it makes the sum shorter (or as long but of lower degree), so the process ends.
The partner of a term is looked up, not searched for: the work is proportional to the number of terms.
"""

from __future__ import annotations

from collections.abc import Iterator
from fractions import Fraction

import sympy

from lagrange_cli.symbolic.terms import Monomial, Terms, add_into, combine, multiply, to_terms

TWO = Fraction(2)
WAVES = (sympy.sin, sympy.cos)
PARTNERS = {
    sympy.sin: (sympy.cos, 1),
    sympy.cos: (sympy.sin, 1),
    sympy.cosh: (sympy.sinh, -1),
    sympy.sinh: (sympy.cosh, -1),
}
"""f(x)^2 + sign * partner(x)^2 is a constant."""
MOST_WAVES = 8
"""Sines and cosines in one term up to which addition theorems are looked for: there are w**2/2 pairs."""


def contract(terms: Terms) -> Terms:
    """The sum, contracted until no rule shortens it."""
    terms = dict(terms)
    for rule in (contract_squares, contract_angles):
        changed = True
        while changed:
            changed = False
            for monomial in list(terms):
                while monomial in terms and rule(terms, monomial):
                    changed = True
    return terms


def contract_squares(terms: Terms, monomial: Monomial) -> bool:
    """Apply a rule for squares to one term, in place."""
    for base, exponent in monomial:
        if type(base) not in PARTNERS or exponent < TWO:
            continue
        partner_type, sign = PARTNERS[type(base)]
        coefficient = terms[monomial]
        rest = combine(monomial, frozenset({(base, -TWO)}))
        partner = combine(rest, frozenset({(partner_type(*base.args), TWO)}))
        other = terms.get(partner)
        if other is not None and (coefficient < 0) == (sign * other < 0):
            # a f^2 + b g^2 = s (f^2 + sign g^2) + ..., with the smaller coefficient s wholly used up
            shared = min(coefficient, sign * other, key=abs)
            constant = -shared if base.func is sympy.sinh else shared
            add_into(terms, {monomial: -shared, partner: -sign * shared})
            add_into(terms, {rest: constant})
            return True
        if terms.get(rest) == -coefficient and base.func in WAVES:
            add_into(terms, {monomial: -coefficient, rest: coefficient})
            add_into(terms, {partner: -coefficient})
            return True
    return False


def contract_angles(terms: Terms, monomial: Monomial) -> bool:
    """Apply an addition theorem to one term, in place."""
    for first, second in wave_pairs(monomial):
        coefficient = terms[monomial]
        rest = combine(monomial, frozenset({(first, Fraction(-1)), (second, Fraction(-1))}))
        swapped = tuple(PARTNERS[type(base)][0](*base.args) for base in (first, second))
        partner = combine(rest, frozenset({(swapped[0], Fraction(1)), (swapped[1], Fraction(1))}))
        other = terms.get(partner)
        if other is None or abs(other) != abs(coefficient) or partner == monomial:
            continue
        alike = other == coefficient
        factor = coefficient
        a, b = first.args[0], second.args[0]
        if type(first) is type(second):
            wave = sympy.cos(a - b if alike else a + b)
            if type(first) is sympy.sin:
                factor = other
        else:
            if type(first) is sympy.cos:
                a, b = b, a
            wave = sympy.sin(a + b if alike else a - b)
        add_into(terms, {monomial: -coefficient, partner: -other})
        add_into(terms, multiply({rest: factor}, to_terms(wave)))
        return True
    return False


def wave_pairs(monomial: Monomial) -> Iterator[tuple[sympy.Expr, sympy.Expr]]:
    """Pairs of different sines and cosines of different angles in a monomial."""
    waves = [base for base, exponent in monomial if type(base) in WAVES and exponent >= 1]
    if len(waves) > MOST_WAVES:
        return
    waves.sort(key=sympy.default_sort_key)  # a set has no order, but the result must not depend on chance
    for index, first in enumerate(waves):
        for second in waves[index + 1 :]:
            if first.args != second.args:
                yield first, second
