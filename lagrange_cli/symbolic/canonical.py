"""The canonical form of an expression: an expanded sum of monomials, shortened by trigonometric identities.

    sin^2 + cos^2 = 1        1 - sin^2 = cos^2        1 - cos^2 = sin^2
    cosh^2 - sinh^2 = 1      1 + sinh^2 = cosh^2      cosh^2 - 1 = sinh^2
    cos a cos b + sin a sin b = cos(a - b)            cos a cos b - sin a sin b = cos(a + b)
    sin a cos b - cos a sin b = sin(a - b)            sin a cos b + cos a sin b = sin(a + b)

Each is applied only where it makes the sum shorter (or as long but of lower degree), so the process ends.
The partner of a term is looked up, not searched for: the work is proportional to the number of terms.

The change of form is exact. Expanding and shortening need each other: the argument of a function or a root is
shortened when it is expanded.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence

import sympy

from lagrange_cli.expression.symbolic_switches import OfExpressions
from lagrange_cli.symbolic.monomials import (
    LARGEST,
    ONE,
    Monomial,
    Number,
    Terms,
    TooLargeError,
    add_into,
    combine,
    common_factor,
    divide,
    from_terms,
    joined,
    raised,
    ratio,
    term,
    to_power,
)
from lagrange_cli.symbolic.work import COUNTER, charge, size_of

FACTORS = 16
"""The largest number of factors of the terms of the longest sums."""

HIGHEST_POWER = 4
"""The highest power of a sum that is expanded; (x - l)**12 would be unreadable."""

WAVES = (sympy.sin, sympy.cos)
PARTNERS = {
    sympy.sin: (sympy.cos, 1),
    sympy.cos: (sympy.sin, 1),
    sympy.cosh: (sympy.sinh, -1),
    sympy.sinh: (sympy.cosh, -1),
}
"""f(x)^2 + sign * partner(x)^2 is a constant."""
MOST_WAVES = 8
"""Sines and cosines in one term up to which addition theorems are looked for: there are w**2/2 pairs."""


def to_terms(expression: sympy.Expr) -> Terms:
    """The expanded form of an expression. Raises ``TooLargeError``."""
    if expression.is_Rational:
        return {ONE: ratio(expression)} if expression else {}
    if expression.is_Add:
        total: Terms = {}
        for argument in expression.args:
            add_into(total, to_terms(argument))
        return total
    if expression.is_Mul:
        return product_of(expression.args)
    if expression.is_Pow and expression.exp.is_Rational:
        return power(expression.base, ratio(expression.exp))
    inner = settled(expression)
    if inner is not expression and not inner.is_Function:
        return to_terms(inner)
    return {frozenset({(inner, 1)}): 1}


def product_of(factors: Sequence[sympy.Expr]) -> Terms:
    """The expanded form of a product: powers of symbols and functions together, and sums one by one."""
    exponents: dict[sympy.Expr, Number] = {}
    number: Number = 1
    others = []
    for factor in factors:
        if factor.is_Rational:
            number = number * ratio(factor)
            continue
        plain = factor.is_Pow and factor.exp.is_Rational
        base, exponent = (factor.base, ratio(factor.exp)) if plain else (factor, 1)
        base = settled(base) if base.is_Function else base
        if base.is_Symbol or base.is_Function:
            exponents[base] = exponents.get(base, 0) + exponent
        else:
            others.append(factor)
    product: Terms = {frozenset(item for item in exponents.items() if item[1]): number} if number else {}
    for factor in others:
        product = multiply(product, to_terms(factor))
    return product


def power(base: sympy.Expr, exponent: Number) -> Terms:
    """The expanded form of ``base**exponent``."""
    if exponent.denominator == 1 and (base.is_Add or base.is_Mul or base.is_Pow):
        terms = to_terms(base)
        if exponent > HIGHEST_POWER and len(terms) > 1:
            return {frozenset({(settled(base), exponent)}): 1}
        if exponent > 0:
            result: Terms = {ONE: 1}
            for _ in range(exponent.numerator):
                result = multiply(result, terms)
            return result
        if len(terms) == 1:
            ((monomial, coefficient),) = terms.items()
            return {raised(monomial, exponent): to_power(coefficient, exponent.numerator)}
        base, content, coefficient = primitive(base, terms)
        monomial = combine(raised(content, exponent), frozenset({(base, exponent)}))
        return {monomial: to_power(coefficient, exponent.numerator)}
    if base.is_Rational and exponent.denominator == 1:
        return {ONE: to_power(ratio(base), exponent.numerator)}
    return {frozenset({(settled(base), exponent)}): 1}


def primitive(base: sympy.Expr, terms: Terms) -> tuple[sympy.Expr, Monomial, Number]:
    """``base`` as (base', content, number) with base = number * content * base', base' in lowest terms."""
    content, number = common_factor(terms)
    if not content and number == 1:
        return settled(base), ONE, 1
    return from_terms(divide(terms, content, number)), content, number


def settled(expression: sympy.Expr) -> sympy.Expr:
    """The argument of a function or root, contracted where that makes it shorter."""
    if not expression.args or (expression.is_Pow and not expression.exp.is_Rational):
        return expression
    found = COUNTER.settled.get(expression)
    if found is None:
        found = settle(expression)
        if COUNTER.work is not None:
            COUNTER.settled[expression] = found
    return found


def settle(expression: sympy.Expr) -> sympy.Expr:
    """``settled``, found for the first time."""
    if expression.is_Function:
        arguments = tuple(settled(argument) for argument in expression.args)
        return expression if arguments == expression.args else expression.func(*arguments)
    shorter = from_terms(without_denominators(contract(to_terms(expression))))
    return shorter if size_of(shorter) < size_of(expression) else expression


def without_denominators(terms: Terms) -> Terms:
    """A sum with a common denominator, divided by it where that leaves nothing: (a^2 + 2 a b + b^2)/(a + b)^2
    is 1."""
    for base, exponent in sorted(common_factor(terms)[0], key=str) if len(terms) > 1 else ():
        if base.is_Add and exponent < 0 and exponent.denominator == 1:
            from lagrange_cli.symbolic.rings import divided  # few systems have such sums

            quotient, times = divided(divide(terms, frozenset({(base, exponent)})), to_terms(base))
            left = frozenset({(base, exponent + times)}) if exponent + times else ONE
            terms = {combine(monomial, left): number for monomial, number in quotient.items()}
    return terms


def multiply(left: Terms, right: Terms) -> Terms:
    """The product of two sums, expanded. Raises ``TooLargeError``."""
    count = len(left) * len(right)
    if count > LARGEST or (
        count > 1 and count * (max(map(len, left)) + max(map(len, right))) > FACTORS * LARGEST
    ):
        raise TooLargeError
    sizes = len(right) * sum(map(len, left)) + len(left) * sum(map(len, right))
    charge(28 * count + 2 * sizes)
    reducible = not (is_plain(left) and is_plain(right))
    product: Terms = {}
    for monomial, coefficient in left.items():
        exponents = dict(monomial)
        for other, factor in right.items():
            both = joined(exponents.copy(), other) if other else monomial
            if reducible and any(is_reducible(base, exponent) for base, exponent in both):
                # a squared root, sqrt(x + y)**2, is a sum or a number again
                add_into(product, to_terms(term(both)), coefficient * factor)
                continue
            value = product.get(both, 0) + coefficient * factor
            if value:
                product[both] = value
            else:
                product.pop(both, None)
    return product


def is_plain(terms: Terms) -> bool:
    """Whether a sum is one of products of powers of symbols and functions, of which none is reducible."""
    return all(base.is_Symbol or base.is_Function for monomial in terms for base, _ in monomial)


def is_reducible(base: sympy.Expr, exponent: Number) -> bool:
    """Whether ``base**exponent`` is not a factor of a monomial but should be expanded further."""
    if exponent.denominator != 1 or base.is_Symbol or base.is_Function:
        return False
    if base.is_Add:
        return bool(0 < exponent <= HIGHEST_POWER)
    return bool(base.is_Rational or base.is_Mul or (base.is_Pow and base.exp.is_Rational))


def contract(terms: Terms) -> Terms:
    """The sum, contracted until no rule shortens it."""
    return contract_by((contract_powers, contract_kinks, contract_squares, contract_angles), terms)


def contract_by(rules: Sequence[Callable[[Terms, Monomial], bool]], terms: Terms) -> Terms:
    """The sum, contracted by one rule after the other."""
    terms = dict(terms)
    for rule in rules:
        changed = True
        while changed:
            changed = False
            for monomial in list(terms):
                while monomial in terms and rule(terms, monomial):
                    changed = True
    return terms


def contract_powers(terms: Terms, monomial: Monomial) -> bool:
    """x**p/x = x**(p - 1), where p is no number: apply it to one term, in place."""
    for base, exponent in monomial:
        if exponent != 1 or not base.is_Pow or base.exp.is_Rational:
            continue
        for other, power in monomial:
            if other == base.base:
                raised_base = other ** (base.exp + sympy.Rational(power.numerator, power.denominator))
                both = frozenset({(base, -1), (other, -power)})
                coefficient = terms.pop(monomial)
                add_into(terms, multiply({combine(monomial, both): coefficient}, to_terms(raised_base)))
                return True
    return False


def contract_kinks(terms: Terms, monomial: Monomial) -> bool:
    """Apply a rule for functions with kinks and jumps to one term, in place."""
    if not any(isinstance(base, OfExpressions) for base, _ in monomial):
        return False
    from lagrange_cli.symbolic.kinks import replacements  # few systems have them

    for product, value, better in replacements(terms, monomial):
        found = dict(terms)
        coefficient = found.pop(monomial)
        factors = (one.as_base_exp() for one in sympy.Mul.make_args(product))
        rest = combine(monomial, frozenset((base, -ratio(power)) for base, power in factors))
        add_into(found, multiply({rest: coefficient}, to_terms(value)))
        if better or len(found) < len(terms):
            terms.clear()
            terms.update(found)
            return True
    return False


def contract_squares(terms: Terms, monomial: Monomial) -> bool:
    """Apply a rule for squares to one term, in place."""
    squares = [base for base, exponent in monomial if type(base) in PARTNERS and exponent >= 2]
    for base in in_order(squares):
        partner_type, sign = PARTNERS[type(base)]
        constant = -1 if base.func is sympy.sinh else 1
        coefficient = terms[monomial]
        rest = combine(monomial, frozenset({(base, -2)}))
        partner = combine(rest, frozenset({(partner_type(*base.args), 2)}))
        other = terms.get(partner)
        if other is not None and (coefficient < 0) == (sign * other < 0):
            # a f^2 + b g^2 = s (f^2 + sign g^2) + ..., with the smaller coefficient s wholly used up
            shared = min(coefficient, sign * other, key=abs)
            add_into(terms, {monomial: -shared, partner: -sign * shared})
            add_into(terms, {rest: constant * shared})
            return True
        if terms.get(rest) == -constant * coefficient:
            # f^2 - c = -sign g^2
            add_into(terms, {monomial: -coefficient, rest: constant * coefficient})
            add_into(terms, {partner: -sign * coefficient})
            return True
    return False


def contract_angles(terms: Terms, monomial: Monomial) -> bool:
    """Apply an addition theorem to one term, in place."""
    for first, second in wave_pairs(monomial):
        coefficient = terms[monomial]
        rest = combine(monomial, frozenset({(first, -1), (second, -1)}))
        swapped = tuple(PARTNERS[type(base)][0](*base.args) for base in (first, second))
        partner = combine(rest, frozenset({(swapped[0], 1), (swapped[1], 1)}))
        other = terms.get(partner)
        if other is None or abs(other) != abs(coefficient) or partner == monomial:
            continue
        alike = other == coefficient
        factor = coefficient
        a, b = first.args[0], second.args[0]
        if type(first) is type(second):
            wave = sympy.cos(a - b if alike else a + b)
            if type(first) is sympy.sin:
                factor = other
        else:
            if type(first) is sympy.cos:
                a, b = b, a
            wave = sympy.sin(a + b if alike else a - b)
        add_into(terms, {monomial: -coefficient, partner: -other})
        add_into(terms, multiply({rest: factor}, to_terms(wave)))
        return True
    return False


def in_order(bases: list[sympy.Expr]) -> list[sympy.Expr]:
    """Factors of a monomial, sorted: a set has no order, but the result must not depend on chance."""
    return sorted(bases, key=sympy.default_sort_key) if len(bases) > 1 else bases


def wave_pairs(monomial: Monomial) -> Iterator[tuple[sympy.Expr, sympy.Expr]]:
    """Pairs of different sines and cosines of different angles in a monomial."""
    waves = [base for base, exponent in monomial if type(base) in WAVES and exponent >= 1]
    if len(waves) > MOST_WAVES:
        return
    waves = in_order(waves)
    for index, first in enumerate(waves):
        for second in waves[index + 1 :]:
            if first.args != second.args:
                yield first, second
