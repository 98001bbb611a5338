"""Rates of change as products of powers, where that is short: the power of friction, -c (x_dot - y_dot)^2."""

from __future__ import annotations

import sympy

from lagrange_cli.symbolic.canonical import contract, to_terms
from lagrange_cli.symbolic.grouping import in_powers
from lagrange_cli.symbolic.monomials import Terms, TooLargeError, combine, common_factor, divide, term
from lagrange_cli.symbolic.order import Order
from lagrange_cli.symbolic.work import size_of


def compact(plain: sympy.Expr, order: Order) -> sympy.Expr:
    """A sum in textbook form, or as a product if that is shorter."""
    try:
        terms = contract(to_terms(plain))
        found = (rooted(terms), in_powers(terms, order))
    except TooLargeError:
        return plain
    return min((plain, *(one for one in found if one is not None)), key=size_of)


def rooted(terms: Terms) -> sympy.Expr | None:
    """A power of a sum, where the terms are that sum times a root of it: x^2 sqrt(x^2 + y^2) + y^2 sqrt(x^2 +
    y^2) = (x^2 + y^2)^(3/2)."""
    content, number = common_factor(terms)
    rest = divide(terms, content, number)
    for base, exponent in content:
        if base.is_Add and exponent.denominator != 1 and rest == to_terms(base):
            return term(combine(content, frozenset({(base, 1)})), number)
    return None
