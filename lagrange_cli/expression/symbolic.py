"""The algebra of sympy expressions: what people read, and what needs algebra, is built over it."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from math import isinf

import sympy

from lagrange_cli.expression import symbolic_switches as switches
from lagrange_cli.expression.algebra import Undecided


def angle(y: sympy.Expr, x: sympy.Expr) -> sympy.Expr:
    """atan2(y, x), which is 0 at the origin, as in all kinds of numbers. (In sympy it is no number there.)"""
    return sympy.S.Zero if y.is_zero and x.is_zero else sympy.atan2(y, x)


FUNCTIONS: dict[str, Callable[..., sympy.Expr]] = {
    "sin": sympy.sin, "cos": sympy.cos, "tan": sympy.tan,
    "asin": sympy.asin, "acos": sympy.acos, "atan": sympy.atan, "atan2": angle,
    "sinh": sympy.sinh, "cosh": sympy.cosh, "tanh": sympy.tanh,
    "exp": sympy.exp, "log": sympy.log, "sqrt": sympy.sqrt,
    "abs": switches.Absolute, "sign": switches.Sign, "min": switches.Least, "max": switches.Largest,
}  # fmt: skip


NOWHERE = frozenset({sympy.nan, sympy.zoo, sympy.oo, -sympy.oo})
"""What is no number."""


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


class SympyAlgebra(Undecided):
    """``Algebra[sympy.Expr]``.

    Numbers are exact rationals, so that nothing is lost and like terms cancel. Symbols carry no
    assumptions: those read back from printed text are then the same, and sqrt(r**2) stays as it was
    written instead of turning into Abs(r), whose derivative the expression language does not have.
    """

    def __init__(self) -> None:
        self._slopes = Slopes()

    def number(self, text: str) -> sympy.Expr:
        """The exact rational that a literal stands for: 9.81 is 981/100. Raises ``OverflowError``."""
        size = float(text)
        if isinf(size):
            raise OverflowError
        # 0 for a float is 0 here: the digits of 1e-999999999 would not fit into memory
        return sympy.Rational(text.replace("_", "")) if size else sympy.S.Zero

    def pi(self) -> sympy.Expr:
        """The circle constant."""
        return sympy.pi

    def symbol(self, name: str) -> sympy.Expr:
        """The symbol of that name."""
        return sympy.Symbol(name)

    def function(self, name: str, arguments: Sequence[sympy.Expr]) -> sympy.Expr:
        """One of the functions of ``expression.vocabulary``. Raises ``ZeroDivisionError`` where an argument
        has been divided by 0."""
        if any(one in NOWHERE for one in arguments):
            raise ZeroDivisionError
        return FUNCTIONS[name](*arguments)

    def switch(self, u: sympy.Expr, above: sympy.Expr, below: sympy.Expr, at: int) -> sympy.Expr:
        """A ``switches.Switch``."""
        return switches.Switch(u, above, below, sympy.Integer(at))

    def total(self, terms: Sequence[sympy.Expr]) -> sympy.Expr:
        """The sum of the terms."""
        return sympy.Add(*terms)

    def symbols(self, expression: sympy.Expr) -> list[sympy.Expr]:
        """The symbols in ``expression``, by name."""
        return sorted(expression.free_symbols, key=str)

    def diff(self, expression: sympy.Expr, symbol: sympy.Expr) -> sympy.Expr:
        """The partial derivative of ``expression`` by ``symbol``."""
        return self._slopes.slope(expression, symbol)
