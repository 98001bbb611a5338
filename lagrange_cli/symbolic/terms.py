"""Expressions as sums of monomials, in which like terms are collected.

A monomial maps bases (symbols, functions, sums under a root or in a denominator) to rational exponents;
``Terms`` maps monomials to rational coefficients. The change of form is exact.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from fractions import Fraction
from math import gcd
from typing import TypeAlias

import sympy

from lagrange_cli.symbolic.work import COUNTER, charge, size_of

Monomial: TypeAlias = frozenset[tuple[sympy.Expr, Fraction]]
Terms: TypeAlias = dict[Monomial, Fraction]

ONE: Monomial = frozenset()
LARGEST = 4000
"""The largest number of terms of a sum: longer ones are not expanded."""
FACTORS = 16
"""The largest number of factors of the terms of the longest sums."""

HIGHEST_POWER = 4
"""The highest power of a sum that is expanded; (x - l)**12 would be unreadable."""


class TooLargeError(Exception):
    """The expanded form would have more than ``LARGEST`` terms."""


def to_terms(expression: sympy.Expr) -> Terms:
    """The expanded form of an expression. Raises ``TooLargeError``."""
    if expression.is_Rational:
        return {ONE: Fraction(int(expression.p), int(expression.q))} if expression else {}
    if expression.is_Add:
        total: Terms = {}
        for argument in expression.args:
            add_into(total, to_terms(argument))
        return total
    if expression.is_Mul:
        product: Terms = {ONE: Fraction(1)}
        for argument in expression.args:
            product = multiply(product, to_terms(argument))
        return product
    if expression.is_Pow and expression.exp.is_Rational:
        return power(expression.base, Fraction(int(expression.exp.p), int(expression.exp.q)))
    inner = settled(expression)
    if inner is not expression and not inner.is_Function:
        return to_terms(inner)
    return {frozenset({(inner, Fraction(1))}): Fraction(1)}


def power(base: sympy.Expr, exponent: Fraction) -> Terms:
    """The expanded form of ``base**exponent``."""
    if exponent.denominator == 1 and (base.is_Add or base.is_Mul or base.is_Pow):
        terms = to_terms(base)
        if exponent > HIGHEST_POWER and len(terms) > 1:
            return {frozenset({(settled(base), exponent)}): Fraction(1)}
        if exponent > 0:
            result: Terms = {ONE: Fraction(1)}
            for _ in range(exponent.numerator):
                result = multiply(result, terms)
            return result
        if len(terms) == 1:
            ((monomial, coefficient),) = terms.items()
            return {raised(monomial, exponent): coefficient**exponent.numerator}
        base, content, coefficient = primitive(base, terms)
        monomial = combine(raised(content, exponent), frozenset({(base, exponent)}))
        return {monomial: coefficient**exponent.numerator}
    if base.is_Rational and exponent.denominator == 1:
        return {ONE: Fraction(int(base.p), int(base.q)) ** exponent.numerator}
    return {frozenset({(settled(base), exponent)}): Fraction(1)}


def primitive(base: sympy.Expr, terms: Terms) -> tuple[sympy.Expr, Monomial, Fraction]:
    """``base`` as (base', content, number) with base = number * content * base', base' in lowest terms."""
    content, number = common_factor(terms)
    if not content and number == 1:
        return settled(base), ONE, Fraction(1)
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
    from lagrange_cli.symbolic.trigonometry import contract

    if expression.is_Function:
        arguments = tuple(settled(argument) for argument in expression.args)
        return expression if arguments == expression.args else expression.func(*arguments)
    shorter = from_terms(contract(to_terms(expression)))
    return shorter if size_of(shorter) < size_of(expression) else expression


def from_terms(terms: Mapping[Monomial, Fraction]) -> sympy.Expr:
    """The sum of the terms as an expression."""
    return sympy.Add(*(term(monomial, coefficient) for monomial, coefficient in terms.items()))


def term(monomial: Monomial, coefficient: Fraction = Fraction(1)) -> sympy.Expr:
    """One term as an expression."""
    return sympy.Mul(rational(coefficient), *(base ** rational(exponent) for base, exponent in monomial))


def rational(value: Fraction) -> sympy.Rational:
    """A fraction as a sympy number."""
    return sympy.Rational(value.numerator, value.denominator)


def add_into(total: Terms, terms: Mapping[Monomial, Fraction], factor: Fraction = Fraction(1)) -> None:
    """Add ``factor * terms`` to ``total`` in place, without terms that cancel. Raises ``TooLargeError``."""
    charge(6 * len(terms))
    for monomial, coefficient in terms.items():
        value = total.get(monomial, 0) + factor * coefficient
        if value:
            total[monomial] = value
        else:
            total.pop(monomial, None)
    if len(total) > LARGEST:
        raise TooLargeError


def multiply(left: Terms, right: Terms) -> Terms:
    """The product of two sums, expanded. Raises ``TooLargeError``."""
    count = len(left) * len(right)
    if count > LARGEST or (
        count > 1 and count * (max(map(len, left)) + max(map(len, right))) > FACTORS * LARGEST
    ):
        raise TooLargeError
    charge(20 * count)
    product: Terms = {}
    for monomial, coefficient in left.items():
        for other, factor in right.items():
            joined = combine(monomial, other)
            if any(is_reducible(base, exponent) for base, exponent in joined):
                # a squared root, sqrt(x + y)**2, is a sum or a number again
                add_into(product, to_terms(term(joined)), coefficient * factor)
            else:
                add_into(product, {joined: coefficient * factor})
    return product


def is_reducible(base: sympy.Expr, exponent: Fraction) -> bool:
    """Whether ``base**exponent`` is not a factor of a monomial but should be expanded further."""
    if exponent.denominator != 1 or base.is_Symbol or base.is_Function:
        return False
    if base.is_Add:
        return 0 < exponent <= HIGHEST_POWER
    return bool(base.is_Rational or base.is_Mul or (base.is_Pow and base.exp.is_Rational))


def combine(left: Monomial, right: Monomial) -> Monomial:
    """The product of two monomials."""
    if not left or not right:
        return left or right
    charge(2 * (1 + len(left) + len(right)))
    exponents = dict(left)
    for base, exponent in right:
        exponents[base] = exponents.get(base, Fraction(0)) + exponent
    return frozenset(item for item in exponents.items() if item[1])


def raised(monomial: Monomial, exponent: Fraction) -> Monomial:
    """A monomial to an integer power."""
    return frozenset((base, own * exponent) for base, own in monomial)


def divide(terms: Terms, monomial: Monomial, number: Fraction = Fraction(1)) -> Terms:
    """The terms, each divided by ``number * monomial``."""
    inverse = raised(monomial, Fraction(-1))
    return {combine(own, inverse): coefficient / number for own, coefficient in terms.items()}


def common_factor(terms: Mapping[Monomial, Fraction]) -> tuple[Monomial, Fraction]:
    """The largest monomial and number that divide every term; exponents of both signs are taken out."""
    monomials = iter(terms)
    shared = dict(next(monomials, ONE))
    for monomial in monomials:
        own = dict(monomial)
        for base in {*shared, *own}:
            # a base that one term lacks has the power 0 there
            exponent = min(shared.get(base, Fraction(0)), own.get(base, Fraction(0)))
            shared[base] = exponent
    content = frozenset(item for item in shared.items() if item[1])
    return content, common_number(terms.values())


def common_number(numbers: Iterable[Fraction]) -> Fraction:
    """The number to factor out of a sum: that of fractions such as 1/2 and 1/3, but 1 if the sum contains
    decimals, which would become long integers; negative if every term is."""
    numbers = list(numbers)
    if not numbers:
        return Fraction(1)
    sign = -1 if all(number < 0 for number in numbers) else 1
    if len(set(map(abs, numbers))) == 1:
        return sign * abs(numbers[0])
    if any(144 % number.denominator for number in numbers):
        return Fraction(sign)
    numerator, denominator = 0, 1
    for number in numbers:
        numerator = gcd(numerator, number.numerator)
        denominator = denominator * number.denominator // gcd(denominator, number.denominator)
    return Fraction(sign * numerator, denominator)
