"""Disks as a kind of numbers: what a function of complex numbers in disks can be.

A disk holds all complex numbers within a radius of its centre, which is real; and a bound from below of their
size, which may say more: a power, an exponential or cosh far from 0 is large all over a disk that contains 0.
(Circular arithmetic: I. Gargantini and P. Henrici, Numer. Math. 18, 305, 1972. A function's radius is the sum
of its Taylor series with the sizes of the coefficients, or of a series that bounds these.)

What is enclosed are analytic functions on a disk around 0, by their values there: a power or logarithm of one
that is nowhere 0 has one branch. Radii contain the rounding of centres; a last factor is to contain theirs.
Where nothing is known, a radius is infinite or not a number.
"""

from __future__ import annotations

from collections.abc import Callable
from fractions import Fraction

from lagrange_cli.native.llvm.function import Function
from lagrange_cli.native.llvm.text import Operand, Value, operand
from lagrange_cli.native.llvm.vector import Bit, Real, constant
from lagrange_cli.native.numbers.double import Emitter
from lagrange_cli.native.numbers.kind import Composed, Number
from lagrange_cli.native.recurrences.evaluation import emit_power

ROUNDING, FUNCTIONS = 2.0**-51, 2.0**-49
"""What sums, products and quotients, and what functions may be off, relative to what they are made of."""
TINY, HUGE = 1e-300, 1e300
"""What underflows and overflows counts as that."""


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
        """What is known of its least size, beside centre and radius; written when it is asked for."""
        if callable(self._bound):
            self._bound = self._bound()
        return self._bound


