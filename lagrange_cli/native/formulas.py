"""The formulas of the elementary functions where their arguments are plain.

Argument reduction: W. J. Cody and W. Waite, Software Manual for the Elementary Functions (1980); with fma:
S. Boldo, M. Daumas and R.-C. Li, IEEE Trans. Comp. 58 (2009). Coefficients: benchmarks/minimax.py.
"""

from __future__ import annotations

from lagrange_cli.native.arithmetic import Body, Real

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


def angle_is_plain(body: Body, x: Real, low: Real) -> str:
    """Where ``sine_and_cosine`` holds."""
    return body.below(body.function("fabs", x), LARGEST_ANGLE)


def sine_and_cosine(body: Body, x: Real, low: Real) -> list[Real]:
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
    sine = r + body.fma(r * square, body.polynomial(SINE, square), rest * top)
    # cos(r + rest) = 1 - r^2/2 + [r^4 C(r^2) - r rest], r^2 with its rounding error
    small = body.fma(-r, rest, one - top - half)
    small = body.fma(body.fma(r, r, -square), -0.5, small)
    cosine = top + body.fma(fourth, body.polynomial(COSINE, square), small)
    n = body.bits(shifted)
    odd = body.define(f"trunc {body.integer} {n} to {body.bit}")
    return [
        turned(body, n, body.select(odd, cosine, sine)),
        turned(body, body.integers("add", n, 1), body.select(odd, sine, cosine)),
    ]


def turned(body: Body, n: str, value: Real) -> Real:
    """``value`` with its sign changed where bit 1 of n is set."""
    sign = body.integers("and", body.integers("shl", n, 62), SIGN)
    return body.number(body.define(f"xor {body.integer} {body.bits(value)}, {sign}"))


def library_sine_and_cosine(body: Body, x: Real, low: Real) -> list[Real]:
    """The same by the C library, to first order in ``low``."""
    sine, cosine = body.function("sin", x), body.function("cos", x)
    return [body.fma(cosine, low, sine), body.fma(-sine, low, cosine)]
