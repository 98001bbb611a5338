"""Why a motion ended: which expression of the system file has no value beyond that place.

All expressions in the equations are searched for quotients, roots, logarithms and the
like. The arguments of these are evaluated where the motion ended, with their first two derivatives along it.
If an argument follows c (T - t)^alpha, then alpha = 1/(1 - u u''/u'^2) and T = t - alpha u/u'.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from contextlib import suppress
from typing import TYPE_CHECKING

import numpy as np

from lagrange_cli.decimals import decimal
from lagrange_cli.errors import SpecError
from lagrange_cli.expression.borders import Border, borders
from lagrange_cli.expression.indices import Indices, known_indices
from lagrange_cli.expression.syntax import Binary, Call, ExpressionError, Tree
from lagrange_cli.expression.vocabulary import TIME, velocity_name
from lagrange_cli.integrate.ending import Ending
from lagrange_cli.integrate.method import Cause
from lagrange_cli.model.scope import Scope, multiplier_name
from lagrange_cli.records import replace

if TYPE_CHECKING:
    from lagrange_cli.integrate.method import End
    from lagrange_cli.spec.spec import Expression, Spec
    from lagrange_cli.symbolic.direct import Dual

SOON = 2.0**-28
"""An argument that reaches its end within this part of the time is why the motion ended."""
NEARING = 2.0**-12
"""The same where steps become shorter without end, of which there are too many farther away."""
ROUNDED, HALF = 2.0**-48, 2.0**-26
"""Arguments are at their ends, up to rounding, if no more is left of what they are the difference of; and if
so much is left, half of their digits are lost."""
ALIKE = 4.0
"""Among arguments that reach their ends almost at the same time, the first one counts."""
MOST = 10_000
"""The largest number of arguments that are examined."""
ALPHA = 0.125, 8.0
"""Powers of the time that is left that an argument may follow."""
BENT = -0.125
"""Below this x x''/x'^2 = 1 - 1/alpha, the velocity is infinite where x is 0."""
GOLDEN = 0.6180339887498949
"""The fractional parts of its multiples are all different."""
STEEP = 64.0
"""Beyond this size of x x''/x'^2, x hardly changes until a growing velocity is infinite."""


LONGEST = 1e60
"""The longest run in which powers of steps do not overflow, whatever the motion."""


def explained(spec: Spec, parameters: Mapping[str, float], start: float, end: End) -> Cause | None:
    """Why a motion that began at ``start`` could not go on, if an expression of ``spec`` ends there."""
    if not len(end.accelerations):
        return None
    near = NEARING if end.ending in (Ending.CRAWLING, Ending.EDGE) else SOON
    whole, way = max(abs(end.t), abs(end.t - start)), -1.0 if end.t < start else 1.0
    found: list[tuple[float, str]] = []
    try:
        found = endings(spec, parameters, start, end, near * whole, way)
    except SpecError as error:  # it ended at the very place
        first = error.problems[0]
        earlier = before(end, way * SOON / 4 * whole)
        with suppress(SpecError, ValueError, ArithmeticError):
            found = endings(spec, parameters, start, earlier, SOON * whole, way) if whole else []
        if not found:
            return Cause(f"{first.message} (line {first.line})", end.t) if first.line else None
        end = earlier
    except (ValueError, ArithmeticError):  # beyond the domain of a function that nothing depends on
        return None
    if not found:
        return None
    least = min(abs(left) for left, _ in found)
    left, text = next(one for one in found if abs(one[0]) <= ALIKE * least)
    return Cause(text, end.t + left)


def endings(
    spec: Spec, parameters: Mapping[str, float], start: float, end: End, soon: float, way: float
) -> list[tuple[float, str]]:
    """What a motion may have ended for: in which time, and a message."""
    numbers = along(spec, parameters, end)
    found = fewest_digits([*reached(spec, numbers, soon, way)])
    found = found or [one for one in escapes(spec, numbers) if abs(one[0]) <= soon]
    if found or not (end.t == start or end.ending is Ending.EDGE):
        return found
    staying = reached(spec, numbers, 0.0, way, staying=True)
    found = [(left, said) for left, _, said in staying if left == 0]
    return found or [(0.0, said) for said in outside(spec, numbers)]


