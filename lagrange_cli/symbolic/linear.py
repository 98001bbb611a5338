"""Linear systems M x = f with symbolic entries: split into blocks, each solved by Cramer's rule."""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction

import sympy

from lagrange_cli.symbolic.canonical import contract, multiply, to_terms
from lagrange_cli.symbolic.grouping import group
from lagrange_cli.symbolic.monomials import (
    ONE,
    Terms,
    TooLargeError,
    add_into,
    combine,
    common_factor,
    degree,
    divide,
    term,
)
from lagrange_cli.symbolic.order import Order
from lagrange_cli.symbolic.work import charge

LARGEST_BLOCK = 3
"""The largest number of coupled unknowns with an explicit solution: with four, it fills pages."""
LARGEST_FRACTION = 40
"""The largest number of terms in numerator and denominator for which common sums are cancelled."""
HIGHEST_FRACTION = 16
"""The highest degree of these: the time that it takes grows suddenly, to minutes, where degrees are high."""
STEPS_TO_CANCEL = 100
"""What that takes at most, for each term and degree."""

Matrix = Sequence[Sequence[Terms]]


def solve(
    matrix: Sequence[Sequence[sympy.Expr]], right: Sequence[sympy.Expr], order: Order
) -> tuple[sympy.Expr, ...] | None:
    """The explicit solution, or None where it would be too long to print.

    ``matrix``: n rows of n, symmetric; ``right``: n entries.
    """
    solution: list[sympy.Expr] = [sympy.S.Zero] * len(right)
    try:
        for block in blocks(matrix):
            if len(block) > LARGEST_BLOCK:
                return None
            rows = [[to_terms(matrix[i][j]) for j in block] for i in block]
            column = [to_terms(right[i]) for i in block]
            determinant = contract(determinant_of(rows))
            if not determinant:
                return None
            for position, index in enumerate(block):
                replaced = [
                    [column[i] if j == position else rows[i][j] for j in range(len(block))]
                    for i in range(len(block))
                ]
                solution[index] = quotient(contract(determinant_of(replaced)), determinant, order)
    except TooLargeError:
        return None
    return tuple(solution)


def blocks(matrix: Sequence[Sequence[sympy.Expr]]) -> list[list[int]]:
    """The indices of unknowns that the matrix couples, block by block."""
    found: list[list[int]] = []
    for index, row in enumerate(matrix):
        joined = [block for block in found if any(row[other] != 0 for other in block)]
        found = [block for block in found if block not in joined]
        found.append(sorted([*(member for block in joined for member in block), index]))
    return sorted(found)


def determinant_of(rows: Matrix) -> Terms:
    """The determinant by expansion along the first row."""
    if len(rows) == 1:
        return rows[0][0]
    total: Terms = {}
    for column, entry in enumerate(rows[0]):
        if entry:
            minor = [[*row[:column], *row[column + 1 :]] for row in rows[1:]]
            sign = Fraction(-1 if column % 2 else 1)
            add_into(total, multiply(entry, contract(determinant_of(minor))), sign)
    return total


def quotient(numerator: Terms, denominator: Terms, order: Order) -> sympy.Expr:
    """A fraction of two sums in lowest terms; over a single product, term by term."""
    if not numerator:
        return sympy.S.Zero
    content, number = common_factor(denominator)
    numerator, denominator = divide(numerator, content, number), divide(denominator, content, number)
    if len(denominator) > 1 and len(numerator) + len(denominator) <= LARGEST_FRACTION:
        numerator, denominator = reduced(numerator, denominator)
    if denominator == {ONE: 1}:
        return group(numerator, order)
    first = min(denominator, key=lambda monomial: order.term_key(term(monomial)))
    sign = 1 if denominator[first] > 0 else -1
    content, number = common_factor(numerator)
    above = group(divide(numerator, content, number), order)
    return term(content, number * sign) * above / group(divide(denominator, ONE, Fraction(sign)), order)


def reduced(numerator: Terms, denominator: Terms) -> tuple[Terms, Terms]:
    """Both sums divided by their greatest common divisor, as polynomials in all they contain."""
    content, number = common_factor(numerator)
    polynomial = divide(numerator, content, number)
    bases = sorted({base for terms in (polynomial, denominator) for m in terms for base, _ in m}, key=str)
    exponents = [e for terms in (polynomial, denominator) for m in terms for _, e in m]
    highest = max(degree(polynomial), degree(denominator))
    if not bases or any(e.denominator != 1 or e < 0 for e in exponents) or highest > HIGHEST_FRACTION:
        return numerator, denominator
    charge(STEPS_TO_CANCEL * (len(polynomial) + len(denominator)) * (1 + highest))
    from sympy.polys.domains import QQ
    from sympy.polys.rings import PolyRing

    ring = PolyRing([f"x{i}" for i in range(len(bases))], QQ)

    def to_ring(terms: Terms) -> sympy.Expr:
        return ring.from_dict(
            {
                tuple(int(dict(monomial).get(base, 0)) for base in bases): QQ(c.numerator, c.denominator)
                for monomial, c in terms.items()
            }
        )

    def from_ring(element: sympy.Expr) -> Terms:
        return {
            frozenset((base, Fraction(e)) for base, e in zip(bases, powers, strict=True) if e): Fraction(
                int(c.numerator), int(c.denominator)
            )
            for powers, c in element.terms()
        }

    top, bottom = to_ring(polynomial).cancel(to_ring(denominator))
    scale, rest = common_factor(from_ring(bottom))
    above = divide(from_ring(top), combine(scale, frozenset((b, -e) for b, e in content)), rest / number)
    return above, divide(from_ring(bottom), scale, rest)
