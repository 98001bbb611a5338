"""Powers of sums of velocities, as in relativity."""

from __future__ import annotations

import sympy

from lagrange_cli.symbolic.common_denominators import over_one_denominator
from lagrange_cli.symbolic.monomials import (
    Monomial,
    Number,
    Terms,
    TooLargeError,
    add_into,
    combine,
    from_terms,
)
from lagrange_cli.symbolic.order import Order, Role
from lagrange_cli.symbolic.work import size_of


def with_shared_speeds(terms: Terms, order: Order) -> Terms:
    """The sum, with different powers of sums of velocities over the lowest of them where that is shorter:
    m v^2/u + m c^2 u = m c^2/u with u = sqrt(1 - v^2/c^2)."""
    parts: dict[Monomial, Terms] = {}
    for monomial, coefficient in terms.items():
        kind = frozenset(
            (base, exponent % 1) if is_power_of_speed((base, exponent), order) else (base, exponent)
            for base, exponent in monomial
            if is_power_of_speed((base, exponent), order) or order.role(base) >= Role.ACCELERATION
        )
        parts.setdefault(kind, {})[monomial] = coefficient
    found: Terms = {}
    for part in parts.values():
        try:
            joined = over_one_denominator(part) if len(part) > 1 else None
        except TooLargeError:  # it would not be shorter
            joined = None
        if joined is not None:
            numerator, denominator = joined
            other = {combine(monomial, denominator): number for monomial, number in numerator.items()}
            part = other if size_of(from_terms(other)) < size_of(from_terms(part)) else part
        add_into(found, part)
    return found


def is_power_of_speed(item: tuple[sympy.Expr, Number], order: Order) -> bool:
    """Whether this factor of a monomial is a power of a sum with velocities, as in relativity."""
    base, exponent = item
    odd = exponent < 0 or exponent.denominator != 1
    return bool(odd and base.is_Add and order.role(base) >= Role.VELOCITY)
