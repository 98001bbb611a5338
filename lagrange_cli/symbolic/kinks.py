"""Functions with kinks and jumps in sums of monomials: which factors of a term are equal to others.

max(0, u) where(u > 0, a, b) = max(0, u) a        max(-a, -b) = -min(a, b)
abs(u)**p sign(u) = u abs(u)**(p - 1)             abs(u) = u sign(u)
"""

from __future__ import annotations

from collections.abc import Iterator

import sympy

from lagrange_cli.expression.symbolic_switches import Absolute, Extremum, Sign, Switch
from lagrange_cli.symbolic.monomials import Monomial, Terms
from lagrange_cli.symbolic.work import COUNTER


def replacements(terms: Terms, monomial: Monomial) -> Iterator[tuple[sympy.Expr, sympy.Expr, bool]]:
    """Products of factors of a monomial with what each of them is, and whether this is a better form even if
    it does not make the sum shorter."""
    for base, exponent in monomial:
        if type(base) is Switch and exponent == 1:
            for other, power in monomial:
                branch = base.where_nonzero(other) if power > 0 else None
                if branch is not None:
                    yield base, branch, True
        elif isinstance(base, Extremum) and exponent.denominator == 1:
            other = turned(base)
            if other is not None and occurs(other, terms):
                yield base**exponent, (-other) ** exponent, True
        elif isinstance(base, Absolute) and exponent > 0:
            (u,) = base.args
            sign = Sign(u)
            times = dict(monomial).get(sign, 0)
            if times >= 2:
                yield sign**2, sympy.S.One, True
            elif times == 1 and exponent >= 1:
                yield base * sign, u, False
            elif exponent == 1:
                yield base, u * sign, False


def occurs(factor: sympy.Expr, terms: Terms) -> bool:
    """Whether a factor occurs in a sum; types are compared first, as that takes no time."""
    kind = type(factor)
    return any(type(one) is kind and one == factor for monomial in terms for one, _ in monomial)


def turned(extremum: Extremum) -> sympy.Expr | None:
    """Its opposite where that has fewer minus signs. The same ones occur in many terms."""
    if extremum in COUNTER.turned:
        return COUNTER.turned[extremum]
    other = extremum.opposite
    found = other if minus_signs(extremum) > minus_signs(other) else None
    if COUNTER.work is not None:
        COUNTER.turned[extremum] = found
    return found


def minus_signs(extremum: Extremum) -> tuple[int, str]:
    """How many arguments begin with a minus sign, and what is unique."""
    return sum(one.could_extract_minus_sign() for one in extremum.args), str(extremum)
