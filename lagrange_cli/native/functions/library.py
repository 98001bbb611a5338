"""The C library's functions of doubles, each with one result on every machine.

They come from ``elementary`` where its formulas hold; beyond their range, and for the other functions, from
double-double numbers.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from functools import partial

from lagrange_cli.native.functions import elementary
from lagrange_cli.native.functions.double_double import LN2, PI, cosh_within, leg, refined_angle, sinh_within
from lagrange_cli.native.functions.formulas import LEAST_NORMAL
from lagrange_cli.native.functions.payne_hanek import LEAST_WIDE
from lagrange_cli.native.llvm.text import ONE, ZERO, Value, literal
from lagrange_cli.native.numbers.double_double import DoubleDoubleBody, Pair, function

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

INFINITY, NAN = literal(float("inf")), literal(float("nan"))
Formula = Callable[..., "Pair | Value"]


def texts() -> Iterator[str]:
    """The texts of all of them (see ``FORMULAS``)."""
    for name, (count, formula) in FORMULAS.items():
        body, arguments = DoubleDoubleBody(), [f"%a{i}" for i in range(count)]
        made = formula(body, *arguments)
        result = rounded(body, made) if isinstance(made, Pair) else made
        body.line(f"  ret double {body.written(result)}")
        yield function(f"double @{name}({', '.join(f'double {a}' for a in arguments)})", body)


def pair(e: DoubleDoubleBody, x: Value) -> Pair:
    """A double as a number of two."""
    return Pair(e, x, ZERO)


def rounded(e: DoubleDoubleBody, value: Pair) -> Value:
    """The double nearest to it."""
    return e.add(value.high, value.low)


def signed(e: DoubleDoubleBody, size: Value, x: Value) -> Value:
    """``size`` with the sign of x, zeros' too."""
    bits = e.define(f"bitcast double {x} to i64")
    return e.select(e.define(f"icmp slt i64 {bits}, 0"), e.neg(size), size)


def turned(which: int, e: DoubleDoubleBody, x: Value) -> Value:
    """Sine (0) or cosine (1) of x."""
    both = elementary.sine_and_cosine(1)
    made = e.define(f"call {both} @sin_cos.1(double {e.written(x)}, double {ZERO})")
    return e.define(f"extractvalue {both} {made}, {which}")


def tangent(e: DoubleDoubleBody, x: Value) -> Value:
    """tan x."""
    near = e.compare("olt", e.magnitude(x), LEAST_WIDE)
    wide = e.apply("wide_sin", x) / e.apply("wide_cos", x)
    return rounded(e, e.choose(near, e.apply("tan", pair(e, x)), wide))


def normal(e: DoubleDoubleBody, x: Value) -> tuple[str, Value]:
    """Whether x > 0 is denormal, and x, raised if it is."""
    tiny = e.both(e.compare("ogt", x, 0.0), e.compare("olt", x, LEAST_NORMAL))
    return tiny, e.select(tiny, e.mul(x, literal(2.0**RAISED)), x)


def beyond_log(e: DoubleDoubleBody, x: Value) -> Value:
    """ln x of what is not a normal positive number."""
    tiny, raised = normal(e, x)
    made: Value = e.call("log.1", e.select(tiny, raised, ONE))
    made = e.sub(made, literal(float(RAISED * LN2)))
    other = e.select(e.compare("olt", x, 0.0), NAN, x)
    other = e.select(e.compare("oeq", x, 0.0), literal(float("-inf")), other)
    return e.select(tiny, made, other)


def beyond_pow(e: DoubleDoubleBody, x: Value, y: Value) -> Value:
    """x^y where it is not a product of normal numbers, or x is not positive; C's special values."""
    size = e.magnitude(x)
    tiny, raised = normal(e, size)
    log = e.apply("log", pair(e, raised))
    log = e.choose(tiny, log - e.pair(RAISED * LN2), log)
    made = rounded(e, e.apply("exp", pair(e, y) * log))
    exponent = e.mul(y, e.intrinsic("log", size))
    made = e.select(e.compare("olt", exponent, -746.0), ZERO, made)
    made = e.select(e.compare("ogt", exponent, 710.0), INFINITY, made)
    made = e.select(e.compare("oeq", size, 1.0), ONE, made)
    half = e.mul(y, literal(0.5))
    whole = e.compare("oeq", e.intrinsic("floor", y), y)
    odd = e.both(whole, e.compare("one", e.intrinsic("floor", half), half))
    real = e.define(f"or i1 {whole}, {e.compare('oeq', size, float('inf'))}")
    of_negative = e.select(real, e.select(odd, e.neg(made), made), NAN)
    made = e.select(e.compare("olt", x, 0.0), of_negative, made)
    return e.select(e.compare("oeq", y, 0.0), ONE, made)


