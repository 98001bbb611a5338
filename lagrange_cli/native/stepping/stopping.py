"""Vectors that friction acts along and that come to rest: where one is so short that it is nothing but
rounding beside the velocities that it is made of, or in systems that have many of them, beside the fastest
velocity, it counts as 0. No step comes nearer.

Steps on rates end before. A vector u that they lead to 0, or past it so closely that their errors are larger,
is taken on to there if the way is so short that rates hardly change on it.
"""

from __future__ import annotations

import math
from functools import reduce

from lagrange_cli.native.guards import GuardRows
from lagrange_cli.native.llvm.flow import Variable
from lagrange_cli.native.llvm.function import Function
from lagrange_cli.native.llvm.text import table
from lagrange_cli.native.llvm.vector import Bit, Integer, Real
from lagrange_cli.native.state import StateLayout
from lagrange_cli.native.stepping.lengths import Lengths
from lagrange_cli.records import dataclass

WAY, LOOSER = 2.0**-24, 2.0**-6
"""How long it is at most, as part of the longest step: so much, or this part of the root of the tolerance.
The error of u is its square."""
ASIDE, ALLOWED = 2.0**-48, 0.25
"""How far u may be from 0 there, as part of the velocities that it is made of, or of what it loses in the
longest step: so much, or this part of the tolerance."""
RESOLVED = 2.0**-46
"""Both may be this part of the time, and of what u loses in it: nothing shorter is resolved."""
SHRINKS = 0.5
"""In this step u becomes shorter by this factor: rates of what hardly changes are rounding errors."""
NUMBERS = 4
"""Numbers of each vector in the table of steps on rates."""


@dataclass(frozen=True)
class Searched:
    """The guards, and where their arguments and modes are; up to which part of velocities a vector counts
    as 0."""

    rows: GuardRows
    lengths: Lengths
    layout: StateLayout
    part: float


def sliding(rows: GuardRows) -> list[int]:
    """The guards of vectors that friction acts along."""
    return [j for j in rows.vectors if rows.guards[j].multiplier]


def stopping_tables(rows: GuardRows, *, interpolated: bool) -> list[str]:
    """The numbers of those that are alone; or of all, for steps on rates, with their first parts, the number
    of these, and the coordinates that belong to them."""
    listed = sliding(rows)
    if not interpolated:
        alone = [j for j in listed if rows.guards[j].alone]
        return [table("stopping", alone)] if alone else []
    numbers, pivots = list[int](), list[int]()
    for j in listed:
        guard = rows.guards[j]
        numbers += [j, guard.beside, guard.parts, len(pivots)]
        pivots += guard.pivots
    every = [int(j in listed) for j in range(rows.count)]
    tables = ("stopping", numbers), ("stopping_pivots", pivots), ("guard_vectors", every)
    return [table(*one) for one in tables] if listed else []


def first_stopped(search: Searched, f: Function, earliest: Variable[Real], which: Variable[Integer]) -> None:
    """Set the ``earliest`` time to 0 where one of them is 0 but for rounding, and becomes shorter."""
    rows, lengths, listed = search.rows, search.lengths, sliding(search.rows)
    alone = [j for j in listed if rows.guards[j].alone]
    for j in listed:
        if j not in alone:
            with f.when(_stopped(search, f, j)):
                earliest.set(f.constant(0.0))
                which.set(f.count(j))
    if not alone:
        return
    fastest = f.variable(f.zero(lengths.lanes))
    with lengths.velocities(f) as row:
        fastest.set(f.larger(fastest.get(), row.only_velocities(f.magnitude(row.at("%state")))))
    near = lengths.gather(f, "fmax", fastest.get()) * search.part
    with f.loop(0, len(alone), tested=False) as i:
        k = f.load_integer("@stopping", i)
        slides = f.load("%state", k + rows.mode(search.layout)) > 0.0
        place = lengths.place(f, f.load_integer("@guard_rows", k))
        size, change = (f.load(place, m * lengths.term) for m in (1, 2))
        with f.when(slides & (size <= near) & (change <= 0.0)):
            earliest.set(f.constant(0.0))
            which.set(k)


def _stopped(search: Searched, f: Function, k: int) -> Bit:
    """Whether a vector is 0 beside the velocities that it is made of, and becomes shorter."""
    guard, lengths, layout = search.rows.guards[k], search.lengths, search.layout
    speeds = [f.magnitude(f.load("%state", layout.degrees + i)) for i in guard.pivots]
    rows = [lengths.place(f, f.count(guard.beside + i)) for i in range(guard.parts)]
    parts = [f.magnitude(f.load(row, lengths.term)) for row in rows]
    change = f.load(lengths.place(f, f.count(guard.row)), 2 * lengths.term)
    slides = f.load("%state", k + search.rows.mode(layout)) > 0.0
    near = reduce(f.larger, parts) <= reduce(f.larger, speeds) * search.part
    return slides & (change <= 0.0) & near


def first_reached(
    search: Searched, f: Function, tolerance: float, longest: int,
    earliest: Variable[Real], which: Variable[Integer],
) -> None:  # fmt: skip
    """The same of steps on rates where one of them is about to be 0. The ``longest`` step is in the state."""
    rows, lengths, layout, listed = search.rows, search.lengths, search.layout, sliding(search.rows)
    if not listed:
        return
    zero = f.constant(0.0)
    step, t = f.load("%state", longest), f.magnitude(f.load("%state", layout.time))
    most = f.larger(step * max(WAY, LOOSER * math.sqrt(tolerance)), t * RESOLVED)
    with f.loop(0, len(listed), tested=False) as i:
        which_one, first, count, pivot = (
            f.load_integer("@stopping", i * NUMBERS + n) for n in range(NUMBERS)
        )
        slides = f.load("%state", which_one + rows.mode(layout)) > 0.0

        def part(k: Integer, first: Integer = first) -> tuple[Real, Real]:
            place = lengths.place(f, first + k)
            return f.load(place, lengths.term), f.load(place, 2 * lengths.term) * 2.0

        dot, square, fastest, speed = (f.variable(zero) for _ in range(4))
        with f.loop(0, count) as k:
            u, rate = part(k)
            dot.set(f.fused(u, rate, dot.get()))
            square.set(f.fused(rate, rate, square.get()))
            fastest.set(f.larger(fastest.get(), f.magnitude(rate)))
            v = f.load("%state", f.load_integer("@stopping_pivots", pivot + k) + layout.degrees)
            speed.set(f.larger(speed.get(), f.magnitude(v)))
        left = -dot.get() / square.get()
        row = lengths.place(f, f.load_integer("@guard_rows", which_one))
        end = f.constant(0.0)
        for m in reversed(range(1, lengths.order)):
            end = f.fused(end, Real(f, "%h"), f.load(row, m * lengths.term) * float(m))
        shrinks = end <= f.load(row, lengths.term) * SHRINKS
        with f.when(slides & shrinks & (left >= 0.0) & (left <= most)):
            aside = f.variable(zero)
            with f.loop(0, count) as k:
                u, rate = part(k)
                aside.set(f.larger(aside.get(), f.magnitude(f.fused(rate, left, u))))
            scale = f.larger(speed.get(), fastest.get() * step) * max(ASIDE, ALLOWED * tolerance)
            with f.when(aside.get() <= f.larger(scale, fastest.get() * t * RESOLVED)):
                earliest.set(zero)
                which.set(which_one)
