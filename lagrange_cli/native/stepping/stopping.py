"""Vectors that friction acts along and that come to rest: where one is so short that it is nothing but
rounding beside the velocities that it is made of, it counts as 0; in systems that have many of them, beside
the fastest velocity. No step comes nearer."""

from __future__ import annotations

from collections.abc import Sequence
from functools import reduce

from lagrange_cli.native.guards import GuardRows
from lagrange_cli.native.llvm.flow import Variable
from lagrange_cli.native.llvm.function import Function
from lagrange_cli.native.llvm.text import table
from lagrange_cli.native.llvm.vector import Bit, Integer, Real
from lagrange_cli.native.state import StateLayout
from lagrange_cli.native.stepping.lengths import Lengths
from lagrange_cli.records import dataclass

AROUND = 16.0
"""Steps on rates may go to and fro about 0, with so many times their errors; then the vector stops."""


SOON, ASIDE = 2.0**-30, 2.0**-50
"""Steps on rates come no nearer to where a vector is 0 than this part of the time, if it passes 0 up to that
part of what it loses in all the time."""


@dataclass(frozen=True)
class Searched:
    """The guards, and where their arguments and modes are; whether series are interpolated."""

    rows: GuardRows
    lengths: Lengths
    layout: StateLayout
    interpolated: bool


def stopping(rows: GuardRows) -> list[int]:
    """The guards of such vectors."""
    return [j for j, one in enumerate(rows.guards) if one.alone]


def stopping_tables(rows: GuardRows) -> list[str]:
    """Their numbers."""
    listed = stopping(rows)
    return [table("stopping", listed)] if listed else []


def first_stopped(
    search: Searched, f: Function, part: float, earliest: Variable[Real], which: Variable[Integer]
) -> None:
    """Set the ``earliest`` time to 0 where one of them is at most this ``part`` of the fastest velocity, and
    becomes shorter."""
    rows, lengths, listed = search.rows, search.lengths, stopping(search.rows)
    if not listed:
        return
    part *= AROUND if search.interpolated else 1.0
    fastest = f.variable(f.zero(lengths.lanes))
    with lengths.velocities(f) as row:
        fastest.set(f.larger(fastest.get(), row.only_velocities(f.magnitude(row.at("%state")))))
    near, t = lengths.gather(f, "fmax", fastest.get()) * part, f.load("%state", search.layout.time)
    with f.loop(0, len(listed), tested=False) as i:
        k = f.load_integer("@stopping", i)
        slides = f.load("%state", k + rows.mode(search.layout)) > 0.0
        place = lengths.place(f, f.load_integer("@guard_rows", k))
        least = f.variable(near)
        if search.interpolated:  # beside what it loses in all the time, too: the others may be at rest
            change = f.constant(0.0)  # rates of values that are rounded are nothing
            for m in reversed(range(2, lengths.order)):
                change = f.fused(change, Real(f, "%h"), f.load(place, m * lengths.term) * float(m))
            least.set(f.larger(near, f.magnitude(change * t) * part))
        else:
            change = f.load(place, 2 * lengths.term)
        with f.when(slides & (f.load(place, lengths.term) <= least.get())), f.when(change <= 0.0):
            earliest.set(f.constant(0.0))
            which.set(k)


def stopped(search: Searched, f: Function, k: int, part: float) -> Bit:
    """Whether a vector is at most this ``part`` of the velocities that it is made of, or is about to be 0, and
    becomes shorter."""
    guard, lengths, layout = search.rows.guards[k], search.lengths, search.layout
    speeds = [f.magnitude(f.load("%state", layout.degrees + i)) for i in guard.pivots]
    rows = [lengths.place(f, f.count(guard.beside + i)) for i in range(guard.parts)]
    parts = [f.load(row, lengths.term) for row in rows]
    near = reduce(f.larger, map(f.magnitude, parts)) <= reduce(f.larger, speeds) * part
    row = lengths.place(f, f.count(guard.row))
    change = f.load(row, 2 * lengths.term)
    if search.interpolated:  # rates of values that are rounded are nothing: what is it where the step ends?
        near = near | soon(f, layout, parts, [f.load(row, 2 * lengths.term) * 2.0 for row in rows])
        change = f.constant(0.0)
        for m in reversed(range(2, lengths.order)):
            change = f.fused(change, Real(f, "%h"), f.load(row, m * lengths.term) * float(m))
    slides = f.load("%state", k + search.rows.mode(layout)) > 0.0
    return slides & (change <= 0.0) & near


def soon(f: Function, layout: StateLayout, parts: Sequence[Real], rates: Sequence[Real]) -> Bit:
    """Whether a vector with these ``parts`` passes 0 at once, with these ``rates``."""
    t, zero = f.magnitude(f.load("%state", layout.time)), f.constant(0.0)
    largest = reduce(f.larger, map(f.magnitude, rates))
    dot, square = zero, zero
    for one, rate in zip(parts, rates):
        dot, square = f.fused(one, rate, dot), f.fused(rate, rate, square)
    left = -dot / f.select(square > 0.0, square, f.constant(1.0))
    aside = reduce(f.larger, [f.magnitude(f.fused(rate, left, one)) for one, rate in zip(parts, rates)])
    return (dot < 0.0) & (left <= t * SOON) & (aside <= largest * t * ASIDE)
