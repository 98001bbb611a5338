"""Comparison of the printed equations with the compiled ones, and with the system file differentiated
directly (``direct``), at random states near the start, along the motion and beside branches (``states``).

The printed text itself is parsed as an expression of the system file and evaluated with 30 digits. A
difference is divided by the *scale* of the printed expression, which bounds the effect of rounding errors in
its sums, products and functions (a running error bound; Higham, Accuracy and Stability of Numerical
Algorithms, section 3.3). For accelerations it is at least the effect of rounding errors in M and f (Skeel's
bound, section 7.2). Rounding errors due to cancellation, or to an almost singular M, therefore do not count
as a difference.
"""

from __future__ import annotations

import random
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import partial, reduce
from itertools import chain
from operator import add
from typing import Any

import mpmath

from lagrange_cli.errors import SpecError, UsageError
from lagrange_cli.expression.algebra import Decided
from lagrange_cli.expression.build import build
from lagrange_cli.expression.parse import parse
from lagrange_cli.expression.syntax import ExpressionError, Tree
from lagrange_cli.symbolic.direct import Direct
from lagrange_cli.symbolic.equations import Equations
from lagrange_cli.symbolic.notations import Text
from lagrange_cli.symbolic.render import render
from lagrange_cli.symbolic.states import State, near

BOUND = 1e-12
"""The largest relative difference of equations that agree."""
DIGITS = 30
STATES = 12
ATTEMPTS = 50
"""Attempts to draw each state: at some states the equations may have no finite value."""

Compiled = Callable[[Sequence[float], float, Sequence[float], Sequence[float]], tuple[Any, Any, float]]
"""(parameters, t, q, v) -> (accelerations, momenta, h), by the compiled program."""


Directly = Callable[[State, Sequence[Any], bool], Direct]
"""(state, accelerations, with many digits) -> ``direct.directly`` of the system file."""
COMPILED, DIRECT = "printed and compiled", "printed and directly differentiated"
"""Two pairs of routes."""


@dataclass(frozen=True)
class Verification:
    """The difference of several routes to the equations: ``difference`` is the largest relative difference
    over ``states`` states, found in ``quantity`` between two ``routes``. ``counted`` says where the states
    were, and ``directly`` whether L was differentiated directly, too."""

    difference: float
    quantity: str
    states: int
    routes: str = COMPILED
    counted: Mapping[str, int] = field(default_factory=dict)
    directly: bool = False

    @property
    def agrees(self) -> bool:
        """Whether the difference is within ``BOUND``."""
        return self.difference <= BOUND

    def __str__(self) -> str:
        verdict = "agree" if self.agrees else "DIFFER"
        compared = "printed, compiled and directly differentiated" if self.directly else COMPILED
        of = f"of {self.quantity}, {self.routes}" if self.directly else f"in {self.quantity}"
        where = ", ".join(f"{count} {where}" for where, count in self.counted.items())
        return (
            f"{compared} equations {verdict}: largest relative difference {self.difference:.1e} "
            f"({of}) over {self.states} states: {where}"
        )


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
    """Its value, which is to be compared; raises ArithmeticError if it is complex."""
    if mpmath.im(one.value) != 0:
        raise ArithmeticError("complex numbers are not compared")
    return mpmath.re(one.value)


class MeasuredAlgebra(Decided):
    """``Algebra[Measured]`` over mpmath's numbers."""

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
        value = getattr(mpmath, name)(x.value)
        return Measured(value, abs(value) + abs(SLOPES[name](x.value)) * x.scale)

    def side(self, u: Measured, at: int) -> int | None:
        return super().side(real(u), at)

    def total(self, terms: Sequence[Measured]) -> Measured:
        return reduce(add, terms)

    def symbols(self, expression: Measured) -> tuple[Measured, ...]:
        raise NotImplementedError("a number remembers no symbol")

    def diff(self, expression: Measured, symbol: Measured) -> Measured:
        raise NotImplementedError("a number remembers no symbol")


@dataclass(frozen=True)
class Printed:
    """The printed equations, parsed: accelerations (explicit, or None), M, f, p and h as trees."""

    accelerations: list[Tree] | None
    mass_matrix: list[list[Tree]]
    force: list[Tree]
    momenta: list[Tree]
    h: Tree


def verify(
    equations: Equations,
    compiled: Compiled,
    start: State,
    others: Sequence[State] = (),
    direct: Directly | None = None,
) -> Verification:
    """Compare printed and compiled equations, and those that ``direct`` has of the system file, at random
    states near ``start`` and at ``others`` (those of them at which the equations have finite values).

    Raises ``UsageError`` where no state near the start is found at which they have.
    """
    printed = read_back(equations)
    source = random.Random(0)
    largest, where, routes = 0.0, "h", COMPILED
    counted: dict[str, int] = {}
    drawn = (
        somewhere(source, start, partial(compare, equations, printed, compiled, direct))
        for _ in range(STATES)
    )
    given = ((one, compare(equations, printed, compiled, direct, one)) for one in others)
    for state, differences in chain(drawn, given):
        if differences is None:
            continue
        counted[state.where] = counted.get(state.where, 0) + 1
        for pair, quantity, difference in differences:
            if difference > largest:
                largest, where, routes = difference, quantity, pair
    return Verification(largest, where, sum(counted.values()), routes, counted, direct is not None)


