"""Convolutions of series in batches, as functions of vectors: they are given the places of coefficients."""

from __future__ import annotations

from collections.abc import Callable

from lagrange_cli.native.interface import LANES
from lagrange_cli.native.llvm.flow import Variable
from lagrange_cli.native.llvm.function import Function
from lagrange_cli.native.llvm.vector import Integer, Real
from lagrange_cli.native.numbers.lanes import VECTOR

CHAINS = 4
"""Sums that a dot product is made of, so that its additions need not wait for each other."""
AHEAD = 4
"""Orders of which dot products are begun together."""


def dot_products() -> list[str]:
    """The text of all of them."""
    return [dot_product(), square_dot(), power_dots(), dot_products_ahead()]


def dot_product() -> str:
    """``@dot(a, b, n)``: sum_{m=1}^{n-1} a[m] b[n-m] of vectors."""
    f = Function(f"define internal {VECTOR} @dot(ptr %a, ptr %b, i64 %n) #0", LANES)
    n = Integer(f, "%n", 1)
    sums = chained(f, n, lambda m: [(f.load("%a", m), f.load("%b", n - m))])
    f.give(sums[0])
    return f.text()


def square_dot() -> str:
    """``@square_dot(a, n)``: that of a series with itself, from half of the terms."""
    f = Function(f"define internal {VECTOR} @square_dot(ptr %a, i64 %n) #0", LANES)
    n = Integer(f, "%n", 1)
    middle = (n + 1).operation("lshr", 1)
    half, _ = chained(f, middle, lambda m: [(f.load("%a", m), f.load("%a", n - m))])
    total = f.variable(half + half)
    with f.when(~n.odd()):
        one = f.load("%a", middle)
        total.set(f.fused(one, one, total.get()))
    f.give(total.get())
    return f.text()


def power_dots() -> str:
    """``@power_dots(a, b, n)``: sum_{m=1}^{n-1} a[m] b[n-m], and that of m a[m] b[n-m]."""
    both = f"{{ {VECTOR}, {VECTOR} }}"
    f = Function(f"define internal {both} @power_dots(ptr %a, ptr %b, i64 %n) #0", LANES)
    n = Integer(f, "%n", 1)

    def terms(m: Integer) -> list[tuple[Real, Real]]:
        a, b = f.load("%a", m), f.load("%b", n - m)
        return [(a, b), (f.splat(m.to_real(), LANES) * a, b)]

    f.give(*chained(f, n, terms))
    return f.text()


def dot_products_ahead() -> str:
    """``@dots(a, b, first, last, n, out)``: out[r] = sum_{m=first}^{last} a[m] b[n+r-m], ``AHEAD`` of them:
    coefficients are loaded once for several orders."""
    given = "ptr %a, ptr %b, i64 %first, i64 %last, i64 %n, ptr %out"
    f = Function(f"define internal void @dots({given}) #0", LANES)
    first, last, n = (Integer(f, f"%{name}", 1) for name in ("first", "last", "n"))
    m, sums = f.variable(first), [f.variable(f.zero(LANES)) for _ in range(AHEAD)]
    window = [f.variable(f.load("%b", n - first + r)) for r in range(1, AHEAD)]

    def add(steps: int) -> None:
        """So many terms of each sum."""
        values = [one.get() for one in window]
        for i in range(steps):
            here = m.get() + i if i else m.get()
            a, values = f.load("%a", here), [f.load("%b", n - here), *values]
            for total, b in zip(sums, values):
                total.set(f.fused(a, b, total.get()))
            values.pop()
        for one, value in zip(window, values):
            one.set(value)
        m.set(m.get() + steps)

    with f.forever() as rounds:
        with f.when(m.get() + (AHEAD - 1) > last):
            rounds.leave()
        add(AHEAD)
    with f.forever() as rounds:
        with f.when(m.get() > last):
            rounds.leave()
        add(1)
    for r, total in enumerate(sums):
        f.store(total.get(), "%out", r)
    f.give()
    return f.text()


def chained(f: Function, last: Integer, terms: Callable[[Integer], list[tuple[Real, Real]]]) -> list[Real]:
    """The sums of products ``terms(m)`` for m = 1, 2, .. below ``last``, each in several chains."""
    m, zero = f.variable(f.count(1)), f.zero(LANES)

    def add(m: Integer, sums: list[Variable[Real]]) -> None:
        for total, (a, b) in zip(sums, terms(m)):
            total.set(f.fused(a, b, total.get()))

    chains = [[f.variable(zero), f.variable(zero)] for _ in range(CHAINS)]
    with f.forever() as rounds:
        with f.when(m.get() + CHAINS > last):
            rounds.leave()
        for i, sums in enumerate(chains):
            add(m.get() + i if i else m.get(), sums)
        m.set(m.get() + CHAINS)
    with f.forever() as rounds:
        with f.when(m.get() >= last):
            rounds.leave()
        add(m.get(), chains[0])
        m.set(m.get() + 1)
    found = []
    for part in zip(*chains):
        values = [total.get() for total in part]
        while len(values) > 1:
            values = [a + b for a, b in zip(values[::2], values[1::2])]
        found.append(values[0])
    return found
