"""Sums of powers of a step: the state at its end and within it, and the accelerations at its end; and
polynomials in memory."""

from __future__ import annotations

from collections.abc import Sequence

from lagrange_cli.native.llvm.function import Function
from lagrange_cli.native.llvm.vector import Pointer, Real
from lagrange_cli.native.numbers.error_free import two_sum
from lagrange_cli.native.state import LANES

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


def powers_of(f: Function, s: Real) -> tuple[Real, Real]:
    """The powers s^0 to s^7 in a vector, and s^8. (``s`` is finite.)"""
    found, lanes, one = f.vector([1.0] * LANES), range(LANES), s
    for bit in (1, 2, 4):
        there = [float(bool(lane & bit)) for lane in lanes]
        found = found * f.fused(f.splat(one, LANES), f.vector(there), f.vector([1.0 - x for x in there]))
        one = one * one
    return found, one


def added(f: Function, vector: Real) -> Real:
    """The sum of the lanes of a vector of ``LANES``, added in pairs."""
    lanes = LANES // 2
    while lanes > 1:
        vector = f.shuffle(vector, range(lanes)) + f.shuffle(vector, range(lanes, 2 * lanes))
        lanes //= 2
    return f.lane(vector, 0) + f.lane(vector, 1)


def bernstein(degree: int) -> Function:
    """``@bernstein(p, b, a, w)``: the coefficients ``b`` of a polynomial ``p`` on [a, a + w]: how often they
    change their sign, and the smallest one. (``@inverse_binomials`` is a table.)"""
    given = "ptr noalias %p, ptr noalias %b, double %a, double %w"
    f = Function(f"define internal {{ i64, double }} @bernstein({given}) #0")
    a, w = f.reals("a", "w")
    f.copy_rows(("%p", 0), ("%b", 0), degree + 1, 1)
    with f.when(~a.equals(0.0)):
        shifted(f, "%b", 0, degree, a)
    power = f.variable(f.constant(1.0))
    with f.loop(0, degree + 1, tested=False) as m:
        f.store(f.load("%b", m) * power.get() * f.load("@inverse_binomials", m), "%b", m)
        power.set(power.get() * w)
    added_up(f, "%b", 0, degree)
    least, changes = f.variable(f.load("%b")), f.variable(f.count(0))
    before = f.variable(f.load("%b") < 0.0)
    with f.loop(1, degree + 1, tested=False) as m:
        one = f.load("%b", m)
        negative = one < 0.0
        changes.set(changes.get() + negative.compared("ne", before.get()).to_integer())
        before.set(negative)
        least.set(f.smaller(one, least.get()))
    f.give(changes.get(), least.get())
    return f


def shifted(f: Function, base: Pointer | str, first: int, n: int, a: Real) -> None:
    """Put p(a + x) in place of p(x), of degree n, whose coefficients are at ``base[first]`` and behind it."""
    with f.loop(0, n, tested=False) as k, f.loop(0, f.count(n) - k, tested=False) as j:
        i = f.count(n - 1 + first) - j
        f.store(f.fused(f.load(base, i + 1), a, f.load(base, i)), base, i)


def added_up(f: Function, base: Pointer | str, first: int, n: int) -> None:
    """The same in Bernstein's form, from its coefficients divided by binomial ones."""
    with f.loop(0, n, tested=False) as k, f.loop(0, f.count(n) - k, tested=False) as j:
        i = f.count(n + first) - j
        f.store(f.load(base, i) + f.load(base, i - 1), base, i)
