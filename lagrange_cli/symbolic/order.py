"""The textbook order of factors and terms.

A product reads: numbers, parameters in the file's order, multipliers, time and coordinates, their functions,
velocities, accelerations. A sum reads: accelerations first, then squares and products of velocities, then the
rest.
"""

from __future__ import annotations

from collections.abc import Collection
from enum import IntEnum
from fractions import Fraction
from typing import Any

import sympy

from lagrange_cli.decimals import exact
from lagrange_cli.records import dataclass, field
from lagrange_cli.symbolic.monomials import Monomial, Number, term
from lagrange_cli.symbolic.work import charge, folded, size_of

STEPS_A_KEY = 5
"""The work of sorting a factor."""
LONG = 200
"""Terms and factors of an expression beyond which it is sorted by a digest."""


class Role(IntEnum):
    """The role of a symbol; roles are in the order of factors in a product."""

    PARAMETER = 0
    MULTIPLIER = 1
    TIME = 2
    COORDINATE = 3
    VELOCITY = 4
    ACCELERATION = 5


@dataclass(frozen=True)
class Order:
    """The role and rank of every symbol, and the order of expressions. ``known``, ``keys`` and
    ``expanded`` are caches.

    With ``decimals`` 7/10 is written as 0.7, as in files with decimals."""

    ranks: dict[sympy.Symbol, tuple[Role, int]]
    decimals: bool = True
    written: frozenset[sympy.Expr] = frozenset()
    """Differences of parameters that are written in this direction."""
    known: dict[sympy.Expr, tuple[Role, tuple[int, ...]]] = field(default_factory=dict, compare=False)
    keys: dict[sympy.Expr, tuple[Any, ...]] = field(default_factory=dict, compare=False)
    expanded: dict[sympy.Expr, bool] = field(default_factory=dict, compare=False)
    """Whether a product of sums is shorter when it is expanded."""

    def role(self, expression: sympy.Expr) -> Role:
        """The highest role of the symbols of an expression."""
        return self.describe(expression)[0]

    def is_motion(self, base: sympy.Expr) -> bool:
        """Whether ``base`` is itself a velocity or an acceleration."""
        return bool(base.is_Symbol) and self.role(base) >= Role.VELOCITY

    def describe(self, expression: sympy.Expr) -> tuple[Role, tuple[int, ...]]:
        """The role of an expression and the ranks of the symbols that have that role."""
        found = self.known.get(expression)
        if found is None:
            symbols = [self.ranks[symbol] for symbol in expression.free_symbols]
            role = max((role for role, _ in symbols), default=Role.PARAMETER)
            found = role, tuple(sorted(rank for own, rank in symbols if own == role))
            self.known[expression] = found
        return found

    def factor_key(self, base: sympy.Expr) -> tuple[Any, ...]:
        """Sort key of a factor within a product; ``base`` is the factor without its exponent."""
        key = self.keys.get(base)
        if key is None:
            key = self.keys[base] = self.make_factor_key(base)
        return key

    def make_factor_key(self, base: sympy.Expr) -> tuple[Any, ...]:
        role, ranks = self.describe(base)
        if base.is_Symbol:
            return (role, 0, ranks, 0, "")
        if role is Role.PARAMETER:  # (m1 + m2) g l1: a sum takes the place of its first symbol
            return (role, 0, ranks, 1, text_key(base)) if ranks else (role, -1, ranks, 1, text_key(base))
        if base.is_Add and len(ranks) < 2:
            return (role, 1, ranks, 1, text_key(base))
        name = {"sin": 0, "cos": 1}.get(getattr(base.func, "__name__", ""), 2)
        return (role, 2 if base.is_Function else 1, ranks, name, text_key(base))

    def term_key(self, expression: sympy.Expr) -> tuple[Any, ...]:
        """Sort key of a term within a sum."""
        factors = sympy.Mul.make_args(expression)
        return self.product_key([base_and_exponent(factor) for factor in factors if not factor.is_Number])

    def monomial_key(self, monomial: Monomial) -> tuple[Any, ...]:
        """The same of a monomial, found without making the term where sympy would not change its factors."""
        if all(stays_a_factor(base, exponent) for base, exponent in monomial):
            return self.product_key(monomial)
        return self.term_key(term(monomial))

    def product_key(self, factors: Collection[tuple[sympy.Expr, Any]]) -> tuple[Any, ...]:
        """Sort key of a product of powers, without its number."""
        accelerations: list[int] = []
        velocities: list[int] = []
        degree = 0
        slow: list[tuple[Any, ...]] = []
        constants: list[tuple[Any, ...]] = []
        charge(STEPS_A_KEY * (1 + len(factors)))
        for base, exponent in factors:
            role, ranks = self.describe(base)
            times = int(exponent) if is_whole(exponent) and exponent > 0 else 1
            if role is Role.ACCELERATION:
                accelerations += ranks * times
            elif role is Role.VELOCITY:
                velocities += ranks * times
            elif role is Role.PARAMETER:
                constants.append((self.factor_key(base), -times))
            else:
                degree += times
                slow.append((self.factor_key(base), -times))
        return (
            -len(accelerations),
            sorted(accelerations),
            -len(velocities),
            len(set(velocities)),
            sorted(velocities),
            degree,
            sorted(slow),
            sorted(constants),
        )

    def sorted_terms(self, expression: sympy.Expr) -> list[sympy.Expr]:
        """The terms of a sum in reading order. A positive term comes first in a constant sum, and a positive
        constant precedes variable terms: 1 - x_dot**2. A negative one follows them: x**2 + y**2 - l**2."""
        terms = sorted(sympy.Add.make_args(expression), key=self.term_key)
        if is_negative(terms[0]):
            slow = Role.VELOCITY if self.role(expression) < Role.VELOCITY else Role.COORDINATE
            positive = (term for term in terms if not is_negative(term) and self.role(term) < slow)
            first = next(positive, None)
            moving = [term for term in terms if self.role(term) > Role.PARAMETER]
            if first in moving and not any(map(is_negative, moving)):
                return moving + [term for term in terms if self.role(term) is Role.PARAMETER]
            if first is not None:
                terms.remove(first)
                terms.insert(0, first)
        return terms

    def is_reversed(self, expression: sympy.Expr) -> bool:
        """Whether it is like r - R for (R - r)**2, with R - r or R first in the file: parameters of which the
        first one has a minus sign."""
        if self.role(expression) is not Role.PARAMETER:
            return False
        if expression in self.written or -expression in self.written:
            return expression not in self.written
        return is_negative(min(sympy.Add.make_args(expression), key=self.term_key))


