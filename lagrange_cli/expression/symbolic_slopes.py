"""Derivatives of sympy expressions by the chain rule, each part of an expression once."""

from __future__ import annotations

from collections.abc import Sequence

import sympy


class Slopes:
    """Derivatives by symbols; those of parts that expressions share are kept."""

    def __init__(self) -> None:
        self._known: dict[sympy.Expr, dict[sympy.Expr, sympy.Expr]] = {}

    def slope(self, expression: sympy.Expr, symbol: sympy.Expr) -> sympy.Expr:
        """The derivative of ``expression`` by ``symbol``."""
        known = self._known.setdefault(symbol, {symbol: sympy.S.One})
        pending = [expression]
        while pending:
            node = pending[-1]
            missing = [one for one in node.args if one not in known] if node not in known else []
            if missing:
                pending += missing
                continue
            pending.pop()
            if node not in known:
                slopes = [known[one] for one in node.args]
                known[node] = chained(node, symbol, slopes) if any(slopes) else sympy.S.Zero
        return known[expression]


def chained(node: sympy.Expr, symbol: sympy.Expr, slopes: Sequence[sympy.Expr]) -> sympy.Expr:
    """The derivative of an expression by a symbol, from those of its arguments."""
    if node.is_Add:
        return sympy.Add(*slopes)
    if node.is_Mul:
        factors, each = node.args, enumerate(slopes)
        return sympy.Add(*(sympy.Mul(*factors[:i], own, *factors[i + 1 :]) for i, own in each if own != 0))
    if node.is_Pow and slopes[1] == 0:
        return node * (slopes[0] * node.exp / node.base)
    if type(node)._eval_derivative is sympy.Function._eval_derivative:
        return sympy.Add(*(node.fdiff(i) * own for i, own in enumerate(slopes, 1) if own != 0))
    return node.diff(symbol)
