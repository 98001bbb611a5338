"""Arithmetic of disks: enclosures of sums, products and quotients of complex numbers in disks.

A disk holds all complex numbers within a radius of its centre, which is real; and a bound from below of their
size, which may say more: a power, an exponential or cosh far from 0 is large all over a disk that contains 0.
(Circular arithmetic: I. Gargantini and P. Henrici, Numer. Math. 18, 305, 1972.)

Radii include
the rounding of centres; a last factor includes their own.
Where nothing is known, a radius is infinite or not a number.
"""

from __future__ import annotations

from collections.abc import Callable

from lagrange_cli.native.llvm.function import Function
from lagrange_cli.native.llvm.text import Operand, Value, constant, operand
from lagrange_cli.native.llvm.vector import Bit, Real
from lagrange_cli.native.numbers.double import Emitter
from lagrange_cli.native.numbers.kind import Number, NumberKind

ROUNDING = 2.0**-51
"""The rounding error of sums, products and quotients, relative to their operands."""
TINY, HUGE = 1e-300, 1e300
"""Numbers that underflow or overflow count as this."""


class Disk:
    """A centre, a radius (None: a point), and a bound from below of the size. ``value`` is that of a constant
    that is known now."""

    __slots__ = ("_bound", "centre", "radius", "value")

    def __init__(
        self,
        centre: Value,
        radius: Real | None = None,
        bound: Callable[[], Real | None] | None = None,
        value: Number | None = None,
    ) -> None:
        self.centre: Value = centre
        self.radius: Real | None = radius
        self.value: Number | None = value
        self._bound: Callable[[], Real | None] | Real | None = bound

    def bound(self) -> Real | None:
        """The lower bound of its size, besides centre and radius; written when it is used."""
        if callable(self._bound):
            self._bound = self._bound()
        return self._bound


