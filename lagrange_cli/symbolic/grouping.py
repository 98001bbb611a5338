"""From a sum of monomials to textbook form: grouped by accelerations, velocities and multipliers."""

from __future__ import annotations

import math

import sympy

from lagrange_cli.symbolic.canonical import contract, to_terms
from lagrange_cli.symbolic.monomials import (
    ONE,
    Monomial,
    Number,
    Terms,
    TooLargeError,
    combine,
    common_factor,
    degree,
    divide,
    from_terms,
    is_decimal,
    term,
)
from lagrange_cli.symbolic.order import Order, Role
from lagrange_cli.symbolic.work import COUNTER, attempt, charge, check_size, size_of

LONGEST = 5000
"""Terms and factors beyond which an expression is not multiplied out where that makes it longer."""
MOST_WORK = 2_000_000
"""The largest work for grouping one expression: what takes more becomes longer, or no easier to read."""
FEWEST_IN_POWER = 3
"""Terms of the square of a sum, at least."""
MOST_FACTORED, HIGHEST_FACTORED = 60, 12
"""Terms and degree of the largest polynomials of parameters that are factored."""
STEPS_TO_FACTOR = 200
"""The largest work for that, for each term and degree."""


def tidy(expression: sympy.Expr, order: Order) -> sympy.Expr:
    """The expression, contracted and grouped; unchanged if that is too much work, or too long to read."""
    check_size(expression)
    try:
        grouped = attempt(MOST_WORK, lambda: group(contract(to_terms(expression)), order))
    except TooLargeError:
        return expression
    if grouped is None:
        return expression
    longer = size_of(grouped) > max(LONGEST, size_of(expression))
    return expression if longer else check_size(grouped)


def group(terms: Terms, order: Order, longest: float = math.inf) -> sympy.Expr:
    """The sum of the terms, collected by their velocities, accelerations and roots. Raises ``TooLargeError``
    as soon as its parts have more terms and factors than ``longest``."""
    if any(base.is_Add and order.role(base) >= Role.VELOCITY for monomial in terms for base, _ in monomial):
        from lagrange_cli.symbolic.speeds import with_shared_speeds  # few systems have sums of velocities

        terms = with_shared_speeds(terms, order)
    groups: dict[Monomial, Terms] = {}
    for monomial, coefficient in terms.items():
        moving = frozenset(item for item in monomial if is_of_motion(item, order))
        groups.setdefault(moving, {})[monomial - moving] = coefficient
    parts, size = [], 0
    for moving, inner in groups.items():
        parts.append(with_denominators(moving, inner, order))
        size += size_of(parts[-1])
        if size > longest:
            raise TooLargeError
    return sympy.Add(*parts)


def shortened(terms: Terms) -> Terms:
    """The sum, with other squares of sines where that makes it shorter."""
    if len(terms) < 2:
        return terms
    from lagrange_cli.symbolic.squares import shortest

    return shortest(terms)


def with_denominators(moving: Monomial, terms: Terms, order: Order) -> sympy.Expr:
    """The sum, times velocities and accelerations: collected by roots and denominators, or over one
    denominator where that is shorter."""
    groups: dict[Monomial, Terms] = {}
    terms = shortened(terms)
    for monomial, coefficient in terms.items():
        roots = frozenset(item for item in monomial if is_sum(item, order))
        groups.setdefault(roots, {})[monomial - roots] = coefficient
    each = sympy.Add(*(once(combine(moving, roots), inner, order) for roots, inner in groups.items()))
    if not any(base.is_Add for monomial in terms for base, _ in monomial):
        return each
    from lagrange_cli.symbolic.common_denominators import over_one_denominator

    try:
        joined = over_one_denominator(terms)
    except TooLargeError:  # it would not be shorter
        joined = None
    if joined is None:
        return each
    numerator, denominator = joined
    if not numerator:
        return sympy.S.Zero
    one = once(combine(moving, denominator), numerator, order)
    return one if size_of(one) < size_of(each) else each


def once(factor: Monomial, terms: Terms, order: Order) -> sympy.Expr:
    """A common factor of terms, written once."""
    return factored(terms, order, factor) if factor else collected(terms, order)


