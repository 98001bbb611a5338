"""The elementary functions of double-double numbers as LLVM IR.

Sine, cosine and the exponential by reduction and Taylor series; what is inverse to them by one step of
Newton's iteration from the double value, which doubles its digits.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping, Sequence
from fractions import Fraction
from functools import partial
from math import factorial

from lagrange_cli.native.interface import LANES
from lagrange_cli.native.llvm.function import Function
from lagrange_cli.native.llvm.vector import Bit, Integer, Real, cast
from lagrange_cli.native.numbers.double_double import (
    OPERATIONS,
    DDReal,
    apply,
    called,
    choose,
    define,
    head_of,
    pair,
    pair_type,
)
from lagrange_cli.native.numbers.error_free import two_product

LARGEST_ANGLE = 2.0**40
"""The largest angle of a sine: beyond it few digits of the angle would be left, and four doubles of pi do not
suffice."""
SERIES = 31
"""The last power of sine's series that counts below pi/4."""
LOWERED = 512
"""Numbers above 2^512 are divided by it for their logarithm."""

OVERFLOWING, ONE = 700.0, 40.0
"""The hyperbolic functions' argument from which e^x may overflow, and that from which tanh is 1 to the last
digit."""
INFINITY = float("inf")
PI = Fraction("3.141592653589793238462643383279502884197169399375105820974944592307816406286208998628")
LN2 = Fraction("0.6931471805599453094172321214581765680755001343602552541206800094933936219696947156058633")


def horner(coefficients: Sequence[Fraction], x: DDReal) -> DDReal:
    """sum_j coefficients[j] x^j."""
    body = x.high.body
    total = pair(body, coefficients[-1])
    for one in reversed(coefficients[:-1]):
        total = total * x + pair(body, one)
    return total


def series(first: int, last: int, by: int = 1, sign: int = 1) -> list[Fraction]:
    """1/first!, sign/(first + by)!, .."""
    return [Fraction(sign**i, factorial(n)) for i, n in enumerate(range(first, last + 1, by))]


def parts(value: Fraction, count: int) -> list[float]:
    """Doubles that add up to ``value``, each what the ones before have left."""
    found = []
    for _ in range(count):
        found.append(float(value))
        value -= Fraction(found[-1])
    return found


def nearest(x: Real) -> Real:
    """The whole number nearest to a double, or nearly so."""
    return x.body.function("floor", x + 0.5)


def less(x: DDReal, count: Real, unit: Sequence[float]) -> DDReal:
    """x - ``count`` times the sum of ``unit``."""
    for one in unit:
        x = x - DDReal(*two_product(count, count.body.constant(one)))
    return x


def turned(quarters: Integer, cosine: bool, sine: DDReal, cosines: DDReal) -> DDReal:
    """Sine, or cosine, of an angle so many right angles further than that of the given sine and cosine."""
    quarter = (quarters + int(cosine)) & 3
    made = choose(quarter.odd(), cosines, sine)
    return choose(quarter >= 2, -made, made)


def _sin_cos(x: DDReal, *, cosine: bool) -> DDReal:
    body, (high, low) = x.high.body, x.parts
    good = body.magnitude(high) < LARGEST_ANGLE
    turns = body.select(good, nearest(high * float(2 / PI)), 0.0)
    first, *others = parts(PI / 2, 4)
    product, error = two_product(turns, body.constant(first))
    rest = DDReal(high - product) + DDReal(-error)
    rest = less(rest + DDReal(low), turns, others)
    square = rest * rest
    sine = rest + rest * (square * horner(series(3, SERIES, 2, -1), square)).scaled(-1.0)
    cosines = pair(body, 1) - square * horner(series(2, SERIES + 1, 2, -1), square)
    made = turned(cast(turns, "fptosi", Integer), cosine, sine, cosines)
    return choose(good, made, pair(body, float("nan")))


def _exp(x: DDReal) -> DDReal:
    body = x.high.body
    bounded = body.function("minnum", body.function("maxnum", x.high, -800.0), 800.0)
    twos = nearest(bounded * float(1 / LN2))
    rest = less(x, twos, parts(LN2, 3))
    made = pair(body, 1) + (rest + rest * rest * horner(series(2, 27), rest))
    whole = cast(twos, "fptosi", Integer)
    half = whole.operation("ashr", 1)  # 2^1024 is no double: in two steps
    for power in (half, whole - half):
        factor = ((power + 1023) << 52).number()
        made = DDReal(*(one * factor for one in made.parts))
    infinite = choose(x.high > 709.79, DDReal(body.constant(INFINITY)), made)
    return choose(x.high < -745.2, pair(body, 0), infinite)


def _log(x: DDReal) -> DDReal:
    body = x.high.body
    large = x.high > 2.0**LOWERED  # else the low part of 1/x would underflow
    lowered = choose(large, x.scaled(2.0**-LOWERED), x)
    first = DDReal(body.function("log", lowered.high))
    rest = lowered * apply("exp", -first) - pair(body, 1)
    made = first + (rest - (rest * rest).scaled(0.5))
    made = choose(large, made + pair(body, LOWERED * LN2), made)
    return choose(body.magnitude(first.high) < INFINITY, made, first)


