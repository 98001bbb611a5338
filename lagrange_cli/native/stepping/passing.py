"""Whether a motion clearly passes u = 0, where a force that jumps there may hold it.

It does if neither of two forces stops it: that which would hold it exceeds its bound, or it has a velocity
across u = 0; and that of the other side leads on. Whatever is not far above rounding is left to the caller
(``integrate.guards.settling``), as are several arguments that are 0 at one time.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from lagrange_cli.native.guards import GuardRow, GuardRows, Role
from lagrange_cli.native.llvm.function import Function
from lagrange_cli.native.llvm.text import table
from lagrange_cli.native.llvm.vector import Bit, Integer, Real
from lagrange_cli.native.state import Clock

if TYPE_CHECKING:
    from lagrange_cli.native.stepping.motion import Steps

CLEAR = 2.0**-40
"""A rate that is more than this part of all accelerations is no rounding error."""
EXCEEDS = 1.0 + 2.0**-30
"""A multiplier beyond this is more than the force that jumps can be."""
NEVER, TRIED, PLACED = range(3)
"""Compiled code does not look at a guard; it finds out what would hold the motion; or need not, as the
argument is a place."""


def kind_of(guard: GuardRow) -> int:
    """Which of these it is. Friction along vectors, or on members alone, holds the motion whenever it can."""
    if guard.role is not Role.HOLD or guard.pivots or guard.explicit:
        return NEVER
    return PLACED if guard.placed else TRIED


def passing_tables(rows: GuardRows) -> list[str]:
    """The kinds of all guards, and the events that may have no side."""
    kinds = table("passing", [kind_of(one) for one in rows.guards])
    return [kinds, table("standing", rows.standing)] if rows.standing else [kinds]


def passes(steps: Steps) -> Function:
    """``@passes(constants, state, work, j)``: whether the motion passes u = 0 at guard ``j``. Then its mode
    and the constants are those of the other side, else they are as before. The series are lost."""
    f = Function("define internal i1 @passes(ptr %constants, ptr %state, ptr %work, i64 %j) #0")
    guards, lengths, j, state = steps.guards, steps.lengths, Integer(f, "%j"), f.pointer("%state")
    assert guards
    rows, layout = guards.rows, guards.layout
    place, kind = j + rows.mode(layout), f.load_integer("@passing", j)
    before = f.load(state, place)
    with f.when(kind.equals(NEVER) | before.equals(0.0) | _others(f, steps, j)):
        f.give(f.never(1))

    def coefficient(row: Integer, m: int) -> Real:
        return f.load(lengths.place(f, row), m * lengths.term) * float(m)

    def tried(mode: Real) -> tuple[Real, Real]:
        """With this mode, the rate of the argument, and what is rounding beside accelerations."""
        f.store(mode, state, place)
        guards.prepare(f, state)
        steps.compute(f, steps.time(f), f.constant(1.0), state, f.pointer("%work"))
        total = f.variable(f.constant(0.0))
        with f.loop(layout.degrees, 2 * layout.degrees, tested=False) as i:
            total.set(total.get() + f.magnitude(coefficient(i, 1)))
        return coefficient(f.load_integer("@guard_rows", j), 2), total.get() * CLEAR

    free = f.variable(kind.equals(PLACED))
    with f.when(~free.get()):
        rate, least = tried(f.constant(0.0))
        force, most = coefficient(f.load_integer("@guard_multipliers", j), 1), f.constant(1.0)
        if any(one.limit for one in rows.guards):
            limit = f.load_integer("@guard_limits", j)
            with_limit = ~limit.equals(0)
            first = f.select(with_limit, limit, f.count(layout.degrees))
            above, below = coefficient(first, 1), coefficient(first + 1, 1)
            force = f.select(with_limit, above - below, force)
            most = f.select(with_limit, f.magnitude(above + below), most)
        free.set((f.magnitude(rate) > least) | (f.magnitude(force) > most * EXCEEDS))
    beyond, least = tried(-before)
    with f.when(free.get() & (-(before * beyond) > least)):
        f.give(~f.never(1))
    f.store(before, state, place)
    guards.prepare(f, state)
    f.give(f.never(1))
    return f


def _others(f: Function, steps: Steps, j: Integer) -> Bit:
    """Whether something else has a say: other arguments that are 0 now, events that have no side while the
    motion stands still, or so many changes that the motion may be held by them."""
    guards, state = steps.guards, f.pointer("%state")
    assert guards
    rows, layout = guards.rows, guards.layout
    found = f.variable(f.load(state, layout.at(Clock.PASSES)) >= rows.changes)
    with f.loop(0, rows.switches, tested=False) as k:
        fresh = f.load(state, k + rows.fresh(layout)) > 0.0
        found.set(found.get() | (fresh & ~k.equals(j)))
    if rows.standing:
        with f.loop(0, len(rows.standing), tested=False) as n:
            side = f.load(state, f.load_integer("@standing", n) + rows.mode(layout))
            found.set(found.get() | side.equals(0.0))
    return found.get()
