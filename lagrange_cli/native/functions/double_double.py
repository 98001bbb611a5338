"""The elementary functions of double-double numbers as LLVM IR.

Sine, cosine and the exponential by reduction and Taylor series; what is inverse to them by one step of
Newton's iteration from the double value, which doubles its digits.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from fractions import Fraction
from math import factorial

from lagrange_cli.native.llvm.text import Value, literal
from lagrange_cli.native.numbers.double_double import DoubleDoubleBody, Pair, define
from lagrange_cli.native.numbers.error_free import fast_sum, two_product

LARGEST_ANGLE = 2.0**40
"""The largest angle of a sine: beyond it few digits of the angle would be left, and four doubles of pi do not
suffice."""
SERIES = 31
"""The last power of sine's series that counts below pi/4."""
LOWERED = 512
"""Numbers above 2^512 are divided by it for their logarithm."""

MINUS_ONE, INFINITY = literal(-1.0), literal(float("inf"))
PI = Fraction("3.141592653589793238462643383279502884197169399375105820974944592307816406286208998628")
LN2 = Fraction("0.6931471805599453094172321214581765680755001343602552541206800094933936219696947156058633")


def horner(e: DoubleDoubleBody, coefficients: Sequence[Fraction], x: Pair) -> Pair:
    """sum_j coefficients[j] x^j."""
    total = e.pair(coefficients[-1])
    for one in reversed(coefficients[:-1]):
        total = total * x + e.pair(one)
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


def nearest(e: DoubleDoubleBody, x: Value) -> Value:
    """The whole number nearest to a double, or nearly so."""
    return e.intrinsic("floor", e.add(x, literal(0.5)))


def whole(e: DoubleDoubleBody, x: Value) -> str:
    """A double that is whole as an integer."""
    return e.define(f"fptosi double {x} to i64")


def turned(e: DoubleDoubleBody, quarters: str, cosine: bool, sine: Pair, cosines: Pair) -> Pair:
    """Sine, or cosine, of an angle so many right angles further than that of the given sine and cosine."""
    quarter = e.integer("and", e.integer("add", quarters, int(cosine)), 3)
    made = e.choose(e.define(f"trunc i64 {quarter} to i1"), cosines, sine)
    return e.choose(e.define(f"icmp uge i64 {quarter}, 2"), -made, made)


def _sin_cos(cosine: bool) -> str:
    def formula(e: DoubleDoubleBody, x: Pair) -> Pair:
        size = e.magnitude(x.high)
        good = e.compare("olt", size, LARGEST_ANGLE)
        turns = nearest(e, e.mul(x.high, literal(float(2 / PI))))
        turns = e.select(good, turns, None)
        first, *others = parts(PI / 2, 4)
        product, error = two_product(e, turns, literal(first))
        rest = Pair(e, e.sub(x.high, product), None)
        rest = rest + Pair(e, *fast_sum(e, e.neg(error), None))
        rest = rest + Pair(e, x.low, None)
        for one in others:
            rest = rest - Pair(e, *two_product(e, turns, literal(one)))
        square = rest * rest
        sine = rest + rest * (square * horner(e, series(3, SERIES, 2, -1), square).scaled(MINUS_ONE))
        cosines = e.pair(1) - square * horner(e, series(2, SERIES + 1, 2, -1), square)
        made = turned(e, whole(e, turns), cosine, sine, cosines)
        return e.choose(good, made, e.pair(float("nan")))

    return define("cos" if cosine else "sin", "p", formula)


def _exp(e: DoubleDoubleBody, x: Pair) -> Pair:
    bounded = e.intrinsic("minnum", e.intrinsic("maxnum", x.high, literal(-800.0)), literal(800.0))
    twos = nearest(e, e.mul(bounded, literal(float(1 / LN2))))
    rest = x - Pair(e, *two_product(e, twos, literal(parts(LN2, 3)[0])))
    for one in parts(LN2, 3)[1:]:
        rest = rest - Pair(e, *two_product(e, twos, literal(one)))
    made = e.pair(1) + (rest + rest * rest * horner(e, series(2, 27), rest))
    half = e.define(f"ashr i64 {whole(e, twos)}, 1")  # 2^1024 is no double: in two steps
    for power in (half, e.integer("sub", whole(e, twos), half)):
        bits = e.integer("shl", e.integer("add", power, 1023), 52)
        factor = e.define(f"bitcast i64 {bits} to double")
        made = Pair(e, e.mul(made.high, factor), e.mul(made.low, factor))
    zero, infinite = e.compare("olt", x.high, -745.2), e.compare("ogt", x.high, 709.79)
    return e.choose(zero, e.pair(0), e.choose(infinite, Pair(e, INFINITY, None), made))


