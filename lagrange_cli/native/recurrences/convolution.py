"""Code for the dot products of a group: a lane for each, so that nothing is ever summed across a vector.

Stages of any schedule take their sums from here, and store their coefficients as vectors for later ones.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TypeAlias

from lagrange_cli.native.llvm.function import Function
from lagrange_cli.native.llvm.text import ONE, Value, literal, operand
from lagrange_cli.native.llvm.vector import Integer, Pointer, Real
from lagrange_cli.native.numbers.double import Emitter
from lagrange_cli.native.recurrences.layout import FIRST, DotGroup
from lagrange_cli.native.recurrences.stage import Factors, Stage

Vectors: TypeAlias = "tuple[Real, Real]"
"""A vector of the first operands, and one of the second ones."""

CHAINS = 4
"""Sums that a dot product is made of, so that its additions need not wait for each other."""
TOGETHER = 8
"""Groups that are summed in one loop: their sums stay in registers."""


def packed(f: Function, group: DotGroup, values: Sequence[Value]) -> Real:
    """A vector of the group, a value for each of its dot products; the other lanes are not used."""
    return f.joined([Real(f, operand(one), 1) for one in values], group.width)


def store(f: Function, group: DotGroup, pair: Vectors, base: Pointer | str, m: int) -> None:
    """Keep vector m of both operands, counted from ``base``.

    (Volatile, so that it is stored as one: a vector of which halves are stored cannot be loaded until both
    have reached memory.)
    """
    for place, value in zip((group.first, group.second), pair):
        f.store_row(value, base, place + group.width * m, aligned=True, volatile=True)


def load(f: Function, group: DotGroup, base: Pointer | str, offset: int) -> Real:
    """A vector of the group from memory."""
    return f.load_row(base, offset, group.width, aligned=True)


def multiply_add(emitter: Emitter, group: DotGroup, a: Real, b: Real, total: Real | None) -> Real:
    """``a * b + total``, lane by lane."""
    emitter.body.operations += len(group.dots) * emitter.repeated
    return a * b if total is None else emitter.body.fused(a, b, total)


def sum_unrolled(
    emitter: Emitter, group: DotGroup, last: int, base: Pointer | str, n: int, recent: Mapping[int, Vectors]
) -> Real | None:
    """sum_{m=1}^{last} a[m] b[n-m] of vectors, ``n`` counted from ``base``; None for no terms.

    It begins with those in the middle, which have been known for longest. The ``recent`` ones, by their
    indices, need not be loaded.
    """
    totals: list[Real | None] = [None] * CHAINS
    for turn, m in enumerate(sorted(range(FIRST, last + 1), key=lambda m: max(m, last + FIRST - m))):
        a, b = recent.get(m, (None, None))[0], recent.get(n - m, (None, None))[1]
        a = a or load(emitter.body, group, "%work", group.first + group.width * m)
        b = b or load(emitter.body, group, base, group.second + group.width * (n - m))
        totals[turn % CHAINS] = multiply_add(emitter, group, a, b, totals[turn % CHAINS])
    some = [total for total in totals if total is not None]
    while len(some) > 1:
        some.append(some.pop(0) + some.pop(0))
    return some[0] if some else None


def sum_in_loop(emitter: Emitter, groups: Sequence[DotGroup], k: Integer, stages: range) -> list[Real]:
    """sum_{m=1}^{n-1} a[m] b[n-m] of vectors with n = ``k`` + level of each group, the newest at last.

    ``k`` is each of ``stages``.
    """
    f, lowest = emitter.body, min(group.level for group in groups)
    totals = [f.variable(f.zero(group.width)) for group in groups]
    emitter.repeated = sum(max(0, stage + lowest - FIRST - 2) for stage in stages)
    with f.loop(FIRST + 1, k + (lowest - FIRST)) as m:
        opposite = k - m
        widths = dict.fromkeys(group.width for group in groups)
        bases = {w: (moved(f, m, w), moved(f, opposite, w)) for w in widths}
        for group, total in zip(groups, totals):
            first, second = bases[group.width]
            a = load(f, group, first, group.first)
            b = load(f, group, second, group.second + group.width * group.level)
            total.set(multiply_add(emitter, group, a, b, total.get()))
    emitter.repeated = len(stages)
    sums = [total.get() for total in totals]
    for i, group in enumerate(groups):
        base = moved(f, k, group.width)
        for ahead in range(lowest - FIRST, group.level):  # m = k + ahead
            a = load(f, group, base, group.first + group.width * ahead)
            b = load(f, group, "%work", group.second + group.width * (group.level - ahead))
            sums[i] = multiply_add(emitter, group, a, b, sums[i])
        a = load(f, group, "%work", group.first + group.width * FIRST)
        b = load(f, group, base, group.second + group.width * (group.level - FIRST))
        sums[i] = multiply_add(emitter, group, a, b, sums[i])
    return sums


def moved(f: Function, index: Integer, width: int) -> Pointer:
    """``%work`` moved on by so many vectors."""
    return f.place("%work", index * width)


def take(emitter: Emitter, stage: Stage[str], group: DotGroup, total: Real | None) -> None:
    """``stage.sums`` from the vector sums of a group; to be added is what its vectors do not hold."""
    table = stage.expansion.table
    for lane, (dot, (first, second)) in enumerate(zip(group.dots, group.shifts)):
        start = None if total is None else emitter.body.lane(total, lane).name
        n = dot.level
        terms: Factors[str] = []
        for m in range(1, first + 1):
            a = table[dot.a].get(m)
            terms.append((emitter.mul(literal(m), a) if dot.weighted else a, stage.at(dot.b, n - m)))
        for m in range(1, second + 1):
            a = stage.at(dot.a, n - m)
            weight = stage.number(n - m) if dot.weighted else ONE
            terms.append((emitter.mul(weight, a), table[dot.b].get(m)))
        stage.sums[dot.index, dot.weighted] = start, terms


def vectors(emitter: Emitter, stage: Stage[str], group: DotGroup) -> Vectors:
    """Vectors k + level of the group."""
    first: list[Value] = []
    second: list[Value] = []
    for dot, shifts in zip(group.dots, group.shifts):
        a, b = (group.level + shift for shift in shifts)
        value = stage.at(dot.a, a)
        first.append(emitter.mul(stage.number(a), value) if dot.weighted else value)
        second.append(stage.at(dot.b, b))
    return packed(emitter.body, group, first), packed(emitter.body, group, second)
