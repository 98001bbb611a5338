"""Functions with kinks and jumps in sympy: of real arguments, and as they are written in system files.

sympy's own Abs, Max and Piecewise rewrite one another, and ask whether symbols are real, which is not said of
them. Derivatives are those on both sides of a jump, as in the expression graph.

Their arguments are sympy expressions that ``expression.build`` has made of a checked tree. sympy would run a
string as a program, also one in a tuple or a dict: ``OfExpressions`` refuses whatever is not sympy's already.
"""

from __future__ import annotations

from typing import Any

import sympy
from sympy.core.cache import cacheit
from sympy.core.parameters import global_parameters


def decided(u: sympy.Expr) -> bool:
    """Whether it is a real number."""
    return bool(u.is_number and u.is_extended_real)


def sign_of(u: sympy.Expr) -> int | None:
    """The sign of a constant; None if it is not found, as for cos(1)**2 + sin(1)**2 - 1."""
    if not decided(u):
        return None
    return 1 if u.is_positive else -1 if u.is_negative else 0 if u.is_zero else None


class OfExpressions(sympy.Function):  # type: ignore[misc]
    """A function of expressions. Raises ``TypeError`` for other arguments, in which sympy would run text."""

    @cacheit  # type: ignore[untyped-decorator]
    def __new__(cls, *arguments: Any, **options: Any) -> Any:
        if not all(isinstance(one, sympy.Basic) for one in arguments):
            raise TypeError(f"{cls.__name__} takes expressions of sympy only, not text")
        simpler = cls.simplified(*arguments) if options.get("evaluate", global_parameters.evaluate) else None
        return super().__new__(cls, *arguments, **options) if simpler is None else simpler

    @classmethod
    def simplified(cls, *arguments: Any) -> sympy.Expr | None:
        """What the function of these arguments is, if that is simpler; else None."""
        raise NotImplementedError


class Absolute(OfExpressions):
    """abs(u)."""

    @classmethod
    def simplified(cls, u: sympy.Expr) -> sympy.Expr | None:
        """Numbers come out of it, and so does a sign."""
        number, rest = u.as_coeff_Mul()
        if rest is sympy.S.One:
            return abs(number)
        if number != 1:
            return abs(number) * cls(rest)
        if isinstance(u, Absolute):
            return u
        return cls(-u) if u.could_extract_minus_sign() else None

    def _eval_power(self, exponent: sympy.Expr) -> sympy.Expr | None:
        even = exponent.is_Integer and exponent % 2 == 0
        return self.args[0] ** exponent if even else None

    def _eval_derivative(self, symbol: sympy.Symbol) -> sympy.Expr:
        return Sign(self.args[0]) * self.args[0].diff(symbol)


class Sign(OfExpressions):
    """sign(u), 0 at 0."""

    @classmethod
    def simplified(cls, u: sympy.Expr) -> sympy.Expr | None:
        """Take the signs of a number and of factors out of it."""
        number, rest = u.as_coeff_Mul()
        if rest is sympy.S.One and (sign := sign_of(number)) is not None:
            return sympy.Integer(sign)
        if number != 1 and decided(number):
            return sympy.sign(number) * cls(rest)
        return -cls(-u) if u.could_extract_minus_sign() else None

    def _eval_derivative(self, symbol: sympy.Symbol) -> sympy.Expr:
        return sympy.S.Zero


class Extremum(OfExpressions):
    """What ``max`` and ``min`` have in common."""

    SIGN = 1

    @classmethod
    def simplified(cls, *arguments: sympy.Expr) -> sympy.Expr | None:
        """Numbers are compared, and come first; what is equal is one, and so is one within another."""
        flat = (inner for one in arguments for inner in (one.args if isinstance(one, cls) else (one,)))
        distinct = tuple(dict.fromkeys(flat))
        constants = [one for one in distinct if decided(one)]
        beaten = {one for one in constants for other in constants if sign_of(other - one) == cls.SIGN}
        kept = [one for one in distinct if one not in beaten]
        if len(kept) == 1:
            return kept[0]
        ordered = tuple(sorted(kept, key=lambda one: (not one.is_number, sympy.default_sort_key(one))))
        return cls(*ordered) if ordered != arguments else None

    @property
    def opposite(self) -> sympy.Expr:
        """The negative of the same: min(-a, -b) = -max(a, b)."""
        other = Least if isinstance(self, Largest) else Largest
        return other(*(-one for one in self.args))

    def _eval_derivative(self, symbol: sympy.Symbol) -> sympy.Expr:
        first, *others = self.args
        rest = self.func(*others)
        difference = sympy.Integer(self.SIGN) * (first - rest)
        return Switch(difference, first.diff(symbol), rest.diff(symbol), sympy.S.Zero)


class Largest(Extremum):
    """max(a, b, ...)."""


class Least(Extremum):
    """min(a, b, ...)."""

    SIGN = -1


class Switch(OfExpressions):
    """where(u > 0, above, below), or with u >= 0 if ``at`` is 1; 0 if both sides meet."""

    @classmethod
    def simplified(cls, u: sympy.Expr, above: sympy.Expr, below: sympy.Expr, at: sympy.Integer) -> Any:
        """A number decides."""
        if above == below:
            return above
        sign = sign_of(u)
        if sign is None:
            return None
        return above if sign > 0 or (sign == 0 and at >= 0) else below

    def where_nonzero(self, factor: sympy.Expr) -> sympy.Expr | None:
        """The branch that is taken where ``factor``, an extremum of 0 and another, is not 0; or None."""
        if not isinstance(factor, Extremum) or len(factor.args) != 2 or sympy.S.Zero not in factor.args:
            return None
        u = factor.args[0] + factor.args[1]
        if self.args[0] not in (u, -u):
            return None
        return self.args[1 if (self.args[0] == u) == (factor.SIGN > 0) else 2]

    def _eval_derivative(self, symbol: sympy.Symbol) -> sympy.Expr:
        u, above, below, at = self.args
        return self.func(u, above.diff(symbol), below.diff(symbol), at)


for _kind, _name in ((Absolute, "abs"), (Sign, "sign"), (Largest, "max"), (Least, "min"), (Switch, "where")):
    _kind.__name__ = _name
