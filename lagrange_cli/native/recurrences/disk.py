"""Functions of disks (see ``disk_arithmetic``): enclosures of sines, logarithms, powers of the numbers in
them.

A function's radius is the sum of its Taylor series with the sizes of the coefficients, or of a series that
bounds these. What is enclosed are analytic functions on a disk around 0, by their values there: a power or
logarithm of one that is nowhere 0 has one branch.
"""

from __future__ import annotations

import operator
from collections.abc import Callable
from fractions import Fraction

from lagrange_cli.native.llvm.text import Operand, Value
from lagrange_cli.native.llvm.vector import Real
from lagrange_cli.native.numbers.kind import Number
from lagrange_cli.native.recurrences.disk_arithmetic import ROUNDING, TINY, Disk, DiskArithmetic
from lagrange_cli.native.recurrences.evaluation import emit_power, whole_power

FUNCTIONS = 2.0**-49
"""The relative rounding error of functions."""
MOST_ROOTS = 16
"""Half integers up to this are powers of square roots: logarithms and exponentials take ten times as long."""
PARTNERS = {"sin": "cos", "cos": "sin", "sinh": "cosh", "cosh": "sinh"}
"""Functions with addition theorems, in which these are the other ones."""


class Disks(DiskArithmetic):
    """Disks as a kind of numbers."""

    products = 0  # powers are functions

    def function(self, name: str, *arguments: Disk | None) -> Disk:
        given = [self.constant(0) if one is None else one for one in arguments]
        if name == "pow":
            return self._power(*given)
        if name == "sqrt":
            return self._power(given[0], self.constant(0.5))
        centre = self.centres.function(name, *(one.centre for one in given))
        if all(one.radius is None for one in given):
            return Disk(centre, self.spread_of(centre) * FUNCTIONS)
        if name in PARTNERS:
            return self._by_addition(name, centre, *given)
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

    def _by_addition(self, name: str, centre: Value, u: Disk) -> Disk:
        """A sine or cosine, or a hyperbolic one."""
        radius = self._turning(u, self._other(PARTNERS[name], u), centre)
        return self.rounded(centre, radius, (lambda: self.sinh_least(u)) if name.endswith("h") else None)

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
        return whole_power(x, n, operator.mul)

    def _broken(self, u: Disk, exponent: Number) -> Disk:
        """A power that is not whole."""
        centre = self.centre_power(u, exponent)
        if u.radius is None:
            return Disk(centre, self.spread_of(centre) * FUNCTIONS)
        e = float(exponent)
        if 2 * e == int(2 * e) and abs(e) <= MOST_ROOTS:
            return self._power_of_root(centre, u, e)
        return self._constant_power(centre, u, self.all(e), positive=e > 0)

    def _power_of_root(self, centre: Value, u: Disk, e: float) -> Disk:
        """A power with half an integer e as its exponent (see ``_constant_power``), by square roots."""
        f, size, r, above = self.f, self.size(u), self.radius(u), abs(e)

        def raised(x: Real) -> Real:
            power = self.whole_power(f.function("sqrt", self.positive(x)), int(2 * above))
            return power if e > 0 else self.all(1.0) / power

        value, s = self.spread_of(centre), r / size
        grown = self.all(1.0) / self.whole_power(f.function("sqrt", self.all(1.0) - s), int(2 * above))
        x = f.fused(s * s, 0.51, s) * above  # -log(1 - s) / e, and e^x is less than 1 / (1 - x)
        near = f.select(s < 2.0**-8, x + x * x * 0.5 / (self.all(1.0) - x), grown - 1.0)
        if 0 < e < 1:
            near = self.lesser(near, self.all(1.0))
        near = self.among(s < 1.0, value * near)
        least, most = self.least(u), self.most(u)
        radius = self.lesser(near, self.among(least > 0.0, raised(most if e > 0 else least) + value))
        radius = f.fused(value, self.all((2 * above + 8) * FUNCTIONS), radius) + TINY
        return Disk(centre, radius, lambda: raised(least if e > 0 else most))

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
