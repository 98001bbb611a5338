"""The equations of motion at one state, straight from the system file: no symbol is differentiated.

A motion q(t + s) = q + v s + a s^2/2 is varied by e d_k(s). Numbers are polynomials in s, up to s^2, and in
e, up to the first power (dual numbers; Clifford, Proc. London Math. Soc. 4, 381, 1873). In L, e is
multiplied by

    dL/dq_k d_k + dL/dq_dot_k d_k',

so d_k = 1 gives dL/dq_k, and d_k = s gives p_k at s = 0 and d/ds (s dL/dq_k + p_k) in the next power. So do
df/dq_k and dg/dq_dot_k of constraints; their rates of change are found with the powers of s. Neither the
graph nor sympy has any part in this.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from functools import reduce
from operator import add
from typing import Any

import mpmath
import numpy as np

from lagrange_cli.expression.algebra import Decided
from lagrange_cli.expression.derivatives import FUNCTIONS, powers
from lagrange_cli.expression.vocabulary import TIME, velocity_name
from lagrange_cli.model.build import build_model
from lagrange_cli.model.scope import Scope, multiplier_name
from lagrange_cli.model.start.equations import with_what_is_used
from lagrange_cli.records import dataclass, replace
from lagrange_cli.spec.spec import Spec

Series = tuple[Any, Any, Any]
"""The coefficients of 1, s and s^2."""
NOTHING: Series = (0.0, 0.0, 0.0)


def times(a: Series, b: Series) -> Series:
    """The product, up to s^2."""
    return (a[0] * b[0], a[0] * b[1] + a[1] * b[0], a[0] * b[2] + a[1] * b[1] + a[2] * b[0])


def plus(a: Series, b: Series, factor: float = 1.0) -> Series:
    """a + factor b."""
    return (a[0] + factor * b[0], a[1] + factor * b[1], a[2] + factor * b[2])


def zero(series: Series) -> bool:
    """Whether all of its coefficients, numbers or arrays, are 0."""
    return not any(np.any(one) for one in series)


class Dual:
    """``value`` + e ``varied``; of the latter, each coefficient is an array (2 n,): all variations."""

    __slots__ = ("value", "varied")

    def __init__(self, value: Series, varied: Series = NOTHING) -> None:
        self.value, self.varied = value, varied

    @property
    def fixed(self) -> bool:
        """Whether it changes neither with s nor with e."""
        return self.value[1:] == (0, 0) and zero(self.varied)

    def __neg__(self) -> Dual:
        return Dual(plus(NOTHING, self.value, -1.0), plus(NOTHING, self.varied, -1.0))

    def __add__(self, other: Dual) -> Dual:
        return Dual(plus(self.value, other.value), plus(self.varied, other.varied))

    def __sub__(self, other: Dual) -> Dual:
        return Dual(plus(self.value, other.value, -1.0), plus(self.varied, other.varied, -1.0))

    def __mul__(self, other: Dual) -> Dual:
        varied = plus(times(self.value, other.varied), times(self.varied, other.value))
        return Dual(times(self.value, other.value), varied)

    def __truediv__(self, other: Dual) -> Dual:
        return self * power(other, -1.0)

    def __pow__(self, other: Dual) -> Dual:
        if not any(other.value[1:]) and zero(other.varied):
            return power(self, other.value[0])
        m = math if isinstance(self.value[0], float) else mpmath
        exponent = other * composed(FUNCTIONS["log"](m, self.value[0]), self)
        return composed(FUNCTIONS["exp"](m, exponent.value[0]), exponent)

    def rate(self) -> Dual:
        """The derivative by s: correct up to s, if this is up to s^2."""
        (_, a, b), (_, c, d) = self.value, self.varied
        return Dual((a, 2.0 * b, 0.0), (c, 2.0 * d, 0.0))


def composed(derivatives: Sequence[Any], x: Dual) -> Dual:
    """f(x) by Taylor's theorem, from f, f', f'' and f''' where s and e are 0."""
    f, first, second, third = derivatives
    rest = (0.0, *x.value[1:])
    square = times(rest, rest)
    value = plus((f + second / 2 * square[0], *(second / 2 * one for one in square[1:])), rest, first)
    slope = plus((first + third / 2 * square[0], *(third / 2 * one for one in square[1:])), rest, second)
    return Dual(value, times(slope, x.varied))


def power(base: Dual, exponent: float) -> Dual:
    """``base`` to a constant power; a base that stays 0, as max(0, x) does, has no slope that matters."""
    if exponent > 0.0 and zero(base.value) and zero(base.varied):
        return Dual(NOTHING)
    return composed(powers(base.value[0], exponent), base)


class DualAlgebra(Decided):
    """``Algebra[Dual]``; ``values`` has those of the symbols."""

    def __init__(self, values: Mapping[str, Dual], exact: bool) -> None:
        self.values, self.exact = values, exact
        self.m: Any = mpmath if exact else math

    def number(self, text: str) -> Dual:
        return Dual((mpmath.mpf(text.replace("_", "")) if self.exact else float(text), 0.0, 0.0))

    def pi(self) -> Dual:
        return Dual((+self.m.pi, 0.0, 0.0))

    def of_one(self, name: str, x: Dual) -> Dual:
        """A function of one number."""
        return composed(FUNCTIONS[name](self.m, x.value[0]), x)

    def symbol(self, name: str) -> Dual:
        return self.values[name]

    def function(self, name: str, arguments: Sequence[Dual]) -> Dual:
        x = arguments[0]
        if name == "atan2":  # the angle from the one at s = e = 0 on is that of a quotient
            y, x = arguments
            a, b = Dual((y.value[0], 0.0, 0.0)), Dual((x.value[0], 0.0, 0.0))
            turn = self.of_one("atan", (y * b - x * a) / (x * b + y * a))
            return Dual((self.m.atan2(y.value[0], x.value[0]), 0.0, 0.0)) + turn
        if name in ("min", "max"):
            chosen = (min if name == "min" else max)(arguments, key=lambda one: one.value[0])
            for one in arguments:
                self.side(one - chosen, 0)  # which raises where two of them meet
            return chosen
        if name in ("abs", "sign"):
            return Dual((float(self.side(x, 0) or 0), 0.0, 0.0)) * (x if name == "abs" else self.number("1"))
        return power(x, 0.5) if name == "sqrt" else self.of_one(name, x)

    def side(self, u: Dual, at: int) -> int | None:
        if u.value[0] == 0 and not u.fixed:  # there a force that jumps may hold the motion
            raise ArithmeticError("a kink")
        return super().side(u.value[0], at)

    def symbols(self, expression: Dual) -> Sequence[Dual]:
        """Time alone, by which everything that moves is differentiated at once."""
        return [self.values[TIME]]

    def diff(self, expression: Dual, symbol: Dual) -> Dual:
        return expression.rate()


@dataclass(frozen=True)
class Direct:
    """``residual`` d/dt dL/dq_dot - dL/dq - Q (n,), the momenta (n,) and h at a state; of the constraints,
    what they are (m,) and their second or first ``rates`` (m,), which are 0."""

    residual: Sequence[Any]
    momenta: Sequence[Any]
    h: Any
    constraints: Sequence[Any] = ()
    rates: Sequence[Any] = ()


@dataclass(frozen=True)
class Bound:
    """A constraint at a state: its ``value``, its ``speed`` and its ``rate``, 0 where it holds, and the
    ``slopes`` (n,) of the speed by the velocities."""

    value: Any
    speed: Any
    rate: Any
    slopes: np.ndarray


def directly(
    spec: Spec,
    parameters: Mapping[str, float],
    t: float,
    q: Sequence[float],
    v: Sequence[float],
    a: Sequence[Any],
    multipliers: Sequence[Any] = (),
    exact: bool = False,
) -> Direct:
    """The equations of motion with the accelerations ``a`` (n,) and the ``multipliers`` (m,) of constraints;
    ``exact`` with the digits of mpmath.

    Raises ``ArithmeticError`` or ``ValueError`` where something has no value.
    """
    n = len(q)
    zero = np.zeros(2 * n)
    algebra = algebra_at(spec, parameters, t, q, v, a, exact, multipliers)
    with np.errstate(all="ignore"):
        model = build_model(replace(spec, constraints={}, nonholonomic={}), algebra)
        bound = bindings(spec, algebra, n)
        lagrangian = model.lagrangian
        if lagrangian is None:
            half = Dual((0.5, 0.0, 0.0))
            kinetic = [half * p.mass * u * u for p in model.particles for u in p.velocity]
            lagrangian = reduce(add, kinetic, -model.potential)
        slopes, momenta, both = (np.zeros(2 * n) + lagrangian.varied[i] for i in (0, 0, 1))
        force = np.array([one.value[0] for one in model.generalized_forces])
        force = force - (zero + model.dissipation.varied[0])[n:]
        for particle in model.particles:
            for x, given in zip(particle.position, particle.force):
                force = force + given.value[0] * (zero + x.varied[0])[:n]
        for one, multiplier in zip(bound, multipliers, strict=True):
            force = force + multiplier * one.slopes
        residual = both[n:] - 2 * slopes[:n] - force
        h = np.dot(momenta[n:], v) - lagrangian.value[0]
        return Direct(residual, momenta[n:], h, [one.value for one in bound], [one.rate for one in bound])


def bindings(spec: Spec, algebra: DualAlgebra, n: int) -> list[Bound]:
    """The constraints on n coordinates, first the holonomic ones."""
    bare = with_what_is_used(spec, spec.all_constraints.values())
    scope, zero = Scope(bare, algebra), np.zeros(2 * n)
    found = []
    for written in spec.constraints.values():
        f: Dual = scope.scalar(written)
        found.append(Bound(f.value[0], f.value[1], 2 * f.value[2], (zero + f.varied[0])[:n]))
    for written in spec.nonholonomic.values():
        g: Dual = scope.scalar(written)
        found.append(Bound(g.value[0], g.value[0], g.value[1], (zero + g.varied[0])[n:]))
    return found


def algebra_at(
    spec: Spec,
    parameters: Mapping[str, float],
    t: float,
    q: Sequence[float],
    v: Sequence[float],
    a: Sequence[Any],
    exact: bool = False,
    multipliers: Sequence[Any] = (),
) -> DualAlgebra:
    """The algebra in which all symbols have their values along a motion with these accelerations."""
    n = len(q)
    number: Any = mpmath.mpf if exact else float
    zero = np.zeros(2 * n)
    values = {name: Dual((number(x), 0.0, 0.0)) for name, x in parameters.items()}
    values[TIME] = Dual((number(t), 1.0, 0.0))
    for name, multiplier in zip(spec.all_constraints, multipliers or [0.0] * len(spec.all_constraints)):
        values[multiplier_name(name)] = Dual((number(multiplier), 0.0, 0.0))
    for k, one in enumerate(spec.coordinates):
        by_one, by_s = np.zeros(2 * n), np.zeros(2 * n)
        by_one[k] = by_s[n + k] = 1.0
        coordinate = Dual((number(q[k]), number(v[k]), number(a[k]) / 2), (by_one, by_s, zero))
        values |= {one.name: coordinate, velocity_name(one.name): coordinate.rate()}
    return DualAlgebra(values, exact)
