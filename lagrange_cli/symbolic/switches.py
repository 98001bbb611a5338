"""Functions with kinks and jumps in one form, whichever way they are written."""

from __future__ import annotations

from collections.abc import Sequence

import sympy

from lagrange_cli.expression.symbolic_switches import (
    Absolute,
    Extremum,
    Largest,
    Least,
    OfExpressions,
    Sign,
    Switch,
)
from lagrange_cli.symbolic.canonical import contract, to_terms
from lagrange_cli.symbolic.kinks import minus_signs
from lagrange_cli.symbolic.monomials import (
    ONE,
    Terms,
    TooLargeError,
    add_into,
    common_number,
    divide,
    from_terms,
    rational,
    term,
)
from lagrange_cli.symbolic.rings import divided


def in_one_direction(expressions: Sequence[sympy.Expr]) -> list[sympy.Expr]:
    """The expressions with -min(a, b) in place of max(-a, -b), where both are in them."""
    found = set().union(*(one.atoms(Extremum) for one in expressions))
    changes = {
        one: -one.opposite
        for one in found
        if one.opposite in found and minus_signs(one) > minus_signs(one.opposite)
    }
    return [one.xreplace(changes) for one in expressions]


def without_squares(terms: Terms) -> Terms:
    """The sum with u sign(u)**2 = u."""
    signs = {base for monomial in terms for base, power in monomial if isinstance(base, Sign) and power == 2}
    for sign in sorted(signs, key=str):
        square = frozenset({(sign, 2)})
        factor = divide({own: c for own, c in terms.items() if square <= own}, square)
        if divided(factor, to_terms(sign.args[0]))[1]:
            terms = {own: c for own, c in terms.items() if not square <= own}
            add_into(terms, factor)
    return terms


def normal(expression: sympy.Expr, side: int = 1, within: bool = False) -> sympy.Expr:
    """The expression with its kinks and jumps in one form, whichever way they are written: the arguments are
    expanded, without a common number, and of switches only where(u > 0, 1, 0) is left, or where(u > 0, 0, 1)
    if ``side`` is -1. Absolute values are left only ``within`` others. What a switch is at 0 is not kept."""
    if not expression.has(OfExpressions) and not expression.has(sympy.Pow):
        return expression
    base, exponent = to_power(*expression.as_base_exp()).as_base_exp()
    if isinstance(base, Absolute):
        number, u = primitive(normal(base.args[0], side, True))
        return abs(number) ** exponent * (Absolute(u) ** exponent if within else signed_power(u, exponent))
    inside = within or (isinstance(expression, OfExpressions) and not isinstance(expression, Switch))
    arguments = [normal(one, side, inside) for one in expression.args]
    if isinstance(expression, Sign):
        number, u = primitive(arguments[0])
        return sympy.sign(number) * Sign(u)
    if isinstance(expression, Extremum) and len(arguments) == 2 and sympy.S.Zero in arguments:
        number, u = primitive(arguments[0] + arguments[1])
        return abs(number) * expression.func(sympy.S.Zero, sympy.sign(number) * u)
    if isinstance(expression, Extremum):
        one = expression.func(*(from_terms(contract(to_terms(argument))) for argument in arguments))
        turned = isinstance(one, Extremum) and minus_signs(one.opposite) < minus_signs(one)
        return -one.opposite if turned else one
    if not isinstance(expression, Switch):
        return expression.func(*arguments) if arguments else expression
    _, above, below, _ = arguments
    number, u = primitive(normal(expression.args[0], side, True))
    if number < 0:
        above, below = below, above
    found = recognized(u, above, below, 0)
    if isinstance(found, Switch):
        if side > 0:
            return below + (above - below) * Switch(u, sympy.S.One, sympy.S.Zero, sympy.S.Zero)
        return above + (below - above) * Switch(u, sympy.S.Zero, sympy.S.One, sympy.S.Zero)
    return normal(found, side, within)


def to_power(base: sympy.Expr, exponent: sympy.Expr) -> sympy.Expr:
    """(u**2)**p = abs(u)**(2 p), and (-max(-a, -b))**p = min(a, b)**p, where p is not whole."""
    if exponent.is_Rational and not exponent.is_Integer:
        if base.is_Pow and base.exp.is_Integer and base.exp % 2 == 0:
            return Absolute(base.base) ** (base.exp * exponent)
        number, rest = base.as_coeff_Mul()
        if number.is_negative and isinstance(rest, Extremum):
            return (-number * rest.opposite) ** exponent
    return base**exponent


def signed_power(u: sympy.Expr, exponent: sympy.Expr) -> sympy.Expr:
    """abs(u)**p as u**n times a power between 0 and 1, and times sign(u) if n is odd."""
    if not exponent.is_Rational:
        return Absolute(u) ** exponent
    whole = exponent.floor() if exponent > 0 else exponent.ceiling()
    sign = Sign(u) if whole % 2 else 1
    return u**whole * sign * Absolute(u) ** (exponent - whole)


def recognized(u: sympy.Expr, above: sympy.Expr, below: sympy.Expr, at: int) -> sympy.Expr:
    """``above`` where u > 0, ``below`` where u < 0: an absolute value, sign or extremum where it is one, else
    a ``Switch``."""
    slope = multiple(above - below, u)
    if slope:  # both sides meet
        if above == -below:
            return slope / 2 * Absolute(u)
        return (Largest if slope > 0 else Least)(above, below)
    if at == 0 and above == -below:
        return above * Sign(u)
    return Switch(u, above, below, sympy.Integer(at))


def multiple(expression: sympy.Expr, u: sympy.Expr) -> sympy.Rational | None:
    """The number by which u is multiplied to give the expression; None where it is none."""
    try:
        (factor, one), (other, same) = primitive(expression), primitive(u)
    except TooLargeError:
        return None
    return factor / other if one == same and other else None


def primitive(expression: sympy.Expr) -> tuple[sympy.Rational, sympy.Expr]:
    """The expression as a number times another one, expanded, which is the same for all of its multiples."""
    terms = contract(to_terms(expression))
    if not terms:
        return sympy.S.Zero, sympy.S.Zero
    leading = terms[min(terms, key=lambda monomial: str(term(monomial)))]
    terms = divide(terms, ONE, leading)
    number = abs(common_number(terms.values()))
    return rational(leading * number), from_terms(divide(terms, ONE, number))
