"""Sine and cosine of angles of many turns as LLVM IR, to double-double precision.

M. H. Payne and R. N. Hanek, ACM SIGNUM Newsletter 18 (1983): of x 2/pi only what is left of whole turns is
computed, x being an integer times a power of two, by integers of 256 bits of those digits of 2/pi that count.
"""

from __future__ import annotations

from functools import partial

from lagrange_cli.native.functions.double_double import PI, turned
from lagrange_cli.native.llvm.vector import Integer, Real
from lagrange_cli.native.numbers.double_double import DDReal, apply, choose, define, pair

LEAST_WIDE = 2.0**20
"""Angles below it are none of these."""
WORDS, WORD = 4, 64
BITS, PADDING = 1280, 128
"""Binary digits of 2/pi that are kept, so many zeros above them."""
FRACTION = WORDS * WORD - 2
"""Binary digits of a product that are a fraction of a right angle; the two above count right angles."""
MANTISSA, BIAS = 52, 1075
PIECE = 32
"""Bits of an integer that are made a double at once."""


def two_over_pi() -> int:
    """2^BITS 2/pi, by pi = 16 atan(1/5) - 4 atan(1/239) (J. Machin, 1706)."""
    one = 1 << (BITS + WORD)

    def arc_cotangent(n: int) -> int:
        term = total = one // n
        k = 1
        while term:
            term //= -n * n
            k += 2
            total += term // k
        return total

    return (2 * one << BITS) // (16 * arc_cotangent(5) - 4 * arc_cotangent(239))


def table() -> str:
    """``@two_over_pi``: its bytes, lowest first."""
    digits = two_over_pi().to_bytes((BITS + PADDING) // 8, "little")
    listed = ", ".join(f"i8 {byte}" for byte in digits)
    return f"@two_over_pi = private constant [{len(digits)} x i8] [{listed}], align 8\n"


def reduced(size: Real) -> tuple[Integer, DDReal]:
    """``size`` in right angles: the nearest integer (its two last bits count), and what is left."""
    body, bits = size.body, size.bits()
    exponent = bits.operation("lshr", MANTISSA) - BIAS
    mantissa = (bits & (1 << MANTISSA) - 1) | 1 << MANTISSA
    # So many digits of 2/pi are left out that the product has ``FRACTION`` bits of fraction: whole bytes, and
    # the mantissa is moved to make up for what these are too much.
    out = body.count(BITS - FRACTION) - exponent
    byte = (out + 7).operation("lshr", 3)
    mantissa = mantissa << (byte << 3) - out
    place = body.define(f"getelementptr inbounds i8, ptr @two_over_pi, i64 {byte.name}")
    factor = body.define(f"zext i64 {mantissa.name} to i128")
    carry, words = "0", list[Integer]()
    for i in range(WORDS):
        at = body.define(f"getelementptr inbounds i8, ptr {place}, i64 {8 * i}")
        digits = body.define(f"zext i64 {body.define(f'load i64, ptr {at}, align 1')} to i128")
        product = body.define(f"add i128 {body.define(f'mul i128 {factor}, {digits}')}, {carry}")
        words.append(Integer(body, body.define(f"trunc i128 {product} to i64")))
        carry = body.define(f"lshr i128 {product}, {WORD}")
    top = words[-1]
    count = (top + (1 << (WORD - 3))).operation("lshr", WORD - 2)
    rest = top - (count << WORD - 2)
    total, scale = pair(body, 0), 2.0 ** (PIECE - WORD + 2)
    for shift, word in (("ashr", rest), ("lshr", words[-2]), ("lshr", words[-3])):
        for piece in (word.operation(shift, PIECE), word & (1 << PIECE) - 1):
            total = total + DDReal(piece.to_real() * scale)
            scale /= 2.0**PIECE
    return count, total


def _wide(x: Real, *, cosine: bool) -> DDReal:
    body, size = x.body, x.body.magnitude(x)
    finite = size < float("inf")
    count, rest = reduced(body.select(finite & (size >= LEAST_WIDE), size, body.constant(LEAST_WIDE)))
    rest = rest * pair(body, PI / 2)
    made = turned(count, cosine, apply("sin", rest), apply("cos", rest))
    if not cosine:
        made = choose(x < 0.0, -made, made)
    return choose(finite, made, pair(body, float("nan")))


def wide_functions() -> tuple[str, ...]:
    """``@pair_wide_sin`` and ``@pair_wide_cos`` of a double of either sign, from ``LEAST_WIDE`` on."""
    return tuple(define(f"wide_{name}", "d", partial(_wide, cosine=name == "cos")) for name in ("sin", "cos"))
