"""``NumberKind``: the operations that a kind of numbers provides, so that recurrences are written once for
all.

A kind writes code: its values name numbers that the code computes. For doubles and vectors they are plain
text, for double-double numbers pairs. None is a number known to be 0: nothing is written for it. A kind that
computes at once, whose values are the numbers themselves, is one as well.
"""

from __future__ import annotations

import operator
from abc import ABC, abstractmethod
from collections.abc import Iterable
from typing import TYPE_CHECKING, Any, Generic, TypeAlias, TypeVar, cast

if TYPE_CHECKING:
    from fractions import Fraction

    from lagrange_cli.native.llvm.function import Function

V = TypeVar("V")

Number: TypeAlias = "float | Fraction"
Condition: TypeAlias = Any
"""Whether something holds: as text, or a truth value."""


class NumberKind(ABC, Generic[V]):
    """Arithmetic, functions, memory and choices over numbers of one kind.

    ``parts`` are the doubles that a number takes in memory, ``unit`` is its relative rounding error, and
    ``fused`` tells whether a product and a sum take no longer than a sum. Whole powers up to ``products`` are
    written as products.

    Arithmetic follows from ``plus``, ``minus``, ``times`` and ``over``, which never see None: operators of
    the numbers themselves, unless they are overridden.
    """

    parts: int = 1
    unit: float
    fused: bool = False
    products: int = 16
    one: V
    true: Condition = True

    @abstractmethod
    def number(self, value: Number) -> V | None:
        """A constant."""

    def plus(self, a: V, b: V) -> V:
        made: V = operator.add(a, b)
        return made

    def minus(self, a: V) -> V:
        """The opposite number."""
        made: V = operator.neg(cast("Any", a))
        return made

    def times(self, a: V, b: V) -> V:
        made: V = operator.mul(a, b)
        return made

    def over(self, a: V, b: V) -> V:
        made: V = operator.truediv(a, b)
        return made

    def add(self, a: V | None, b: V | None) -> V | None:
        return b if a is None else a if b is None else self.plus(a, b)

    def neg(self, a: V | None) -> V | None:
        return None if a is None else self.minus(a)

    def sub(self, a: V | None, b: V | None) -> V | None:
        return self.add(a, self.neg(b))

    def mul(self, a: V | None, b: V | None) -> V | None:
        return None if a is None or b is None else self.times(a, b)

    def div(self, a: V | None, b: V | None) -> V | None:
        return None if a is None or b is None else self.over(a, b)

    def fma(self, a: V | None, b: V | None, c: V | None) -> V | None:
        """``a * b + c``."""
        return self.add(c, self.mul(a, b))

    def fms(self, a: V | None, b: V | None, c: V | None) -> V | None:
        """``c - a * b``."""
        return self.sub(c, self.mul(a, b))

    def total(self, terms: Iterable[tuple[V | None, V | None]], start: V | None = None) -> V | None:
        """``start`` + sum of products, in any order."""
        for a, b in terms:
            start = self.fma(a, b, start)
        return start

    @abstractmethod
    def function(self, name: str, *arguments: V | None) -> V:
        """One of the expression language's functions, ``pow`` or ``sqrt``."""

    def normalized(self, a: V | None) -> V | None:
        """The same number in the form in which it is stored."""
        return a

    @abstractmethod
    def load(self, pointer: str, index: int | str, beyond: int | str = 0) -> V:
        """``pointer[index]``, and a low part, where numbers have one, from ``beyond`` doubles behind it."""

    @abstractmethod
    def store(self, value: V | None, pointer: str, index: int | str, beyond: int | str = 0) -> None:
        """``pointer[index] = value``, likewise."""

    def magnitude(self, a: V | None) -> V | None:
        """|a|."""
        return None if a is None else self.select(self.compare("olt", a, None), self.minus(a), a)

    def larger(self, a: V | None, b: V | None) -> V | None:
        """The larger one."""
        return self.select(self.compare("ogt", a, b), a, b)

    @abstractmethod
    def compare(self, relation: str, a: V | None, b: V | None) -> Condition:
        """Whether ``a`` and ``b`` are in a relation: one of LLVM's words, ``ogt``, ``oeq``, ``one``."""

    @abstractmethod
    def both(self, a: Condition, b: Condition) -> Condition:
        """Whether both hold."""

    @abstractmethod
    def select(self, condition: Condition, yes: V | None, no: V | None) -> V:
        """One or the other."""

    def depth(self, value: V | None) -> int:
        """The number of successive operations until ``value`` is known; 0 if they are not counted."""
        return 0


class Written(NumberKind[V]):
    """A kind that writes code, into a function's ``body``."""

    body: Function
