"""Linear systems M x = f with symbolic entries: split into blocks, each solved by Cramer's rule."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence

import sympy

from lagrange_cli.symbolic.canonical import contract, is_reducible, multiply, to_terms
from lagrange_cli.symbolic.grouping import group, shortened, with_leading_sign
from lagrange_cli.symbolic.monomials import (
    ONE,
    Number,
    Terms,
    TooLargeError,
    add_into,
    combine,
    common_factor,
    degree,
    divide,
    is_decimal,
    ratio,
    term,
)
from lagrange_cli.symbolic.order import Order
from lagrange_cli.symbolic.work import charge, size_of

LARGEST_BLOCK = 3
"""The largest number of coupled unknowns with an explicit solution: with four, it fills pages."""
LARGEST_FRACTION = 40
"""The largest number of terms in numerator and denominator for which common sums are cancelled."""
HIGHEST_FRACTION = 16
"""The highest degree of these: the time that it takes grows suddenly, to minutes, where degrees are high."""
LONGEST_INTEGER = 10**4
"""The least integer of a fraction that is not written where decimals are."""
STEPS_TO_CANCEL = 100
"""The largest work for that, for each term and degree."""

Matrix = Sequence[Sequence[Terms]]


class Singular(ArithmeticError):
    """The determinant vanishes identically."""


def solve(
    matrix: Sequence[Sequence[sympy.Expr]],
    right: Callable[[int], sympy.Expr],
    order: Order,
    largest: int = LARGEST_BLOCK,
    longest: float = math.inf,
) -> tuple[sympy.Expr, ...] | None:
    """The explicit solution, or None where more than ``largest`` unknowns are coupled, or some of several are
    longer than ``longest``: it is too long to print.

    ``matrix``: n rows of n; ``right``: an entry by its row, asked for in blocks that are solved. Raises
    ``Singular``.
    """
    solution: list[sympy.Expr] = [sympy.S.Zero] * len(matrix)
    try:
        for block in blocks(matrix):
            if len(block) > largest:
                return None
            rows = [[to_terms(matrix[i][j]) for j in block] for i in block]
            column = [to_terms(right(i)) for i in block]
            determinant = shortened(contract(determinant_of(rows)))
            if not determinant:
                raise Singular
            for position, index in enumerate(block):
                replaced = [
                    [column[i] if j == position else rows[i][j] for j in range(len(block))]
                    for i in range(len(block))
                ]
                numerator = shortened(contract(determinant_of(replaced)))
                if least_size(numerator) > longest:
                    return None
                found = solution[index] = quotient(numerator, determinant, order, longest)
                if size_of(found) > longest:
                    return None
    except TooLargeError:
        return None
    return tuple(solution)


def least_size(terms: Terms) -> int:
    """A lower bound on the size of a sum, however it is written: each of its factors stands there once."""
    return sum(map(size_of, {base for monomial in terms for base, _ in monomial}))


def blocks(matrix: Sequence[Sequence[sympy.Expr]]) -> list[list[int]]:
    """The indices of unknowns that the matrix couples, block by block."""
    found: list[list[int]] = []
    for index, row in enumerate(matrix):
        joined = [block for block in found if any(row[j] != 0 or matrix[j][index] != 0 for j in block)]
        found = [block for block in found if block not in joined]
        found.append(sorted([*(member for block in joined for member in block), index]))
    return sorted(found)


def determinant_of(rows: Matrix) -> Terms:
    """The determinant by expansion along the first row, each minor once."""
    known: dict[tuple[int, ...], Terms] = {(): {ONE: 1}}

    def minor(columns: tuple[int, ...]) -> Terms:
        """A minor of the last rows, as many as there are ``columns``."""
        if columns not in known:
            total: Terms = {}
            for place, column in enumerate(columns):
                if entry := rows[-len(columns)][column]:
                    rest = contract(minor(columns[:place] + columns[place + 1 :]))
                    add_into(total, multiply(entry, rest), -1 if place % 2 else 1)
            known[columns] = total
        return known[columns]

    return minor(tuple(range(len(rows))))


def quotient(numerator: Terms, denominator: Terms, order: Order, longest: float = math.inf) -> sympy.Expr:
    """A fraction of two sums in lowest terms; over a single product, term by term. Raises ``TooLargeError``
    as soon as it is certain to be longer than ``longest``: what it is divided by may be left out by sympy."""
    if not numerator:
        return sympy.S.Zero
    content, number = common_factor(denominator)
    numerator, denominator = (expanded(divide(one, content, number)) for one in (numerator, denominator))
    if len(denominator) > 1 and len(numerator) + len(denominator) <= LARGEST_FRACTION:
        numerator, denominator = reduced(numerator, denominator)
    if denominator == {ONE: 1}:
        return group(numerator, order, longest)
    sign = with_leading_sign(denominator, 1, order)
    content, number = common_factor(numerator)
    below = group(divide(denominator, ONE, sign), order)
    factor = term(content, number * sign)
    enough = longest + size_of(below) + size_of(factor)
    above = group(expanded(divide(numerator, content, number)), order, enough)
    return factor * above / below


def expanded(terms: Terms) -> Terms:
    """The sum, with the powers of sums expanded that a division has left: a root divided by its inverse."""
    if not any(is_reducible(base, exponent) for monomial in terms for base, exponent in monomial):
        return terms
    total: Terms = {}
    for monomial, coefficient in terms.items():
        add_into(total, to_terms(term(monomial, coefficient)))
    return contract(total)


def reduced(numerator: Terms, denominator: Terms) -> tuple[Terms, Terms]:
    """Both sums divided by their greatest common divisor, as polynomials in all they contain."""
    content, number = common_factor(numerator)
    polynomial = divide(numerator, content, number)
    from lagrange_cli.symbolic.rings import ring_of  # few systems have such fractions

    ring, highest = ring_of(polynomial, denominator), max(degree(polynomial), degree(denominator))
    if ring is None or highest > HIGHEST_FRACTION:
        return numerator, denominator
    charge(STEPS_TO_CANCEL * (len(polynomial) + len(denominator)) * (1 + highest))
    top, bottom = ring.polynomial(polynomial).cancel(ring.polynomial(denominator))
    scale, rest = common_factor(ring.terms(bottom))
    if any(is_decimal(one) for one in (*polynomial.values(), *denominator.values())):
        rest = rest * decimal_size(ring.terms(bottom), rest)
    above = divide(
        ring.terms(top), combine(scale, frozenset((b, -e) for b, e in content)), ratio(rest, number)
    )
    return above, divide(ring.terms(bottom), scale, rest)


def decimal_size(terms: Terms, number: Number) -> int:
    """The power of ten by which a sum, divided by a number, is divided further: above 1 where decimals have
    become long integers."""
    largest = max(abs(one) for one in divide(terms, ONE, number).values())
    return 10 ** (len(str(math.floor(largest))) - 1) if largest >= LONGEST_INTEGER else 1
