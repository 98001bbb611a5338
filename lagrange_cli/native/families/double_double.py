"""Double-double numbers in loops over members (see ``vectors``).

High parts are where doubles would be, and low parts so much further behind, the same for all numbers of
``%work`` and for all of ``%constants``. Series are in units of time about as long as a step, as those of
single double-double numbers are (``recurrences.in_memory``).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import ClassVar

from lagrange_cli.native.families.tables import gathered
from lagrange_cli.native.families.vector_dots import Coefficients, Pair
from lagrange_cli.native.interface import CONSTANTS, LANES
from lagrange_cli.native.llvm.flow import Variable
from lagrange_cli.native.llvm.function import Function
from lagrange_cli.native.llvm.vector import Bit, Index, Integer, Pointer, Real
from lagrange_cli.native.numbers.beside import BesideDoubleDouble, beside
from lagrange_cli.native.numbers.double_double import DDReal, DoubleDouble, pair
from lagrange_cli.native.numbers.error_free import fast_sum, two_sum
from lagrange_cli.native.numbers.kind import Number

BEHIND_WORK, BEHIND_CONSTANTS = "@low_work", "@low_constants"
"""The constants of a program that say how far low parts are behind."""


class DoubleDoublePointer(Pointer):
    """A place of numbers whose low parts are ``beyond`` doubles behind."""

    __slots__ = ("beyond",)

    def __init__(self, place: Pointer, beyond: Index) -> None:
        super().__init__(place.body, place.name, 1)
        self.beyond = beyond


class DoubleDoubleLanes(DoubleDouble):
    """Eight numbers side by side as a ``NumberKind``."""

    lanes = LANES

    def __init__(self, vectors: DoubleDoubleVectors) -> None:
        self.vectors = vectors
        super().__init__(vectors.f)
        self.repeated = 1

    @property
    def operations(self) -> int:
        """Floating-point operations of the function so far, each once."""
        return self.body.operations

    def number(self, value: Number) -> DDReal | None:
        return super().number(beside(value, self.vectors.factor))

    def everywhere(self, table: str, first: str, index: int) -> DDReal:
        """One number of ``%constants`` in every lane."""
        one = self.vectors.load(self.vectors.place(table, int(first)), index)
        return self.vectors.splat(one, LANES)


class DoubleDoubleVariable:
    """A variable of such numbers."""

    def __init__(self, f: Function, value: DDReal) -> None:
        self._parts: list[Variable[Real]] = [f.variable(one) for one in value.parts]

    def get(self) -> DDReal:
        """Its value."""
        return DDReal(*(one.get() for one in self._parts))

    def set(self, value: DDReal) -> None:
        """Its value from here on."""
        for variable, one in zip(self._parts, value.parts):
            variable.set(one)


class DoubleDoubleVectors:
    """Double-double numbers in the function ``f``."""

    parts: ClassVar[int] = 2
    times: ClassVar[str] = "double %t, double %tl, double %scale"

    factor: ClassVar[int] = 1
    """Not 1 for numbers in expressions that are beside those of the run (``numbers.beside``)."""

    behind_work: ClassVar[str] = BEHIND_WORK
    """How far low parts are behind in ``%work``."""

    def __init__(self, f: Function) -> None:
        self.f = f
        self.behind = {
            base: f.load_integer(name)
            for base, name in (("%work", self.behind_work), ("%constants", BEHIND_CONSTANTS))
        }
        self.kind = DoubleDoubleLanes(self)

    # memory

    def place(self, base: Pointer | str, index: Index) -> DoubleDoublePointer:
        beyond = base.beyond if isinstance(base, DoubleDoublePointer) else self.behind[str(base)]
        return DoubleDoublePointer(self.f.place(base, index, "double"), beyond)

    def in_state(self, place: Pointer, width: int) -> DoubleDoublePointer:
        return DoubleDoublePointer(place, width)

    def add_to_state(self, row: Integer, first: int, width: int, change: Callable[[], DDReal]) -> None:
        state, at = self.in_state(self.f.pointer("%state"), width), row + first
        self.store(self.load(state, at) + change(), state, at)

    def parts_at(self, base: Pointer, part: int) -> Pointer:
        assert isinstance(base, DoubleDoublePointer)
        return self.f.place(base, base.beyond, "double") if part else base

    def load(self, base: Pointer | str, index: Index = 0) -> DDReal:
        return self.load_row(base, index, 1)

    def store(self, value: DDReal, base: Pointer | str, index: Index = 0) -> None:
        self.store_row(value, base, index)

    def load_row(self, base: Pointer | str, index: Index, lanes: int) -> DDReal:
        place = self.place(base, index)
        return DDReal(*(self.f.load_row(place, at, lanes) for at in (0, place.beyond)))

    def store_row(self, value: DDReal, base: Pointer | str, index: Index) -> None:
        place = self.place(base, index)
        for part, at in zip(value.parts, (0, place.beyond)):
            self.f.store_row(part, place, at)

    def gather(self, base: Pointer | str, places: Pointer) -> DDReal:
        both = (self.parts_at(self.place(base, 0), part) for part in range(self.parts))
        return DDReal(*(Real(self.f, gathered(self.f, one.name, places), LANES) for one in both))

    # numbers

    def zero(self, lanes: int) -> DDReal:
        return DDReal(self.f.zero(lanes))

    def single(self) -> DoubleDouble:
        return BesideDoubleDouble(self.f, CONSTANTS * self.factor)

    def of_single(self, value: DDReal | None) -> DDReal:
        return pair(self.f, 0) if value is None else value

    def constant(self, value: float) -> DDReal:
        return DDReal(self.f.constant(value))

    def fused(self, a: DDReal, b: DDReal, c: DDReal) -> DDReal:
        return a * b + c

    def whole(self, value: Integer) -> DDReal:
        return DDReal(value.to_real())

    def moment(self) -> Sequence[Real]:
        return tuple(Real(self.f, name, 1) for name in ("%t", "%tl", "%scale"))

    def now(self) -> DDReal:
        self.inverse = self.f.constant(1.0) / Real(self.f, "%scale", 1)
        return DDReal(Real(self.f, "%t", 1), Real(self.f, "%tl", 1))

    def at(self, time: Real, low: Real | None = None) -> DDReal:
        return DDReal(time, low)

    def variable(self, value: DDReal) -> DoubleDoubleVariable:
        return DoubleDoubleVariable(self.f, value)

    def select(self, condition: Bit, yes: DDReal, no: DDReal) -> DDReal:
        return DDReal(*(self.f.select(condition, a, b) for a, b in zip(yes.parts, no.parts)))

    def splat(self, one: DDReal, lanes: int) -> DDReal:
        high, low = self.f.splat(one.high, lanes), one.low
        return DDReal(high, low and self.f.splat(low, lanes))

    def lane(self, vector: DDReal, index: Index) -> DDReal:
        return DDReal(*(self.f.lane(part, index) for part in vector.parts))

    def shuffle(self, a: DDReal, lanes: Sequence[int], b: DDReal) -> DDReal:
        return DDReal(*(self.f.shuffle(one, lanes, other) for one, other in zip(a.parts, b.parts)))

    def total(self, vector: DDReal, start: DDReal) -> DDReal:
        for lane in range(LANES):
            start = start + self.lane(vector, lane)
        return start

    def high(self, value: DDReal) -> Real:
        return value.high

    def operand(self, value: DDReal) -> DDReal:
        return value

    def number(self, value: DDReal | None) -> DDReal:
        return self.kind.written(value)

    # divisions

    def quotient(self, a: DDReal, b: DDReal, inverse: DDReal) -> DDReal:
        return a / b

    def divisor(self, k: Index, ahead: int) -> Real:
        return self._real(k, ahead) * self.inverse

    def divided(self, value: DDReal, divisor: Real) -> DDReal:
        return value.divided(self.f.splat(divisor, value.high.lanes))

    def over(self, value: DDReal | None, k: Index, ahead: int) -> DDReal | None:
        return None if value is None else self.divided(value, self._real(k, ahead))

    def integrated(self, value: DDReal | None, k: Index, ahead: int) -> DDReal | None:
        return None if value is None else self.divided(value, self.divisor(k, ahead))

    def rate(self, k: Index, ahead: int) -> DDReal:
        return DDReal(self.f.splat(self.divisor(k, ahead), LANES))

    def _real(self, k: Index, ahead: int) -> Real:
        return self.f.constant(float(k + ahead)) if isinstance(k, int) else (k + ahead).to_real()

    # convolutions

    def dots(
        self, pairs: Sequence[Pair], n: Index, *, same: bool, weighted: bool
    ) -> Sequence[Sequence[DDReal]]:
        return [self._dots(*pair, n, weighted) for pair in pairs]

    def _dots(self, a: Coefficients, b: Coefficients, n: Index, weighted: bool) -> list[DDReal]:
        f, last = self.f, self.f.count(n) if isinstance(n, int) else n
        sums = [Accumulated(self) for _ in range(1 + weighted)]
        with f.loop(1, last) as m:
            (one, low), (other, lower) = (
                self.load_row(series.place, at * (LANES * series.step), LANES).parts
                for series, at in ((a, m), (b, last - m))
            )
            product = one * other
            error = f.fma(low, other, f.fma(one, lower, f.fma(one, other, -product)))
            sums[0].add(product, error)
            if weighted:
                number = f.splat(m.to_real(), LANES)
                larger = number * product
                sums[1].add(larger, f.fma(number, error, f.fma(number, product, -larger)))
        return [one.get() for one in sums]


class Accumulated:
    """A sum of vectors, and apart from it all that was rounded off."""

    def __init__(self, vectors: DoubleDoubleVectors) -> None:
        self._sum, self._rest = (vectors.f.variable(vectors.f.zero(LANES)) for _ in range(2))

    def add(self, value: Real, error: Real) -> None:
        """Add a number and what belongs to it."""
        total, lost = two_sum(self._sum.get(), value)
        self._sum.set(total)
        self._rest.set(self._rest.get() + (lost + error))

    def get(self) -> DDReal:
        """The sum."""
        return DDReal(*fast_sum(self._sum.get(), self._rest.get()))


def beside_double_doubles(factor: int) -> type[DoubleDoubleVectors]:
    """The numbers that constants of a companion are computed in, to many digits."""
    return type("BesideNumbers", (DoubleDoubleVectors,), {"factor": factor // CONSTANTS})


class InConstants(DoubleDoubleVectors):
    """The same for a function whose ``%work`` is a part of the ``%constants``."""

    behind_work = BEHIND_CONSTANTS
