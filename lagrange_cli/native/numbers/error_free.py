"""Sums and products of two numbers without loss: the rounded result, and its rounding error.

T. J. Dekker, Numerische Mathematik 18 (1971); D. E. Knuth, The Art of Computer Programming 2, sec. 4.2.2.
Each is written once, for any kind of operands: in code (doubles or vectors), arrays, formulas.
"""

from __future__ import annotations

import operator
from typing import Any, Protocol, cast

from lagrange_cli.native.numbers.kind import V


class Sums(Protocol[V]):
    """Addition of doubles; None is 0."""

    def add(self, a: V | None, b: V | None) -> V | None: ...
    def sub(self, a: V | None, b: V | None) -> V | None: ...


class Products(Sums[V], Protocol[V]):
    """Their multiplication, too; ``exact_fma(a, b, c)`` is a * b + c with one rounding."""

    def neg(self, a: V | None) -> V | None: ...
    def mul(self, a: V | None, b: V | None) -> V | None: ...
    def exact_fma(self, a: V | None, b: V | None, c: V | None) -> V | None: ...


class Operators:
    """Sums and products of whatever has operators: arrays, formulas."""

    add = staticmethod(operator.add)
    sub = staticmethod(operator.sub)
    mul = staticmethod(operator.mul)
    neg = staticmethod(operator.neg)

    @staticmethod
    def exact_fma(a: Any, b: Any, c: Any) -> Any:
        """For values of ``llvm.vector``."""
        return a.body.fma(a, b, c)


OPERATORS: Any = Operators()


def two_sum(kind: Sums[V], a: V | None, b: V | None) -> tuple[V | None, V | None]:
    """a + b and its rounding error."""
    if a is None or b is None:
        return (b if a is None else a), None
    total = kind.add(a, b)
    back = kind.sub(total, a)
    return total, kind.add(kind.sub(a, kind.sub(total, back)), kind.sub(b, back))


def fast_sum(kind: Sums[V], a: V | None, b: V | None) -> tuple[V | None, V | None]:
    """a + b and its rounding error, where |a| >= |b|."""
    if b is None:
        return a, None
    total = kind.add(a, b)
    return total, kind.sub(b, kind.sub(total, a))


def two_product(kind: Products[V], a: V | None, b: V | None) -> tuple[V | None, V | None]:
    """a * b and its rounding error."""
    product = kind.mul(a, b)
    return product, None if product is None else kind.exact_fma(a, b, kind.neg(product))


def operators_two_sum(a: V, b: V) -> tuple[V, V]:
    """``two_sum`` of what has operators."""
    return cast("tuple[V, V]", two_sum(OPERATORS, a, b))


def operators_fast_sum(a: V, b: V) -> tuple[V, V]:
    """``fast_sum`` of what has operators."""
    return cast("tuple[V, V]", fast_sum(OPERATORS, a, b))


def operators_two_product(a: V, b: V) -> tuple[V, V]:
    """``two_product`` of formulas."""
    return cast("tuple[V, V]", two_product(OPERATORS, a, b))
