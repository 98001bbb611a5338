"""Sine and cosine of angles of many turns as LLVM IR, to double-double precision.

M. H. Payne and R. N. Hanek, ACM SIGNUM Newsletter 18 (1983): of x 2/pi only what is left of whole turns is
computed, x being an integer times a power of two, by integers of 256 bits of those digits of 2/pi that count.
"""

from __future__ import annotations

from lagrange_cli.native.functions.double_double import PI, turned
from lagrange_cli.native.llvm.text import Operand, literal
from lagrange_cli.native.numbers.double_double import DoubleDoubleBody, Pair, define

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


def reduced(e: DoubleDoubleBody, size: Operand) -> tuple[str, Pair]:
    """``size`` in right angles: the nearest integer (its two last bits count), and what is left."""
    bits = e.define(f"bitcast double {size} to i64")
    exponent = e.integer("sub", e.integer("lshr", bits, MANTISSA), BIAS)
    mantissa = e.integer("or", e.integer("and", bits, (1 << MANTISSA) - 1), 1 << MANTISSA)
    # So many digits of 2/pi are left out that the product has ``FRACTION`` bits of fraction: whole bytes, and
    # the mantissa is moved to make up for what these are too much.
    out = e.integer("sub", BITS - FRACTION, exponent)
    byte = e.integer("lshr", e.integer("add", out, 7), 3)
    mantissa = e.integer("shl", mantissa, e.integer("sub", e.integer("shl", byte, 3), out))
    place = e.define(f"getelementptr inbounds i8, ptr @two_over_pi, i64 {byte}")
    factor = e.define(f"zext i64 {mantissa} to i128")
    carry, words = "0", []
    for i in range(WORDS):
        at = e.define(f"getelementptr inbounds i8, ptr {place}, i64 {8 * i}")
        digits = e.define(f"zext i64 {e.define(f'load i64, ptr {at}, align 1')} to i128")
        product = e.define(f"add i128 {e.define(f'mul i128 {factor}, {digits}')}, {carry}")
        words.append(e.define(f"trunc i128 {product} to i64"))
        carry = e.define(f"lshr i128 {product}, {WORD}")
    top = words[-1]
    count = e.integer("lshr", e.integer("add", top, 1 << (WORD - 3)), WORD - 2)
    rest = e.integer("sub", top, e.integer("shl", count, WORD - 2))
    total = e.pair(0)
    scale = 2.0 ** (PIECE - WORD + 2)
    for shift, word in (("ashr", rest), ("lshr", words[-2]), ("lshr", words[-3])):
        upper, lower = e.integer(shift, word, PIECE), e.integer("and", word, (1 << PIECE) - 1)
        for piece in (upper, lower):
            number = e.define(f"sitofp i64 {piece} to double")
            total = total + Pair(e, e.mul(number, literal(scale)), None)
            scale /= 2.0**PIECE
    return count, total


def _wide(cosine: bool) -> str:
    def formula(e: DoubleDoubleBody, x: Operand) -> Pair:
        size = e.magnitude(x)
        finite = e.compare("olt", size, float("inf"))
        wide = e.both(finite, e.compare("oge", size, LEAST_WIDE))
        count, rest = reduced(e, e.select(wide, size, literal(LEAST_WIDE)))
        rest = rest * e.pair(PI / 2)
        made = turned(e, count, cosine, e.apply("sin", rest), e.apply("cos", rest))
        if not cosine:
            made = e.choose(e.compare("olt", x, 0.0), -made, made)
        return e.choose(finite, made, e.pair(float("nan")))

    return define("wide_cos" if cosine else "wide_sin", "d", formula)


def wide_functions() -> tuple[str, ...]:
    """``@pair_wide_sin`` and ``@pair_wide_cos`` of a double of either sign, from ``LEAST_WIDE`` on."""
    return _wide(cosine=False), _wide(cosine=True)
