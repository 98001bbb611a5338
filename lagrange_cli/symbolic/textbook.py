"""An equation of motion as textbooks print it."""

from __future__ import annotations

import sympy

from lagrange_cli.symbolic.canonical import contract, to_terms
from lagrange_cli.symbolic.equations import Equation
from lagrange_cli.symbolic.grouping import LONGEST, group
from lagrange_cli.symbolic.monomials import Terms, TooLargeError, common_factor, divide, term
from lagrange_cli.symbolic.order import Order, Role
from lagrange_cli.symbolic.work import check_size, size_of


def textbook_form(left: sympy.Expr, order: Order) -> Equation:
    """``left = 0`` without common factors of parameters; what does not depend on the motion, and forces of
    constraint, on the right.

    The factor may be divided out although a parameter could be zero: it then makes the mass matrix singular.
    """
    try:
        terms = contract(to_terms(check_size(left)))
    except TooLargeError:
        return Equation(left, sympy.S.Zero, sympy.S.One)
    content, number = common_factor(terms)
    content = frozenset((base, e) for base, e in content if order.role(base) is Role.PARAMETER)
    if accelerated := [c for m, c in terms.items() if any(order.role(b) is Role.ACCELERATION for b, _ in m)]:
        number = abs(number) if accelerated[0] > 0 else -abs(number)
    terms = divide(terms, content, number)
    moving: Terms = {}
    given: Terms = {}
    for monomial, coefficient in terms.items():
        roles = [order.role(base) for base, _ in monomial]
        if Role.MULTIPLIER not in roles and any(role >= Role.COORDINATE for role in roles):
            moving[monomial] = coefficient
        else:
            given[monomial] = -coefficient
    form = Equation(group(moving, order), group(given, order), term(content, number))
    longer = size_of(form.left) > max(LONGEST, size_of(left))
    return Equation(left, sympy.S.Zero, sympy.S.One) if longer else form
