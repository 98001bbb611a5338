"""Code for the dot products of a group: a lane for each, so that nothing is ever summed across a vector.

Stages of any schedule take their sums from here, and store their coefficients as vectors for later ones.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TypeAlias

from lagrange_cli.native.llvm.function import Function
from lagrange_cli.native.llvm.text import ONE, Operand, Value, literal, operand
from lagrange_cli.native.llvm.vector import Integer, Real
from lagrange_cli.native.numbers.double import Emitter
from lagrange_cli.native.recurrences.layout import FIRST, Group
from lagrange_cli.native.recurrences.stage import Factors, Stage

Vectors: TypeAlias = "tuple[Operand, Operand]"
"""A vector of the first operands, and one of the second ones."""

CHAINS = 4
"""Sums that a dot product is made of, so that its additions need not wait for each other."""
TOGETHER = 8
"""Groups that are summed in one loop: their sums stay in registers."""


def vector(group: Group) -> str:
    """The type of the group's vectors."""
    return f"<{group.width} x double>"


def packed(emitter: Emitter, group: Group, values: Sequence[Value]) -> Operand:
    """A vector of the group, a value for each of its dot products; the other lanes are not used."""
    whole = "poison"
    for lane, value in enumerate(values):
        whole = emitter.define(f"insertelement {vector(group)} {whole}, double {operand(value)}, i64 {lane}")
    return whole


def store(emitter: Emitter, group: Group, pair: Vectors, base: str, m: int) -> None:
    """Keep vector m of both operands, counted from ``base``.

    (Volatile, so that it is stored as one: a vector of which halves are stored cannot be loaded until both
    have reached memory.)
    """
    for place, value in zip((group.first, group.second), pair):
        address = emitter.define(f"getelementptr inbounds double, ptr {base}, i64 {place + group.width * m}")
        emitter.line(f"  store volatile {vector(group)} {value}, ptr {address}, align {8 * group.width}")


def load(emitter: Emitter, group: Group, base: str, offset: int) -> Operand:
    """A vector of the group from memory."""
    address = emitter.define(f"getelementptr inbounds double, ptr {base}, i64 {offset}")
    return emitter.define(f"load {vector(group)}, ptr {address}, align {8 * group.width}")


def multiply_add(emitter: Emitter, group: Group, a: Operand, b: Operand, total: Operand | None) -> Operand:
    """``a * b + total``, lane by lane."""
    emitter.body.operations += len(group.dots) * emitter.repeated
    kind = vector(group)
    if total is None:
        return emitter.define(f"fmul {kind} {a}, {b}")
    return emitter.define(
        f"call {kind} @llvm.fmuladd.v{group.width}f64({kind} {a}, {kind} {b}, {kind} {total})"
    )


def sum_unrolled(
    emitter: Emitter, group: Group, last: int, base: str, n: int, recent: Mapping[int, Vectors]
) -> Operand | None:
    """sum_{m=1}^{last} a[m] b[n-m] of vectors, ``n`` counted from ``base``; None for no terms.

    It begins with those in the middle, which have been known for longest. The ``recent`` ones, by their
    indices, need not be loaded.
    """
    totals: list[Operand | None] = [None] * CHAINS
    for turn, m in enumerate(sorted(range(FIRST, last + 1), key=lambda m: max(m, last + FIRST - m))):
        a, b = recent.get(m, (None, None))[0], recent.get(n - m, (None, None))[1]
        a = a or load(emitter, group, "%work", group.first + group.width * m)
        b = b or load(emitter, group, base, group.second + group.width * (n - m))
        totals[turn % CHAINS] = multiply_add(emitter, group, a, b, totals[turn % CHAINS])
    some = [total for total in totals if total is not None]
    while len(some) > 1:
        some.append(emitter.define(f"fadd {vector(group)} {some.pop(0)}, {some.pop(0)}"))
    return some[0] if some else None


def sum_in_loop(
    f: Function, emitter: Emitter, groups: Sequence[Group], k: Integer, stages: range
) -> list[Operand]:
    """sum_{m=1}^{n-1} a[m] b[n-m] of vectors with n = ``k`` + level of each group, the newest at last.

    ``k`` is each of ``stages``.
    """
    lowest = min(group.level for group in groups)
    totals = [f.variable(f.zero(group.width)) for group in groups]
    emitter.repeated = sum(max(0, stage + lowest - FIRST - 2) for stage in stages)
    with f.loop(FIRST + 1, k + (lowest - FIRST)) as m:
        opposite = k - m
        widths = dict.fromkeys(group.width for group in groups)
        bases = {w: (moved(emitter, m.name, w), moved(emitter, opposite.name, w)) for w in widths}
        for group, total in zip(groups, totals):
            first, second = bases[group.width]
            a = load(emitter, group, first, group.first)
            b = load(emitter, group, second, group.second + group.width * group.level)
            added = multiply_add(emitter, group, a, b, total.get().name)
            total.set(Real(f, added, group.width))
    emitter.repeated = len(stages)
    sums = [total.get().name for total in totals]
    for i, group in enumerate(groups):
        base = moved(emitter, k.name, group.width)
        for ahead in range(lowest - FIRST, group.level):  # m = k + ahead
            a = load(emitter, group, base, group.first + group.width * ahead)
            b = load(emitter, group, "%work", group.second + group.width * (group.level - ahead))
            sums[i] = multiply_add(emitter, group, a, b, sums[i])
        a = load(emitter, group, "%work", group.first + group.width * FIRST)
        b = load(emitter, group, base, group.second + group.width * (group.level - FIRST))
        sums[i] = multiply_add(emitter, group, a, b, sums[i])
    return sums


def moved(emitter: Emitter, index: str, width: int) -> Operand:
    """``%work`` moved on by so many vectors."""
    doubles = emitter.define(f"mul i64 {index}, {width}")
    return emitter.define(f"getelementptr inbounds double, ptr %work, i64 {doubles}")


def take(emitter: Emitter, stage: Stage[str], group: Group, total: Operand | None) -> None:
    """``stage.sums`` from the vector sums of a group; to be added is what its vectors do not hold."""
    table = stage.expansion.table
    for lane, (dot, (first, second)) in enumerate(zip(group.dots, group.shifts)):
        start = total and emitter.define(f"extractelement {vector(group)} {total}, i64 {lane}")
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


def vectors(emitter: Emitter, stage: Stage[str], group: Group) -> Vectors:
    """Vectors k + level of the group."""
    first: list[Value] = []
    second: list[Value] = []
    for dot, shifts in zip(group.dots, group.shifts):
        a, b = (group.level + shift for shift in shifts)
        value = stage.at(dot.a, a)
        first.append(emitter.mul(stage.number(a), value) if dot.weighted else value)
        second.append(stage.at(dot.b, b))
    return packed(emitter, group, first), packed(emitter, group, second)
