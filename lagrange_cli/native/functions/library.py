"""The C library's functions of doubles, each with one result on every machine.

They come from ``elementary`` where its formulas hold; beyond their range, and for the other functions, from
double-double numbers.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from functools import partial

from lagrange_cli.native.functions.double_double import LN2, PI, cosh_within, leg, refined_angle, sinh_within
from lagrange_cli.native.functions.formulas import LEAST_NORMAL
from lagrange_cli.native.functions.payne_hanek import LEAST_WIDE
from lagrange_cli.native.llvm.function import Function
from lagrange_cli.native.llvm.vector import Bit, Real
from lagrange_cli.native.numbers.double_double import DDReal, apply, called, choose, pair

ARC_TANGENT = (
    1.0, -0.3333314528, 0.1999355085, -0.1420889944, 0.1065626393, -0.0752896400, 0.0429096138,
    -0.0161657367, 0.0028662257,
)  # fmt: skip
"""atan(r) / r in powers of r^2, |r| <= 1; error 2^-25 (Abramowitz and Stegun, 4.4.49). A step of Newton's
iteration makes three times as many digits of it."""
RAISED = 54
"""Binary orders by which denormal numbers are raised to be normal."""
LARGE, SMALL = 2.0**500, 2.0**-500
"""Sizes of coordinates beyond which they are scaled, so that nothing overflows or underflows."""
OVERFLOWING = 700.0
"""The hyperbolic functions' argument from which e^-x no longer counts."""

INFINITY, NAN = float("inf"), float("nan")
Formula = Callable[..., "DDReal | Real"]


def texts() -> Iterator[str]:
    """The texts of all of them (see ``FORMULAS``)."""
    for name, (count, formula) in FORMULAS.items():
        f = Function(f"define internal double @{name}({', '.join(f'double %a{i}' for i in range(count))}) #0")
        made = formula(*(Real(f, f"%a{i}") for i in range(count)))
        f.give(rounded(made) if isinstance(made, DDReal) else made)
        yield f.text()


def rounded(value: DDReal) -> Real:
    """The double nearest to a number."""
    high, low = value.parts
    return high + low


def signed(size: Real, x: Real) -> Real:
    """``size`` with the sign of x, zeros' too."""
    return x.body.select(x.bits().compared("slt", 0), -size, size)


def of_double(name: str, *arguments: Real) -> Real:
    """A function of ``elementary`` of one double."""
    listed = ", ".join(f"double {one.name}" for one in arguments)
    return arguments[0].made(f"call double @{name}.1({listed})")


def exponential(x: Real) -> Real:
    """e^x"""
    return of_double("exp", x, x.body.constant(0.0))


def turned(which: int, x: Real) -> Real:
    """Sine (0) or cosine (1) of x."""
    return called(x.body, "sin_cos.1", x, x.body.constant(0.0)).parts[which]


def tangent(x: Real) -> Real:
    """tan x."""
    near = x.body.magnitude(x) < LEAST_WIDE
    wide = apply("wide_sin", x) / apply("wide_cos", x)
    return rounded(choose(near, apply("tan", DDReal(x)), wide))


def normal(x: Real) -> tuple[Bit, Real]:
    """Whether x > 0 is denormal, and x, raised if it is."""
    tiny = (x > 0.0) & (x < LEAST_NORMAL)
    return tiny, x.body.select(tiny, x * 2.0**RAISED, x)


def beyond_log(x: Real) -> Real:
    """ln x of what is not a normal positive number."""
    body, (tiny, raised) = x.body, normal(x)
    made = of_double("log", body.select(tiny, raised, 1.0)) - float(RAISED * LN2)
    other = body.select(x < 0.0, NAN, x)
    other = body.select(x.equals(0.0), -INFINITY, other)
    return body.select(tiny, made, other)


def beyond_pow(x: Real, y: Real) -> Real:
    """x^y where it is not a product of normal numbers, or x is not positive; C's special values."""
    body, size = x.body, x.body.magnitude(x)
    zero, one, infinity = (body.constant(value) for value in (0.0, 1.0, INFINITY))
    tiny, raised = normal(size)
    log = apply("log", DDReal(raised))
    log = choose(tiny, log - pair(body, RAISED * LN2), log)
    made = rounded(apply("exp", DDReal(y) * log))
    exponent = y * body.function("log", size)
    made = body.select(exponent < -746.0, zero, made)
    made = body.select(exponent > 710.0, infinity, made)
    made = body.select(size.equals(1.0), one, made)
    half, whole = y * 0.5, body.function("floor", y).equals(y)
    odd = whole & body.function("floor", half).compared("one", half)
    real = whole | size.equals(INFINITY)
    of_negative = body.select(real, body.select(odd, -made, made), NAN)
    made = body.select(x < 0.0, of_negative, made)
    return body.select(y.equals(0.0), one, made)


