"""What loops over members do with numbers, in each kind: vectors of eight of them, and single ones.

The kinds are doubles (here) and double-double numbers (``pairs``).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial
from typing import Any, ClassVar, Protocol, TypeAlias

from lagrange_cli.native.families.spans import divided
from lagrange_cli.native.families.tables import gathered
from lagrange_cli.native.families.vector_dots import Pair, dots
from lagrange_cli.native.interface import LANES
from lagrange_cli.native.llvm.function import Function
from lagrange_cli.native.llvm.text import ZERO, Operand, table
from lagrange_cli.native.llvm.vector import Bit, Index, Integer, Pointer, Real
from lagrange_cli.native.numbers.beside import BesideLanes
from lagrange_cli.native.numbers.double import Emitter
from lagrange_cli.native.numbers.error_free import two_sum
from lagrange_cli.native.numbers.lanes import LaneEmitter
from lagrange_cli.native.recurrences.stage import reciprocal_rest

Numbers: TypeAlias = Any
"""A vector of numbers, or a single one: a ``Real``, or a ``DDReal``. It has operators."""
Operands: TypeAlias = Any
"""The same as values of the kind of numbers, in which expressions are written."""
Divisor: TypeAlias = Any
"""What coefficients are divided by."""


class Vectors(Protocol):
    """Memory, choices and sums of numbers of so many ``parts``, in the function ``f``; ``kind`` is the
    arithmetic of vectors. A place in memory is that of high parts."""

    parts: ClassVar[int]
    times: ClassVar[str]
    """The arguments of ``@jet`` that are times."""
    f: Function
    kind: Any

    def __init__(self, f: Function) -> None: ...

    def place(self, base: Pointer | str, index: Index) -> Pointer:
        """The address of a number."""

    def in_state(self, place: Pointer, width: int) -> Pointer:
        """A place in the state, whose low parts are ``width`` behind."""

    def add_to_state(self, row: Integer, first: int, width: int, change: Callable[[], Numbers]) -> None:
        """Add a number to the ``row``-th row of the state behind the ``first`` one; low parts are ``width``
        behind."""

    def load(self, base: Pointer | str, index: Index = 0) -> Numbers:
        """A single number."""

    def store(self, value: Numbers, base: Pointer | str, index: Index = 0) -> None:
        """The same, stored."""

    def load_row(self, base: Pointer | str, index: Index, lanes: int) -> Numbers:
        """``lanes`` numbers side by side."""

    def store_row(self, value: Numbers, base: Pointer | str, index: Index) -> None:
        """The same, stored."""

    def gather(self, base: Pointer | str, places: Pointer) -> Numbers:
        """Eight numbers at eight places."""

    def parts_at(self, base: Pointer, part: int) -> Pointer:
        """Where the high (0) or the low parts (1) of numbers are."""

    def single(self) -> Any:
        """The arithmetic of single numbers."""

    def of_single(self, value: Operands) -> Numbers:
        """A single number from its value there."""

    def zero(self, lanes: int) -> Numbers:
        """0 in every lane."""

    def constant(self, value: float) -> Numbers:
        """A constant, a single one."""

    def fused(self, a: Numbers, b: Numbers, c: Numbers) -> Numbers:
        """a * b + c."""

    def whole(self, value: Integer) -> Numbers:
        """A whole number."""

    def moment(self) -> Sequence[Real]:
        """The ``times``."""

    def now(self) -> Numbers:
        """The same as a number."""

    def at(self, time: Real, low: Real | None = None) -> Numbers:
        """A time, whose low part may be known."""

    def variable(self, value: Numbers) -> Any:
        """A variable with its first value."""

    def select(self, condition: Bit, yes: Numbers, no: Numbers) -> Numbers:
        """One or the other."""

    def splat(self, one: Numbers, lanes: int) -> Numbers:
        """A number in every lane."""

    def lane(self, vector: Numbers, index: Index) -> Numbers:
        """One lane."""

    def shuffle(self, a: Numbers, lanes: Sequence[int], b: Numbers) -> Numbers:
        """Lanes of two vectors."""

    def total(self, vector: Numbers, start: Numbers) -> Numbers:
        """All lanes added to ``start``."""

    def high(self, value: Numbers) -> Real:
        """The nearest doubles."""

    def operand(self, value: Numbers) -> Operands:
        """It as a value of the kind."""

    def number(self, value: Operands) -> Numbers:
        """The other way."""

    def quotient(self, a: Numbers, b: Numbers, inverse: Numbers) -> Numbers:
        """a / b, given 1/b as it is rounded."""

    def divisor(self, k: Index, ahead: int) -> Divisor:
        """k + ahead, in units of the series' time: what the coefficients of a rate are divided by."""

    def divided(self, value: Numbers, divisor: Divisor) -> Numbers:
        """By it."""

    def over(self, value: Operands, k: Index, ahead: int) -> Operands:
        """By the number k + ahead."""

    def integrated(self, value: Operands, k: Index, ahead: int) -> Operands:
        """By k + ahead, in units of the series' time."""

    def rate(self, k: Index, ahead: int) -> Operands:
        """k + ahead, in these units, by which a coefficient is multiplied in a derivative."""

    def dots(
        self, pairs: Sequence[Pair], n: Index, *, same: bool, weighted: bool
    ) -> Sequence[Sequence[Operands]]:
        """sum_{m=1}^{n-1} a[m] b[n-m] of each pair of series, and that of m a[m] b[n-m] if it is
        ``weighted``; ``same``: a is b."""


