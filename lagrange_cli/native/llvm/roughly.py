"""Logarithms and powers of 2 to a few digits, from the bits of numbers: the same on every machine."""

from __future__ import annotations

from lagrange_cli.native.llvm.text import kind, literal, operand
from lagrange_cli.native.llvm.vector import Integer, Real, cast


def upper_half(x: Real) -> Real:
    """The upper half of its bits as a number: for x > 0, 2^20 (1023 + log2 x) to 0.09 * 2^20."""
    body, short = x.body, kind("i32", x.lanes)
    upper = x.bits().operation("lshr", 32)
    halved = body.define(f"trunc {upper.kind} {upper.name} to {short}")
    return Real(body, body.define(f"sitofp {short} {halved} to {x.kind}"), x.lanes)


def log2_roughly(x: Real) -> Real:
    """log2 of a positive number to 0.09; for 0 some -1023."""
    return x.body.fma(upper_half(x), 2.0**-20, -1023.0)


def exp2_roughly(x: Real) -> Real:
    """2^x to 0.3 percent, for |x| <= 1000; beyond, as at the limit."""
    body = x.body
    low, high = (body.splat(Real(body, operand(literal(bound)), 1), x.lanes) for bound in (-1000.0, 1000.0))
    bounded = body.smaller(body.larger(x, low), high)
    floor = body.function("floor", bounded)
    f = bounded - floor
    p = body.fma(f, body.fma(f, 0.3301, 0.6645), 1.0)
    return p * ((cast(floor, "fptosi", Integer) + 1023) << 52).number()