def angle(y: DDReal, x: DDReal) -> DDReal:
    """The angle of the point (x, y), which is neither very far nor very near."""
    body = y.high.body
    across, along = body.magnitude(y.high), body.magnitude(x.high)
    steep = across > along
    shorter, longer = body.select(steep, along, across), body.select(steep, across, along)
    nowhere = (across + along).equals(0.0)
    ratio = body.select(nowhere, 0.0, shorter / longer)
    square = ratio * ratio
    total = body.constant(ARC_TANGENT[-1])
    for one in reversed(ARC_TANGENT[:-1]):
        total = total * square + one
    first = total * ratio
    first = body.select(steep, float(PI / 2) - first, first)
    first = body.select(x.high < 0.0, float(PI) - first, first)
    start = DDReal(signed(first, y.high))
    return choose(nowhere, start, refined_angle(start, y, x))


def atan2(y: Real, x: Real) -> Real:
    """The angle of any point."""
    body = y.body
    zero, one, small, large = (body.constant(value) for value in (0.0, 1.0, SMALL, LARGE))
    across, along = body.magnitude(y), body.magnitude(x)
    far = body.function("maxnum", across, along)
    factor = body.select(far < SMALL, large, body.select(far > LARGE, small, one))
    endless = far.equals(INFINITY)
    sides = []
    for side, size in ((y, across), (x, along)):
        unit = body.select(size.equals(INFINITY), one, zero)
        unit = body.select(size.compared("uno", 0.0), NAN, unit)
        sides.append(DDReal(signed(body.select(endless, unit, size * factor), side)))
    return rounded(angle(*sides))


def growing(within: Callable[[DDReal], DDReal], x: Real) -> Real:
    """sinh or cosh: e^|x| / 2 where the other half does not count."""
    body, size = x.body, x.body.magnitude(x)
    half = rounded(apply("exp", DDReal(size) - pair(body, LN2)))
    half = body.select(size.equals(INFINITY), size, half)
    half = half if within is cosh_within else signed(half, x)
    return body.select(size < OVERFLOWING, rounded(within(DDReal(x))), half)


def tanh(x: Real) -> Real:
    """1 to the last digit beyond 40."""
    body, number = x.body, DDReal(x)
    made = rounded(sinh_within(number) / cosh_within(number))
    made = body.select(x > 40.0, 1.0, made)
    return body.select(x < -40.0, -1.0, made)


FORMULAS: Mapping[str, tuple[int, Formula]] = {
    "portable.sin": (1, partial(turned, 0)),
    "portable.cos": (1, partial(turned, 1)),
    "portable.exp": (1, exponential),
    "portable.log": (1, partial(of_double, "log")),
    "portable.pow": (2, partial(of_double, "pow")),
    "portable.log2": (1, lambda x: of_double("log", x) * float(1 / LN2)),
    "portable.exp2": (1, lambda x: exponential(x * float(LN2))),
    "portable.tan": (1, tangent),
    "portable.atan": (1, lambda x: atan2(x, x.body.constant(1.0))),
    "portable.asin": (1, lambda x: angle(DDReal(x), leg(DDReal(x)))),
    "portable.acos": (1, lambda x: angle(leg(DDReal(x)), DDReal(x))),
    "portable.atan2": (2, atan2),
    "portable.sinh": (1, partial(growing, sinh_within)),
    "portable.cosh": (1, partial(growing, cosh_within)),
    "portable.tanh": (1, tanh),
    "beyond.sin": (1, partial(apply, "wide_sin")),
    "beyond.cos": (1, partial(apply, "wide_cos")),
    "beyond.exp": (1, lambda x: apply("exp", DDReal(x))),
    "beyond.log": (1, beyond_log),
    "beyond.pow": (2, beyond_pow),
}
"""By name, how many doubles a function takes, and what it is; ``beyond`` the range of ``elementary``."""