def _log(e: DoubleDoubleBody, x: Pair) -> Pair:
    large = e.compare("ogt", x.high, 2.0**LOWERED)  # else the low part of 1/x would underflow
    lowered = e.choose(large, x.scaled(literal(2.0**-LOWERED)), x)
    first = Pair(e, e.intrinsic("log", lowered.high), None)
    rest = lowered * e.apply("exp", -first) - e.pair(1)
    made = first + (rest - (rest * rest).scaled(literal(0.5)))
    made = e.choose(large, made + e.pair(LOWERED * LN2), made)
    finite = e.compare("olt", e.magnitude(first.high), INFINITY)
    return e.choose(finite, made, first)


def _pow(e: DoubleDoubleBody, x: Pair, y: Pair) -> Pair:
    made = e.apply("exp", y * e.apply("log", x))
    zero, above, below = (
        e.compare(*one) for one in (("oeq", x.high, None), ("ogt", y.high, None), ("olt", y.high, None))
    )
    of_zero = e.choose(above, e.pair(0), e.choose(below, Pair(e, INFINITY, None), e.pair(1)))
    return e.choose(zero, of_zero, made)


def _atan2(e: DoubleDoubleBody, y: Pair, x: Pair) -> Pair:
    first = Pair(e, e.call("atan2", y.high, x.high), None)
    return refined_angle(e, first, y, x)


def refined_angle(e: DoubleDoubleBody, first: Pair, y: Pair, x: Pair) -> Pair:
    """The angle of (x, y) from one near it, by the tangent of the difference: three times its digits."""
    sine, cosine = e.apply("sin", first), e.apply("cos", first)
    return first + (y * cosine - x * sine) / (x * cosine + y * sine)


def _tan(e: DoubleDoubleBody, x: Pair) -> Pair:
    return e.apply("sin", x) / e.apply("cos", x)


def leg(e: DoubleDoubleBody, x: Pair) -> Pair:
    """sqrt(1 - x^2)."""
    return e.apply("sqrt", (e.pair(1) - x) * (e.pair(1) + x))


def sinh_within(e: DoubleDoubleBody, x: Pair) -> Pair:
    """sinh x where e^x does not overflow."""
    power = e.apply("exp", x)
    large = (power - e.pair(1) / power).scaled(literal(0.5))
    square = x * x
    small = x + x * square * horner(e, series(3, 27, 2), square)
    return e.choose(e.compare("olt", e.magnitude(x.high), 0.5), small, large)


def cosh_within(e: DoubleDoubleBody, x: Pair) -> Pair:
    """cosh x, likewise."""
    power = e.apply("exp", x)
    return (power + e.pair(1) / power).scaled(literal(0.5))


def overflowing(name: str, within: Callable[[DoubleDoubleBody, Pair], Pair]) -> str:
    """sinh or cosh; as a double where e^x may overflow."""

    def formula(e: DoubleDoubleBody, x: Pair) -> Pair:
        made, double = within(e, x), Pair(e, e.call(name, x.high), None)
        return e.choose(e.compare("olt", e.magnitude(x.high), 700.0), made, double)

    return define(name, "p", formula)


def _tanh(e: DoubleDoubleBody, x: Pair) -> Pair:
    made = e.apply("sinh", x) / e.apply("cosh", x)
    sign = Pair(e, e.call("tanh", x.high), None)  # beyond 40 it is 1 to the last digit
    return e.choose(e.compare("olt", e.magnitude(x.high), 40.0), made, sign)


def functions() -> Sequence[str]:
    """``@pair_sin`` and the others; they need ``numbers.double_double.operations``."""
    return (
        _sin_cos(cosine=False),
        _sin_cos(cosine=True),
        define("exp", "p", _exp),
        define("log", "p", _log),
        define("pow", "pp", _pow),
        define("atan2", "pp", _atan2),
        define("tan", "p", _tan),
        define("atan", "p", lambda e, x: e.apply("atan2", x, e.pair(1))),
        define("asin", "p", lambda e, x: e.apply("atan2", x, leg(e, x))),
        define("acos", "p", lambda e, x: e.apply("atan2", leg(e, x), x)),
        overflowing("sinh", sinh_within),
        overflowing("cosh", cosh_within),
        define("tanh", "p", _tanh),
    )