def somewhere(
    source: random.Random, start: State, compared: Callable[[State], list[tuple[str, str, float]] | None]
) -> tuple[State, list[tuple[str, str, float]]]:
    """A random state near ``start``, the first one at which all values are finite, and the differences."""
    for _ in range(ATTEMPTS):
        state = near(start, source)
        differences = compared(state)
        if differences is not None:
            return state, differences
    raise UsageError("the equations have no finite values at random states near the initial one")


def read_back(equations: Equations) -> Printed:
    """The printed text of the equations, parsed. Raises ``UsageError`` where it is too long for that."""

    def tree(expression: Any) -> Tree:
        return parse(render(expression, Text(), equations.order))

    try:
        accelerations = None
        if equations.accelerations is not None:
            accelerations = [tree(each) for each in equations.accelerations]
    except ExpressionError:
        accelerations = None  # longer than an expression may be; M a = f is equivalent
    try:
        return Printed(
            accelerations,
            [[tree(entry) for entry in row] for row in equations.mass_matrix],
            [tree(each) for each in equations.force],
            [tree(each) for each in equations.momenta],
            tree(equations.h),
        )
    except ExpressionError as error:
        raise UsageError(f"the printed equations are too long to be verified ({error.message})") from error


def compare(
    equations: Equations,
    printed: Printed,
    compiled: Compiled,
    direct: Directly | None,
    state: State,
) -> list[tuple[str, str, float]] | None:
    """The relative differences at a state, with the routes and the quantity that they are of; None if the
    printed equations have no finite values there."""
    values = dict(state.parameters) | {str(equations.time): state.t}
    values |= {str(symbol): value for symbol, value in zip(equations.q, state.q, strict=True)}
    values |= {str(symbol): value for symbol, value in zip(equations.v, state.v, strict=True)}
    try:
        with mpmath.workdps(DIGITS):
            known = {name: Measured(mpmath.mpf(x), abs(mpmath.mpf(x))) for name, x in values.items()}
            exact, scales = evaluate(equations, printed, known)
    except (ArithmeticError, ValueError, ExpressionError):
        return None
    if not all(mpmath.isfinite(each.value) and mpmath.im(each.value) == 0 for _, each in exact):
        return None
    a, p, h = compiled(list(state.parameters.values()), state.t, state.q, state.v)
    found = [
        (COMPILED, name, relative_difference(each, number))
        for (name, each), number in zip(exact, [float(x) for x in (*a, *p, h)], strict=True)
    ]
    if direct is None:
        return found
    accelerations = [mpmath.re(each.value) for _, each in exact[: len(state.q)]]
    zero = Measured(mpmath.mpf(0), mpmath.mpf(0))
    others = [
        *exact[len(state.q) :],
        *((name, replace(zero, scale=one)) for (name, _), one in zip(exact, scales)),
    ]
    for digits in (False, True):  # doubles lose some where terms cancel that the printed equations have not
        try:
            with mpmath.workdps(DIGITS):
                own = direct(state, accelerations, digits)
                rest = [
                    (DIRECT, name, relative_difference(each, number))
                    for (name, each), number in zip(others, (*own.momenta, own.h, *own.residual), strict=True)
                ]
        except (ArithmeticError, ValueError, SpecError):
            return None
        if max(difference for _, _, difference in rest) <= BOUND / 10:
            break
    return found + rest


def relative_difference(exact: Measured, number: Any) -> float:
    """The difference of a compiled number from the exact one, relative to its scale; infinite for nan."""
    difference = abs(number - exact.value) / (exact.scale or 1)
    return float(difference) if mpmath.isfinite(difference) else float("inf")


def evaluate(
    equations: Equations, printed: Printed, known: Mapping[str, Measured]
) -> tuple[list[tuple[str, Measured]], list[Any]]:
    """Names and values of the accelerations, the momenta and h; and the scale |M| |a| + |f| of each equation
    M a = f."""
    algebra = MeasuredAlgebra()

    def value(tree: Tree) -> Measured:
        result: Measured = build(tree, known.__getitem__, algebra)
        return result

    matrix = [[value(entry) for entry in row] for row in printed.mass_matrix]
    force = [value(each) for each in printed.force]
    accelerations = solve_measured(matrix, force)
    if printed.accelerations is not None:  # the compiled side always solves M a = f, which has its own scale
        accelerations = [
            Measured(own.value, max(own.scale, solved.scale))
            for own, solved in zip(map(value, printed.accelerations), accelerations, strict=True)
        ]
    names = [*map(str, equations.a), *(f"p_{name}" for name in equations.coordinates), "h"]
    values = [*accelerations, *map(value, printed.momenta), value(printed.h)]
    sizes = [abs(each.value) for each in accelerations]
    scales = [
        one.scale + sum(entry.scale * size for entry, size in zip(row, sizes, strict=True))
        for row, one in zip(matrix, force, strict=True)
    ]
    return list(zip(names, values, strict=True)), scales


def solve_measured(matrix: list[list[Measured]], force: list[Measured]) -> list[Measured]:
    """The solution of M a = f; its scale is |M^-1| (|M| |a| + |f|), after Skeel."""
    inverse = mpmath.matrix([[entry.value for entry in row] for row in matrix]) ** -1
    n = len(force)
    solution = [sum(inverse[i, k] * force[k].value for k in range(n)) for i in range(n)]
    slack = [force[k].scale + sum(matrix[k][j].scale * abs(solution[j]) for j in range(n)) for k in range(n)]
    return [Measured(solution[i], sum(abs(inverse[i, k]) * slack[k] for k in range(n))) for i in range(n)]