def before(end: End, time: float) -> End:
    """A motion as if it had ended some time before it did."""
    count = len(end.accelerations)
    rates = np.zeros(len(end.state))  # integrals behind q and v are not asked for
    rates[: 2 * count] = [*end.state[count : 2 * count], *end.accelerations]
    return replace(end, t=end.t - time, state=end.state - np.where(np.isfinite(rates), rates, 0.0) * time)


def too_long(start: float, stop: float, end: End) -> Cause | None:
    """That steps may become so long that their powers overflow, in a run to ``stop``."""
    return None if abs(stop - start) <= LONGEST else Cause(Ending.TOO_LONG.value, end.t, Ending.TOO_LONG)


def along(spec: Spec, parameters: Mapping[str, float], end: End) -> dict[str, Dual]:
    """The values of all symbols, with their first two derivatives where the motion ended. They vary by their
    size times a factor of their own, so that differences vary by the size of their terms."""
    from lagrange_cli.symbolic.direct import Dual

    count = len(spec.coordinates)
    values = {name: Dual((float(x), 0.0, 0.0)) for name, x in parameters.items()}
    values[TIME] = Dual((end.t, 1.0, 0.0), (end.t, 0.0, 0.0))
    for name in spec.all_constraints:  # multipliers are not known there
        values[multiplier_name(name)] = Dual((math.nan, math.nan, math.nan))
    accelerations = [a if math.isfinite(a) else 0.0 for a in end.accelerations.tolist()]
    state = zip(end.state.tolist(), end.state[count:].tolist(), accelerations)
    for k, (one, (q, v, a)) in enumerate(zip(spec.coordinates, state), 1):
        factor = 1.0 + k * GOLDEN % 1.0
        values[one.name] = Dual((q, v, a / 2), (q * factor, 0.0, 0.0))
        values[velocity_name(one.name)] = Dual((v, a, 0.0), (v * factor, 0.0, 0.0))
    return values


def reached(
    spec: Spec, values: Mapping[str, Dual], soon: float, way: float, *, staying: bool = False
) -> Iterator[tuple[float, float, str]]:
    """The time until arguments reach their ends, where that is ``soon`` or they are there up to rounding;
    what is left of what they are the difference of; and a message for each. Arguments that stay at their ends
    end no motion, unless it could not begin: with ``staying`` they count. Time goes one ``way``.
    """
    for expression, border, indices, built in arguments(spec, values):
        for one in border.ends or [nearest_pole(built.value[0])]:
            left = time_left(built, one, way)
            if staying and left is None and built.value[0] == one:
                left = 0.0
            u, size = abs(float(built.value[0]) - one), max(abs(float(built.varied[0])), abs(one))
            if left is not None and (u <= ROUNDED * size or abs(left) <= soon):
                left = left if abs(left) <= soon else 0.0
                yield left, u / size if size else math.inf, sentence(expression, border, one, indices)


def fewest_digits(found: Sequence[tuple[float, float, str]]) -> list[tuple[float, str]]:
    """The times and messages of those that are at their ends up to rounding; else, of those that have lost
    half of their digits; else, of all."""
    for most in (ROUNDED, HALF, math.inf):
        some = [(left, said) for left, part, said in found if part <= most]
        if some:
            return some
    return []


def outside(spec: Spec, values: Mapping[str, Dual]) -> Iterator[str]:
    """The messages for arguments beyond the domain of their function."""
    for expression, border, indices, built in arguments(spec, values):
        value = float(built.value[0])
        if isinstance(border.whole, Call) and border.ends:
            beyond = abs(value) > 1.0 if len(border.ends) > 1 else value < 0.0
            if beyond and border.whole is not border.argument:
                yield (
                    f"{text(expression, border.argument)} is "
                    f"{decimal(value)}{place(expression, border, indices)}"
                )


