"""Sums and products of two numbers without loss: the rounded result, and its rounding error.

T. J. Dekker, Numerische Mathematik 18 (1971); D. E. Knuth, The Art of Computer Programming 2, sec. 4.2.2.
Each is written once: for whatever has operators (values in code, arrays, formulas), and for the numbers of a
``kind`` of doubles, where None is 0.
"""

from __future__ import annotations

import operator
from typing import Any

from lagrange_cli.native.numbers.kind import V


class Operators:
    """The operations of what has operators."""

    add = staticmethod(operator.add)
    sub = staticmethod(operator.sub)
    mul = staticmethod(operator.mul)
    neg = staticmethod(operator.neg)

    @staticmethod
    def exact_fma(a: Any, b: Any, c: Any) -> Any:
        """For values of ``llvm.vector``."""
        return a.body.fma(a, b, c)


NONE: Any = None


def two_sum(a: V, b: V, kind: Any = Operators) -> tuple[V, V]:
    """a + b and its rounding error."""
    if a is None or b is None:
        return (b if a is None else a), NONE
    total = kind.add(a, b)
    back = kind.sub(total, a)
    return total, kind.add(kind.sub(a, kind.sub(total, back)), kind.sub(b, back))


def fast_sum(a: V, b: V) -> tuple[V, V]:
    """a + b and its rounding error, where |a| >= |b|, of what has operators."""
    total = operator.add(a, b)
    return total, operator.sub(b, operator.sub(total, a))


def two_product(a: V, b: V, kind: Any = Operators) -> tuple[V, V]:
    """a * b and its rounding error."""
    product = kind.mul(a, b)
    return product, NONE if product is None else kind.exact_fma(a, b, kind.neg(product))
