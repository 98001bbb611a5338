"""Vectors that friction acts along and that come to rest, in systems that have many of them: where one is so
short that it is nothing but rounding beside the fastest velocity, it counts as 0. No step comes nearer."""

from __future__ import annotations

from lagrange_cli.native.guards import GuardRows
from lagrange_cli.native.llvm.flow import Variable
from lagrange_cli.native.llvm.function import Function
from lagrange_cli.native.llvm.text import table
from lagrange_cli.native.llvm.vector import Integer, Real
from lagrange_cli.native.state import StateLayout
from lagrange_cli.native.stepping.lengths import Lengths

AROUND = 16.0
"""Steps on rates may go to and fro about 0, with so many times their errors; then the vector stops."""


def stopping(rows: GuardRows) -> list[int]:
    """The guards of such vectors."""
    return [j for j, one in enumerate(rows.guards) if one.alone]


def stopping_tables(rows: GuardRows) -> list[str]:
    """Their numbers."""
    listed = stopping(rows)
    return [table("stopping", listed)] if listed else []


def first_stopped(
    f: Function,
    guards: tuple[GuardRows, StateLayout, Lengths],
    part: float,
    earliest: Variable[Real],
    which: Variable[Integer],
    *,
    interpolated: bool,
) -> None:
    """Set the ``earliest`` time to 0 where one of them is at most this ``part`` of the fastest velocity, and
    becomes shorter; arguments may be ``interpolated`` polynomials."""
    rows, layout, lengths = guards
    listed = stopping(rows)
    if not listed:
        return
    part *= AROUND if interpolated else 1.0
    fastest = f.variable(f.zero(lengths.lanes))
    with lengths.velocities(f) as row:
        fastest.set(f.larger(fastest.get(), row.only_velocities(f.magnitude(row.at("%state")))))
    near, t = lengths.gather(f, "fmax", fastest.get()) * part, f.load("%state", layout.time)
    with f.loop(0, len(listed), tested=False) as i:
        k = f.load_integer("@stopping", i)
        slides = f.load("%state", k + rows.mode(layout)) > 0.0
        place = lengths.place(f, f.load_integer("@guard_rows", k))
        least = f.variable(near)
        if interpolated:  # beside what it loses in all the time, too: the others may be at rest
            change = f.constant(0.0)  # rates of values that are rounded are nothing
            for m in reversed(range(2, lengths.order)):
                change = f.fused(change, Real(f, "%h"), f.load(place, m * lengths.term) * float(m))
            least.set(f.larger(near, f.magnitude(change * t) * part))
        else:
            change = f.load(place, 2 * lengths.term)
        with f.when(slides & (f.load(place, lengths.term) <= least.get())), f.when(change <= 0.0):
            earliest.set(f.constant(0.0))
            which.set(k)
