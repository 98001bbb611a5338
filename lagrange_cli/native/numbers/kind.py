"""``NumberKind``: what a kind of numbers has to answer, for the recurrences to be written once for all kinds.

A kind writes code: its values name numbers that the code computes. For doubles and vectors they are plain
text, for double-double numbers pairs. None is a number known to be 0: nothing is written for it. A kind that
computes at once, whose values are the numbers themselves, is one as well.
"""

from __future__ import annotations

from collections.abc import Iterable
from fractions import Fraction
from typing import Any, Protocol, TypeAlias, TypeVar

V = TypeVar("V")

Number: TypeAlias = "float | Fraction"
Condition: TypeAlias = Any
"""Whether something holds: as text, or a truth value."""


class Body(Protocol):
    """The function that code is written into."""

    lines: list[str]
    operations: int

    def line(self, text: str) -> None: ...
    def define(self, text: str) -> str: ...


class NumberKind(Protocol[V]):
    """Arithmetic, functions, memory and choices over numbers of one kind.

    ``parts`` are the doubles that a number takes in memory, ``unit`` is its relative rounding error, and
    ``fused`` tells whether a product and a sum take no longer than a sum. Whole powers up to ``products`` are
    written as products.
    """

    parts: int
    unit: float
    fused: bool
    products: int

    @property
    def one(self) -> V: ...
    @property
    def true(self) -> Condition: ...

    def number(self, value: Number) -> V | None:
        """A constant."""

    def add(self, a: V | None, b: V | None) -> V | None: ...
    def sub(self, a: V | None, b: V | None) -> V | None: ...
    def neg(self, a: V | None) -> V | None: ...
    def mul(self, a: V | None, b: V | None) -> V | None: ...
    def div(self, a: V | None, b: V | None) -> V | None: ...

    def fma(self, a: V | None, b: V | None, c: V | None) -> V | None:
        """``a * b + c``."""

    def fms(self, a: V | None, b: V | None, c: V | None) -> V | None:
        """``c - a * b``."""

    def total(self, terms: Iterable[tuple[V | None, V | None]], start: V | None = None) -> V | None:
        """``start`` + sum of products, in any order."""

    def function(self, name: str, *arguments: V | None) -> V:
        """One of the expression language's functions, ``pow`` or ``sqrt``."""

    def normalized(self, a: V | None) -> V | None:
        """The same number in the form in which it is stored."""

    def load(self, pointer: str, index: int | str, beyond: int | str = 0) -> V:
        """``pointer[index]``, and a low part, where numbers have one, from ``beyond`` doubles behind it."""

    def store(self, value: V | None, pointer: str, index: int | str, beyond: int | str = 0) -> None:
        """``pointer[index] = value``, likewise."""

    def magnitude(self, a: V | None) -> V | None:
        """|a|."""

    def larger(self, a: V | None, b: V | None) -> V | None:
        """The larger one."""

    def compare(self, relation: str, a: V | None, b: V | None) -> Condition:
        """Whether ``a`` and ``b`` are in a relation: one of LLVM's words, ``ogt``, ``oeq``, ``one``."""

    def both(self, a: Condition, b: Condition) -> Condition:
        """Whether both hold."""

    def select(self, condition: Condition, yes: V | None, no: V | None) -> V:
        """One or the other."""

    def depth(self, value: V | None) -> int:
        """How many operations follow one another until ``value`` is known; 0 where nobody counts."""


class Written(NumberKind[V], Protocol[V]):
    """A kind that writes code."""

    @property
    def body(self) -> Body: ...
