"""Sums of powers of a step: the state at its end and within it, and the accelerations at its end."""

from __future__ import annotations

from collections.abc import Sequence

from lagrange_cli.native.llvm.function import Function
from lagrange_cli.native.llvm.vector import Real
from lagrange_cli.native.numbers.error_free import two_sum

CAREFUL = 4
"""Terms of the series that are summed with twice the precision."""


def polynomial(f: Function, c: Sequence[Real], h: Real, chains: int = 1) -> Real:
    """sum_j c[j] h^j by Horner's rule, in so many ``chains`` (1, 2 or 4) that are worked on side by side."""
    powers = {1: h}
    while max(powers) < chains:
        powers[2 * max(powers)] = powers[max(powers)] * powers[max(powers)]
    sums = []
    for start in range(min(chains, len(c))):
        *lower, total = c[start::chains]
        for one in reversed(lower):
            total = f.fused(total, powers[chains], one)
        sums.append(total)
    n = 1
    while len(sums) > 1:
        pairs = [sums[i : i + 2] for i in range(0, len(sums), 2)]
        sums = [f.fused(pair[1], powers[n], pair[0]) if len(pair) > 1 else pair[0] for pair in pairs]
        n *= 2
    return sums[0]


def powers(x: Real, count: int) -> list[Real]:
    """x, x^2, .., x^count"""
    found = [x]
    for _ in range(1, count):
        found.append(found[-1] * x)
    return found


def weighed(f: Function, values: Sequence[Real], weights: Sequence[float]) -> Real:
    """The sum of each value times its weight."""
    total = values[0] * weights[0]
    for value, weight in zip(values[1:], weights[1:]):
        total = f.fused(value, weight, total)
    return total


def rate(f: Function, c: Sequence[Real], h: Real, chains: int = 1) -> Real:
    """The derivative of sum_m c[m - 1] h^m."""
    return polynomial(f, [one * float(m) for m, one in enumerate(c, 1)], h, chains)


def careful_sum(f: Function, c: Sequence[Real], h: Real, chains: int = 1) -> tuple[Real, Real]:
    """sum_m c[m - 1] h^m as a sum of two, the first terms free of rounding.

    (Compensated Horner scheme: Graillat, Langlois and Louvet 2005. It is what keeps the error of a step below
    that of its coefficients.) The other terms, whose last ones are known last, do not hold it up: they go
    into the rest.
    """
    total, rest = c[CAREFUL - 1], f.splat(f.constant(0.0), h.lanes)
    for m in range(CAREFUL - 1, -1, -1):
        product = total * h
        rest = f.fma(rest, h, f.fma(total, h, -product))
        total = product
        if m:
            total, error = two_sum(c[m - 1], product)
            rest = rest + error
    if len(c) == CAREFUL:
        return total, rest
    square = h * h
    return total, f.fused(polynomial(f, c[CAREFUL:], h, chains), square * square * h, rest)
