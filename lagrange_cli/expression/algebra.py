"""What an algebra must offer so that one expression tree can be built over it.

Three algebras exist: ``graph_algebra`` (our hash-consed expression graph, for
``solve``), ``symbolic`` (sympy, for printed equations) and ``numbers`` (floats, for parameter values).
Their elements combine with Python's own ``+ - * / **``; all else is asked of the algebra.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import reduce
from operator import add
from typing import Any, Protocol, TypeVar

E = TypeVar("E")
"""An element of an algebra: a graph node, a sympy expression or a float."""


Value = Any
"""A built value: an element ``E`` (scalar) or a tuple of elements (vector)."""


class Algebra(Protocol[E]):
    """Numbers, symbols and functions, and the derivative of one element by a symbol."""

    def number(self, text: str) -> E:
        """The number a literal such as ``2``, ``0.5`` or ``1e-3`` stands for."""

    def pi(self) -> E:
        """The circle constant."""

    def symbol(self, name: str) -> E:
        """The symbol of that name; the same name gives the same symbol."""

    def function(self, name: str, arguments: Sequence[E]) -> E:
        """A function of scalars of ``expression.vocabulary``, except ``where``, applied to elements."""

    def side(self, u: E, at: int) -> int | None:
        """The sign of ``u``, or ``at`` where it is 0; None where that is not known."""

    def switch(self, u: E, above: E, below: E, at: int) -> E:
        """``above`` where u > 0, ``below`` where u < 0; where u is 0, that of the side ``at``."""

    def both(self, chosen: E, above: Callable[[], Value], below: Callable[[], Value]) -> tuple[Value, Value]:
        """Both branches; ``chosen`` is 1 where the first one applies, 0 where the second one does."""

    def total(self, terms: Sequence[E]) -> E:
        """The sum of one or more elements, in one go."""

    def symbols(self, expression: E) -> Sequence[E]:
        """The symbols that ``expression`` contains, in an order that does not change from run to run."""

    def diff(self, expression: E, symbol: E) -> E:
        """The partial derivative of ``expression`` with respect to ``symbol``."""


class Undecided:
    """An algebra whose elements do not show which branch of a switch applies."""

    def side(self, u: Any, at: int) -> int | None:
        return None

    def both(
        self, chosen: Any, above: Callable[[], Value], below: Callable[[], Value]
    ) -> tuple[Value, Value]:
        return above(), below()


class Decided:
    """An algebra of numbers, which remember no symbol: only the branch that applies is computed."""

    def side(self, u: Any, at: int) -> int | None:
        """Raises ArithmeticError where there is nothing to compare."""
        if u != u:
            raise ArithmeticError("what is compared is not a number")
        return 1 if u > 0 else -1 if u < 0 else at

    def switch(self, u: Any, above: Any, below: Any, at: int) -> Any:
        raise NotImplementedError("the side is known")

    def both(
        self, chosen: Any, above: Callable[[], Value], below: Callable[[], Value]
    ) -> tuple[Value, Value]:
        raise NotImplementedError("the side is known")

    def total(self, terms: Sequence[Any]) -> Any:
        return reduce(add, terms)

    def symbols(self, expression: Any) -> Sequence[Any]:
        raise NotImplementedError("a number remembers no symbol")

    def diff(self, expression: Any, symbol: Any) -> Any:
        raise NotImplementedError("a number remembers no symbol")
