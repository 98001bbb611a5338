"""Convolutions of series of eight members at a time: their coefficients are vectors.

They stand where they are needed. In a call, the caller's vectors would have to wait in memory: no register
of eight doubles outlasts it (a lattice of 30 x 30 pendulums: a third of the time).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TypeAlias

from lagrange_cli.native.interface import LANES
from lagrange_cli.native.llvm.flow import Variable
from lagrange_cli.native.llvm.function import Function
from lagrange_cli.native.llvm.vector import Integer, Pointer, Real
from lagrange_cli.native.numbers.lanes import VECTOR
from lagrange_cli.records import dataclass

CHAINS = 4
"""Sums that a dot product is made of, so that its additions need not wait for each other."""
AHEAD = 4
"""Orders of which dot products are begun together."""
Products: TypeAlias = "Sequence[tuple[Real, Real]]"


@dataclass(frozen=True)
class Coefficients:
    """Those of a series, each ``step`` vectors behind the one before."""

    place: Pointer
    step: int = 1


def coefficient(f: Function, series: Coefficients, m: Integer | int) -> Real:
    """The ``m``-th vector of a series."""
    place = f.place(series.place, m if series.step == 1 else m * series.step, VECTOR)
    return Real(f, f.define(f"load {VECTOR}, ptr {place.name}, align {8 * LANES}"), LANES)


def dots(
    f: Function, a: Coefficients, b: Coefficients, n: Integer | int, *, same: bool, weighted: bool
) -> list[str]:
    """The dot product of two series, of one with itself where they are the ``same``; and the ``weighted``
    one, where that is asked for."""
    if same:
        return [square_dot(f, a, n).name]
    if weighted:
        return [one.name for one in power_dots(f, a, b, n)]
    return [dot(f, a, b, n).name]


def dot(f: Function, a: Coefficients, b: Coefficients, n: Integer | int) -> Real:
    """sum_{m=1}^{n-1} a[m] b[n-m]."""
    return chained(f, n, n, lambda m, rest: [(coefficient(f, a, m), coefficient(f, b, rest))])[0]


def square_dot(f: Function, a: Coefficients, n: Integer | int) -> Real:
    """That of a series with itself, from half of the terms."""
    middle = (n + 1) // 2 if isinstance(n, int) else (n + 1).operation("lshr", 1)
    half = chained(f, n, middle, lambda m, rest: [(coefficient(f, a, m), coefficient(f, a, rest))])[0]
    if isinstance(n, int):
        one = coefficient(f, a, middle)
        return half + half if n % 2 else f.fused(one, one, half + half)
    total = f.variable(half + half)
    with f.when(~n.odd()):
        one = coefficient(f, a, middle)
        total.set(f.fused(one, one, total.get()))
    return total.get()


def power_dots(f: Function, a: Coefficients, b: Coefficients, n: Integer | int) -> list[Real]:
    """sum_{m=1}^{n-1} a[m] b[n-m], and that of m a[m] b[n-m]."""

    def products(m: Integer | int, rest: Integer | int) -> Products:
        one, other = coefficient(f, a, m), coefficient(f, b, rest)
        number = f.constant(float(m)) if isinstance(m, int) else m.to_real()
        return [(one, other), (f.splat(number, LANES) * one, other)]

    return chained(f, n, n, products)


def begin_dots(
    f: Function, a: Coefficients, b: Coefficients, n: Integer, rest: Sequence[tuple[int, int]], out: Pointer
) -> None:
    """out[r] = sum_m a[m] b[n+r-m], ``AHEAD`` of them, but for the ``rest`` of m = 1 .. n+r-1: so many of the
    first terms and of the last ones. Coefficients are loaded once for several orders."""
    first = max(before for before, _ in rest) + 1
    ends = [r - 1 - behind for r, (_, behind) in enumerate(rest)]
    last = n + min(ends)
    m, sums = f.variable(f.count(first)), [f.variable(f.zero(LANES)) for _ in range(AHEAD)]
    window = [f.variable(coefficient(f, b, n - first + r)) for r in range(1, AHEAD)]

    def add(steps: int) -> None:
        """So many terms of each sum."""
        values = [one.get() for one in window]
        for i in range(steps):
            here = m.get() + i if i else m.get()
            one, values = coefficient(f, a, here), [coefficient(f, b, n - here), *values]
            for total, other in zip(sums, values):
                total.set(f.fused(one, other, total.get()))
            values.pop()
        for variable, value in zip(window, values):
            variable.set(value)
        m.set(m.get() + steps)

    with f.forever() as rounds:
        with f.when(m.get() + (AHEAD - 1) > last):
            rounds.leave()
        add(AHEAD)
    with f.forever() as rounds:
        with f.when(m.get() > last):
            rounds.leave()
        add(1)
    for r, (total, (before, _), end) in enumerate(zip(sums, rest, ends)):
        value = total.get()
        for i in range(before + 1, first):
            value = f.fused(coefficient(f, a, i), coefficient(f, b, n + (r - i)), value)
        for i in range(min(ends) + 1, end + 1):
            value = f.fused(coefficient(f, a, n + i), coefficient(f, b, r - i), value)
        f.store_row(value, out, r * LANES, aligned=True)


def chained(
    f: Function,
    n: Integer | int,
    last: Integer | int,
    products: Callable[[Integer | int, Integer | int], Products],
) -> list[Real]:
    """The sums of ``products(m, n - m)`` for m = 1, 2, .. below ``last``, each in several chains."""
    zero = f.zero(LANES)
    chains: list[list[Variable[Real]]] = [[f.variable(zero), f.variable(zero)] for _ in range(CHAINS)]

    def add(factors: Products, sums: list[Variable[Real]]) -> None:
        for total, (a, b) in zip(sums, factors):
            total.set(f.fused(a, b, total.get()))

    if isinstance(n, int) or isinstance(last, int):
        assert isinstance(n, int) and isinstance(last, int)
        together = max(0, last - 1) // CHAINS * CHAINS
        for m in range(1, last):
            add(products(m, n - m), chains[(m - 1) % CHAINS if m <= together else 0])
        return added(chains)
    at = f.variable(f.count(1))
    with f.forever() as rounds:
        with f.when(at.get() + CHAINS > last):
            rounds.leave()
        for i, sums in enumerate(chains):
            here = at.get() + i if i else at.get()
            add(products(here, n - here), sums)
        at.set(at.get() + CHAINS)
    with f.forever() as rounds:
        with f.when(at.get() >= last):
            rounds.leave()
        add(products(at.get(), n - at.get()), chains[0])
        at.set(at.get() + 1)
    return added(chains)


def added(chains: Sequence[Sequence[Variable[Real]]]) -> list[Real]:
    """The sums of chains, in pairs."""
    found = []
    for part in zip(*chains):
        values = [total.get() for total in part]
        while len(values) > 1:
            values = [a + b for a, b in zip(values[::2], values[1::2])]
        found.append(values[0])
    return found