def arguments(spec: Spec, values: Mapping[str, Dual]) -> Iterator[tuple[Expression, Border, Indices, Dual]]:
    """All arguments that may reach an end, with their values."""
    from lagrange_cli.symbolic.direct import DualAlgebra

    scope = Scope(spec, DualAlgebra(values, exact=False))
    looked = 0
    for expression in scope.in_equations:
        known = {**spec.sizes, **expression.indices}
        for border, indices in borders(expression.tree, known):
            looked += 1
            if looked > MOST:
                return
            try:
                built = scope.builder.build(border.argument, indices)
                if isinstance(border.whole, Binary) and border.whole.operator == "**":
                    exponent = scope.builder.build(border.whole.right, indices)
                    if exponent.fixed and exponent.value[0] >= 0 and exponent.value[0] % 1 == 0:
                        continue
            except (ExpressionError, ValueError, ArithmeticError):
                continue
            yield expression, border, indices, built


def nearest_pole(u: float) -> float:
    """The pole of tan that is nearest to u."""
    return math.pi / 2 + math.pi * round(u / math.pi - 0.5)


def time_left(argument: Dual, end: float, way: float = 0.0) -> float | None:
    """The time until an argument reaches its end; None if it never does, or is there and stays, or goes away
    from it faster and faster while time goes that ``way``."""
    value, rate, half = map(float, argument.value)
    u = value - end
    if u == 0:
        return None if rate == half == 0.0 else 0.0
    if not (math.isfinite(u) and rate):
        return None
    bend = 2.0 * half * u / rate / rate
    if bend >= 1.0 and u * rate * way > 0.0:
        return None
    alpha = 1.0 / (1.0 - bend) if bend < 1.0 else ALPHA[1]
    return -u / rate * min(max(alpha, ALPHA[0]), ALPHA[1])


def sentence(expression: Expression, border: Border, end: float, indices: Indices) -> str:
    """The message for an argument that reaches its end."""
    argument = text(expression, border.argument)
    if isinstance(border.whole, Binary) and border.whole.operator == "/":
        return f"the denominator {argument} reaches 0{place(expression, border, indices)}"
    if border.whole is border.argument:
        return f"{argument} reaches 0{place(expression, border, indices)}"
    return f"{argument} reaches {decimal(end)}{place(expression, border, indices)}"


def place(expression: Expression, border: Border, indices: Indices) -> str:
    """Where an argument stands."""
    inside = "" if border.whole is border.argument else f" in {text(expression, border.whole)}"
    line = expression.at(border.whole.span).line
    return f"{inside}{known_indices(border.whole, indices)} (line {line})"


def text(expression: Expression, tree: Tree) -> str:
    """A piece of an expression as it is written."""
    return " ".join(expression.excerpt(tree.span).split())


def escapes(spec: Spec, values: Mapping[str, Dual]) -> Iterator[tuple[float, str]]:
    """The time until coordinates or their velocities are infinite, and a message for each."""
    from lagrange_cli.symbolic.direct import power

    for one in spec.coordinates:
        value = values[one.name]
        size, rate, half = map(float, value.value)
        if not (size and rate):
            continue
        bend = 2.0 * half * size / rate / rate
        outward = size * rate > 0.0
        left: float | None
        if rate * half > 0.0 and abs(bend) > STEEP:  # x ends elsewhere, and its velocity as 1/(T - t)^p
            left, name = rate / (2.0 * half), velocity_name(one.name)
        elif outward and bend > 1.0:  # as 1/(T - t)^p
            left, name = time_left(power(value, -1.0), 0.0), one.name
        elif not outward and bend < BENT:  # as (T - t)^alpha with alpha < 1
            left, name = time_left(value, 0.0), velocity_name(one.name)
        else:
            continue
        if left is not None:
            yield left, f"{name} grows without bound"
