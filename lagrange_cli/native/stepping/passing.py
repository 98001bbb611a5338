"""Whether a motion clearly passes u = 0, where a force that jumps there may hold it.

It does if neither of two forces stops it: that which would hold it exceeds its bound, or it has a velocity
across u = 0; and that of the other side leads on. Whatever is not far above rounding is left to the caller
(``integrate.guards.settling``), as are several arguments that are 0 at one time.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from lagrange_cli.native.guards import EVENTS, GuardRow, GuardRows, Role
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


def may_pass(guard: GuardRow) -> bool:
    """Whether compiled code looks at a guard that may hold the motion. Others hold it whenever their argument,
    a velocity, is 0, or along a vector."""
    return guard.role is Role.HOLD and not guard.limited and not guard.pivots


def passing_tables(rows: GuardRows) -> list[str]:
    """Which guards these are."""
    return [table("may_pass", [int(may_pass(one)) for one in rows.guards])]


def passes(steps: Steps) -> Function:
    """``@passes(constants, state, work, j)``: whether the motion passes u = 0 at guard ``j``. Then its mode
    and the constants are those of the other side, else they are as before. The series are lost."""
    f = Function("define internal i1 @passes(ptr %constants, ptr %state, ptr %work, i64 %j) #0")
    guards, lengths, j, state = steps.guards, steps.lengths, Integer(f, "%j"), f.pointer("%state")
    assert guards
    rows, layout = guards.rows, guards.layout
    place = j + rows.mode(layout)
    before = f.load(state, place)
    with f.when(f.load_integer("@may_pass", j).equals(0) | before.equals(0.0) | _others(f, steps, j)):
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

    rate, least = tried(f.constant(0.0))
    force, most = coefficient(f.load_integer("@guard_multipliers", j), 1), f.constant(1.0)
    if any(one.limit for one in rows.guards):
        limit = f.load_integer("@guard_limits", j)
        some = ~limit.equals(0)
        above, below = (coefficient(f.select(some, limit + k, f.count(layout.degrees)), 1) for k in range(2))
        force = f.select(some, above - below, force)
        most = f.select(some, f.magnitude(above + below), most)
    free = (f.magnitude(rate) > least) | (f.magnitude(force) > most * EXCEEDS)
    beyond, least = tried(-before)
    with f.when(free & (-(before * beyond) > least)):
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
    switches = next((k for k, one in enumerate(rows.guards) if one.role in EVENTS), rows.count)
    with f.loop(0, switches, tested=False) as k:
        fresh = f.load(state, k + rows.fresh(layout)) > 0.0
        found.set(found.get() | (fresh & ~k.equals(j)))
    with f.loop(switches, switches + rows.events) as k:
        found.set(found.get() | f.load(state, k + rows.mode(layout)).equals(0.0))
    return found.get()