class Disks(Composed[Disk]):
    """Such disks as a ``NumberKind``: centres are numbers of ``centres``, whose text goes to ``f``; radii are
    vectors of so many ``lanes``, for disks around the same centres where these have one."""

    products = 0  # powers are functions

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
        name = operand(value)
        if name not in self._spread:
            vector = self.centres.REAL != "double"
            if vector:
                real = Real(self.f, self.centres.written(value), self.lanes)
            else:
                real = self.f.splat(Real(self.f, name, 1), self.lanes)
            self._spread[name] = real
        return self._spread[name]

    def all(self, value: float) -> Real:
        """A constant in every lane."""
        return Real(self.f, constant("double", self.lanes, value), self.lanes)

    def size(self, a: Disk) -> Real:
        """|centre|."""
        return self.spread(self.centres.magnitude(a.centre) if a.centre is not None else None)

    def radius(self, a: Disk) -> Real:
        """The radius, written out."""
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
        """The greater one; the other one where one is not a number, of which nothing is known."""
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
        if isinstance(exponent, float) and exponent == 0.5:
            return self.f.function("sqrt", x)
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
        radius = self.with_product(self.size(a) + self.size(b), ROUNDING, self.sum(a.radius, b.radius))
        return Disk(
            centre,
            radius,
            lambda: self.greater(self.least(a) - self.most(b), self.least(b) - self.most(a)),
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
            inverse = Disk(
                centre,
                self.among(least > 0.0, radius),
                lambda: self.all(1.0) / self.most(b),
            )
        return inverse if a.value == 1 else self.times(a, inverse)

    def spread_of(self, centre: Value) -> Real:
        """The size of a centre."""
        return self.spread(None if centre is None else self.centres.magnitude(centre))

    def positive(self, a: Real) -> Real:
        """At least 0."""
        return self.greater(a, self.all(0.0))

    def with_product(self, a: Real, b: float, c: Real | None) -> Real:
        """``c + a * b``"""
        return a * b if c is None else self.f.fused(a, b, c)

    def sum(self, a: Real | None, b: Real | None) -> Real | None:
        """Their sum."""
        return b if a is None else a if b is None else a + b

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
        chosen = Bit(self.f, condition, self.lanes if self.centres.REAL != "double" else 1)
        return Disk(
            self.centres.select(condition, first.centre, second.centre),
            self.f.select(chosen, self.radius(first), self.radius(second)),
            lambda: self.f.select(chosen, self.least(first), self.least(second)),
        )

    # functions

    def function(self, name: str, *arguments: Disk | None) -> Disk:
        given = [self.constant(0) if one is None else one for one in arguments]
        if name == "pow":
            return self._power(*given)
        if name == "sqrt":
            return self._power(given[0], self.constant(0.5))
        centre = self.centres.function(name, *(one.centre for one in given))
        if all(one.radius is None for one in given):
            return Disk(centre, self.spread_of(centre) * FUNCTIONS)
        made: Disk = getattr(self, f"_{name}")(centre, *given)
        return made

    def rounded(self, centre: Value, radius: Real, bound: Callable[[], Real] | None = None) -> Disk:
        """The disk of a function."""
        return Disk(centre, self.f.fused(self.spread_of(centre), FUNCTIONS, radius) + TINY, bound)

    def growth(self, a: Disk) -> tuple[Real, Real]:
        """sinh r and cosh r - 1 of the radius."""
        r = self.radius(a)
        if r.name not in self._growths:
            self._growths[r.name] = self.exp(r)
        e = self._growths[r.name]
        near, inverse = r < 2.0**-8, self.all(1.0) / e
        square = r * r
        sinh = self.f.select(near, self.f.fused(r * square, 0.17, r), (e - inverse) * 0.5)
        return sinh, self.f.select(near, square * 0.501, self.f.fused(e + inverse, 0.5, -1.0))

    def beyond(self, a: Disk) -> Real:
        """By how much the centre's size exceeds the radius: at least so far is the real part from 0."""
        return self.size(a) - self.radius(a)

    def sinh_least(self, a: Disk) -> Real:
        """sinh |Re u|, which neither sinh nor cosh is less than."""
        e = self.exp(self.beyond(a))
        return self.f.fused(e, -FUNCTIONS, (e - self.all(1.0) / e) * 0.5)

    def _exp(self, centre: Value, u: Disk) -> Disk:
        most = self.exp(self.spread(u.centre) + self.radius(u))
        radius = self.f.fused(most, FUNCTIONS, most - self.spread(centre))
        return self.rounded(centre, radius, lambda: self.exp(self.spread(u.centre) - self.radius(u)))

    def _turning(self, u: Disk, own: Value, other: Value) -> Real:
        """|own| sinh r + |other| (cosh r - 1) by addition theorems, as of sin and cos."""
        sinh, cosh = self.growth(u)
        return self.f.fused(self.spread_of(own), sinh, self.spread_of(other) * cosh)

    def _other(self, name: str, u: Disk) -> Operand:
        return self.centres.function(name, u.centre)

    def _sin(self, centre: Value, u: Disk) -> Disk:
        return self.rounded(centre, self._turning(u, self._other("cos", u), centre))

    def _cos(self, centre: Value, u: Disk) -> Disk:
        return self.rounded(centre, self._turning(u, self._other("sin", u), centre))

    def _sinh(self, centre: Value, u: Disk) -> Disk:
        radius = self._turning(u, self._other("cosh", u), centre)
        return self.rounded(centre, radius, lambda: self.sinh_least(u))

    def _cosh(self, centre: Value, u: Disk) -> Disk:
        radius = self._turning(u, self._other("sinh", u), centre)
        return self.rounded(centre, radius, lambda: self.sinh_least(u))

    def _quotient(self, u: Disk, below: str, aside: str) -> Real:
        """sinh r / (|b| (|b| - its radius)), as of tan and tanh, which divide by ``below``."""
        b, c = self._other(below, u), self._other(aside, u)
        size, (sinh, _) = self.spread_of(b), self.growth(u)
        least = size - self._turning(u, c, b)
        return self.among(least > 0.0, sinh / (size * least))

    def _tan(self, centre: Value, u: Disk) -> Disk:
        return self.rounded(centre, self._quotient(u, "cos", "sin"))

    def _tanh(self, centre: Value, u: Disk) -> Disk:
        near, far = self._quotient(u, "cosh", "sinh"), self.beyond(u)
        rest = self.all(1.0) - self.spread_of(centre)
        saturated = rest + self.all(2.0) / (self.exp(far + far) - 1.0)
        return self.rounded(centre, self.lesser(near, self.among(far > 0.0, saturated)))

    def share(self, radius: Real, whole: Real) -> Real:
        """The part of the way to a singularity that a disk goes; infinite beyond."""
        return self.among(radius < whole, radius / whole)

    def minus_log(self, s: Real) -> Real:
        """-log(1 - s), s >= 0; infinite from 1 on. For small s by a bound that does not cancel."""
        small = s < 2.0**-8
        made = -self.log(self.f.select(small, self.all(0.5), self.all(1.0) - s))
        return self.among(s < 1.0, self.f.select(small, self.f.fused(s * s, 0.51, s), made))

    def _log(self, centre: Value, u: Disk) -> Disk:
        return self.rounded(centre, self.minus_log(self.radius(u) / self.size(u)))

    def _atan(self, centre: Value, u: Disk) -> Disk:
        size = self.size(u)
        s = self.radius(u) / self.f.function("sqrt", self.f.fused(size, size, 1.0))
        # coefficient k is sin(k phi) / (k R^k), |phi| <= 1/|u|
        steep = self.among(s < 1.0, s / (size * (self.all(1.0) - s)))
        return self.rounded(centre, self.lesser(self.minus_log(s), steep))

    def _asin(self, centre: Value, u: Disk) -> Disk:
        most = self.most(u)
        rest = self.all(1.0) - most * most
        made = self.radius(u) / self.f.function("sqrt", rest)
        return self.rounded(centre, self.among(rest > 0.0, made))

    _acos = _asin

    def _atan2(self, centre: Value, y: Disk, x: Disk) -> Disk:
        a, b = self.size(y), self.size(x)
        distance = self.f.function("sqrt", self.f.fused(a, a, b * b))
        return self.rounded(centre, self.minus_log((self.radius(y) + self.radius(x)) / distance))

    # powers

    def _power(self, u: Disk, exponent: Disk) -> Disk:
        if u.radius is None and exponent.radius is None and exponent.value is None:
            centre = self.centres.function("pow", u.centre, exponent.centre)
            return Disk(centre, self.spread_of(centre) * FUNCTIONS)
        if exponent.value is not None:
            return self._known_power(u, exponent.value)
        centre = self.centres.function("pow", u.centre, exponent.centre)
        if exponent.radius is None:
            return self._constant_power(centre, u, self.spread(exponent.centre))
        log = self._log(self.centres.function("log", u.centre), u)
        return self._exp(centre, self.times(log, exponent))

    def _known_power(self, u: Disk, exponent: Number) -> Disk:
        """A power whose exponent is known now."""
        size = -exponent if exponent < 0 else exponent
        whole = size == int(size)
        if exponent < 0:
            return self.over(self.one, self._known_power(u, size)) if whole else self._broken(u, exponent)
        if not whole:
            return self._broken(u, exponent)
        n = int(size)
        if n == 1:
            return u
        centre = self.centre_power(u, Fraction(n))
        if u.radius is None:
            return Disk(centre, self.spread_of(centre) * (n * FUNCTIONS))
        most = self.whole_power(self.most(u), n)
        if n == 2:
            radius = self.radius(u) * (self.size(u) + self.most(u))
        else:
            radius = self.f.fused(most, n * FUNCTIONS, most - self.spread_of(centre))
        return Disk(
            centre,
            self.f.fused(self.spread_of(centre), n * ROUNDING, radius) + TINY,
            lambda: self.whole_power(self.positive(self.least(u)), n),
        )

    def centre_power(self, u: Disk, exponent: Number) -> Value:
        """The centre's power."""
        return emit_power(self.centres, u.centre, int(exponent) if exponent == int(exponent) else exponent)

    def whole_power(self, x: Real, n: int) -> Real:
        """x^n, x >= 0."""
        if n > 64:
            return self.power_of(x, float(n))
        result, square = None, x
        while n:
            if n & 1:
                result = square if result is None else result * square
            n >>= 1
            if n:
                square = square * square
        assert result is not None
        return result

    def _broken(self, u: Disk, exponent: Number) -> Disk:
        """A power that is not whole."""
        centre = self.centre_power(u, exponent)
        if u.radius is None:
            return Disk(centre, self.spread_of(centre) * FUNCTIONS)
        return self._constant_power(centre, u, self.all(float(exponent)), positive=exponent > 0)

    def _constant_power(self, centre: Value, u: Disk, exponent: Real, positive: bool | None = None) -> Disk:
        """A power with a constant exponent e.

        Within the disk of convergence |c|^e ((1 - r/|c|)^-|e| - 1), or |c|^e if that is less and 0 < e < 1;
        beyond, if it is nowhere 0, what its size says; and for whole e > 0, (|c| + r)^e - |c|^e.
        """
        f, size, r = self.f, self.size(u), self.radius(u)
        value, s, above = self.spread_of(centre), r / size, f.magnitude(exponent)
        logs = self.minus_log(s)
        grown = self.exp(above * logs)
        near = self.f.select(s < 2.0**-8, self.small_power(s, above), grown - 1.0)
        root = (exponent > 0.0) & (exponent < 1.0)
        near = f.select(root, self.lesser(near, self.all(1.0)), near)
        near = self.among(s < 1.0, value * near)
        least, most = self.least(u), self.most(u)
        extreme = f.select(exponent > 0.0, most, least)
        reached = self.power_of(self.positive(extreme), exponent)
        radius = self.lesser(near, self.among(least > 0.0, reached + value))
        if positive is None:
            whole = f.function("floor", exponent).equals(exponent) & (exponent > 0.0)
            radius = self.lesser(radius, self.among(whole, f.fused(reached, FUNCTIONS, reached - value)))
        radius = f.fused(above * 2.0 + 8.0, value * FUNCTIONS, radius) + TINY

        def bound() -> Real:
            other = f.select(exponent > 0.0, self.least(u), self.most(u))
            return self.power_of(self.positive(other), exponent)

        return Disk(centre, radius, bound)

    def small_power(self, s: Real, e: Real) -> Real:
        """A bound of (1 - s)^-e - 1 for small s that does not cancel: x = -e log(1 - s), x + x^2 e^x / 2."""
        x = self.f.fused(s * s, 0.51, s) * e
        return self.f.fused(x * x * 0.5, self.exp(x), x)