def is_of_motion(item: tuple[sympy.Expr, Number], order: Order) -> bool:
    """Whether terms are collected by this factor of a monomial: x_dot, theta_ddot, lambda."""
    base, exponent = item
    return (order.is_motion(base) or order.role(base) is Role.MULTIPLIER) and exponent > 0


def is_sum(item: tuple[sympy.Expr, Number], order: Order) -> bool:
    """Whether terms are collected by this factor of a monomial: a distance."""
    base, _ = item
    return bool(base.is_Add) and order.role(base) > Role.PARAMETER


def factored(terms: Terms, order: Order, factor: Monomial = ONE) -> sympy.Expr:
    """The sum, times a factor, as one product: with its common factor in front."""
    content, number = common_factor(terms)
    number = with_leading_sign(terms, number, order)
    return multiplied(
        term(combine(factor, content), number), collected(divide(terms, content, number), order)
    )


def collected(terms: Terms, order: Order) -> sympy.Expr:
    """The sum with powers of shorter ones, or by functions of the coordinates: the shortest of these."""
    found = [by_functions(terms, order)]
    fixed = {m: c for m, c in terms.items() if all(order.role(base) is Role.PARAMETER for base, _ in m)}
    for first in ({}, fixed) if 0 < len(fixed) < len(terms) else ({},):
        power = in_powers({m: c for m, c in terms.items() if m not in first}, order)
        if power is not None:
            found.append(by_functions(first, order) + power)
    return min(found, key=size_of) if len(found) > 1 else found[0]


def in_powers(terms: Terms, order: Order) -> sympy.Expr | None:
    """The sum as a product of powers of shorter ones, if it is one."""
    if len(terms) < FEWEST_IN_POWER:
        return None
    from lagrange_cli.symbolic.perfect_powers import powers

    content, number = common_factor(terms)
    number = with_leading_sign(terms, number, order)
    split = powers(divide(terms, content, number))
    if split is None:
        return None
    scale, found = split
    factors = (as_written(by_functions(factor, order) ** exponent, order) for factor, exponent in found)
    return multiplied(term(content, number * scale), sympy.Mul(*factors))


def as_written(product: sympy.Expr, order: Order) -> sympy.Expr:
    """A product with its differences of parameters in the direction that the file has."""
    pairs = [factor.as_base_exp() for factor in sympy.Mul.make_args(product)] if order.written else []
    if not any(-base in order.written and exponent.is_Integer for base, exponent in pairs):
        return product
    turned = [(-base in order.written and exponent.is_Integer, base, exponent) for base, exponent in pairs]
    return sympy.Mul(*((-1) ** e * (-base) ** e if turn else base**e for turn, base, e in turned))


def by_functions(terms: Terms, order: Order) -> sympy.Expr:
    """The sum, collected by sines and the like that multiply several terms, where that is shorter."""
    groups: dict[Monomial, Terms] = {}
    for monomial, coefficient in terms.items():
        functions = frozenset(item for item in monomial if is_function_of_motion(item[0], order))
        groups.setdefault(functions, {})[monomial - functions] = coefficient
    found = by_coordinates(terms, order)
    if all(len(inner) == 1 for functions, inner in groups.items() if functions):
        return found
    other = sympy.Add(*(once(functions, inner, order) for functions, inner in groups.items()))
    return other if size_of(other) < size_of(found) else found


def is_function_of_motion(base: sympy.Expr, order: Order) -> bool:
    """Whether it is a function of coordinates or t, as sin(theta) is."""
    return bool(base.is_Function) and order.role(base) > Role.PARAMETER


def by_coordinates(terms: Terms, order: Order) -> sympy.Expr:
    """The sum, with the parameters that multiply each function of the coordinates collected."""
    groups: dict[Monomial, Terms] = {}
    for monomial, coefficient in terms.items():
        moving = frozenset(item for item in monomial if order.role(item[0]) > Role.PARAMETER)
        groups.setdefault(moving, {})[monomial - moving] = coefficient
    if len(groups) > 1 and all(len(inner) > 1 for inner in groups.values()):
        from lagrange_cli.symbolic.rings import without_shared_factor  # few sums have one

        shared, parts = without_shared_factor([*groups.values()])
        if shared:
            sign = with_leading_sign(shared, 1, order)
            factor = times_constant(ONE, divide(shared, ONE, sign), order)
            rest = {
                combine(moving, own): sign * number
                for moving, part in zip(groups, parts, strict=True)
                for own, number in part.items()
            }
            content, number = common_factor(rest)
            number = with_leading_sign(rest, number, order)
            inner = collected(divide(rest, content, number), order)
            return sympy.Mul(term(content, number), inner, factor)
    return sympy.Add(*(times_constant(moving, inner, order) for moving, inner in groups.items()))


