"""From a sum of monomials to textbook form: grouped by accelerations, velocities and multipliers."""

from __future__ import annotations

from collections.abc import Mapping
from fractions import Fraction

import sympy

from lagrange_cli.symbolic.canonical import contract, settled, to_terms
from lagrange_cli.symbolic.monomials import (
    Monomial,
    Terms,
    TooLargeError,
    common_factor,
    degree,
    divide,
    from_terms,
    term,
)
from lagrange_cli.symbolic.order import Order, Role
from lagrange_cli.symbolic.work import charge, check_size, size_of

LONGEST = 5000
"""Terms and factors beyond which an expression is not multiplied out where that makes it longer."""
MOST_FACTORED, HIGHEST_FACTORED = 60, 12
"""Terms and degree of the largest polynomials of parameters that are factored."""
STEPS_TO_FACTOR = 200
"""The largest work for that, for each term and degree."""


def tidy(expression: sympy.Expr, order: Order) -> sympy.Expr:
    """The expression, contracted and grouped; unchanged if that is too much work, or too long to read."""
    check_size(expression)
    try:
        grouped = group(contract(to_terms(expression)), order)
    except TooLargeError:
        return expression
    longer = size_of(grouped) > max(LONGEST, size_of(expression))
    return expression if longer else check_size(grouped)


def neat(expression: sympy.Expr, order: Order, fastest: Role) -> sympy.Expr:
    """As ``tidy``, but powers of sums, as in k*(x - l)**2/2, are not expanded where that is shorter.

    This applies only to terms that depend on nothing faster than ``fastest``: others have to be collected.
    """
    kept = sympy.S.Zero
    others = sympy.S.Zero
    for part in sympy.Add.make_args(check_size(expression)):
        short = with_settled_sums(part)
        if short is None or order.role(part) > fastest or size_of(short) >= size_of(tidy(part, order)):
            others += part
        else:
            kept += short
    return kept + tidy(others, order)


def with_settled_sums(part: sympy.Expr) -> sympy.Expr | None:
    """A product with the sums that it has powers of contracted; None where there are none, or too large."""
    factors = sympy.Mul.make_args(part)
    if not any(is_power_of_sum(factor) for factor in factors):
        return None
    try:
        return sympy.Mul(*(settled(f.base) ** f.exp if is_power_of_sum(f) else f for f in factors))
    except TooLargeError:
        return None


def is_power_of_sum(factor: sympy.Expr) -> bool:
    """Whether a factor is a square or higher power of a sum."""
    return bool(factor.is_Pow and factor.base.is_Add and factor.exp.is_Integer and factor.exp > 1)


def group(terms: Terms, order: Order) -> sympy.Expr:
    """The sum of the terms, collected by their velocities, accelerations and roots."""
    groups: dict[Monomial, Terms] = {}
    for monomial, coefficient in terms.items():
        moving = frozenset(item for item in monomial if is_grouped_by(item, order))
        groups.setdefault(moving, {})[monomial - moving] = coefficient
    return sympy.Add(
        *(
            term(moving) * (factored(inner, order) if moving else collected(inner, order))
            for moving, inner in groups.items()
        )
    )


def is_grouped_by(item: tuple[sympy.Expr, Fraction], order: Order) -> bool:
    """Whether terms are collected by this factor of a monomial: x_dot, theta_ddot, lambda, a distance."""
    base, exponent = item
    if order.is_motion(base) or order.role(base) is Role.MULTIPLIER:
        return exponent > 0
    return bool(base.is_Add) and order.role(base) > Role.PARAMETER


def factored(terms: Terms, order: Order) -> sympy.Expr:
    """The sum as one product: its common factor times the rest."""
    content, number = common_factor(terms)
    number = with_leading_sign(terms, number, order)
    return multiplied(term(content, number), collected(divide(terms, content, number), order))


def collected(terms: Terms, order: Order) -> sympy.Expr:
    """The sum, with the parameters that multiply each function of the coordinates collected."""
    groups: dict[Monomial, Terms] = {}
    for monomial, coefficient in terms.items():
        moving = frozenset(item for item in monomial if order.role(item[0]) > Role.PARAMETER)
        groups.setdefault(moving, {})[monomial - moving] = coefficient
    return sympy.Add(*(times_constant(moving, inner, order) for moving, inner in groups.items()))


def times_constant(moving: Monomial, terms: Terms, order: Order) -> sympy.Expr:
    """A sum of products of parameters, factored, times a function of the coordinates."""
    content, number = common_factor(terms)
    number = with_leading_sign(terms, number, order)
    inner = divide(terms, content, number)
    rest = from_terms(inner)
    mixed = any(exponent > 1 or len(m) > 1 for m in terms for _, exponent in m - content)
    if len(terms) > 2 and mixed and is_factored(inner):
        charge(STEPS_TO_FACTOR * len(inner) * (1 + degree(inner)))
        rest = sympy.factor(rest)  # m2**2 + 2*m2*m3 + m3**2
    return multiplied(term(moving) * term(content, number), rest)


def is_factored(terms: Terms) -> bool:
    """Whether factors of the sum are looked for: of longer or higher polynomials that takes minutes, and
    powers of sums would be expanded first."""
    plain = all(base.is_Symbol or base.is_Function for monomial in terms for base, _ in monomial)
    return plain and len(terms) <= MOST_FACTORED and degree(terms) <= HIGHEST_FACTORED


def with_leading_sign(terms: Mapping[Monomial, Fraction], number: Fraction, order: Order) -> Fraction:
    """The common number with the sign that leaves the first term of the sum positive."""
    first = min(terms, key=lambda monomial: order.term_key(term(monomial)))
    return abs(number) if terms[first] > 0 else -abs(number)


def multiplied(factor: sympy.Expr, expression: sympy.Expr) -> sympy.Expr:
    """The product, without distributing a number over the terms of a sum."""
    if expression.is_Add and factor.is_Number and abs(factor) != 1:
        return sympy.Mul(factor, expression, evaluate=False)
    return factor * expression
