"""What an algebra must offer so that one expression tree can be built over it.

Three algebras exist: ``graph_algebra`` (our hash-consed expression graph; serves ``solve``),
``symbolic`` (sympy; serves what people read) and ``numbers`` (floats; serves parameter values).
Their elements combine with Python's own ``+ - * / **``; all else is asked of the algebra.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, Protocol, TypeVar

E = TypeVar("E")
"""An element of an algebra: a graph node, a sympy expression or a float."""


class Algebra(Protocol[E]):
    """Numbers, symbols and functions, and the derivative of one element by a symbol."""

    def number(self, text: str) -> E:
        """The number a literal such as ``2``, ``0.5`` or ``1e-3`` stands for."""

    def pi(self) -> E:
        """The circle constant."""

    def symbol(self, name: str) -> E:
        """The symbol of that name; the same name gives the same symbol."""

    def function(self, name: str, arguments: Sequence[E]) -> E:
        """One of the elementary functions of ``expression.vocabulary`` applied to elements."""

    def total(self, terms: Sequence[E]) -> E:
        """The sum of one or more elements, in one go."""

    def symbols(self, expression: E) -> Sequence[E]:
        """The symbols that ``expression`` contains, in an order that does not change from run to run."""

    def diff(self, expression: E, symbol: E) -> E:
        """The partial derivative of ``expression`` with respect to ``symbol``."""


Value = Any
"""A built value: an element ``E`` (scalar) or a tuple of elements (vector)."""
