"""Products of sums, and powers of sums, that stay as they are where that is short: k*(x - l)**2/2."""

from __future__ import annotations

import sympy

from lagrange_cli.symbolic.canonical import settled
from lagrange_cli.symbolic.grouping import tidy
from lagrange_cli.symbolic.monomials import TooLargeError
from lagrange_cli.symbolic.order import Order, Role
from lagrange_cli.symbolic.work import check_size, size_of


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