def parity(y: DDReal) -> tuple[Bit, Bit]:
    """Whether a number is whole, and whether it is odd then."""
    body = y.high.body
    floors = [body.function("floor", one) for one in y.parts]
    rests = [one - body.function("floor", one * 0.5) * 2.0 for one in floors]
    whole = floors[0].equals(y.parts[0])
    for floor, one in zip(floors[1:], y.parts[1:]):
        whole = whole & floor.equals(one)
    total = rests[0]
    for one in rests[1:]:
        total = total + one
    return whole, total.equals(1.0)


def _pow(x: DDReal, y: DDReal) -> DDReal:
    body = x.high.body
    negative = x.high < 0.0
    made = apply("exp", y * apply("log", choose(negative, -x, x)))
    whole, odd = parity(y)
    of_negative = choose(whole, choose(odd, -made, made), pair(body, float("nan")))
    made = choose(negative, of_negative, made)
    other = choose(y.high < 0.0, DDReal(body.constant(INFINITY)), pair(body, 1))
    of_zero = choose(y.high > 0.0, pair(body, 0), other)
    return choose(x.high.equals(0.0), of_zero, made)


def of_doubles(name: str, *arguments: DDReal) -> DDReal:
    """A function of the C library of the doubles nearest to numbers."""
    high = arguments[0].high
    listed = ", ".join(f"double {one.high.name}" for one in arguments)
    return DDReal(high.made(f"call double @{name}({listed})"))


def refined_angle(first: DDReal, y: DDReal, x: DDReal) -> DDReal:
    """The angle of (x, y) from one near it, by the tangent of the difference: three times its digits."""
    sine, cosine = apply("sin", first), apply("cos", first)
    return first + (y * cosine - x * sine) / (x * cosine + y * sine)


def leg(x: DDReal) -> DDReal:
    """sqrt(1 - x^2)."""
    one = pair(x.high.body, 1)
    return apply("sqrt", (one - x) * (one + x))


def sinh_within(x: DDReal) -> DDReal:
    """sinh x where e^x does not overflow."""
    power = apply("exp", x)
    large = (power - pair(x.high.body, 1) / power).scaled(0.5)
    square = x * x
    small = x + x * square * horner(series(3, 27, 2), square)
    return choose(x.high.body.magnitude(x.high) < 0.5, small, large)


def cosh_within(x: DDReal) -> DDReal:
    """cosh x, likewise."""
    power = apply("exp", x)
    return (power + pair(x.high.body, 1) / power).scaled(0.5)


def otherwise_double(name: str, made: DDReal, x: DDReal, below: float) -> DDReal:
    """A function as it was ``made`` if |x| is ``below`` that, and as a double beyond."""
    double = of_doubles(name, x)
    return choose(x.high.body.magnitude(x.high) < below, made, double)


FUNCTIONS: Mapping[str, tuple[str, Callable[..., DDReal]]] = {
    "sin": ("p", partial(_sin_cos, cosine=False)),
    "cos": ("p", partial(_sin_cos, cosine=True)),
    "exp": ("p", _exp),
    "log": ("p", _log),
    "pow": ("pp", _pow),
    "atan2": ("pp", lambda y, x: refined_angle(of_doubles("atan2", y, x), y, x)),
    "tan": ("p", lambda x: apply("sin", x) / apply("cos", x)),
    "atan": ("p", lambda x: apply("atan2", x, pair(x.high.body, 1))),
    "asin": ("p", lambda x: apply("atan2", x, leg(x))),
    "acos": ("p", lambda x: apply("atan2", leg(x), x)),
    "sinh": ("p", lambda x: otherwise_double("sinh", sinh_within(x), x, OVERFLOWING)),
    "cosh": ("p", lambda x: otherwise_double("cosh", cosh_within(x), x, OVERFLOWING)),
    "tanh": ("p", lambda x: otherwise_double("tanh", apply("sinh", x) / apply("cosh", x), x, ONE)),
}
TOGETHER = "sin", "cos", "exp"
"""Those that need no function of doubles: vectors are computed together."""
CALLED = re.compile(rf"@pair_(\w+)\.{LANES}\(")


def functions() -> Sequence[str]:
    """``@pair_sin`` and the others; they need ``numbers.double_double.operations``."""
    return [define(name, *one) for name, one in FUNCTIONS.items()]


def of_vectors(text: str) -> Sequence[str]:
    """The functions of eight numbers that ``text`` calls, and those that these call."""
    made: dict[str, str] = {}
    pending = [text]
    while pending:
        for name in sorted(set(CALLED.findall(pending.pop())) - made.keys()):
            if name in OPERATIONS or name in TOGETHER:
                made[name] = define(name, *(OPERATIONS.get(name) or FUNCTIONS[name]), LANES)
            else:
                made[name] = one_by_one(name, FUNCTIONS[name][0])
            pending.append(made[name])
    return [*made.values()]


def one_by_one(name: str, kinds: str) -> str:
    """The text of a function of eight numbers, each computed by the function of one."""
    f = Function(f"define internal {pair_type(LANES)} {head_of(name, kinds, LANES)} #0")
    given = [Real(f, f"%{part}{i}", LANES) for i in range(len(kinds)) for part in "ab"]
    f.give(*f.lane_by_lane(given, 2, lambda one: called(f, f"pair_{name}", *one).parts))
    return f.text()