class DoubleVectors:
    """Doubles: what a ``Function`` has."""

    parts: ClassVar[int] = 1
    times: ClassVar[str] = "double %t"

    emitter: ClassVar[Any] = LaneEmitter
    """What makes the arithmetic of a function."""

    def __init__(self, f: Function) -> None:
        self.f = f
        self.kind: LaneEmitter = self.emitter(f)
        self.load, self.store, self.load_row, self.store_row = f.load, f.store, f.load_row, f.store_row
        self.zero, self.select, self.splat, self.lane, self.shuffle = (
            f.zero, f.select, f.splat, f.lane, f.shuffle
        )  # fmt: skip
        self.variable, self.constant, self.fused = f.variable, f.constant, f.fused

    def place(self, base: Pointer | str, index: Index) -> Pointer:
        return self.f.place(base, index, "double")

    def in_state(self, place: Pointer, width: int) -> Pointer:
        return place

    def add_to_state(self, row: Integer, first: int, width: int, change: Callable[[], Real]) -> None:
        f = self.f
        high, low = f.load("%state", row + first), f.load("%state", row + (first + width))
        total, error = two_sum(high, change())
        total, error = two_sum(total, error + low)
        f.store(total, "%state", row + first)
        f.store(error, "%state", row + (first + width))

    def gather(self, base: Pointer | str, places: Pointer) -> Real:
        name = base if isinstance(base, str) else base.name
        return Real(self.f, gathered(self.f, name, places), LANES)

    def parts_at(self, base: Pointer, part: int) -> Pointer:
        return base

    def single(self) -> Emitter:
        return Emitter(self.f)

    def of_single(self, value: Operand | None) -> Real:
        return Real(self.f, ZERO if value is None else value, 1)

    def whole(self, value: Integer) -> Real:
        return value.to_real()

    def moment(self) -> Sequence[Real]:
        return (Real(self.f, "%t", 1),)

    def now(self) -> Real:
        return Real(self.f, "%t", 1)

    def at(self, time: Real, low: Real | None = None) -> Real:
        return time

    def total(self, vector: Real, start: Real) -> Real:
        return self.f.reduce("fadd", vector, start)

    def high(self, value: Real) -> Real:
        return value

    def operand(self, value: Real) -> Operand:
        return value.name

    def number(self, value: Operand | None) -> Real:
        return Real(self.f, self.kind.written(value), LANES)

    def quotient(self, a: Real, b: Real, inverse: Real) -> Real:
        """Correctly rounded but in rare cases."""
        rough, f = a * inverse, self.f
        return f.fused(f.fused(-rough, b, a), inverse, rough)

    def divisor(self, k: Index, ahead: int) -> tuple[Real, Real]:
        name = str(k) if isinstance(k, int) else k.name
        one, rest = (self.kind.everywhere(table, name, ahead) for table in ("@reciprocals", "@rests"))
        return Real(self.f, one, LANES), Real(self.f, rest, LANES)

    def divided(self, value: Real, divisor: tuple[Real, Real]) -> Real:
        parts = (one if value.lanes == LANES else self.f.lane(one, 0) for one in divisor)
        return divided(self.f, value, *parts)

    def over(self, value: Operand | None, k: Index, ahead: int) -> Operand | None:
        """Correctly rounded except for the product of two small numbers."""
        kind = self.kind
        if isinstance(k, int):
            inverse, rest = kind.number(1.0 / (k + ahead)), kind.number(reciprocal_rest(k + ahead))
        else:
            inverse, rest = (kind.everywhere(f"@{name}", k.name, ahead) for name in ("reciprocals", "rests"))
        return kind.fma(value, inverse, kind.mul(value, rest))

    integrated = over

    def rate(self, k: Index, ahead: int) -> Operand | None:
        if isinstance(k, int):
            return self.kind.number(k + ahead)
        return self.kind.everywhere("@numbers", k.name, ahead)

    def dots(
        self, pairs: Sequence[Pair], n: Index, *, same: bool, weighted: bool
    ) -> Sequence[Sequence[Operand]]:
        return dots(self.f, pairs, n, same=same, weighted=weighted)


def beside_doubles(factor: int, kind: type[BesideLanes] = BesideLanes) -> type[DoubleVectors]:
    """The doubles of a companion (``numbers.beside``)."""
    emitter = staticmethod(partial(kind, factor=factor))
    return type("BesideDoubles", (DoubleVectors,), {"emitter": emitter})


def rests(size: int) -> str:
    """The table of the rounding errors of 1/m."""
    return table("rests", [reciprocal_rest(m) if m else 0.0 for m in range(size)], "double")