def text_key(expression: sympy.Expr) -> str:
    """The expression's text, or where that is long what is found faster: a digest of its structure."""
    if size_of(expression) <= LONG:
        return str(expression)
    from hashlib import sha256  # 2 ms, for few systems

    def digest(node: sympy.Expr, arguments: list[str]) -> str:
        name = type(node).__name__ if arguments else str(node)
        return sha256(f"{name}({','.join(arguments)})".encode()).hexdigest()

    return folded(expression, digest)


def is_negative(term: sympy.Expr) -> bool:
    """Whether a term is written with a minus sign."""
    return bool(term.as_coeff_Mul()[0].is_negative)


def stays_a_factor(base: sympy.Expr, exponent: Number) -> bool:
    """Whether sympy is certain to leave a power as it is in a product: it joins exponentials, and takes
    numbers out of roots."""
    if base.is_Add:
        return is_whole(exponent)
    return bool(base.is_Symbol or (base.is_Function and not isinstance(base, sympy.exp)))


def is_whole(exponent: Any) -> bool:
    """Whether an exponent, of sympy's kind or a ``Number``, is an integer."""
    return bool(exponent.is_Integer) if isinstance(exponent, sympy.Expr) else exponent.denominator == 1


def base_and_exponent(factor: sympy.Expr) -> tuple[sympy.Expr, sympy.Expr]:
    """A factor as base and exponent; unlike in sympy, exp(x) is a function and not a power."""
    return (factor.base, factor.exp) if factor.is_Pow else (factor, sympy.S.One)


def digits_of(value: Fraction) -> str:
    """A decimal number with the digits of a double; an integer beyond those with all of its own."""
    try:
        return exact(value)
    except OverflowError:
        return str(value.numerator // value.denominator)


def reads_as_fraction(value: Fraction, decimals: bool) -> bool:
    """Whether to write a fraction (1/2, 3/4, 1/3, 1/5), as textbooks do, rather than a decimal number (9.81,
    0.3), which is used only beside other ``decimals``."""
    if not decimals and max(value.numerator, value.denominator) < 1000:
        return True
    rest = value.denominator
    for prime in (2, 5):
        while rest % prime == 0:
            rest //= prime
    if rest != 1:  # no decimal number equals it: a fraction, unless it is very long
        return max(value.numerator, value.denominator) < 10**15
    if value.denominator & (value.denominator - 1) == 0:
        return value.numerator < 10 and value.denominator <= 1024
    return value.numerator < 10 and value.denominator == 5
