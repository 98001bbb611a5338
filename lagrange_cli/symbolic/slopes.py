"""Derivatives of expressions: each part of an expression once, for all symbols together.

sympy looks for the symbol in all that is below a part, at every level, for one symbol after the other.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import chain

import sympy

from lagrange_cli.expression.symbolic import chained
from lagrange_cli.symbolic.work import folded

Row = Sequence[sympy.Expr]


def slope(expression: sympy.Expr, symbol: sympy.Expr) -> sympy.Expr:
    """The derivative by a symbol."""
    return gradient(expression, [symbol])[0]


def gradient(expression: sympy.Expr, symbols: Row) -> list[sympy.Expr]:
    """The derivatives by ``symbols``."""
    wanted = {*symbols}

    def combine(node: sympy.Expr, inner: list[dict[sympy.Expr, sympy.Expr]]) -> dict[sympy.Expr, sympy.Expr]:
        if not inner:
            return {node: sympy.S.One} if node in wanted else {}
        present = dict.fromkeys(chain.from_iterable(inner))
        return {x: chained(node, x, [one.get(x, sympy.S.Zero) for one in inner]) for x in present}

    found = folded(expression, combine)
    return [found.get(symbol, sympy.S.Zero) for symbol in symbols]


def along_motion(expression: sympy.Expr, q: Row, v: Row, time: sympy.Expr) -> sympy.Expr:
    """d/dt of an expression as far as q and t change, v held: sum_k v_k d/dq_k + d/dt."""
    *slopes, drift = gradient(expression, [*q, time])
    pairs = zip(slopes, v, strict=True)
    return sympy.Add(*(each * own for each, own in pairs if each != 0), drift)
