"""Numbers with many digits that know their scale: a running error bound (Higham, Accuracy and Stability of
Numerical Algorithms, section 3.3) of what doubles would have, in units of their rounding.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from itertools import chain
from typing import Any

import mpmath
import numpy as np

from lagrange_cli.expression.algebra import Decided
from lagrange_cli.mechanics.switching.saturation import GROWING
from lagrange_cli.records import dataclass
from lagrange_cli.symbolic.inverses import nearly_inverse, refined


@dataclass(frozen=True)
class Measured:
    """A value and its scale, to which its errors are relative; scale >= abs(value)."""

    value: Any
    scale: Any

    def __neg__(self) -> Measured:
        return Measured(-self.value, self.scale)

    def __add__(self, other: Measured) -> Measured:
        return Measured(self.value + other.value, self.scale + other.scale)

    def __sub__(self, other: Measured) -> Measured:
        return self + -other

    def __mul__(self, other: Measured) -> Measured:
        scale = self.scale * abs(other.value) + abs(self.value) * other.scale
        return Measured(self.value * other.value, scale)

    def __truediv__(self, other: Measured) -> Measured:
        value = self.value / other.value
        return Measured(value, (self.scale + abs(value) * other.scale) / abs(other.value))

    def __pow__(self, other: Measured) -> Measured:
        value = self.value**other.value
        scale = abs(value)
        if self.value != 0:
            scale += abs(other.value * value / self.value) * self.scale
        return Measured(value, scale)


DEPENDENT = 1e-9
"""Directions in which rows are this small, relative to others, are none."""
SLOPES: dict[str, Callable[[Any], Any]] = {
    "sin": mpmath.cos,
    "cos": mpmath.sin,
    "tan": lambda x: 1 + mpmath.tan(x) ** 2,
    "asin": lambda x: 1 / mpmath.sqrt(1 - x**2),
    "acos": lambda x: 1 / mpmath.sqrt(1 - x**2),
    "atan": lambda x: 1 / (1 + x**2),
    "sinh": mpmath.cosh,
    "cosh": mpmath.sinh,
    "tanh": lambda x: 1 - mpmath.tanh(x) ** 2,
    "exp": mpmath.exp,
    "log": lambda x: 1 / x,
    "sqrt": lambda x: 1 / (2 * mpmath.sqrt(x)),
}
"""The derivatives, up to sign."""


def real(one: Measured) -> Any:
    """Its value for a comparison; raises ArithmeticError if it is complex."""
    if mpmath.im(one.value) != 0:
        raise ArithmeticError("complex numbers are not compared")
    return mpmath.re(one.value)


class MeasuredAlgebra(Decided):
    """``Algebra[Measured]`` over mpmath's numbers. Exponentials grow up to arguments of ``bound`` only."""

    def __init__(self, bound: float | None = None) -> None:
        self.bound = bound

    def number(self, text: str) -> Measured:
        value = mpmath.mpf(text.replace("_", ""))
        return Measured(value, abs(value))

    def pi(self) -> Measured:
        return Measured(+mpmath.pi, +mpmath.pi)

    def symbol(self, name: str) -> Measured:
        raise NotImplementedError("symbols have values here, which the scope gives")

    def function(self, name: str, arguments: Sequence[Measured]) -> Measured:
        if name == "atan2":
            y, x = arguments
            value = mpmath.atan2(y.value, x.value)
            turn = (abs(x.value) * y.scale + abs(y.value) * x.scale) / (x.value**2 + y.value**2)
            return Measured(value, abs(value) + turn)
        if name in ("min", "max"):
            return (min if name == "min" else max)(arguments, key=real)
        (x,) = arguments
        if name == "abs":
            return Measured(abs(x.value), x.scale)
        if name == "sign":
            return Measured(mpmath.sign(x.value), mpmath.mpf(1))
        if self.bound is not None and name in GROWING:
            least = -mpmath.inf if name == "exp" else -self.bound
            x = Measured(min(max(real(x), least), self.bound), x.scale)
        value = getattr(mpmath, name)(x.value)
        return Measured(value, abs(value) + abs(SLOPES[name](x.value)) * x.scale)

    def side(self, u: Measured, at: int) -> int | None:
        return super().side(real(u), at)


def solve_measured(
    matrix: list[list[Measured]], force: list[Measured], *, dependent: bool = False
) -> list[Measured]:
    """The solution of M a = f; its scale is |M^-1| (|M| |a| + |f|), after Skeel. It is the least of all
    solutions where rows are ``dependent``. Raises ArithmeticError where numbers are complex."""
    for one in chain(force, *matrix):
        real(one)
    values = mpmath.matrix([[entry.value for entry in row] for row in matrix])
    n, nearly = len(force), None if dependent else nearly_inverse(values)
    if nearly is None:
        inverse = pseudoinverse(values) if dependent else values**-1
        solution = [sum(inverse[i, k] * force[k].value for k in range(n)) for i in range(n)]
    else:
        inverse, solution = nearly, refined(values, nearly, [one.value for one in force])
    slack = [force[k].scale + sum(matrix[k][j].scale * abs(solution[j]) for j in range(n)) for k in range(n)]
    return [Measured(solution[i], sum(abs(inverse[i, k]) * slack[k] for k in range(n))) for i in range(n)]


def pseudoinverse(matrix: Any) -> Any:
    """The pseudoinverse of Moore and Penrose of a symmetric matrix."""
    sizes, vectors = mpmath.eigsy(matrix)
    largest = max(map(abs, sizes))
    kept = [1 / x if abs(x) > DEPENDENT * largest else mpmath.mpf(0) for x in sizes]
    return vectors * mpmath.diag(kept) * vectors.T


def are_dependent(rows: Sequence[Sequence[Measured]]) -> bool:
    """Whether rows depend on one another, up to rounding."""
    if not rows:
        return False
    numbers = np.array([[float(entry.value) for entry in row] for row in rows])
    lengths = np.linalg.norm(numbers, axis=1, keepdims=True)
    scaled = numbers / np.where(lengths == 0.0, 1.0, lengths)
    return bool(np.linalg.matrix_rank(scaled, tol=DEPENDENT) < len(rows))
