"""The formulas of the elementary functions, and where they hold: each returns (condition, results).

Argument reduction: W. J. Cody and W. Waite, Software Manual for the Elementary Functions (1980); with fma:
S. Boldo, M. Daumas and R.-C. Li, IEEE Trans. Comp. 58 (2009). Coefficients: benchmarks/tools/minimax.py.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import TypeAlias

from lagrange_cli.native.llvm.declarations import INTRINSICS
from lagrange_cli.native.llvm.vector import Bit, Instructions, Integer, Real
from lagrange_cli.native.numbers.error_free import fast_sum

SINE = (
    -0.16666666666666632, 0.00833333333332249, -0.00019841269829857768, 2.7557313706978406e-06,
    -2.5050760235187317e-08, 1.5896908699284646e-10,
)  # fmt: skip
"""(sin(r) / r - 1) / r^2 in powers of r^2, |r| <= pi/4; error of the sine 2^-58."""
COSINE = (
    0.0416666666666666, -0.0013888888888874474, 2.4801587289671537e-05, -2.7557314401029515e-07,
    2.0875729280832274e-09, -1.1359934206398372e-11,
)  # fmt: skip
"""(cos(r) - 1 + r^2 / 2) / r^4 in powers of r^2; error of the cosine 2^-64."""
HALF_PI = (1.5707963267948966, 6.12323399538461e-17, 3.5215598651832e-27)
"""pi/2 in three parts. The second has 33 bits: times an integer below 2^20 it is exact."""
TWO_OVER_PI = 0.6366197723675814
LARGEST_ANGLE = 2.0**20
ROUND = 1.5 * 2.0**52
"""Added to a number below 2^51, it leaves the nearest integer in the lowest bits."""
SIGN = -(2**63)
EXPONENTIAL = (
    0.5, 0.1666666666666668, 0.04166666666666678, 0.008333333333320201, 0.0013888888888802706,
    0.00019841269892117319, 2.4801587556717142e-05, 2.7557235074474104e-06, 2.755701138921772e-07,
    2.5113214962457922e-08, 2.101449177070314e-09,
)  # fmt: skip
"""(e^r - 1 - r) / r^2 in powers of r, |r| <= ln(2)/2; error of the exponential 2^-61."""
LOGARITHM = (
    0.4, 0.2857142857142689, 0.22222222222716462, 0.18181818106032005, 0.15384622184355357,
    0.13332959967841837, 0.1177726617573723, 0.10278975216531955, 0.12028916057464094,
)  # fmt: skip
"""(2 artanh(s) / s - 2 - 2 s^2 / 3) / s^4 in powers of s^2, where ln m = 2 artanh(s); error of ln 2^-77."""
LN_2 = (0.6931471805598903, 5.497923018708371e-14)
"""ln 2 in two parts. The first has 42 bits: times an integer below 2^11 it is exact."""
INVERSE_LN_2 = 1.4426950408889634
TWO_THIRDS = (0.6666666666666666, 3.700743415417188e-17)
LARGEST_EXPONENT = 708.0
LEAST_NORMAL = 2.0**-1022
EXPONENT, BIAS = 52, 1023
"""The first bit of the exponent, and its bias."""
SQRT_HALF = 0x3FE6A09E667F3BCD
"""The bits of sqrt(1/2)."""
RAISED = 0x4330000000000000
"""The bits of 2^52: or-ed with the bits of a small integer n, those of 2^52 + n."""


Results: TypeAlias = tuple[Bit, list[Real]]


def sine_and_cosine(body: Instructions, x: Real, low: Real) -> Results:
    """sin(x + low) and cos(x + low).

    x = n pi/2 + r + rest: subtracting n times the first part of pi/2 is exact, and so is what remains of the
    second in ``rest``.
    """
    shifted = body.fma(x, TWO_OVER_PI, ROUND)
    minus_n = -(shifted - ROUND)
    first = body.fma(minus_n, HALF_PI[0], x)
    main = body.fma(minus_n, HALF_PI[1], first)
    rest = body.fma(minus_n, HALF_PI[1], first - main)
    rest = body.fma(minus_n, HALF_PI[2], rest) + low
    r = main + rest
    rest = rest - (r - main)
    square = r * r
    half, fourth = square * 0.5, square * square
    one = body.constant(1.0)
    top = one - half
    # sin(r + rest) = r + [r^3 S(r^2) + rest (1 - r^2/2)]
    sine = r + body.fma(r * square, polynomial(body, SINE, square), rest * top)
    # cos(r + rest) = 1 - r^2/2 + [r^4 C(r^2) - r rest], r^2 with its rounding error
    small = body.fma(-r, rest, one - top - half)
    small = body.fma(body.fma(r, r, -square), -0.5, small)
    cosine = top + body.fma(fourth, polynomial(body, COSINE, square), small)
    n = shifted.bits()
    odd = n.odd()
    sine, cosine = body.select(odd, cosine, sine), body.select(odd, sine, cosine)
    plain = body.magnitude(x) < LARGEST_ANGLE
    return plain, [turned(n, sine), turned(n + 1, cosine)]


def polynomial(body: Instructions, coefficients: Sequence[float], x: Real) -> Real:
    """sum_j coefficients[j] x^j, by pairs, pairs of pairs, .. (G. Estrin 1960), with short chains of
    operations."""
    terms: list[Real | float] = list(coefficients)
    while True:
        pairs: list[Real | float] = [body.fma(x, b, a) for a, b in zip(terms[::2], terms[1::2])]
        terms = pairs + terms[2 * len(pairs) :]
        if len(terms) == 1:
            assert isinstance(terms[0], Real)
            return terms[0]
        x = x * x


def turned(n: Integer, value: Real) -> Real:
    """``value`` with its sign changed where bit 1 of n is set."""
    sign = (n << 62) & SIGN
    return (value.bits() ^ sign).number()


def library_sine_and_cosine(body: Instructions, x: Real, low: Real) -> list[Real]:
    """The same by the C library, to first order in ``low``."""
    sine, cosine = body.function("sin", x), body.function("cos", x)
    return [body.fma(cosine, low, sine), body.fma(-sine, low, cosine)]


def exponential(body: Instructions, x: Real, low: Real) -> Results:
    """e^(x + low), where x = n ln 2 + r + rest."""
    shifted = body.fma(x, INVERSE_LN_2, ROUND)
    minus_n = -(shifted - ROUND)
    first = body.fma(minus_n, LN_2[0], x)
    r, rest = fast_sum(first, body.fma(minus_n, LN_2[1], low))
    # 1 + r + [r^2 P(r) + rest (1 + r)]
    one = body.constant(1.0)
    top, top_rest = fast_sum(one, r)
    small = body.fma(r * r, polynomial(body, EXPONENTIAL, r), body.fma(rest, top, top_rest))
    power = shifted.bits() << EXPONENT
    made = (top + small).bits() + power
    return body.magnitude(x) < LARGEST_EXPONENT, [made.number()]


def logarithm(body: Instructions, x: Real) -> Results:
    """ln x."""
    plain, high, _ = exact_logarithm(body, x)
    return plain, [high]


def power(body: Instructions, x: Real, y: Real) -> Results:
    """x^y = e^(y ln x)."""
    positive, high, low = exact_logarithm(body, x)
    exponent = y * high
    small, results = exponential(body, exponent, body.fma(y, low, body.fma(y, high, -exponent)))
    return positive & small, results


def exact_logarithm(body: Instructions, x: Real) -> tuple[Bit, Real, Real]:
    """ln x = k ln 2 + ln m as a sum of two doubles, to about 68 bits, for positive x that are not denormal.

    With s = (m - 1) / (m + 1), ln m = 2 artanh(s) = 2 s + s [2/3 s^2 + s^4 P(s^2)].
    """
    finite = x < math.inf
    plain = (x >= LEAST_NORMAL) & finite
    bits = x.bits()
    biased = bits + ((BIAS << EXPONENT) - SQRT_HALF)  # sqrt(1/2) <= m < sqrt(2)
    k = (biased.operation("lshr", EXPONENT) | RAISED).number() - (2.0**52 + BIAS)
    exponent = biased & -(1 << EXPONENT)
    m = ((bits - exponent) + (BIAS << EXPONENT)).number()
    one = body.constant(1.0)
    above, below = m - one, m + one
    below_rest = m - (below - one)
    inverse = one / below
    s = above * inverse
    s_rest = body.fma(-s, below_rest, body.fma(-s, below, above)) * inverse
    square = s * s
    square_rest = body.fma(s, s, -square)
    square_rest = body.fma(s + s, s_rest, square_rest)
    # The bracket as w + w_rest, its first term as u + u_rest.
    u = square * TWO_THIRDS[0]
    u_rest = body.fma(square, TWO_THIRDS[0], -u)
    u_rest = body.fma(square_rest, TWO_THIRDS[0], body.fma(square, TWO_THIRDS[1], u_rest))
    fourth = square * square
    fourth_rest = body.fma(square + square, square_rest, body.fma(square, square, -fourth))
    tail = body.fma(square, polynomial(body, LOGARITHM[1:], square), LOGARITHM[0])
    w = body.fma(fourth, tail, u)
    w_rest = body.fma(fourth_rest, tail, body.fma(fourth, tail, u - w) + u_rest)
    product = s * w
    product_rest = body.fma(s, w_rest, body.fma(s, w, -product))
    product_rest = body.fma(s_rest, w, body.fma(s_rest, 2.0, product_rest))
    high, low = fast_sum(s + s, product)
    high, rest = fast_sum(k * LN_2[0], high)
    low = body.fma(k, LN_2[1], low + product_rest) + rest
    return (plain, *fast_sum(high, low))


def library_exponential(body: Instructions, x: Real, low: Real) -> list[Real]:
    """The same by the C library."""
    return [body.function("exp", x) * (body.constant(1.0) + low)]


def library(name: str) -> Callable[..., list[Real]]:
    """The C library's function of this name."""
    called = f"llvm.{name}.f64" if name in INTRINSICS else name
    return lambda f, *arguments: [f.call(Real, called, *arguments)]