class DiskArithmetic(NumberKind[Disk]):
    """All that ``Disks`` has but functions. Centres are numbers of ``centres``, whose text goes to ``f``;
    radii are vectors of so many ``lanes``, for disks around the same centres."""

    several = False
    """Whether each lane has a centre of its own."""

    def __init__(self, f: Function, centres: Emitter, lanes: int) -> None:
        self.f, self.centres, self.lanes = f, centres, lanes
        self.unit = centres.unit
        self.one = self.constant(1)
        self.true = centres.true
        self._spread: dict[Operand, Real] = {}
        self._growths: dict[str, Real] = {}

    # what is there to begin with

    def constant(self, value: Number) -> Disk:
        """A number that is known now."""
        return Disk(self.centres.number(value), value=value)

    def number(self, value: Number) -> Disk | None:
        return None if value == 0 else self.constant(value)

    def load(self, pointer: str, index: int | str, beyond: int | str = 0) -> Disk:
        return Disk(self.centres.load(pointer, index, beyond))

    # radii

    def spread(self, value: Value) -> Real:
        """A centre's number in every lane of radii."""
        if self.several:
            return Real(self.f, self.centres.written(value), self.lanes)
        name = operand(value)
        if name not in self._spread:
            self._spread[name] = self.f.splat(Real(self.f, name, 1), self.lanes)
        return self._spread[name]

    def all(self, value: float) -> Real:
        """A constant in every lane."""
        return Real(self.f, constant("double", self.lanes, value), self.lanes)

    def size(self, a: Disk) -> Real:
        """|centre|."""
        return self.spread_of(a.centre)

    def spread_of(self, centre: Value) -> Real:
        """The size of a centre."""
        return self.spread(None if centre is None else self.centres.magnitude(centre))

    def radius(self, a: Disk) -> Real:
        """The radius as a value, also where it is 0."""
        return self.all(0.0) if a.radius is None else a.radius

    def most(self, a: Disk) -> Real:
        """The greatest size."""
        return self.size(a) if a.radius is None else self.size(a) + a.radius

    def least(self, a: Disk) -> Real:
        """The least size that is known; not above 0 if it may be 0."""
        if a.radius is None:
            return self.size(a)
        least, bound = self.size(a) - a.radius, a.bound()
        return least if bound is None else self.greater(least, bound)

    def greater(self, a: Real, b: Real) -> Real:
        """The greater one; the other one where one is nan, that is, unknown."""
        return self.f.function("maxnum", a, b)

    def lesser(self, a: Real, b: Real) -> Real:
        """The lesser one, likewise."""
        return self.f.function("minnum", a, b)

    def exp(self, x: Real) -> Real:
        """e^x"""
        return self.elementary("exp", x, self.all(0.0))

    def log(self, x: Real) -> Real:
        """ln x"""
        return self.elementary("log", x)

    def power_of(self, x: Real, exponent: float | Real) -> Real:
        """x^exponent for x >= 0."""
        return self.elementary("pow", x, exponent if isinstance(exponent, Real) else self.all(exponent))

    def elementary(self, name: str, *arguments: Real) -> Real:
        """A function of all lanes."""
        return self.f.call(Real, f"{name}.{self.lanes}", *arguments, lanes=self.lanes)

    def among(self, condition: Bit, value: Real, other: float = float("inf")) -> Real:
        """A value where a condition holds, and another one elsewhere."""
        return self.f.select(condition, value, self.all(other))

    # arithmetic

    def plus(self, a: Disk, b: Disk) -> Disk:
        centre = self.centres.add(a.centre, b.centre)
        radius = (self.size(a) + self.size(b)) * ROUNDING
        for one in (a.radius, b.radius):
            radius = radius if one is None else radius + one
        return Disk(
            centre, radius, lambda: self.greater(self.least(a) - self.most(b), self.least(b) - self.most(a))
        )

    def minus(self, a: Disk) -> Disk:
        return Disk(self.centres.neg(a.centre), a.radius, a.bound, None if a.value is None else -a.value)

    def times(self, a: Disk, b: Disk) -> Disk:
        if a.value == 1 or b.value == 1:
            return b if a.value == 1 else a
        centre = self.centres.mul(a.centre, b.centre)
        if a.value is not None and b.value is not None:
            return Disk(centre, self.spread_of(centre) * ROUNDING)
        one, other = (a, b) if a.radius is None else (b, a)
        rounding = self.spread_of(centre) * ROUNDING
        if other.radius is None:
            radius = rounding
        elif one.radius is None:
            radius = self.f.fused(self.size(one), other.radius, rounding)
        else:
            radius = self.f.fused(self.size(a), self.radius(b), rounding)
            radius = self.f.fused(self.radius(a), self.most(b), radius)
        return Disk(centre, radius, lambda: self.positive(self.least(a)) * self.positive(self.least(b)))

    def over(self, a: Disk, b: Disk) -> Disk:
        centre = self.centres.div(self.one.centre, b.centre)
        size = self.spread_of(centre)
        if b.radius is None:
            inverse = Disk(centre, size * ROUNDING)
        else:
            least = self.lesser(self.least(b), self.all(HUGE))
            most = self.all(1.0) / least
            radius = self.lesser(self.radius(b) * size * most, size + most) + (size * ROUNDING + TINY)
            inverse = Disk(centre, self.among(least > 0.0, radius), lambda: self.all(1.0) / self.most(b))
        return inverse if a.value == 1 else self.times(a, inverse)

    def positive(self, a: Real) -> Real:
        """At least 0."""
        return self.greater(a, self.all(0.0))

    # choices

    def compare(self, relation: str, a: Disk | None, b: Disk | None) -> Operand:
        return self.centres.compare(relation, self.centre(a), self.centre(b))

    def centre(self, a: Disk | None) -> Value:
        """The centre of a disk, or of what is 0."""
        return None if a is None else a.centre

    def store(self, value: Disk | None, pointer: str, index: int | str, beyond: int | str = 0) -> None:
        self.centres.store(self.centre(value), pointer, index, beyond)

    def both(self, a: Operand, b: Operand) -> Operand:
        return self.centres.both(a, b)

    def select(self, condition: Operand, yes: Disk | None, no: Disk | None) -> Disk:
        first, second = (self.constant(0) if one is None else one for one in (yes, no))
        chosen = Bit(self.f, condition, 1)
        return Disk(
            self.centres.select(condition, first.centre, second.centre),
            self.f.select(chosen, self.radius(first), self.radius(second)),
            lambda: self.f.select(chosen, self.least(first), self.least(second)),
        )
