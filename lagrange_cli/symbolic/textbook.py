"""An equation of motion as textbooks print it."""

from __future__ import annotations

import sympy

from lagrange_cli.symbolic.canonical import contract, to_terms
from lagrange_cli.symbolic.equations import Equation
from lagrange_cli.symbolic.grouping import LONGEST, group
from lagrange_cli.symbolic.monomials import (
    Monomial,
    Number,
    Terms,
    TooLargeError,
    combine,
    common_factor,
    divide,
    term,
)
from lagrange_cli.symbolic.order import Order, Role
from lagrange_cli.symbolic.work import check_size, size_of


def textbook_form(left: sympy.Expr, order: Order) -> Equation:
    """``left = 0`` without common factors that are not zero and common denominators; what does not depend on
    the motion, and forces of constraint, on the right.

    The factor may be divided out although a parameter could be zero: it then makes the mass matrix singular.
    """
    try:
        terms = contract(to_terms(check_size(left)))
    except TooLargeError:
        return Equation(left, sympy.S.Zero, sympy.S.One)
    forms = [divided_by(denominator, terms, order) for denominator in common_denominators(terms, order)]
    form = min(forms, key=length)
    longer = size_of(form.left) > max(LONGEST, size_of(left))
    return Equation(left, sympy.S.Zero, sympy.S.One) if longer else form


def length(form: Equation) -> int:
    """Leaves and operations of both sides."""
    return size_of(form.left) + size_of(form.right)


def divided_by(denominator: Monomial, terms: Terms, order: Order) -> Equation:
    """The equation with both sides, sorted, divided by powers of functions of the coordinates, and by common
    factors of parameters and exponentials of t."""
    content, number = common_factor(terms)
    content = frozenset((base, e) for base, e in content if is_never_zero(base, order))
    content = combine(content, denominator)
    if accelerated := [c for m, c in terms.items() if any(order.role(b) is Role.ACCELERATION for b, _ in m)]:
        number = abs(number) if any(c > 0 for c in accelerated) else -abs(number)
    moving: Terms = {}
    given: Terms = {}
    for monomial, coefficient in divide(terms, content, number).items():
        roles = [order.role(base) for base, _ in monomial]
        if Role.MULTIPLIER not in roles and any(role >= Role.COORDINATE for role in roles):
            moving[monomial] = coefficient
        else:
            given[monomial] = -coefficient
    return Equation(group(moving, order), group(given, order), term(content, number))


def is_never_zero(base: sympy.Expr, order: Order) -> bool:
    """Whether a common factor can be divided out: of parameters, or an exponential of t."""
    role = order.role(base)
    return role is Role.PARAMETER or (role is Role.TIME and base.func is sympy.exp)


def common_denominators(terms: Terms, order: Order) -> list[Monomial]:
    """The denominators that every term has, which are not zero: their lowest powers, and their highest."""
    lowest: dict[sympy.Expr, Number] = {}
    highest: dict[sympy.Expr, Number] = {}
    for base in {base for base, e in next(iter(terms), ()) if e < 0 and order.role(base) > Role.PARAMETER}:
        exponents = [dict(monomial).get(base, 0) for monomial in terms]
        if max(exponents) < 0:
            lowest[base], highest[base] = max(exponents), min(exponents)
    found = [frozenset(lowest.items()), frozenset(highest.items())]
    return found if lowest != highest else found[:1]
