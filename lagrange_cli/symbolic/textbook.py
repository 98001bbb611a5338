"""Energies and equations of motion as textbooks print them."""

from __future__ import annotations

import sympy

from lagrange_cli.symbolic.canonical import contract, settled, to_terms
from lagrange_cli.symbolic.equations import Equation
from lagrange_cli.symbolic.grouping import LONGEST, group, tidy
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


def neat(expression: sympy.Expr, order: Order, fastest: Role) -> sympy.Expr:
    """As ``tidy``, but powers of sums, as in k*(x - l)**2/2, and products of several sums are expanded only
    where that is shorter.

    This applies only to terms that depend on nothing faster than ``fastest``: others have to be collected.
    """
    kept, others = [], []
    for part in sympy.Add.make_args(check_size(expression)):
        short = None if order.role(part) > fastest else short_form(part, order)
        if short is None:
            others.append(part)
        else:
            kept.append(short)
    return sympy.Add(*kept, tidy(sympy.Add(*others), order))


def short_form(part: sympy.Expr, order: Order) -> sympy.Expr | None:
    """A term as a product of sums, or of powers of sums; None where it is none, or is shorter when it is
    expanded. The same ones occur in the potential and in h."""
    short = with_settled_sums(part)
    if short is None:
        return None
    if part not in order.expanded:
        order.expanded[part] = is_shorter(tidy(part, order), short)
    return None if order.expanded[part] else short


def is_shorter(expanded: sympy.Expr, short: sympy.Expr) -> bool:
    """Whether an expanded form is shorter than one with powers of sums, and is not such a power itself, or is
    not longer than a product of sums without powers."""
    before, after = (any(map(is_power_of_sum, sympy.Mul.make_args(one))) for one in (short, expanded))
    return size_of(expanded) < size_of(short) + (not before) and not after


def with_settled_sums(part: sympy.Expr) -> sympy.Expr | None:
    """A product of sums, or of powers of sums, with these contracted; None where there are none, or too
    large."""
    factors = sympy.Mul.make_args(part)
    if not any(map(is_power_of_sum, factors)) and sum(one.is_Add for one in factors) < 2:
        return None
    try:
        return sympy.Mul(*(settled(one) if one.is_Add else with_settled_base(one) for one in factors))
    except TooLargeError:
        return None


def with_settled_base(factor: sympy.Expr) -> sympy.Expr:
    """A factor, if it is a power of a sum with that contracted."""
    return settled(factor.base) ** factor.exp if is_power_of_sum(factor) else factor


def is_power_of_sum(factor: sympy.Expr) -> bool:
    """Whether a factor is a square or higher power of a sum."""
    return bool(factor.is_Pow and factor.base.is_Add and factor.exp.is_Integer and factor.exp > 1)
