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
from lagrange_cli.native.llvm.vector import Index, Integer, Pointer, Real
from lagrange_cli.native.numbers.lanes import VECTOR
from lagrange_cli.records import dataclass

CHAINS = 4
"""Sums that a dot product is made of, so that its additions need not wait for each other."""
AHEAD = 4
"""Orders of which dot products are begun together."""


@dataclass(frozen=True, eq=False)
class Coefficients:
    """Those of a series, each ``step`` vectors behind the one before."""

    place: Pointer
    step: int = 1


Pair: TypeAlias = "tuple[Coefficients, Coefficients]"
Near: TypeAlias = "Callable[[int], Real]"
"""The coefficient so many orders behind a place."""


def near(f: Function, series: Coefficients, m: Index) -> Near:
    """The vectors of a series around the ``m``-th one. (The place is computed once: what is added to it is a
    part of the instruction that loads.)"""
    here = f.place(series.place, m * (LANES * series.step), "double")

    def at(behind: int) -> Real:
        place = f.place(here, behind * LANES * series.step, "double") if behind else here
        return Real(f, f.define(f"load {VECTOR}, ptr {place.name}, align {8 * LANES}"), LANES)

    return at


def coefficient(f: Function, series: Coefficients, m: Index) -> Real:
    """The ``m``-th vector of a series."""
    return near(f, series, m)(0)


def dots(f: Function, pairs: Sequence[Pair], n: Index, *, same: bool, weighted: bool) -> list[list[str]]:
    """The dot products of pairs of series, of one with itself where they are the ``same``, in one loop; and
    the ``weighted`` ones, where these are asked for."""
    found = square_dots(f, pairs, n) if same else chained(f, pairs, n, n, weighted=weighted)
    return [[one.name for one in each] for each in found]


def square_dots(f: Function, pairs: Sequence[Pair], n: Index) -> list[list[Real]]:
    """Those of series with themselves, from half of the terms."""
    middle = (n + 1) // 2 if isinstance(n, int) else (n + 1).operation("lshr", 1)
    halves = [half for (half,) in chained(f, pairs, n, middle)]

    def squared(a: Coefficients, total: Real) -> Real:
        one = coefficient(f, a, middle)
        return f.fused(one, one, total)

    if isinstance(n, int):
        return [[half + half if n % 2 else squared(a, half + half)] for (a, _), half in zip(pairs, halves)]
    totals = [f.variable(half + half) for half in halves]
    with f.when(~n.odd()):
        for (a, _), total in zip(pairs, totals):
            total.set(squared(a, total.get()))
    return [[total.get()] for total in totals]


def begin_dots(
    f: Function, a: Coefficients, b: Coefficients, n: Integer, rest: Sequence[tuple[int, int]], out: Pointer
) -> None:
    """out[r] = sum_m a[m] b[n+r-m], ``AHEAD`` of them, but for the ``rest`` of m = 1 .. n+r-1: so many of the
    first terms and of the last ones. Coefficients are loaded once for several orders."""
    first = max(before for before, _ in rest) + 1
    ends = [r - 1 - behind for r, (_, behind) in enumerate(rest)]
    last = n + min(ends)
    m, sums = f.variable(f.count(first)), [f.variable(f.zero(LANES)) for _ in range(AHEAD)]
    begin = near(f, b, n - first)
    window = [f.variable(begin(r)) for r in range(1, AHEAD)]

    def add(steps: int) -> None:
        """So many terms of each sum."""
        values = [one.get() for one in window]
        ones, others = near(f, a, m.get()), near(f, b, n - m.get())
        for i in range(steps):
            one, values = ones(i), [others(-i), *values]
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
    (low, high), (low_other, high_other) = ([near(f, one, 0), near(f, one, n)] for one in (a, b))
    for r, (total, (before, _), end) in enumerate(zip(sums, rest, ends)):
        value = total.get()
        for i in range(before + 1, first):
            value = f.fused(low(i), high_other(r - i), value)
        for i in range(min(ends) + 1, end + 1):
            value = f.fused(high(i), low_other(r - i), value)
        f.store_row(value, out, r * LANES, aligned=True)


def chained(
    f: Function, pairs: Sequence[Pair], n: Index, last: Index, *, weighted: bool = False
) -> list[list[Real]]:
    """sum a[m] b[n - m], m = 1, 2, .. below ``last``, of each pair, and that of m a[m] b[n - m], if also
    ``weighted``; each in several chains."""
    zero, count, several = f.zero(LANES), 1 + weighted, max(CHAINS // len(pairs), 1)
    chains: list[list[list[Variable[Real]]]] = [
        [[f.variable(zero) for _ in range(count)] for _ in range(several)] for _ in pairs
    ]

    def add(m: Index, rest: Index, steps: int, chain: Callable[[int], int]) -> None:
        """So many terms from a[m] b[rest] on."""
        ones = {a: near(f, a, m) for a, _ in pairs}
        others = {b: near(f, b, rest) for _, b in pairs}
        for i in range(steps):
            for (a, b), mine in zip(pairs, chains):
                one, other, (total, *more) = ones[a](i), others[b](-i), mine[chain(i) % several]
                total.set(f.fused(one, other, total.get()))
                for further in more:
                    number = f.constant(float(m + i)) if isinstance(m, int) else (m + i if i else m).to_real()
                    further.set(f.fused(f.splat(number, LANES) * one, other, further.get()))

    if isinstance(n, int) or isinstance(last, int):
        assert isinstance(n, int) and isinstance(last, int)
        together = max(0, last - 1) // CHAINS * CHAINS
        add(1, n - 1, last - 1, lambda i: i % CHAINS if i < together else 0)
        return [added(each) for each in chains]
    at = f.variable(f.count(1))
    with f.forever() as rounds:
        with f.when(at.get() + CHAINS > last):
            rounds.leave()
        add(at.get(), n - at.get(), CHAINS, lambda i: i)
        at.set(at.get() + CHAINS)
    with f.forever() as rounds:
        with f.when(at.get() >= last):
            rounds.leave()
        add(at.get(), n - at.get(), 1, lambda i: 0)
        at.set(at.get() + 1)
    return [added(each) for each in chains]


def added(chains: Sequence[Sequence[Variable[Real]]]) -> list[Real]:
    """The sums of chains, in pairs."""
    found = []
    for part in zip(*chains):
        values = [total.get() for total in part]
        while len(values) > 1:
            values = [a + b for a, b in zip(values[::2], values[1::2])]
        found.append(values[0])
    return found