def times_constant(moving: Monomial, terms: Terms, order: Order) -> sympy.Expr:
    """A sum of products of parameters, factored, times a function of the coordinates."""
    content, number = common_factor(terms)
    number = with_leading_sign(terms, number, order)
    inner = divide(terms, content, number)
    rest = from_terms(inner)
    mixed = any(exponent > 1 or len(m) > 1 for m in terms for _, exponent in m - content)
    if len(terms) > 2 and mixed and is_factored(inner):
        rest = as_written(split(rest, inner), order)  # m2**2 + 2*m2*m3 + m3**2
    return multiplied(term(moving) * term(content, number), rest)


def split(polynomial: sympy.Expr, terms: Terms) -> sympy.Expr:
    """A polynomial with these terms as a product. The same ones occur in many equations."""
    if is_irreducible(terms):
        return polynomial
    found = COUNTER.factored.get(polynomial)
    if found is None:
        charge(STEPS_TO_FACTOR * len(terms) * (1 + degree(terms)))
        found = with_decimals(sympy.factor(polynomial), polynomial)
        if COUNTER.work is not None:
            COUNTER.factored[polynomial] = found
    return found


def is_irreducible(terms: Terms) -> bool:
    """Whether a sum that has no common factor is easily seen to be no product: a base x stands in one of its
    terms alone, a x, where ``a`` is a product without x. Of two factors, the one without x would divide that
    term and all others: it is a number, if all are integers."""
    if any(number.denominator != 1 for number in terms.values()):
        return False
    alone: dict[sympy.Expr, bool] = {}
    for monomial in terms:
        for base, exponent in monomial:
            alone[base] = exponent == 1 and base not in alone
    return any(alone.values())


def with_decimals(product: sympy.Expr, polynomial: sympy.Expr) -> sympy.Expr:
    """The ``product`` that a polynomial is, with decimals in its sums where it has any: otherwise they become
    long integers, as in (20000*J + 3)/20000 for J + 0.00015."""
    number, factors = product.as_coeff_Mul()
    if not is_decimal(number):
        return product
    if factors.is_Add:
        return polynomial
    found = []
    for factor in sympy.Mul.make_args(factors):
        base, exponent = factor.as_base_exp()
        size = abs(sympy.Poly(base).LC()) if base.is_Add else sympy.S.One
        number *= size**exponent
        found.append(sympy.expand(base / size) ** exponent)
    return sympy.Mul(number, *found)


def is_factored(terms: Terms) -> bool:
    """Whether factors of the sum are looked for: of longer or higher polynomials that takes minutes, and
    powers of sums would be expanded first."""
    plain = all(base.is_Symbol or base.is_Function for monomial in terms for base, _ in monomial)
    return plain and len(terms) <= MOST_FACTORED and degree(terms) <= HIGHEST_FACTORED


def with_leading_sign(terms: Terms, number: Number, order: Order) -> Number:
    """The common number with the sign that leaves the first term of the sum positive, or a difference of
    parameters as it is written in the file."""
    if order.written and len(terms) > 1:
        content, size = common_factor(terms)
        rest = from_terms(divide(terms, content, abs(size)))
        if rest in order.written or -rest in order.written:
            return abs(number) if rest in order.written else -abs(number)
    first = min(terms, key=order.monomial_key)
    return abs(number) if terms[first] > 0 else -abs(number)


def multiplied(factor: sympy.Expr, expression: sympy.Expr) -> sympy.Expr:
    """The product, without distributing a number over the terms of a sum."""
    if expression.is_Add and factor.is_Number and factor and abs(factor) != 1:
        return sympy.Mul(factor, expression, evaluate=False)
    return factor * expression
