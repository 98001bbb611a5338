"""The algebra of floats: what parameters, masses and initial values are evaluated over."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from typing import Any, ClassVar, TypeVar

from lagrange_cli.decimals import decimal
from lagrange_cli.expression.algebra import Decided
from lagrange_cli.expression.build import Scope, build
from lagrange_cli.expression.syntax import ExpressionError, Tree
from lagrange_cli.expression.vocabulary import FUNCTIONS

T = TypeVar("T")


def sign(x: Any) -> float:
    """-1, 0 or 1."""
    return float((x > 0) - (x < 0))


class NumberAlgebra(Decided):
    """``Algebra[float]``; a symbol is the number that ``values`` has for it."""

    FUNCTIONS: ClassVar[Mapping[str, Callable[..., float]]] = {
        **{name: getattr(math, name) for name in FUNCTIONS},
        "abs": abs,
        "sign": sign,
        "min": min,
        "max": max,
    }

    def __init__(self, values: Mapping[str, float] | None = None) -> None:
        self.values = values or {}

    def number(self, text: str) -> float:
        return float(text)

    def pi(self) -> float:
        return math.pi

    def symbol(self, name: str) -> float:
        return self.values[name]

    def function(self, name: str, arguments: Sequence[float]) -> float:
        """Raises ArithmeticError outside the function's domain, OverflowError beyond the largest float."""
        try:
            return self.FUNCTIONS[name](*arguments)
        except ValueError as error:
            shown = ", ".join(decimal(argument) for argument in arguments)
            raise ArithmeticError(f"{name}({shown}) is not a real number") from error

    def finite(self, tree: Tree, value: Any, *, fades: bool = False) -> Any:
        """``value``, which ``tree`` was built to, if it is a finite number; ``ExpressionError`` else, as
        where it is too small for a double, unless it ``fades``: is 0 then."""
        return finite(tree, value)

    def positive(self, value: Any) -> bool:
        """Whether a number is greater than 0."""
        return bool(value > 0)

    def fault(self, check: Callable[[Sequence[float]], T | None], values: Sequence[Any]) -> T | None:
        """What is wrong with several numbers by a ``check``."""
        return check([float(one) for one in values])


def evaluate(tree: Tree, scope: Scope | None = None) -> float:
    """The finite number ``tree`` stands for; ``scope`` gives the values of its names.

    Raises:
        ExpressionError: for a vector, a division by zero, a value outside a function's domain, or a
            result that is infinite or not a number.
    """
    return finite(tree, build(tree, scope or NumberAlgebra().symbol, NumberAlgebra()))


def finite(tree: Tree, value: Any) -> float:
    """``value``, which ``tree`` was built to, if it is a finite number; raises ``ExpressionError`` else."""
    if isinstance(value, tuple):
        raise ExpressionError(tree.span, "expected a number, found a vector", "take a component or norm()")
    if not math.isfinite(value):
        raise ExpressionError(
            tree.span, f"the value is not a finite number ({value})", "check the numbers it is computed from"
        )
    return float(value)
