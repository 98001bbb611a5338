"""Sums of monomials, in which like terms are collected.

A monomial maps bases (symbols, functions, sums under a root or in a denominator) to rational exponents;
``Terms`` maps monomials to rational coefficients. How an expression becomes such a sum: ``canonical``.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from fractions import Fraction
from math import ceil, gcd
from typing import Any, TypeAlias

import sympy

from lagrange_cli.symbolic.work import charge

Number: TypeAlias = Any
"""A ``Fraction``, or ``int`` where it is whole, which is many times as fast; quotients are a ``ratio``."""
Monomial: TypeAlias = frozenset[tuple[sympy.Expr, Number]]
Terms: TypeAlias = dict[Monomial, Number]

ONE: Monomial = frozenset()
LARGEST = 4000
"""The largest number of terms of a sum: longer ones are not expanded."""


class TooLargeError(Exception):
    """The expanded form would have more than ``LARGEST`` terms, or its form is longer than it may be."""


def from_terms(terms: Mapping[Monomial, Number]) -> sympy.Expr:
    """The sum of the terms as an expression."""
    return sympy.Add(*(term(monomial, coefficient) for monomial, coefficient in terms.items()))


def term(monomial: Monomial, coefficient: Number = 1) -> sympy.Expr:
    """One term as an expression."""
    factors = (base if exponent == 1 else base ** rational(exponent) for base, exponent in monomial)
    return sympy.Mul(rational(coefficient), *factors)


def rational(value: Number) -> sympy.Rational:
    """A number as one of sympy's."""
    return sympy.Integer(value) if type(value) is int else sympy.Rational(value.numerator, value.denominator)


def ratio(above: Any, below: Any = 1) -> Number:
    """The quotient of two numbers of any kind with numerator and denominator."""
    above, below = int(above.numerator * below.denominator), int(below.numerator * above.denominator)
    whole, rest = divmod(above, below)
    return Fraction(above, below) if rest else whole


def to_power(number: Number, exponent: int) -> Number:
    """``number**exponent``."""
    return number**exponent if exponent >= 0 else ratio(1, number**-exponent)


def add_into(total: Terms, terms: Mapping[Monomial, Number], factor: Number = 1) -> None:
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


def combine(left: Monomial, right: Monomial) -> Monomial:
    """The product of two monomials."""
    if not left or not right:
        return left or right
    charge(2 * (1 + len(left) + len(right)))
    return joined(dict(left), right)


def joined(exponents: dict[sympy.Expr, Number], right: Monomial) -> Monomial:
    """The product of a monomial, given by its ``exponents``, which are used up, and another one."""
    for base, exponent in right:
        if base in exponents:
            exponent = exponents[base] + exponent
            if not exponent:
                del exponents[base]
                continue
        exponents[base] = exponent
    return frozenset(exponents.items())


def raised(monomial: Monomial, exponent: Number) -> Monomial:
    """A monomial to an integer power."""
    return frozenset((base, own * exponent) for base, own in monomial)


def degree(terms: Terms) -> int:
    """The highest sum of the absolute values of a term's exponents, rounded up."""
    return max((ceil(sum(abs(exponent) for _, exponent in monomial)) for monomial in terms), default=0)


def divide(terms: Terms, monomial: Monomial, number: Number = 1) -> Terms:
    """The terms, each divided by ``number * monomial``."""
    inverse = raised(monomial, -1)
    return {combine(own, inverse): ratio(coefficient, number) for own, coefficient in terms.items()}


def common_factor(terms: Mapping[Monomial, Number]) -> tuple[Monomial, Number]:
    """The largest monomial and number that divide every term; exponents of both signs are taken out."""
    monomials = iter(terms)
    shared = dict(next(monomials, ONE))
    for monomial in monomials:
        charge(2 + 2 * len(shared) + len(monomial))
        own = dict(monomial)
        for base in {*shared, *own}:
            # a base that one term lacks has the power 0 there
            exponent = min(shared.get(base, 0), own.get(base, 0))
            shared[base] = exponent
    content = frozenset(item for item in shared.items() if item[1])
    return content, common_number(terms.values())


def common_number(numbers: Iterable[Number]) -> Number:
    """The number to factor out of a sum: that of fractions such as 1/2 and 1/3, but 1 if the sum contains
    decimals, which would become long integers; negative if every term is."""
    numbers = list(numbers)
    if not numbers:
        return 1
    sign = -1 if all(number < 0 for number in numbers) else 1
    if len(set(map(abs, numbers))) == 1:
        return sign * abs(numbers[0])
    if any(is_decimal(number) for number in numbers):
        return sign
    numerator, denominator = 0, 1
    for number in numbers:
        numerator = gcd(numerator, number.numerator)
        denominator = denominator * number.denominator // gcd(denominator, number.denominator)
    return ratio(sign * numerator, denominator)


def is_decimal(number: Number) -> bool:
    """Whether a number is written as a decimal, such as 0.35, and not as a fraction, such as 1/12."""
    return bool(144 % number.denominator)
