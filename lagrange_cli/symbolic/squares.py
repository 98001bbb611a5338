"""Sums in which of sin^2 and cos^2 only one is left: equal sums are the same then."""

from __future__ import annotations

from collections.abc import Container, Mapping
from typing import Any

import sympy

from lagrange_cli.symbolic.canonical import PARTNERS, contract_by, contract_squares, multiply
from lagrange_cli.symbolic.monomials import (
    ONE,
    Monomial,
    Number,
    Terms,
    add_into,
    combine,
    common_factor,
    divide,
    raised,
)

SINES, COSINES = (sympy.sin, sympy.sinh), (sympy.cos, sympy.cosh)
QUOTIENTS: Mapping[type, tuple[Any, Any]] = {
    sympy.tan: (sympy.sin, sympy.cos),
    sympy.tanh: (sympy.sinh, sympy.cosh),
}


def in_squares_of(kept: tuple[type, ...], terms: Terms) -> Terms:
    """The sum without squares of the partners of those functions: with sin^2 = 1 - cos^2 and sinh^2 =
    cosh^2 - 1, or the other way round."""
    found: Terms = {}
    for monomial, coefficient in terms.items():
        product: Terms = {ONE: coefficient}
        for base, exponent in monomial:
            factor: Terms = {frozenset({(base, exponent)}): 1}
            if is_square_of_partner(kept, base, exponent):
                partner, sign = PARTNERS[type(base)]
                constant = -1 if type(base) is sympy.sinh else 1
                square = {ONE: constant, frozenset({(partner(*base.args), 2)}): -sign}
                factor = {frozenset({(base, 1)}) if exponent % 2 else ONE: 1}
                for _ in range(int(exponent) // 2):
                    factor = multiply(factor, square)
            product = multiply(product, factor)
        add_into(found, product)
    return found


def shortest(terms: Terms) -> Terms:
    """A sum as it is, or with squares of one kind only, contracted again: the shortest. Of high powers
    contraction alone finds no shortest form."""
    content, _ = common_factor(terms)
    given = divide(terms, content)
    found = [given, *other_squares(given)]
    if has(QUOTIENTS, given):
        quotients = without_tangents(given)
        found += [one for one in other_squares(quotients) if len(one) < len(given)]
    return divide(min(found, key=length), raised(content, -1))


def other_squares(terms: Terms) -> list[Terms]:
    """The sum with squares of one kind only, where it has squares of the other, contracted again."""
    return [
        contract_by([contract_squares], in_squares_of(kept, terms))
        for kept in (SINES, COSINES)
        if has([PARTNERS[one][0] for one in kept], terms, 2)
    ]


def length(terms: Terms) -> Number:
    """Signs, terms and factors; a power counts as so many of them, and a minus sign among others as two."""
    negative = sum(c < 0 for c in terms.values())
    factors = sum((abs(e) for monomial in terms for _, e in monomial), 0)
    return len(terms) + factors + 2 * min(negative, len(terms) - negative)


def has(kinds: Container[type], terms: Terms, power: int = 1) -> bool:
    """Whether such a power of some of these functions, or a higher one, is a factor."""
    return any(e >= power and type(base) in kinds for monomial in terms for base, e in monomial)


def without_tangents(terms: Terms) -> Terms:
    """The sum with tan = sin/cos and tanh = sinh/cosh."""
    found: Terms = {}
    for monomial, coefficient in terms.items():
        own: Monomial = ONE
        for base, e in monomial:
            above, below = QUOTIENTS.get(type(base), (None, None))
            parts = {(base, e)} if above is None else {(above(*base.args), e), (below(*base.args), -e)}
            own = combine(own, frozenset(parts))
        add_into(found, {own: coefficient})
    return found


def is_square_of_partner(kept: tuple[type, ...], base: sympy.Expr, exponent: Number) -> bool:
    """Whether a factor is a square, or a higher power, of the partner of one of the functions kept."""
    partner = PARTNERS.get(type(base), (None, 0))[0]
    return partner in kept and exponent.denominator == 1 and exponent >= 2