def angle(e: DoubleDoubleBody, y: Pair, x: Pair) -> Pair:
    """The angle of the point (x, y), which is neither very far nor very near."""
    across, along = e.magnitude(y.high), e.magnitude(x.high)
    steep = e.compare("ogt", across, along)
    shorter, longer = e.select(steep, along, across), e.select(steep, across, along)
    nowhere = e.compare("oeq", e.add(across, along), 0.0)
    ratio = e.select(nowhere, ZERO, e.div(shorter, longer))
    square = e.mul(ratio, ratio)
    total = literal(ARC_TANGENT[-1])
    for one in reversed(ARC_TANGENT[:-1]):
        total = e.add(e.mul(total, square), literal(one))
    first = e.mul(total, ratio)
    first = e.select(steep, e.sub(literal(float(PI / 2)), first), first)
    first = e.select(e.compare("olt", x.high, 0.0), e.sub(literal(float(PI)), first), first)
    start = pair(e, signed(e, first, y.high))
    return e.choose(nowhere, start, refined_angle(e, start, y, x))


def atan2(e: DoubleDoubleBody, y: Value, x: Value) -> Value:
    """The angle of any point."""
    across, along = e.magnitude(y), e.magnitude(x)
    far = e.larger(across, along)
    factor = e.select(e.compare("ogt", far, LARGE), literal(SMALL), ONE)
    factor = e.select(e.compare("olt", far, SMALL), literal(LARGE), factor)
    endless = e.compare("oeq", far, float("inf"))
    sides = []
    for one, size in ((y, across), (x, along)):
        unit = e.select(e.compare("oeq", size, float("inf")), ONE, ZERO)
        unit = e.select(e.compare("uno", size, 0.0), NAN, unit)
        sides.append(pair(e, signed(e, e.select(endless, unit, e.mul(size, factor)), one)))
    return rounded(e, angle(e, *sides))


def growing(within: Callable[[DoubleDoubleBody, Pair], Pair]) -> Formula:
    """sinh or cosh: e^|x| / 2 where the other half does not count."""

    def formula(e: DoubleDoubleBody, x: Value) -> Value:
        size = e.magnitude(x)
        half = rounded(e, e.apply("exp", pair(e, size) - e.pair(LN2)))
        half = e.select(e.compare("oeq", size, float("inf")), size, half)
        half = half if within is cosh_within else signed(e, half, x)
        return e.select(e.compare("olt", size, OVERFLOWING), rounded(e, within(e, pair(e, x))), half)

    return formula


def tanh(e: DoubleDoubleBody, x: Value) -> Value:
    """1 to the last digit beyond 40."""
    number = pair(e, x)
    made = rounded(e, sinh_within(e, number) / cosh_within(e, number))
    made = e.select(e.compare("ogt", x, 40.0), ONE, made)
    return e.select(e.compare("olt", x, -40.0), literal(-1.0), made)


FORMULAS: Mapping[str, tuple[int, Formula]] = {
    "portable.sin": (1, partial(turned, 0)),
    "portable.cos": (1, partial(turned, 1)),
    "portable.exp": (1, lambda e, x: e.call("exp.1", x, None)),
    "portable.log": (1, lambda e, x: e.call("log.1", x)),
    "portable.pow": (2, lambda e, x, y: e.call("pow.1", x, y)),
    "portable.log2": (1, lambda e, x: e.mul(e.call("log.1", x), literal(float(1 / LN2)))),
    "portable.exp2": (1, lambda e, x: e.call("exp.1", e.mul(x, literal(float(LN2))), None)),
    "portable.tan": (1, tangent),
    "portable.atan": (1, lambda e, x: atan2(e, x, ONE)),
    "portable.asin": (1, lambda e, x: angle(e, pair(e, x), leg(e, pair(e, x)))),
    "portable.acos": (1, lambda e, x: angle(e, leg(e, pair(e, x)), pair(e, x))),
    "portable.atan2": (2, atan2),
    "portable.sinh": (1, growing(sinh_within)),
    "portable.cosh": (1, growing(cosh_within)),
    "portable.tanh": (1, tanh),
    "beyond.sin": (1, lambda e, x: e.apply("wide_sin", x)),
    "beyond.cos": (1, lambda e, x: e.apply("wide_cos", x)),
    "beyond.exp": (1, lambda e, x: e.apply("exp", pair(e, x))),
    "beyond.log": (1, beyond_log),
    "beyond.pow": (2, beyond_pow),
}  # fmt: skip
"""By name, how many doubles a function takes, and what it is; ``beyond`` the range of ``elementary``."""
